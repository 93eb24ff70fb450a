//! The charts that the page's script draws, as they first are: for files, which nobody can choose in.

use std::collections::BTreeSet;

use crate::analysis::dims::Dimension;
use crate::analysis::effects::Effect;
use crate::analysis::goals::goal;
use crate::analysis::pareto::front;
use crate::html::charts::WIDTH;
use crate::html::charts::bars::beside;
use crate::html::charts::chart::{Chart, Data, Key, cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{COLOURS, FULL, Svg, marker, n, shortened, told_apart};
use crate::html::sweep::number::{number, signed_percent};
use crate::html::sweep::view::{SweepView, VALUES_MAX};
use crate::html::text::{counted, escape};
use crate::table::Field;

/// Height of a row.
const ROW: f64 = 20.0;

/// Breadth of the strip for what is infinite.
const STRIP: f64 = 34.0;

/// Width of a letter of a tick, roughly.
const LETTER: f64 = 6.2;

/// Width of a digit above a column, which is wider.
const DIGIT: f64 = 7.0;

/// Between two names above columns, at least.
const GAP: f64 = 5.0;

/// Height of a line of a note below a chart.
const NOTE: f64 = 14.0;

/// Most values in a legend.
const KEYS_MAX: usize = 24;

/// Draws them.
pub fn keep(view: &SweepView<'_>) {
    if let Some([x, y]) = view.pair.and_then(|[x, y]| Some([view.results.field(x)?, view.results.field(y)?])) {
        let title = format!("{} against {}", y.name, x.name);
        view.charts.keep(&["pareto"], &title, &pareto(view, [x, y]));
        if let Some((title, chart)) = heat(view, y) {
            view.charts.keep(&["heat"], &title, &chart);
        }
    }
    for field in &view.moved() {
        let effects = view.effects(field);
        if !effects.is_empty() {
            let title = format!("What moves {}", field.name);
            view.charts.keep(&["effects", &field.name], &title, &ranges(field, &effects));
        }
    }
}

fn named(field: &Field) -> String {
    if matches!(field.unit.as_str(), "" | "1") { field.name.clone() } else { format!("{}, {}", field.name, field.unit) }
}

/// How many points are left out of a chart and why, in lines below it: what a chart does not have nobody misses.
fn notes(svg: &mut Svg, top: f64, left_out: &[(usize, String)]) {
    for (i, (count, what)) in left_out.iter().filter(|(count, _)| *count > 0).enumerate() {
        let is = if *count == 1 { "is" } else { "are" };
        let text = format!("{} {what} {is} left out", counted(*count, "point"));
        svg.text(0.0, top + NOTE * (i as f64 + 1.0) - 3.0, "note s", &shortened(&text, (WIDTH / LETTER) as usize));
    }
}

/// Room for these notes.
fn room(left_out: &[(usize, String)]) -> f64 {
    NOTE * left_out.iter().filter(|(count, _)| *count > 0).count() as f64
}

/// How many points that could be computed have none of a result.
fn lacking(view: &SweepView<'_>, field: &Field) -> (usize, String) {
    let lacks = |row: &usize| view.error(*row).is_none() && view.result(field, *row).is_none();
    ((0..view.results.rows()).filter(lacks).count(), format!("without {}", field.name))
}

/// The name of a result, and of a second one unless it is the same.
fn once(fields: [&Field; 2]) -> Vec<&Field> {
    fields.into_iter().take(if fields[0].name == fields[1].name { 1 } else { 2 }).collect()
}

/// Points of two results, and of each group those that no other beats in both.
fn pareto(view: &SweepView<'_>, fields: [&Field; 2]) -> Chart {
    let value = |row: usize| {
        let [x, y] = fields.map(|field| view.result(field, row));
        Some([x?, y?]).filter(|_| view.error(row).is_none())
    };
    let points: Vec<Option<[f64; 2]>> = (0..view.results.rows()).map(value).collect();
    let goals = fields.map(|field| goal(&field.name));
    let fronts: Vec<Vec<usize>> = view.groups().into_iter().map(|(_, rows)| best(&points, &rows, goals)).collect();
    // What is infinite, as the PSNR of the same picture, stands in a strip of its own behind the end of its axis.
    let apart = [0, 1].map(|axis| points.iter().flatten().any(|point| point[axis].is_infinite()));
    let bottom = 240.0;
    let right = WIDTH - if apart[0] { 12.0 + STRIP + 4.0 } else { 12.0 };
    let top = 24.0 + if apart[1] { STRIP + 4.0 } else { 0.0 };
    let finite = |axis: usize| points.iter().flatten().map(move |point| point[axis]).filter(|value| value.is_finite());
    let y = Scale::nice(extent(finite(1)).unwrap_or([0.0, 1.0]), 5, [bottom, top]);
    let left = y.margin(52.0, |tick| y.label(tick));
    let x = Scale::nice(extent(finite(0)).unwrap_or([0.0, 1.0]), 5, [left, right]);
    let place = |[a, b]: [f64; 2]| {
        let across = if a.is_infinite() { right + 4.0 + STRIP / 2.0 } else { x.at(a) };
        [across, if b.is_infinite() { top - 4.0 - STRIP / 2.0 } else { y.at(b) }]
    };
    let left_out: Vec<_> = once(fields).into_iter().map(|field| lacking(view, field)).collect();
    let mut svg = Svg::new(WIDTH, bottom + 38.0 + room(&left_out));
    notes(&mut svg, bottom + 38.0, &left_out);
    for tick in y.ticks() {
        svg.line([left, y.at(tick)], [right, y.at(tick)], "grid");
        svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &y.label(tick));
    }
    for (tick, text) in x.named_ticks(|tick| x.label(tick)) {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &text);
    }
    if apart[0] {
        svg.rect([right + 4.0, top, STRIP, bottom - top], "apart");
        svg.text(right + 4.0 + STRIP / 2.0, top - 5.0, "tick m", "same");
    }
    if apart[1] {
        svg.rect([left, top - 4.0 - STRIP, right - left, STRIP], "apart");
        svg.text(left - 5.0, top - STRIP / 2.0, "tick e", "same");
    }
    svg.line([left, bottom], [right, bottom], "axis");
    svg.text(0.0, 11.0, "note s", &named(fields[1]));
    svg.text(right, bottom + 32.0, "note e", &named(fields[0]));
    for front in &fronts {
        let corner = |row: &usize| points[*row].map(place).map(|[a, b]| format!("{} {}", n(a), n(b)));
        let corners: Vec<String> = front.iter().filter_map(corner).collect();
        // A trace may have no point with both results.
        if corners.len() > 1 {
            svg.path(&format!("M{}", corners.join("L")), "frontier", "");
        }
    }
    let on: BTreeSet<usize> = fronts.into_iter().flatten().collect();
    let colour = view.colour().and_then(|name| view.dimensions.iter().find(|dimension| dimension.name == name));
    let names: Vec<&str> = once(fields).into_iter().map(|field| field.name.as_str()).collect();
    let wanted = names.len();
    let columns: Vec<&str> =
        ["point"].into_iter().chain(view.dimensions.iter().map(|d| d.name.as_str())).chain(names).collect();
    let mut data = Data::new(&[columns.as_slice(), &["front"]].concat());
    let mut unlike = false;
    for (row, point) in points.iter().enumerate().filter_map(|(row, point)| Some((row, (*point)?))) {
        let look = colour.map_or(Some(0), |dimension| dimension.of[row]);
        let (class, shape) = look.map_or(("pfull".into(), FULL), |value| (format!("p{}", value % COLOURS), value));
        unlike |= look.is_none();
        let (dim, [across, up]) = (if on.contains(&row) { "" } else { " dim" }, place(point));
        svg.raw(&format!(
            "<path d=\"{}\" class=\"dot {class}{dim}\"><title>{}</title></path>",
            marker(shape, across, up),
            escape(&view.describe(row, None))
        ));
        let values = view.dimensions.iter().map(|d| d.of[row].map(|value| d.values[value].clone()).unwrap_or_default());
        let ends = point.into_iter().take(wanted).map(|value| cell(Some(value)));
        let is_on = [on.contains(&row).to_string()];
        data.row([view.number(row)].into_iter().chain(values).chain(ends).chain(is_on).collect());
    }
    let keys = keys(colour, unlike);
    Chart { svg: svg.finish("Points of two results; lines join those that no other beats", ""), data, keys }
}

