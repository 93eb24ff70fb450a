//! A cycle of each clock.

use std::fmt;
use std::ops::{Add, AddAssign, Sub};

/// A cycle of some clock.
pub trait ClockCycle: Copy + Ord + fmt::Debug + Add<u64, Output = Self> + Sub<Output = u64> {
    /// The first cycle.
    const START: Self;
    /// After the last cycle: what `When::NEVER` is made of.
    const END: Self;

    /// Cycle `number`, counted from 0.
    fn new(number: u64) -> Self;

    /// Its number.
    fn number(self) -> u64;
}

macro_rules! clocks {
    ($($(#[$doc:meta])* $name:ident;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        #[repr(transparent)]
        pub struct $name(pub u64);

        impl ClockCycle for $name {
            const START: Self = Self(0);
            const END: Self = Self(u64::MAX);

            #[inline]
            fn new(number: u64) -> Self {
                Self(number)
            }

            #[inline]
            fn number(self) -> u64 {
                self.0
            }
        }

        impl $name {
            /// Cycles since `earlier`; 0 if that is later.
            #[inline]
            pub fn since(self, earlier: Self) -> u64 {
                self.0.saturating_sub(earlier.0)
            }
        }

        impl Add<u64> for $name {
            type Output = Self;

            #[inline]
            fn add(self, cycles: u64) -> Self {
                Self(self.0 + cycles)
            }
        }

        impl AddAssign<u64> for $name {
            #[inline]
            fn add_assign(&mut self, cycles: u64) {
                self.0 += cycles;
            }
        }

        impl Sub for $name {
            type Output = u64;

            #[inline]
            fn sub(self, earlier: Self) -> u64 {
                self.0 - earlier.0
            }
        }

        impl fmt::Display for $name {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                self.0.fmt(f)
            }
        }

        #[cfg(test)]
        impl PartialEq<u64> for $name {
            fn eq(&self, number: &u64) -> bool {
                self.0 == *number
            }
        }
    )*};
}

clocks! {
    /// A cycle of the T&I clock, in which the machine as a whole counts.
    TiCycle;
    /// A cycle of the SRP clock.
    SrpCycle;
    /// A cycle of the DRAM clock, tCK.
    DramCycle;
}
