//! Clock domains: where an edge of one clock lies among the edges of another.
//!
//! All clocks start together at cycle 0 and have whole megahertz, so cycle `c` of a clock of `f` MHz is at `c / f` microseconds
//! and every conversion is an exact integer division.

use super::Cycle;

/// The way from one clock domain into another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crossing {
    from: u64,
    to: u64,
    sync: Cycle,
}

impl Crossing {
    /// From a clock of `from_mhz` into one of `to_mhz`, through a synchroniser of `sync_cycles` of the receiving clock.
    ///
    /// # Panics
    /// When a clock is 0 MHz.
    pub fn new(from_mhz: u32, to_mhz: u32, sync_cycles: u32) -> Self {
        assert!(from_mhz > 0 && to_mhz > 0, "a clock has at least 1 MHz");
        let divisor = gcd(from_mhz, to_mhz);
        Self { from: (from_mhz / divisor).into(), to: (to_mhz / divisor).into(), sync: sync_cycles.into() }
    }

    /// What leaves at `cycle` is seen at this cycle of the receiving clock: its first edge that is not earlier, plus the
    /// synchroniser.
    #[inline]
    pub fn arrive(&self, cycle: Cycle) -> Cycle {
        self.ceil(cycle) + self.sync
    }

    /// The first cycle of the receiving clock that is not earlier than `cycle`.
    #[inline]
    pub fn ceil(&self, cycle: Cycle) -> Cycle {
        match cycle.checked_mul(self.to) {
            Some(product) => product.div_ceil(self.from),
            None => saturate((u128::from(cycle) * u128::from(self.to)).div_ceil(u128::from(self.from))),
        }
    }

    /// The last cycle of the receiving clock that is not later than `cycle`.
    #[inline]
    pub fn floor(&self, cycle: Cycle) -> Cycle {
        match cycle.checked_mul(self.to) {
            Some(product) => product / self.from,
            None => saturate(u128::from(cycle) * u128::from(self.to) / u128::from(self.from)),
        }
    }
}

/// Times beyond the last cycle are never.
fn saturate(cycle: u128) -> Cycle {
    Cycle::try_from(cycle).unwrap_or(Cycle::MAX)
}

fn gcd(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_edge_meets_the_first_edge_that_is_not_earlier() {
        for (from, to) in [(500, 1600), (1600, 500), (1000, 500), (500, 1000), (533, 1600), (1600, 533), (500, 500)] {
            let crossing = Crossing::new(from, to, 0);
            for cycle in (0..3000).chain([1 << 40, (1 << 40) + 1, u64::MAX / 8]) {
                let at = u128::from(cycle) * u128::from(to);
                let (ceil, floor) = (u128::from(crossing.ceil(cycle)), u128::from(crossing.floor(cycle)));
                let from = u128::from(from);
                assert!(ceil * from >= at && (ceil == 0 || (ceil - 1) * from < at), "{from} -> {to}, {cycle}");
                assert!(floor * from <= at && (floor + 1) * from > at, "{from} -> {to}, {cycle}");
            }
        }
    }

    #[test]
    fn known_edges() {
        let down = Crossing::new(1600, 500, 2);
        assert_eq!([0, 1, 3, 4, 16, 17].map(|c| down.arrive(c)), [2, 3, 3, 4, 7, 8]);
        let up = Crossing::new(500, 1600, 1);
        assert_eq!([0, 1, 2, 5].map(|c| up.arrive(c)), [1, 5, 8, 17]);
        assert_eq!(up.ceil(Cycle::MAX), Cycle::MAX);
        let srp = Crossing::new(1000, 500, 0);
        assert_eq!([0, 1, 2, 3].map(|c| srp.arrive(c)), [0, 1, 1, 2]);
        assert_eq!([0, 1, 2, 3].map(|c| srp.floor(c)), [0, 0, 1, 1]);
    }
}