/// What the colours mean: values of a dimension, and that there is none where `unlike` says that some points have none.
fn keys(colour: Option<&Dimension>, unlike: bool) -> Vec<Key> {
    let Some(dimension) = colour else { return Vec::new() };
    let key = |(value, name): (usize, &String)| Key::of_marker(&format!("p{}", value % COLOURS), value, name);
    let mut keys: Vec<Key> = dimension.values.iter().enumerate().take(KEYS_MAX).map(key).collect();
    keys.extend(unlike.then(|| Key::of_marker("pfull", FULL, "none")));
    let more = dimension.values.len().saturating_sub(KEYS_MAX);
    keys.extend((more > 0).then(|| Key::more(more)));
    keys
}

/// The rows of a group that no other of it beats, along the first result.
fn best(points: &[Option<[f64; 2]>], rows: &[usize], goals: [crate::analysis::goals::Goal; 2]) -> Vec<usize> {
    let here: Vec<Option<[f64; 2]>> = rows.iter().map(|row| points[*row]).collect();
    let mut on: Vec<usize> = rows.iter().zip(front(&here, goals)).filter(|(_, on)| *on).map(|(row, _)| *row).collect();
    let key = |row: &usize| points[*row].unwrap_or_default();
    on.sort_by(|a, b| key(a)[0].total_cmp(&key(b)[0]).then(key(a)[1].total_cmp(&key(b)[1])));
    on
}

