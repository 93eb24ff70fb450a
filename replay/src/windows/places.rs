//! Which parts of a frame are simulated: its beginning, its end, and windows between them.
//!
//! The choice depends on the number of tiles, the machine's tile slots and the share asked for, and on nothing else: runs of
//! several policies have their windows at the same places of the picture, so that what these share cancels in ratios. Beginning
//! and end are always simulated: at the beginning the machine is empty and its caches are cold, at the end it drains.

use crate::detail::Detail;

/// Fewer windows than this tell too little about one another.
const FEWEST_WINDOWS: usize = 20;
/// What a window measures, in tiles. Work of many short windows tells more than the same work in few long ones, for neighbours
/// are alike; but a window has to be longer than what is under way at its ends.
const LENGTH: f64 = 2.0;
/// Work before a window that is simulated and not measured, in tiles: until the machine is as full as it was.
const WARM_UP: f64 = 0.75;
/// Tiles given when the warm-up of the end begins, before the last one.
const BEFORE_END: usize = 2;
/// More of the tiles than this, warm-up included, are not worth a sample: the frame is simulated whole.
const WORTH: f64 = 0.6;
/// Where all is simulated: tiles of a window for each slot of the machine, and tiles of its warm-up. Each seam between two
/// windows costs accuracy, and the warm-up of each costs time; but the tiles of a window are in memory together.
const LONG_WINDOW: usize = 16;
const LONG_WARM_UP: usize = 2;

/// How far something goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Until {
    /// As much work as so many tiles have: as many of the mean of those that the machine got last.
    Work(f64),
    /// The machine has room for a tile, and had so many before.
    Tile(usize),
    /// All is done.
    End,
}

/// Where a window lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Its warm-up begins when the machine has room for a tile and had so many before,
    pub begin: usize,
    /// and so much later, as a part of the work of a tile. Windows that all began with a tile would know too much about the
    /// beginnings of tiles.
    pub delay: f64,
    /// Where the warm-up ends and the measurement begins.
    pub warm_up: Until,
    /// Where the measurement ends.
    pub end: Until,
    /// It stands for itself and for nothing else.
    pub is_certain: bool,
}

/// The windows of a frame, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    list: Vec<Place>,
    slots: usize,
}

impl Places {
    /// The windows of a frame of `tiles` tiles on a machine with `slots` tile slots; nothing where the frame is to be simulated
    /// whole. `share` is the part of the tiles to be measured.
    pub fn sample(tiles: usize, slots: usize, share: f64) -> Option<Self> {
        let windows = ((share * tiles as f64 / LENGTH).round() as usize).max(FEWEST_WINDOWS);
        let simulated = windows as f64 * (LENGTH + WARM_UP) + 2.0 * slots as f64;
        if simulated > WORTH * tiles as f64 {
            return None;
        }
        let (first, last) = (slots + 1, tiles - (LENGTH + WARM_UP).ceil() as usize - 1);
        let start = Place { begin: 0, delay: 0.0, warm_up: Until::Work(0.0), end: Until::Work(slots as f64 / 2.0), is_certain: true };
        let end = Place { begin: tiles - BEFORE_END, warm_up: Until::Tile(tiles), end: Until::End, ..start };
        let window = |i: usize| Place {
            // In the middle of equal parts.
            begin: first + (2 * i + 1) * (last - first) / (2 * windows),
            // Multiples of the golden ratio are spread evenly, however many there are.
            delay: (i as f64 * 0.618_033_988_749_895).fract(),
            warm_up: Until::Work(WARM_UP),
            end: Until::Work(LENGTH),
            is_certain: false,
        };
        let list = std::iter::once(start).chain((0..windows).map(window)).chain([end]).collect();
        Some(Self { list, slots })
    }

    /// Windows that follow one another, so that all tiles are simulated; nothing for a frame that is too small.
    pub fn all(tiles: usize, slots: usize) -> Option<Self> {
        let length = slots.max(4) * LONG_WINDOW;
        let windows = tiles / length;
        let window = |i: usize| {
            let begin = i * length;
            let end = if i + 1 == windows { Until::End } else { Until::Tile(begin + length) };
            let (warm_up, delay) = (Until::Tile(begin), 0.0);
            Place { begin: begin.saturating_sub(LONG_WARM_UP * slots), delay, warm_up, end, is_certain: true }
        };
        (windows >= 2).then(|| Self { list: (0..windows).map(window).collect(), slots })
    }

    /// The windows of what a frame is to be simulated with, as [`Places::sample`] or [`Places::all`].
    pub fn of(detail: Detail, tiles: usize, slots: usize) -> Option<Self> {
        match detail {
            Detail::Full | Detail::Counts => None,
            Detail::All => Self::all(tiles, slots),
            Detail::Sampled(share) => Self::sample(tiles, slots, share.fraction()),
            Detail::Precision(_) => Self::sample(tiles, slots, 0.0),
        }
    }

    /// As these, but more of them by this factor; nothing if that is too many.
    pub fn more(&self, tiles: usize, factor: f64) -> Option<Self> {
        let windows = factor * (self.list.len() - 2) as f64;
        Self::sample(tiles, self.slots, windows.ceil() * LENGTH / tiles as f64)
    }

    /// The windows, in order.
    pub fn list(&self) -> &[Place] {
        &self.list
    }

    /// Tile slots of the machine.
    pub fn slots(&self) -> usize {
        self.slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn windows_are_as_many_as_asked_for_and_evenly_spread() {
        let places = Places::sample(8192, 8, 0.05).unwrap();
        assert_eq!(places.list.len(), 205 + 2);
        let begins: Vec<usize> = places.list.iter().map(|place| place.begin).collect();
        let steps: Vec<usize> = begins[1..begins.len() - 1].windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.iter().all(|step| (39..=41).contains(step)), "{steps:?}");
        let delays = places.list[1..206].iter().map(|place| place.delay);
        assert!((delays.sum::<f64>() / 205.0 - 0.5).abs() < 0.01);
        assert_eq!((begins[0], begins[206]), (0, 8190));
    }

    #[test]
    fn small_frames_are_simulated_whole() {
        assert_eq!(Places::sample(64, 8, 0.1), None);
        assert_eq!(Places::sample(2048, 8, 0.5), None, "with warm-up that is all of it");
        assert!(Places::sample(512, 8, 0.1).is_some());
        assert_eq!(Places::all(64, 8), None);
    }

    #[test]
    fn where_all_is_simulated_one_window_follows_the_other() {
        let places = Places::all(2050, 8).unwrap();
        assert_eq!(places.list.len(), 16);
        for pair in places.list.windows(2) {
            assert_eq!(pair[0].end, pair[1].warm_up);
        }
        assert_eq!((places.list[0].warm_up, places.list[15].end), (Until::Tile(0), Until::End));
    }
}
