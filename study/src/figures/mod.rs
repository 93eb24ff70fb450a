//! The figures of a report, declared once: name, unit, meaning, which way is better, and how frames add up.
//!
//! A figure is one line of [`table`](self::table). From that line come the field of the report, its description in JSON, the
//! columns of results, and the direction in which analyses and pages look for the best point. What the machine counts is declared
//! beside the code that counts (`counters!` of the machine) and stands under `counters`.

mod columns;
mod table;
#[cfg(test)]
mod tests;

pub use columns::{COMPONENT_PARTS, ComponentPart, FixedColumn, column, columns};
pub use table::{ByKind, Figure, RunCost, RunFigures, SamplingFigures, figures, is_key};

/// Which way a figure is better.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Better {
    /// More is better.
    More,
    /// Less is better.
    Less,
    /// Neither: it says what the work was, or which part of the picture is meant.
    Neither,
}

/// How the figure of several frames follows from those of each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OverFrames {
    /// It is their sum.
    Sum,
    /// It is their mean; all frames have the same number of pixels and tiles.
    Mean,
    /// It is made from the counts of all frames together, and from no frame's figure.
    Whole,
}

/// What stands under the key of a figure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    /// A value: it is a column of results under its name.
    Value,
    /// [`ByKind`]: a column for each kind of ray and each of its parts.
    ByKind,
    /// [`RunCost`] of this part of the machine: columns `KEY_NAME`, described as "part: meaning".
    Costs(&'static str),
    /// What the machine counted: columns of their names, described by the machine.
    Counters,
    /// The components of the energy: two columns each, [`COMPONENT_PARTS`].
    Components,
    /// Nothing that is a column of figures.
    Listing,
}