/// The mean of a result over the two axes that move it most.
fn heat(view: &SweepView<'_>, field: &Field) -> Option<(String, Chart)> {
    let [down, across] = view.heat_axes()?;
    let mut sums = vec![vec![(0.0, 0_u32); across.values.len()]; down.values.len()];
    let (mut infinite, mut apart) = (0, 0);
    for row in (0..view.results.rows()).filter(|row| view.error(*row).is_none()) {
        match (view.result(field, row), down.of[row].zip(across.of[row])) {
            (None, _) => {}
            (Some(value), _) if !value.is_finite() => infinite += 1,
            (Some(value), Some((a, b))) => {
                sums[a][b].0 += value;
                sums[a][b].1 += 1;
            }
            (Some(_), None) => apart += 1,
        }
    }
    let left_out = [
        lacking(view, field),
        (infinite, "with ∞".into()),
        (apart, format!("without {} or {}", down.name, across.name)),
    ];
    // Values that no point has with the result are left out, as on the page.
    let has = |a: usize, b: usize| sums[a][b].1 > 0;
    let [all_down, all_across] = [down, across].map(|axis| 0..axis.values.len());
    let rows: Vec<usize> = all_down.clone().filter(|a| all_across.clone().any(|b| has(*a, b))).collect();
    let columns: Vec<usize> = all_across.filter(|b| all_down.clone().any(|a| has(a, *b))).collect();
    if rows.is_empty() || rows.len().max(columns.len()) > VALUES_MAX {
        return None;
    }
    let cells: Vec<Vec<(f64, u32)>> = rows.iter().map(|a| columns.iter().map(|b| sums[*a][*b]).collect()).collect();
    let names = |axis: &Dimension, kept: &[usize]| kept.iter().map(|value| axis.values[*value].clone()).collect();
    let title = format!("{} by {} and {}", named(field), down.name, across.name);
    let sides = [
        Side { name: &down.name, values: names(down, &rows) },
        Side { name: &across.name, values: names(across, &columns) },
    ];
    Some((title, map(field, &sides, &cells, &left_out)))
}

/// A side of a map: an axis with those of its values that stand there.
struct Side<'a> {
    name: &'a str,
    values: Vec<String>,
}

/// The names of columns that there is room for, and the middle of each; of narrow ones only every second has one, or every third.
fn heads(values: &[String], [left, width]: [f64; 2]) -> Vec<(f64, String)> {
    let longest = values.iter().map(|value| value.chars().count()).max().unwrap_or(1);
    let is_number = |value: &String| value.starts_with(|c: char| c.is_ascii_digit());
    let letter = if values.iter().all(is_number) { DIGIT } else { LETTER };
    let room = |step: usize| ((width * step as f64 - GAP) / letter) as usize;
    let step = (1..values.len()).find(|step| room(*step) >= longest.min(6)).unwrap_or(values.len().max(1));
    let named: Vec<&str> = values.iter().map(String::as_str).step_by(step).collect();
    let middle = |i: usize| left + width * ((i * step) as f64 + 0.5);
    let heads = told_apart(&named, room(step).max(1)).into_iter().enumerate().map(|(i, name)| (middle(i), name));
    let fits = |(middle, name): &(f64, String)| middle + name.chars().count() as f64 * letter / 2.0 <= WIDTH + 10.0;
    heads.filter(|head| step == 1 || fits(head)).collect()
}

