//! What a figure is: which way it is better, how frames add up, what stands under its key.

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
    /// [`ByKind`](super::ByKind): a column for each kind of ray and each of its parts.
    ByKind,
    /// [`RunCost`](super::RunCost) of this part of the machine: columns `KEY_NAME`, described as "part: meaning".
    Costs(&'static str),
    /// What the machine counted: columns of their names, described by the machine.
    Counters,
    /// The components of the energy: two columns each, [`COMPONENT_PARTS`](super::COMPONENT_PARTS).
    Components,
    /// Nothing that is a column of figures.
    Listing,
}
