//! What a probe and the table that it fills have to do with each other.

use rayreel_machine::system::Probe;

use crate::schema::Batch;

/// A probe that makes rows of a table.
pub trait TableProbe: Probe {
    /// Rows since the last [`TableProbe::batch`].
    fn rows(&self) -> usize;
    /// These rows.
    fn batch(&mut self) -> Batch;
}
