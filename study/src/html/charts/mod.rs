//! Charts as SVG. They are drawn here and not in the browser: the same study gives the same bytes, and the page prints and
//! reads without a script. Colours are classes, so that light, dark and print each choose their own.

pub mod bars;
pub mod chart;
pub mod file;
pub mod gallery;
pub mod lines;
pub mod scale;
pub mod scatter;
pub mod stacked;
pub mod svg;

/// Width that charts are drawn at, units; text of 12 units stays readable when a phone shrinks it a little.
pub const WIDTH: f64 = 360.0;
