//! Probes put together, and one that tells how far a run is.

use crate::system::{Core, Probe};
use crate::time::{TiCycle, When};

/// Cycles between two looks of [`Watch`]. A few hundred looks a second of computing time.
const WATCH_CYCLES: u64 = 8192;

/// Tells how many tiles of the frame are done.
#[derive(Debug)]
pub struct Watch<F> {
    tell: F,
    due: When,
}

impl<F: FnMut(u64)> Watch<F> {
    /// Calls `tell` with the tiles done so far, from time to time.
    pub fn new(tell: F) -> Self {
        Self { tell, due: When::at(TiCycle(0)) }
    }
}

impl<F: FnMut(u64)> Probe for Watch<F> {
    fn begin(&mut self, _: u32) {
        self.due = When::at(TiCycle(0));
    }

    fn passed(&mut self, tiles: u64) {
        (self.tell)(tiles);
    }

    fn due(&self) -> When {
        self.due
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], _: u64) {
        self.due = When::at(now + WATCH_CYCLES);
        (self.tell)(cores.iter().map(|core| core.srp.tiles_done()).sum());
    }
}

/// A probe, or none.
impl<P: Probe> Probe for Option<P> {
    fn begin(&mut self, frame: u32) {
        self.iter_mut().for_each(|probe| probe.begin(frame));
    }

    fn passed(&mut self, tiles: u64) {
        self.iter_mut().for_each(|probe| probe.passed(tiles));
    }

    fn due(&self) -> When {
        self.as_ref().map_or(When::NEVER, Probe::due)
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        self.iter_mut().for_each(|probe| probe.look(now, cores, bytes));
    }
}

/// Two probes. Both look whenever one of them is due, so each gets looks that it did not ask for.
impl<A: Probe, B: Probe> Probe for (A, B) {
    fn begin(&mut self, frame: u32) {
        self.0.begin(frame);
        self.1.begin(frame);
    }

    fn passed(&mut self, tiles: u64) {
        self.0.passed(tiles);
        self.1.passed(tiles);
    }

    fn due(&self) -> When {
        self.0.due().min(self.1.due())
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        self.0.look(now, cores, bytes);
        self.1.look(now, cores, bytes);
    }
}

impl<P: Probe> Probe for &mut P {
    fn begin(&mut self, frame: u32) {
        (**self).begin(frame);
    }

    fn passed(&mut self, tiles: u64) {
        (**self).passed(tiles);
    }

    fn due(&self) -> When {
        (**self).due()
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        (**self).look(now, cores, bytes);
    }
}
