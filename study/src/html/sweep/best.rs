//! The best points for an objective, and what they change of their presets.

use crate::analysis::best::best;
use crate::analysis::configs::Half;
use crate::analysis::goals::{Goal, goal};
use crate::html::parts::{Head, Section, details, table};
use crate::html::sweep::summary::cells;
use crate::html::sweep::view::SweepView;
use crate::html::text::escape;
use crate::table::Field;

/// How many points of a group.
const BEST: usize = 10;

/// Most groups that the page shows without a script.
const GROUPS: usize = 6;

/// The section.
pub fn section(view: &SweepView<'_>) -> Option<Section> {
    let objective = view.objective?;
    let controls = "<div class=\"controls only-js\"><label class=\"wide\">Best in <select id=\"best-result\"></select></label>\
         <label><select id=\"best-goal\" aria-label=\"Direction\"><option value=\"min\">least</option>\
         <option value=\"max\">most</option></select></label>\
         <label class=\"wide\">for each <select id=\"best-each\"></select></label></div>\n";
    let groups: String = view.groups().iter().take(GROUPS).map(|group| part(view, objective, group)).collect();
    let read = "<p class=\"read\">What a point changes of the presets that it is made of stands as overrides (--set). Of machine and \
                policy files, which this page does not have, every value stands there that varies in the sweep. \
                <span class=\"no-js\">The first of each table has its whole configuration below it.</span>\
                <span class=\"only-js\">Click on the number of a point for its whole configuration.</span></p>\n";
    let html = format!("{controls}<div id=\"best-tables\">\n{groups}</div>\n{read}");
    Section::new("best", "Best points", html)
}

fn part(view: &SweepView<'_>, objective: &Field, (name, rows): &(String, Vec<usize>)) -> String {
    let goal = goal(&objective.name);
    let best = best(|row| view.result(objective, row), rows, goal, BEST);
    let Some(first) = best.first() else { return String::new() };
    let mut results: Vec<&Field> = vec![objective];
    results.extend(view.headlines.iter().copied().filter(|field| field.name != objective.name));
    // The name of the group stands above.
    let dimensions = view.dimensions.iter().enumerate().filter(|(index, _)| Some(*index) != view.each);
    let dimensions = dimensions.map(|(_, dimension)| Head::words(&dimension.name));
    let columns: Vec<Head> = [Head::number("Point")]
        .into_iter()
        .chain(dimensions)
        .chain(results.iter().map(|field| Head::number(&field.name)))
        .chain([Head::words("Changes")])
        .collect();
    let row = |row: &usize| {
        let mut line = vec![escape(&view.number(*row))];
        line.extend(cells(view, *row, &results));
        line.push(changes(view, *row));
        (String::new(), line)
    };
    let rows: Vec<_> = best.iter().map(row).collect();
    let word = if goal == Goal::Min { "Least" } else { "Most" };
    let of = if name.is_empty() { String::new() } else { format!(" on {name}") };
    let caption = format!("{word} {}{of}", objective.name);
    let number = view.number(*first);
    table(&caption, &columns, &rows) + &details(&format!("Configuration of point {number}"), &whole(view, *first))
}

/// What a point changes.
fn changes(view: &SweepView<'_>, row: usize) -> String {
    let all: Vec<String> = Half::ALL
        .iter()
        .flat_map(|half| view.changes(row, *half).list)
        .map(|change| format!("<code>{}={}</code>", escape(&change.key), escape(&change.value)))
        .collect();
    if all.is_empty() { "as the presets".into() } else { all.join(" ") }
}

/// Every value.
fn whole(view: &SweepView<'_>, row: usize) -> String {
    let lines = |half: &Half| {
        let config = view.configs[*half as usize].row(row).into_iter().flatten();
        config.map(|(key, value)| format!("{key} = {value}\n")).collect::<String>()
    };
    let part = |half: &Half| {
        let text = lines(half);
        if text.is_empty() {
            return String::new();
        }
        format!("<h3>{}</h3><pre tabindex=\"0\">{}</pre>\n", half.name(), escape(text.trim_end()))
    };
    format!("<div class=\"configs\">{}</div>\n", Half::ALL.iter().map(part).collect::<String>())
}
