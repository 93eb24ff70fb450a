//! Whether the order of the policies depends on what was varied: a table and a chart.

use crate::analysis::order::{OrderRow, PolicyOrder};
use crate::html::charts::WIDTH;
use crate::html::charts::chart::{Chart, Data, Key, cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{COLOURS, Svg, marker, shortened};
use crate::html::parts::{Head, Section, how_to_read, legend, symbol, table};
use crate::html::sweep::view::SweepView;
use crate::html::text::{escape, fixed, or_dash};

/// More rows than this are no table to read; the tools below find their way in them.
const ROWS_MAX: usize = 60;

/// Width of a letter beside it, roughly.
const LETTER: f64 = 6.0;

/// Height of a row of the chart, and of a line of a name above it.
const ROW: f64 = 19.0;
const LINE: f64 = 15.0;

/// The section.
pub fn section(view: &SweepView<'_>) -> Option<Section> {
    let field = ["gpu_perf_per_watt", "perf_per_watt"].into_iter().find_map(|name| view.results.field(name))?;
    let order =
        PolicyOrder::of(view.results, field).filter(|order| order.compares() && order.rows.len() <= ROWS_MAX)?;
    let changing = (0..order.rows.len()).filter(|row| !order.changed(*row).is_empty()).count();
    let verdict = match changing {
        0 => "The policy that is first in a trace is first there in every row.".to_owned(),
        rows => {
            format!("The order changes: in {rows} of {} rows another policy is first in some trace.", order.rows.len())
        }
    };
    let read = format!(
        "Gain in {} over full at the same values; over several traces the geometric mean of those that all policies of the row have. A trace stands under Changes if another \
         policy is first there than in the first row that has two of it. All points are looked at, whatever the filter shows. Estimates have intervals, \
         which are not looked at here.",
        field.name
    );
    let looks = looks(view, &order);
    let html = format!(
        "<p>{}</p>\n{}{}{}",
        escape(&verdict),
        view.charts.card(&["order"], "Gain over full", &chart(&order, &looks), "") + &legend(&keys(&order, &looks)),
        rows(&order),
        how_to_read(&read)
    );
    Section::new("order", "Order of the policies", html)
}

fn rows(order: &PolicyOrder) -> String {
    let mut columns = vec![Head::words("Varied")];
    columns.extend(order.policies.iter().map(|policy| Head::number(policy)));
    columns.extend([Head::words("First in"), Head::words("Changes")]);
    let row = |(i, row): (usize, &OrderRow)| {
        let mut cells = vec![escape(&row.name)];
        cells.extend((0..order.policies.len()).map(|policy| or_dash(row.mean(policy), |gain| fixed(gain, 2))));
        cells.push(escape(&first_in(order, row)));
        cells.push(escape(&order.changed(i).join(", ")));
        (String::new(), cells)
    };
    table("Gain over full", &columns, &order.rows.iter().enumerate().map(row).collect::<Vec<_>>())
}

/// In how many traces each policy is first.
fn first_in(order: &PolicyOrder, row: &OrderRow) -> String {
    let first = row.first();
    let count = |policy: usize| first.values().filter(|first| **first == policy).count();
    let counts = order.policies.iter().enumerate().map(|(policy, name)| (name, count(policy)));
    let words: Vec<String> =
        counts.filter(|(_, count)| *count > 0).map(|(name, count)| format!("{name} {count}")).collect();
    words.join(", ")
}

/// The marker and colour of each policy: those that it has in the other charts of the page.
fn looks(view: &SweepView<'_>, order: &PolicyOrder) -> Vec<usize> {
    let all = view.dimensions.iter().find(|dimension| dimension.name == "policy");
    let look = |(i, name): (usize, &String)| {
        all.and_then(|all| all.values.iter().position(|value| value == name)).unwrap_or(i)
    };
    order.policies.iter().enumerate().map(look).collect()
}

fn keys(order: &PolicyOrder, looks: &[usize]) -> String {
    let key = |(name, &look): (&String, &usize)| {
        symbol(&format!("<path d=\"{}\" class=\"dot {}\"/>", marker(look, 8.0, 8.0), class(look)), name)
    };
    order.policies.iter().zip(looks).map(key).collect()
}

fn class(look: usize) -> String {
    format!("p{}", look % COLOURS)
}

/// The values of a name in lines of at most so many characters.
fn wrapped(name: &str, most: usize) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for value in name.split(", ") {
        match lines.last_mut().filter(|line| line.chars().count() + value.chars().count() + 2 < most) {
            Some(line) => *line += &format!(", {value}"),
            None => lines.push(value.to_owned()),
        }
    }
    // A comma says that the name goes on.
    let last = lines.len() - 1;
    let line = |(i, line): (usize, &String)| shortened(line, most) + if i < last { "," } else { "" };
    lines.iter().enumerate().map(line).collect()
}

