//! Probes put together, and one that tells how far a run is.

use super::memory::Cycle;
use super::system::{Core, Probe};

/// Cycles between two looks of [`Watch`]. A few hundred looks a second of computing time.
const WATCH_CYCLES: Cycle = 8192;

/// Tells how many tiles of the frame are done.
#[derive(Debug)]
pub struct Watch<F> {
    tell: F,
    due: Cycle,
}

impl<F: FnMut(u64)> Watch<F> {
    /// Calls `tell` with the tiles done so far, from time to time.
    pub fn new(tell: F) -> Self {
        Self { tell, due: 0 }
    }
}

impl<F: FnMut(u64)> Probe for Watch<F> {
    fn begin(&mut self, _: u32) {
        self.due = 0;
    }

    fn due(&self) -> Cycle {
        self.due
    }

    fn look(&mut self, now: Cycle, cores: &[Core], _: u64) {
        self.due = now + WATCH_CYCLES;
        (self.tell)(cores.iter().map(|core| core.srp.stats().local.tiles).sum());
    }
}

/// A probe, or none.
impl<P: Probe> Probe for Option<P> {
    fn begin(&mut self, frame: u32) {
        self.iter_mut().for_each(|probe| probe.begin(frame));
    }

    fn due(&self) -> Cycle {
        self.as_ref().map_or(Cycle::MAX, Probe::due)
    }

    fn look(&mut self, now: Cycle, cores: &[Core], bytes: u64) {
        self.iter_mut().for_each(|probe| probe.look(now, cores, bytes));
    }
}

/// Both probes; each also sees the other's looks.
impl<A: Probe, B: Probe> Probe for (A, B) {
    fn begin(&mut self, frame: u32) {
        self.0.begin(frame);
        self.1.begin(frame);
    }

    fn due(&self) -> Cycle {
        self.0.due().min(self.1.due())
    }

    fn look(&mut self, now: Cycle, cores: &[Core], bytes: u64) {
        self.0.look(now, cores, bytes);
        self.1.look(now, cores, bytes);
    }
}

impl<P: Probe> Probe for &mut P {
    fn begin(&mut self, frame: u32) {
        (**self).begin(frame);
    }

    fn due(&self) -> Cycle {
        (**self).due()
    }

    fn look(&mut self, now: Cycle, cores: &[Core], bytes: u64) {
        (**self).look(now, cores, bytes);
    }
}
