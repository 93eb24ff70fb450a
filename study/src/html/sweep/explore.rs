//! The sections that only a script fills: charts and the table of all points.

use crate::html::parts::Section;

/// The filter, which all that scripts draw obeys.
pub const FILTER: &str = include_str!("filter.html");

/// The scatter plot with its front, and the point that was chosen.
pub fn pareto() -> Option<Section> {
    Section::new("pareto", "Pareto front", include_str!("pareto.html").into())
}

/// The heat map.
pub fn heat() -> Option<Section> {
    Section::new("heat", "Heat map", include_str!("heat.html").into())
}

/// The table.
pub fn points() -> Option<Section> {
    Section::new("points", "Points", include_str!("points.html").into())
}