/// A line a row, a marker a policy.
fn chart(order: &PolicyOrder, looks: &[usize]) -> Chart {
    let gains = |row: &OrderRow| (0..order.policies.len()).filter_map(|policy| row.mean(policy)).collect::<Vec<_>>();
    let ends = extent(order.rows.iter().flat_map(gains)).unwrap_or([0.0, 1.0]);
    // Names that are longer than that stand above their rows.
    let beside = WIDTH * 0.42;
    let longest = order.rows.iter().map(|row| row.name.chars().count()).max().unwrap_or(0);
    let is_beside = longest as f64 * LETTER <= beside - 8.0;
    let names: Vec<Vec<String>> = order.rows.iter().map(|row| wrapped(&row.name, (WIDTH / LETTER) as usize)).collect();
    let lines = names.iter().map(Vec::len).max().unwrap_or(1) as f64;
    let (left, row_height) = if is_beside { (beside, ROW) } else { (12.0, ROW + LINE * lines) };
    let top = 8.0;
    let bottom = top + row_height * order.rows.len() as f64;
    let x = Scale::nice(ends, 5, [left, WIDTH - 12.0]);
    let mut svg = Svg::new(WIDTH, bottom + 24.0);
    for (tick, text) in x.named_ticks(|tick| x.label(tick) + "×") {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &text);
    }
    for (i, row) in order.rows.iter().enumerate() {
        let end = top + row_height * (i as f64 + 1.0);
        let y = end - ROW / 2.0;
        if is_beside {
            svg.text(left - 8.0, y + 4.0, "tick e", &row.name);
        } else {
            for (line, text) in names[i].iter().enumerate() {
                svg.text(0.0, end - row_height + LINE * (line as f64 + 1.0), "tick", text);
            }
        }
        for (policy, name) in order.policies.iter().enumerate() {
            let Some(gain) = row.mean(policy) else { continue };
            svg.raw(&format!(
                "<path d=\"{}\" class=\"dot {}\" data-mark=\"\"><title>{}</title></path>",
                marker(looks[policy], x.at(gain), y),
                class(looks[policy]),
                escape(&format!("{}: {name} {}×", row.name, fixed(gain, 2)))
            ));
        }
    }
    let mut data = Data::new(&["varied", "policy", "gain over full"]);
    for row in &order.rows {
        for (policy, name) in order.policies.iter().enumerate() {
            data.row(vec![row.name.clone(), name.clone(), cell(row.mean(policy))]);
        }
    }
    let keys = order.policies.iter().zip(looks).map(|(name, &look)| Key::of_marker(&class(look), look, name)).collect();
    Chart { svg: svg.finish("Gain of each policy over full, a line for each combination of values", ""), data, keys }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// They were cut to the same text.
    #[test]
    fn long_names_are_told_apart() {
        let chart_of = |names: [&str; 2]| {
            let gains = [1.5, 2.5].map(|gain| BTreeMap::from([("a".to_owned(), gain)]));
            let row = |name: &str| OrderRow { name: name.to_owned(), gains: gains.to_vec() };
            let order = PolicyOrder { policies: vec!["one".into(), "two".into()], rows: names.map(row).to_vec() };
            chart(&order, &[0, 1]).svg
        };
        let names = ["sgrt-ti2-accumulate, lpddr4-3200, 16KiB", "sgrt-ti2-accumulate, lpddr4-3200, 32KiB"];
        let svg = chart_of(names);
        assert!(names.iter().all(|name| svg.contains(&format!(">{name}</text>"))), "{svg}");
        let long = "sgrt-ti2-accumulate, lpddr4-3200-dual-rank-eco-four-channels, ";
        let svg = chart_of([&format!("{long}16KiB"), &format!("{long}32KiB")]);
        assert!(svg.contains("16KiB</text>") && svg.contains("32KiB</text>"), "{svg}");
        assert!(svg.contains(">sgrt-ti2-accumulate,</text>"), "{svg}");
        let svg = chart_of(["16KiB", "32KiB"]);
        assert!(svg.contains(">16KiB</text>") && svg.contains(">32KiB</text>"), "{svg}");
    }
}