fn map(
    field: &Field,
    [down, across]: &[Side<'_>; 2],
    cells: &[Vec<(f64, u32)>],
    left_out: &[(usize, String)],
) -> Chart {
    let mean = |(sum, count): &(f64, u32)| (*count > 0).then(|| sum / f64::from(*count));
    let ends = extent(cells.iter().flatten().filter_map(mean)).unwrap_or([0.0, 1.0]);
    let (names, left) = beside(&down.values.iter().map(String::as_str).collect::<Vec<_>>(), 22);
    let (left, top) = (left.max(96.0), 40.0);
    let bottom = top + ROW * cells.len() as f64 + 4.0;
    let width = (WIDTH - left) / across.values.len().max(1) as f64;
    let mut svg = Svg::new(WIDTH, bottom + room(left_out));
    notes(&mut svg, bottom, left_out);
    svg.text(0.0, 11.0, "note s", &format!("{} down, {} across", down.name, across.name));
    for (middle, name) in heads(&across.values, [left, width]) {
        svg.text(middle, top - 8.0, "tick m", &name);
    }
    let mut data = Data::new(&[down.name, across.name, &field.name, "points"]);
    for (i, (value, row)) in down.values.iter().zip(cells).enumerate() {
        let y = top + ROW * i as f64;
        svg.text(left - 6.0, y + 14.0, "tick e", &names[i]);
        for (j, sum) in row.iter().enumerate() {
            let mean = mean(sum);
            data.row(vec![value.clone(), across.values[j].clone(), cell(mean), sum.1.to_string()]);
            let Some(mean) = mean else { continue };
            let share = if ends[1] > ends[0] { (mean - ends[0]) / (ends[1] - ends[0]) } else { 0.0 };
            let x = left + width * j as f64;
            let tip = format!("{} {value}, {} {}\n{}", down.name, across.name, across.values[j], number(mean));
            svg.mark([x, y, width - 1.0, ROW - 1.0], "b2", 0.08 + 0.72 * share, &tip);
            if width >= 34.0 {
                svg.text(x + width / 2.0, y + 14.0, "value m", &number(mean));
            }
        }
    }
    Chart { svg: svg.finish("Mean of a result over two axes", ""), data, keys: Vec::new() }
}

/// For each axis how far the means of a result at its values lie from the mean of all.
fn ranges(field: &Field, effects: &[(&Dimension, Effect)]) -> Chart {
    let names: Vec<&str> = effects.iter().map(|(dimension, _)| dimension.name.as_str()).collect();
    let names = told_apart(&names, 16);
    let (left, right, top) = (110.0, WIDTH - 56.0, 6.0);
    let bottom = top + ROW * effects.len() as f64;
    let ends = effects.iter().flat_map(|(_, effect)| [effect.end(0), effect.end(1), 0.0]);
    // What is left of sums that are equal is no effect.
    let ends = extent(ends).filter(|[low, high]| high - low > 1e-12).unwrap_or([-0.1, 0.1]);
    let x = Scale::nice(ends, 3, [left, right]);
    let mut svg = Svg::new(WIDTH, bottom + 22.0);
    let percent = x.times(100.0);
    let text = |tick: f64| format!("{}{}\u{202f}%", if tick > 0.0 { "+" } else { "" }, percent.label(tick * 100.0));
    for (tick, text) in x.named_ticks(text) {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &text);
    }
    let mut data = Data::new(&["axis", "value", &field.name]);
    for (i, (dimension, effect)) in effects.iter().enumerate() {
        let y = top + ROW * i as f64;
        let (a, b) = (x.at(effect.end(0)), x.at(effect.end(1)));
        svg.text(left - 6.0, y + 13.0, "label e", &names[i]);
        let tip = format!("{} to {}", dimension.values[effect.ends[0]], dimension.values[effect.ends[1]]);
        svg.mark([a, y + 3.0, (b - a).max(1.0), ROW - 7.0], "b2", 1.0, &tip);
        svg.text(right + 6.0, y + 13.0, "value s", &signed_percent(effect.share()).replace('+', ""));
        for (value, mean) in dimension.values.iter().zip(&effect.means) {
            let Some(mean) = mean else { continue };
            data.row(vec![dimension.name.clone(), value.clone(), cell(Some(*mean))]);
        }
    }
    svg.line([x.at(0.0), top], [x.at(0.0), bottom], "axis");
    Chart {
        svg: svg.finish("Main effects: from the least to the most mean, from the mean of all", ""),
        data,
        keys: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Six numbers ran into one another, and with more room between them the names of presets were cut.
    #[test]
    fn names_above_columns_stay_apart_and_whole() {
        let named = |names: &[&str], width: f64| -> Vec<String> {
            let names: Vec<String> = names.iter().map(|name| (*name).to_owned()).collect();
            heads(&names, [96.0, width]).into_iter().map(|(_, head)| head).collect()
        };
        let presets = ["full", "paper-ss", "multirate", "adaptive"];
        assert_eq!(named(&presets, 66.0), presets);
        let numbers = ["123400", "123401", "123402", "123403"];
        assert_eq!((named(&numbers, 48.0), named(&numbers, 44.0).len()), (numbers.map(String::from).to_vec(), 2));
    }
}
