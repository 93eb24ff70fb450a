//! Which tiles the slots of the cores held, from when to when.

use std::collections::BTreeMap;

use crate::time::TiCycle;

/// Stays kept at most; half of the tiles remain after thinning.
const STAYS_MAX: usize = 1 << 15;

/// A slot: core, number in it.
pub type Place = (usize, usize);

/// A tile in a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stay {
    /// Where.
    pub place: Place,
    /// Number of the tile in its frame.
    pub tile: u32,
    /// From when.
    pub begin: TiCycle,
    /// To when.
    pub end: TiCycle,
}

/// The stays so far. When there are too many, every second tile is forgotten, so memory and file stay small.
#[derive(Clone, Debug)]
pub struct Stays {
    open: BTreeMap<Place, (u32, TiCycle)>,
    done: Vec<Stay>,
    /// Tiles whose number is a multiple of it are kept.
    every: u32,
}

impl Stays {
    /// None yet.
    pub fn new() -> Self {
        Self { open: BTreeMap::new(), done: Vec::new(), every: 1 }
    }

    /// At cycle `at` the slots hold these tiles, and no other slot does.
    pub fn look(&mut self, at: TiCycle, held: impl Iterator<Item = (Place, u32)>) {
        let before = std::mem::take(&mut self.open);
        for (place, tile) in held {
            let begin = before.get(&place).filter(|(old, _)| *old == tile).map_or(at, |(_, begin)| *begin);
            self.open.insert(place, (tile, begin));
        }
        for (place, (tile, begin)) in before {
            if self.open.get(&place).is_none_or(|(now, _)| *now != tile) && tile.is_multiple_of(self.every) {
                self.done.push(Stay { place, tile, begin, end: at });
            }
        }
        if self.done.len() > STAYS_MAX {
            self.every *= 2;
            self.done.retain(|stay| stay.tile.is_multiple_of(self.every));
        }
    }

    /// The stays that are over, by place and time.
    pub fn done(&self) -> Vec<Stay> {
        let mut done = self.done.clone();
        done.sort_by_key(|stay| (stay.place, stay.begin.0));
        done
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stay_goes_from_the_first_look_to_the_first_that_misses_it() {
        let mut stays = Stays::new();
        let looks: [(u64, &[(usize, u32)]); 4] =
            [(0, &[(0, 7)]), (10, &[(0, 7), (1, 8)]), (20, &[(0, 9), (1, 8)]), (30, &[])];
        for (at, held) in looks {
            stays.look(TiCycle(at), held.iter().map(|(slot, tile)| ((0, *slot), *tile)));
        }
        let stay = |slot, tile, begin, end| Stay { place: (0, slot), tile, begin: TiCycle(begin), end: TiCycle(end) };
        assert_eq!(stays.done(), [stay(0, 7, 0, 20), stay(0, 9, 20, 30), stay(1, 8, 10, 30)]);
    }

    #[test]
    fn of_many_every_second_is_kept() {
        let mut stays = Stays::new();
        for at in 0..STAYS_MAX as u32 * 3 {
            stays.look(TiCycle(at.into()), [((0, 0), at)].into_iter());
        }
        let done = stays.done();
        assert!(done.len() <= STAYS_MAX && done.len() > STAYS_MAX / 4, "{}", done.len());
        assert!(done.iter().all(|stay| stay.tile.is_multiple_of(4)));
    }
}
