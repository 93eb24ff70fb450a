//! Something of which there is only so much in a cycle.

use crate::time::TiCycle;

/// How much of it was used in the cycle at hand.
#[derive(Clone, Copy, Debug, Default)]
pub struct PerCycle {
    cycle: Option<TiCycle>,
    used: u64,
}

impl PerCycle {
    /// What was used in cycle `now`, which is not before the cycle of the call before.
    #[inline]
    pub fn used(&mut self, now: TiCycle) -> &mut u64 {
        if self.cycle != Some(now) {
            (self.cycle, self.used) = (Some(now), 0);
        }
        &mut self.used
    }
}
