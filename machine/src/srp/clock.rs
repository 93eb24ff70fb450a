//! SRP time and T&I time, converted exactly.

use crate::config::MachineConfig;
use crate::time::{ClockCycle, Crossing, SrpCycle, TiCycle};

/// SRP cycles of a run that ends before T&I cycle `end`.
pub fn srp_cycles(config: &MachineConfig, end: TiCycle) -> u64 {
    Clock::new(config).srp(end) - SrpCycle::START
}

/// The ratio of the two clocks. SRP cycle `s` begins at T&I time `s * ti / srp`.
#[derive(Clone, Copy, Debug)]
pub struct Clock {
    to_srp: Crossing<TiCycle, SrpCycle>,
    to_ti: Crossing<SrpCycle, TiCycle>,
}

impl Clock {
    /// The clocks of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let (srp, ti) = (config.srp.clock_mhz.max(1), config.ti.clock_mhz.max(1));
        Self { to_srp: Crossing::new(ti, srp, 0), to_ti: Crossing::new(srp, ti, 0) }
    }

    /// The first SRP cycle that begins at or after the beginning of T&I cycle `ti`.
    #[inline]
    pub fn srp(self, ti: TiCycle) -> SrpCycle {
        self.to_srp.ceil(ti)
    }

    /// The first T&I cycle that begins at or after the beginning of SRP cycle `srp`.
    #[inline]
    pub fn ti(self, srp: SrpCycle) -> TiCycle {
        self.to_ti.ceil(srp)
    }

    /// SRP cycles that begin within T&I cycle `ti`.
    #[inline]
    pub fn srp_cycles_of(self, ti: TiCycle) -> u64 {
        self.srp(ti + 1) - self.srp(ti)
    }
}
