//! The page of a sweep: its head and foot around its sections.

use crate::html::shell::Shell;
use crate::html::sweep::view::SweepView;
use crate::html::sweep::{best, columns, data, effects, explore, order, summary};
use crate::html::text::{count, counted, escape};
use crate::table::Results;

const STYLE: &str = include_str!("sweep.css");

/// The scripts; each uses those before it.
const SCRIPTS: &[&str] = &[
    include_str!("../script.js"),
    include_str!("js/data.js"),
    include_str!("js/text.js"),
    include_str!("js/dom.js"),
    include_str!("js/language.js"),
    include_str!("js/filter.js"),
    include_str!("js/summary.js"),
    include_str!("js/point.js"),
    include_str!("js/front.js"),
    include_str!("js/pareto.js"),
    include_str!("js/heat.js"),
    include_str!("js/effects.js"),
    include_str!("js/best.js"),
    include_str!("js/points.js"),
];

/// The whole page.
pub fn page(results: &Results) -> String {
    let view = SweepView::new(results);
    let sections = [
        summary::section(&view),
        order::section(&view),
        explore::pareto(),
        explore::heat(),
        effects::section(&view),
        best::section(&view),
        explore::points(),
        columns::section(&view),
    ];
    let sections: Vec<_> = sections.into_iter().flatten().collect();
    Shell {
        title: &format!("Sweep {}", results.heading.name),
        head: &head(&view),
        sections: &sections,
        foot: &foot(),
        style: STYLE,
        data: Some(("sweep-data", &data::data(&view))),
        scripts: SCRIPTS,
    }
    .html()
}

fn head(view: &SweepView<'_>) -> String {
    let heading = &view.results.heading;
    let (rows, failed) = (view.results.rows(), view.failed());
    let mut facts = vec![format!("plan {}", heading.plan)];
    facts.push(match rows {
        rows if rows == heading.points => counted(rows, "point"),
        rows => format!("{} of {}", count(rows as u64), counted(heading.points, "point")),
    });
    facts.push(if failed == 0 { "none failed".into() } else { format!("{} failed", count(failed as u64)) });
    facts.push(format!("model version {}", heading.model_version));
    let facts: String = facts.iter().map(|fact| format!("<li>{}</li>", escape(fact))).collect();
    format!(
        "<header>\n<div><h1>{}</h1>\n<ul class=\"facts\">{facts}</ul></div>\n\
         <button type=\"button\" id=\"theme\" hidden>Theme: system</button>\n</header>\n{}",
        escape(&heading.name),
        explore::FILTER
    )
}

fn foot() -> String {
    format!(
        "<footer><p>Written by rayreel {}. This file holds everything it shows and loads nothing. Results are kept to seven digits, or to as \
         many as tell them apart; the Parquet file has all.</p></footer>\n",
        env!("CARGO_PKG_VERSION")
    )
}
