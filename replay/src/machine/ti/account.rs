//! What an issue stage did in each cycle, kept as an array because it is written in every cycle.

use super::front::Waiting;
use crate::machine::counters::Activity;
use crate::machine::memory::Cycle;

/// The class of a cycle of a stage; see [`Activity`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Issued.
    Busy,
    /// Issued without work.
    Bypass,
    /// Waits for a lookup or the hit latency.
    Fetch,
    /// Waits for a line.
    Memory,
    /// A lookup is refused.
    Mshr,
    /// The stage behind is full.
    Blocked,
    /// Rays are here, none for this stage.
    Starved,
    /// No ray is here.
    Idle,
}

impl Slot {
    /// The class of a stage behind an input buffer that did not issue.
    #[inline]
    pub fn of(waiting: Waiting, rays: bool) -> Self {
        match waiting {
            Waiting::Fetch => Self::Fetch,
            Waiting::Memory => Self::Memory,
            Waiting::Refused => Self::Mshr,
            Waiting::Nothing if rays => Self::Starved,
            Waiting::Nothing => Self::Idle,
        }
    }
}

/// Cycles by class.
#[derive(Clone, Copy, Debug, Default)]
pub struct Account([Cycle; 8]);

impl Account {
    /// Counts `cycles` of a class.
    #[inline]
    pub fn add(&mut self, slot: Slot, cycles: Cycle) {
        self.0[slot as usize] += cycles;
    }

    /// Cycles in which an operation issued, bypasses not.
    #[inline]
    pub fn busy(&self) -> Cycle {
        self.0[Slot::Busy as usize]
    }

    /// The account as named counters.
    pub fn activity(self) -> Activity {
        let [busy, bypass, fetch, memory, mshr, blocked, starved, idle] = self.0;
        Activity { busy, bypass, fetch, memory, mshr, blocked, starved, idle }
    }
}
