//! The figures of a report, declared once: name, unit, meaning, which way is better, and how frames add up.
//!
//! A figure is one line of `table.rs`. From that line come the field of the report, its description in JSON, the
//! columns of results, and the direction in which analyses and pages look for the best point. What the machine counts is declared
//! beside the code that counts (`counters!` of the machine) and stands under `counters`.

mod columns;
mod kinds;
mod table;
#[cfg(test)]
mod tests;

pub use columns::{COMPONENT_PARTS, ComponentPart, FixedColumn, column, columns};
pub use kinds::{Better, Form, OverFrames};
pub use table::{ByKind, Figure, RunCost, RunFigures, SamplingFigures, figures, is_key};
