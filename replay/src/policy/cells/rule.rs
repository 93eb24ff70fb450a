//! What differs from one policy of cells to the other.

use super::cell::Cell;
use rayreel_machine::work::PolicyReads;

/// What is traced of a cell, and what the rest of it is made of.
pub trait CellRule: Clone + Send + Sync + 'static {
    /// It looks at hits below the primary ones.
    fn deep(&self) -> bool {
        false
    }

    /// What it reads of hits beside their colours.
    fn reads(&self) -> PolicyReads;

    /// Decides all samples that the cell owns beside its R-sample.
    fn decide(&self, cell: &mut Cell<'_>);
}

/// A policy that looks at colours alone.
pub const COLOURS: PolicyReads = PolicyReads { object: false, normal: false, shadow: false, ..PolicyReads::PAPER };
