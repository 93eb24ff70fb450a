//! When something happens next.

use std::fmt;

use super::cycle::{ClockCycle, TiCycle};

/// The cycle at which something happens next, or never. Of two the smaller is the earlier; never is the greatest.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[repr(transparent)]
pub struct When<C = TiCycle>(C);

impl<C: ClockCycle> When<C> {
    /// It does not happen.
    pub const NEVER: Self = Self(C::END);

    /// At `cycle`.
    #[inline]
    pub fn at(cycle: C) -> Self {
        Self(cycle)
    }

    /// At `cycle` if there is a reason to, otherwise never.
    #[inline]
    pub fn only_if(reason: bool, cycle: C) -> Self {
        if reason { Self(cycle) } else { Self::NEVER }
    }

    /// The same, but not before the cycle that follows `now`.
    #[inline]
    pub fn after(self, now: C) -> Self {
        self.max(Self(now + 1))
    }

    /// Whether it is at `now` or was before.
    #[inline]
    pub fn is_due(self, now: C) -> bool {
        self.0 <= now
    }

    /// The cycle, if it is at `now` or was before.
    #[inline]
    pub fn due(self, now: C) -> Option<C> {
        self.is_due(now).then_some(self.0)
    }

    /// Whether it never happens.
    #[inline]
    pub fn is_never(self) -> bool {
        self == Self::NEVER
    }

    /// The cycle, if there is one.
    #[inline]
    pub fn cycle(self) -> Option<C> {
        (!self.is_never()).then_some(self.0)
    }
}

impl<C: ClockCycle> From<Option<C>> for When<C> {
    #[inline]
    fn from(cycle: Option<C>) -> Self {
        cycle.map_or(Self::NEVER, Self)
    }
}

impl<C: ClockCycle> fmt::Debug for When<C> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.cycle() {
            Some(cycle) => write!(f, "at {}", cycle.number()),
            None => f.write_str("never"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::cycle::DramCycle;
    use super::*;

    #[test]
    fn the_earlier_of_two_is_the_smaller_and_never_is_the_latest() {
        let (early, late) = (When::at(TiCycle(3)), When::at(TiCycle(5)));
        assert_eq!((early.min(late), late.min(When::NEVER), When::NEVER.min(early)), (early, late, early));
        assert!(When::<TiCycle>::NEVER.is_never() && !early.is_never());
        assert_eq!((early.cycle(), When::<TiCycle>::NEVER.cycle()), (Some(TiCycle(3)), None));
    }

    #[test]
    fn what_was_due_happens_in_the_next_cycle_and_never_stays_never() {
        let now = TiCycle(7);
        assert_eq!(When::at(TiCycle(3)).after(now), When::at(TiCycle(8)));
        assert_eq!(When::at(TiCycle(9)).after(now), When::at(TiCycle(9)));
        assert!(When::NEVER.after(now).is_never());
        assert!(When::at(now).is_due(now) && !When::at(now + 1).is_due(now) && !When::NEVER.is_due(now));
        assert_eq!((When::at(now).due(now), When::at(now + 1).due(now)), (Some(now), None));
        assert_eq!(When::only_if(false, now), When::NEVER);
        assert_eq!(
            (format!("{:?}", When::at(now)), format!("{:?}", When::<TiCycle>::NEVER)),
            ("at 7".into(), "never".into())
        );
    }

    #[test]
    fn a_cycle_is_as_large_as_a_number() {
        assert_eq!([size_of::<TiCycle>(), size_of::<When>(), size_of::<When<DramCycle>>()], [8; 3]);
        assert_eq!((DramCycle(9) - DramCycle(4), DramCycle(4).since(DramCycle(9))), (5, 0));
    }
}
