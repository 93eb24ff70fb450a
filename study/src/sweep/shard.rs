//! Which points a shard does.

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

/// Part `index` of `count`, from 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    /// Which, from 0.
    pub index: usize,
    /// Of how many.
    pub count: usize,
}

impl Shard {
    /// All points.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// The points it does: consecutive ones, so that it needs few traces. The shards of any `count` cover all points once, and
    /// their sizes differ by one at most.
    pub fn points(self, total: usize) -> Range<usize> {
        let cut = |i: usize| (total as u128 * i as u128 / self.count as u128) as usize;
        cut(self.index)..cut(self.index + 1)
    }

    /// Which of `count` shards have one of these points, given in order, of `total`.
    pub fn with(points: &[usize], total: usize, count: usize) -> Vec<usize> {
        // The last one that does not begin behind the point. There may be far more shards than points.
        let of = |point: &usize| ((*point as u128 + 1) * count as u128).div_ceil(total as u128) as usize - 1;
        let mut shards: Vec<usize> = points.iter().map(of).collect();
        shards.dedup();
        shards
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("{text:?} is no shard; write i/n with i below n, such as 0/8, or auto/8");
        let (index, count) = text.split_once('/').ok_or_else(wrong)?;
        let (index, count) = (index.parse().map_err(|_| wrong())?, count.parse().map_err(|_| wrong())?);
        if index < count { Ok(Self { index, count }) } else { Err(wrong()) }
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index, self.count)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn shards_cover_all_points_once(total in 0usize..5000, count in 1usize..300) {
            let mut next = 0;
            for index in 0..count {
                let points = Shard { index, count }.points(total);
                prop_assert_eq!(points.start, next);
                prop_assert!(points.len() >= total / count && points.len() <= total / count + 1);
                for point in points.clone() {
                    prop_assert_eq!(Shard::with(&[point], total, count), [index]);
                }
                next = points.end;
            }
            prop_assert_eq!(next, total);
        }
    }

    #[test]
    fn shards_with_points_are_found() {
        assert_eq!(Shard::with(&[0, 11, 12, 95], 96, 8), [0, 1, 7]);
        assert_eq!(Shard::with(&[], 96, 8), [0usize; 0]);
        // More shards than points: some have none.
        assert_eq!(Shard::with(&[0, 1, 2], 3, 8).len(), 3);
        // As a stranger's record may have it.
        assert_eq!(Shard::with(&[2], 3, usize::MAX), [usize::MAX - 1]);
    }

    #[test]
    fn shards_are_written_as_fractions() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, count: 8 }));
        for bad in ["8/8", "1", "a/2", "1/0", "-1/2"] {
            assert!(bad.parse::<Shard>().unwrap_err().contains("is no shard"), "{bad}");
        }
    }
}
