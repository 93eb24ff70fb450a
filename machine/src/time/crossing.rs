//! Clock domains: where an edge of one clock lies among the edges of another.
//!
//! All clocks start together at cycle 0 and have whole megahertz, so cycle `c` of a clock of `f` MHz is at `c / f` microseconds
//! and every conversion is an exact integer division.

use std::marker::PhantomData;

use super::cycle::ClockCycle;
use super::when::When;

/// The way from clock domain `A` into clock domain `B`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing<A, B> {
    from: u64,
    to: u64,
    sync_cycles: u64,
    domains: PhantomData<(A, B)>,
}

impl<A: ClockCycle, B: ClockCycle> Crossing<A, B> {
    /// From a clock of `from_mhz` into one of `to_mhz`, through a synchroniser of `sync_cycles` of the receiving clock.
    ///
    /// # Panics
    /// When a clock is 0 MHz.
    pub fn new(from_mhz: u32, to_mhz: u32, sync_cycles: u32) -> Self {
        assert!(from_mhz > 0 && to_mhz > 0, "a clock has at least 1 MHz");
        let divisor = gcd(from_mhz, to_mhz);
        let (from, to) = ((from_mhz / divisor).into(), (to_mhz / divisor).into());
        Self { from, to, sync_cycles: sync_cycles.into(), domains: PhantomData }
    }

    /// What leaves at `cycle` is seen at this cycle of the receiving clock: its first edge that is not earlier, plus the
    /// synchroniser.
    #[inline]
    pub fn arrive(self, cycle: A) -> B {
        self.ceil(cycle) + self.sync_cycles
    }

    /// The first cycle of the receiving clock that is not earlier than `cycle`. A cycle beyond the last one is the last one.
    #[inline]
    pub fn ceil(self, cycle: A) -> B {
        match cycle.number().checked_mul(self.to) {
            Some(product) => B::new(div_ceil(product, self.from)),
            None => self.ceil_wide(cycle),
        }
    }

    /// When an event of the one clock lies in the other.
    #[inline]
    pub fn ceil_when(self, event: When<A>) -> When<B> {
        When::from(event.cycle().map(|cycle| self.ceil(cycle)))
    }

    #[cold]
    fn ceil_wide(self, cycle: A) -> B {
        saturate((u128::from(cycle.number()) * u128::from(self.to)).div_ceil(u128::from(self.from)))
    }

    /// The last cycle of the receiving clock that is not later than `cycle`.
    #[inline]
    pub fn floor(self, cycle: A) -> B {
        match cycle.number().checked_mul(self.to) {
            Some(product) => B::new(product / self.from),
            None => saturate(u128::from(cycle.number()) * u128::from(self.to) / u128::from(self.from)),
        }
    }
}

/// `a / b` rounded up. Divisions are slow and asked for at every event: the usual ratios of SRP and T&I clock are 1 and 2.
#[inline]
fn div_ceil(a: u64, b: u64) -> u64 {
    match b {
        1 => a,
        2 => a.div_ceil(2),
        _ => a.div_ceil(b),
    }
}

/// Times beyond the last cycle are never.
fn saturate<C: ClockCycle>(cycle: u128) -> C {
    u64::try_from(cycle).map_or(C::END, C::new)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::super::cycle::{DramCycle, SrpCycle, TiCycle};
    use super::*;

    #[test]
    fn each_edge_meets_the_first_edge_that_is_not_earlier() {
        for (from, to) in [(500, 1600), (1600, 500), (1000, 500), (500, 1000), (533, 1600), (1600, 533), (500, 500)] {
            let crossing = Crossing::<TiCycle, DramCycle>::new(from, to, 0);
            for cycle in (0..3000).chain([1 << 40, (1 << 40) + 1, u64::MAX / 8]) {
                let at = u128::from(cycle) * u128::from(to);
                let cycle = TiCycle(cycle);
                let (ceil, floor) = (u128::from(crossing.ceil(cycle).0), u128::from(crossing.floor(cycle).0));
                let from = u128::from(from);
                assert!(ceil * from >= at && (ceil == 0 || (ceil - 1) * from < at), "{from} -> {to}, {cycle}");
                assert!(floor * from <= at && (floor + 1) * from > at, "{from} -> {to}, {cycle}");
            }
        }
    }

    #[test]
    fn known_edges() {
        let down = Crossing::<DramCycle, TiCycle>::new(1600, 500, 2);
        assert_eq!([0, 1, 3, 4, 16, 17].map(|c| down.arrive(DramCycle(c)).0), [2, 3, 3, 4, 7, 8]);
        let up = Crossing::<TiCycle, DramCycle>::new(500, 1600, 1);
        assert_eq!([0, 1, 2, 5].map(|c| up.arrive(TiCycle(c)).0), [1, 5, 8, 17]);
        assert_eq!(up.ceil(TiCycle::END), DramCycle::END);
        let srp = Crossing::<SrpCycle, TiCycle>::new(1000, 500, 0);
        assert_eq!([0, 1, 2, 3].map(|c| srp.arrive(SrpCycle(c)).0), [0, 1, 1, 2]);
        assert_eq!([0, 1, 2, 3].map(|c| srp.floor(SrpCycle(c)).0), [0, 0, 1, 1]);
    }
}
