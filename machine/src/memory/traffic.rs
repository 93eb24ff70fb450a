//! Bytes at the DRAM by what they are for.

use crate::work::layout::Region;

/// Bytes at the DRAM by region, in the order of [`Region::ALL`]. Counted when the DRAM's queue takes the request.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes read.
    pub read: [u64; Region::ALL.len()],
    /// Bytes written.
    pub written: [u64; Region::ALL.len()],
}

impl Traffic {
    /// All bytes.
    pub fn total(&self) -> u64 {
        self.read.iter().chain(&self.written).sum()
    }
}

impl std::ops::AddAssign for Traffic {
    fn add_assign(&mut self, other: Self) {
        self.read.iter_mut().zip(other.read).for_each(|(sum, bytes)| *sum += bytes);
        self.written.iter_mut().zip(other.written).for_each(|(sum, bytes)| *sum += bytes);
    }
}
