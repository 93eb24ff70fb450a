//! What the sweep is of, and its best values at a glance.

use crate::analysis::best::best;
use crate::analysis::goals::{Goal, counted_only, goal};
use crate::html::parts::{Head, Section, how_to_read, table};
use crate::html::sweep::view::SweepView;
use crate::html::text::{counted, escape, or_dash, plus_minus};
use crate::point::known::interval_of;
use crate::table::Field;

/// Most traces of a tile.
const TRACES: usize = 3;

/// The section.
pub fn section(view: &SweepView<'_>) -> Option<Section> {
    let tiles: String = view.headlines.iter().filter_map(|field| tile(view, field)).collect();
    let tiles = if tiles.is_empty() { tiles } else { format!("<dl class=\"numbers\">\n{tiles}</dl>\n") };
    let html = tiles + &estimates(view) + &counts(view) + &axes(view) + &failures(view);
    let html = match view.results.rows() {
        0 => "<p>There are no points.</p>\n".into(),
        _ if html.is_empty() => "<p>Nothing is known of the points but what they are.</p>\n".into(),
        _ => html,
    };
    Section::new("summary", "Summary", format!("<div id=\"summary-of\">\n{html}</div>\n"))
}

/// The best value of a result on each trace. Values of different traces are not compared: one scene is easier than another.
fn tile(view: &SweepView<'_>, field: &Field) -> Option<String> {
    let goal = goal(&field.name);
    let first = |(name, rows): (String, Vec<usize>)| {
        Some((name, *best(|row| view.result(field, row), &rows, goal, 1).first()?))
    };
    let found: Vec<(String, usize)> = view.groups().into_iter().filter_map(first).collect();
    found.first()?;
    let word = match goal {
        // One point alone is neither.
        _ if view.results.rows() == 1 => "",
        Goal::Min => "least ",
        Goal::Max => "most ",
    };
    let unit = if matches!(field.unit.as_str(), "" | "1") {
        String::new()
    } else {
        format!(" <small>{}</small>", escape(&field.unit))
    };
    let on = |(name, row): &(String, usize)| {
        let name = if name.is_empty() { String::new() } else { format!("<em>{}</em> ", escape(name)) };
        let within = within(view, field, *row);
        format!(
            "<b>{}{unit}{within}</b><span>{name}{}</span>",
            view.shown(field, *row),
            escape(&view.describe(*row, view.each))
        )
    };
    let shown: String = found.iter().take(TRACES).map(on).collect();
    let more = if found.len() > TRACES {
        format!("<span>and {}</span>", counted(found.len() - TRACES, "more trace"))
    } else {
        String::new()
    };
    let class = if found.len() > 1 { " several" } else { "" };
    Some(format!(
        "<div class=\"tile-number{class}\"><dt>{word}{}</dt><dd>{shown}{more}</dd></div>\n",
        escape(&field.name),
    ))
}

/// Behind an estimate half the width of its interval.
fn within(view: &SweepView<'_>, field: &Field, row: usize) -> String {
    let interval = view.results.field(&interval_of(&field.name)).and_then(|interval| interval.cells.number(row));
    plus_minus(interval.map(|percent| percent / 100.0))
}

/// How many points are estimates, and what that means.
fn estimates(view: &SweepView<'_>) -> String {
    let interval = view.results.field(&interval_of("cycles"));
    let estimated =
        interval.map_or(0, |field| (0..field.cells.len()).filter(|row| field.cells.number(*row).is_some()).count());
    if estimated == 0 {
        return String::new();
    }
    let (rows, of) = (view.results.rows(), if estimated == 1 { "is an estimate" } else { "are estimates" });
    // The script counts again for the points that are shown.
    format!(
        "<p class=\"read\" id=\"estimates\"><span>{estimated} of {} {of}</span>: a part of the tiles was simulated cycle by cycle \
         (detail_fraction), and times, energies and what follows from them reach as far as what stands behind ±, with a probability \
         of 95 %. Rays, samples and pictures are exact.</p>\n",
        counted(rows, "point")
    )
}

/// How many points no cycle was simulated of, and what that means.
fn counts(view: &SweepView<'_>) -> String {
    let (counted_only, rows) = (counted_only(view.results), view.results.rows());
    if counted_only == 0 {
        return String::new();
    }
    let of = if counted_only == 1 { "is" } else { "are" };
    // The script counts these again, too.
    format!(
        "<p class=\"read\" id=\"counts\"><span>{counted_only} of {} {of}</span> of <code>--detail counts</code>: no cycle was simulated. Their energies lack leakage, \
         clocks and what waiting costs, so they rank no machines, and are no match for those of other points.</p>\n",
        counted(rows, "point")
    )
}

/// What varies.
fn axes(view: &SweepView<'_>) -> String {
    if view.dimensions.is_empty() {
        return String::new();
    }
    let columns = [Head::words("Axis"), Head::number("Values"), Head::words("Which"), Head::words("What it is")];
    let rows = view.dimensions.iter().map(|dimension| {
        let (few, more) = dimension.values.split_at(dimension.values.len().min(12));
        let more = if more.is_empty() { String::new() } else { format!(" and {} more", more.len()) };
        let cells = vec![
            escape(&dimension.name),
            dimension.values.len().to_string(),
            escape(&(few.join(", ") + &more)),
            escape(&dimension.description),
        ];
        (String::new(), cells)
    });
    table("What varies", &columns, &rows.collect::<Vec<_>>())
}

/// Points without results.
fn failures(view: &SweepView<'_>) -> String {
    let failed: Vec<(usize, String)> =
        (0..view.results.rows()).filter_map(|row| Some((row, view.error(row)?))).collect();
    if failed.is_empty() {
        return String::new();
    }
    let columns = [Head::number("Point"), Head::words("What"), Head::words("Why")];
    let row = |(row, why): &(usize, String)| {
        (String::new(), vec![escape(&view.number(*row)), escape(&view.describe(*row, None)), escape(why)])
    };
    let some: Vec<_> = failed.iter().take(50).map(row).collect();
    let more = if failed.len() > some.len() { format!(" The first {} are shown.", some.len()) } else { String::new() };
    let read = format!(
        "{} could not be computed; {} in no chart.{more}",
        counted(failed.len(), "point"),
        if failed.len() == 1 { "it stands" } else { "they stand" }
    );
    table("Points that failed", &columns, &some) + &how_to_read(&read)
}

/// Cells of a point in its group: its dimensions, then some results.
pub fn cells(view: &SweepView<'_>, row: usize, results: &[&Field]) -> Vec<String> {
    let dimensions = view.dimensions.iter().enumerate().filter(|(index, _)| Some(*index) != view.each);
    let dimensions =
        dimensions.map(|(_, dimension)| or_dash(dimension.of[row], |value| escape(&dimension.values[value])));
    let result = |field: &&Field| escape(&view.shown(field, row)) + &within(view, field, row);
    dimensions.chain(results.iter().map(result)).collect()
}
