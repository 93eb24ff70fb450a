//! SRP time and T&I time, converted exactly.

use crate::config::MachineConfig;
use crate::memory::Cycle;

/// The ratio of the two clocks. SRP cycle `s` begins at T&I time `s * ti / srp`.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    srp: u64,
    ti: u64,
}

impl Clock {
    /// The clocks of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let (srp, ti) = (config.srp.clock_mhz.max(1), config.ti.clock_mhz.max(1));
        let divisor = gcd(srp, ti);
        Self { srp: u64::from(srp / divisor), ti: u64::from(ti / divisor) }
    }

    /// The first SRP cycle that begins at or after the beginning of T&I cycle `ti`.
    #[inline]
    pub fn srp(self, ti: Cycle) -> u64 {
        ceil(ti * self.srp, self.ti)
    }

    /// The first T&I cycle that begins at or after the beginning of SRP cycle `srp`.
    #[inline]
    pub fn ti(self, srp: u64) -> Cycle {
        ceil(srp * self.ti, self.srp)
    }

    /// SRP cycles that begin within T&I cycle `ti`.
    #[inline]
    pub fn srp_cycles_of(self, ti: Cycle) -> u64 {
        self.srp(ti + 1) - self.srp(ti)
    }
}

/// `a / b` rounded up. Divisions are slow and asked for at every event: the usual ratios are 1 and 2.
#[inline]
fn ceil(a: u64, b: u64) -> u64 {
    match b {
        1 => a,
        2 => a.div_ceil(2),
        _ => a.div_ceil(b),
    }
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}
