//! Which parts of a frame are simulated: its beginning, its end, and windows between them.
//!
//! Places are given in tiles that are done, parts of tiles included, and chosen in work ([`WorkLine`]): every ray is as likely to lie in a
//! window as any other. The choice depends on the tiles and their rays, the machine's tile slots and the share asked for, and on
//! nothing else: runs of several policies have their windows at the same places of the picture, so that what these share cancels
//! in ratios. Beginning and end are always simulated: at the beginning the machine is empty and its caches are cold, at the end
//! it drains.

use super::work_line::WorkLine;
use crate::detail::Detail;

/// Fewer windows than this tell too little about one another.
const FEWEST_WINDOWS: usize = 24;
/// What a window measures, in tiles: the less the fewer tiles there are. Work of many short windows tells more than the same work
/// in few long ones, for neighbours are alike; but a window has to be longer than what is under way at its ends.
const LENGTH: (f64, f64) = (2.0, 4.0);
/// What is simulated before a window and not measured, in tiles, of the shortest windows and of the longest: until the machine is as full as it
/// was. What is still missing then falls on all that a window measures, so short ones take longer. With one tile for all, a frame of 625
/// tiles of which a part is empty took 4.5 % too many cycles (docs/accuracy.md).
const WARM_UP: (f64, f64) = (2.0, 1.0);
/// Samples of a tile that these lengths are made for, with as many rays in the T&I units and [`SLOTS`] tiles in the slots. Of smaller tiles it
/// takes more: what is under way at the ends of a window are rays, and no fewer of them if tiles are small. So it does where more of
/// either is under way.
const TILE: f64 = 1024.0;
/// See [`TILE`].
const SLOTS: f64 = 8.0;
/// More of the tiles than this, warm-up included, are not worth a sample: the frame is simulated whole.
const WORTH: f64 = 0.6;
/// A frame of which the fewest and shortest windows are more than this is simulated whole too: there intervals missed more often than they
/// state (docs/accuracy.md).
const WORTH_AT_LEAST: f64 = 0.35;
/// Where all is simulated: tiles of a window for each slot of the machine, and tiles of its warm-up. Each seam between two
/// windows costs accuracy, and the warm-up of each costs time; but the tiles of a window are in memory together.
const LONG_WINDOW: usize = 16;
/// With one tile a slot the time of frames that are soon done was up to 1.7 % off, with four at most 0.4 % (docs/accuracy.md).
const LONG_WARM_UP: f64 = 4.0;

/// Where a window lies, in tiles that are done before.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// Where its warm-up begins.
    pub begin: f64,
    /// Where the measurement begins.
    pub from: f64,
    /// Where it ends: with the frame if this is infinite.
    pub to: f64,
    /// It stands for itself and for nothing else.
    pub is_certain: bool,
}

/// The tiles of a frame.
#[derive(Clone, Copy, Debug)]
pub struct Tiles {
    /// How many.
    pub count: usize,
    /// Samples of one.
    pub samples: u32,
}

/// What a machine has under way at a time, at most.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnderWay {
    /// Tiles.
    pub slots: usize,
    /// Rays in its T&I units.
    pub rays: u32,
}

/// The windows of a frame, in order.
#[derive(Clone, Debug, PartialEq)]
pub struct Places {
    list: Vec<Place>,
    under_way: UnderWay,
    /// The part of the work that is measured, beginning and end left out.
    share: f64,
}

impl Places {
    /// The windows of a frame of `tiles` tiles on a machine that has so much under way; nothing where the frame is to be simulated
    /// whole. `share` is the part of the tiles to be measured, and of the work, once they are [by work](Places::by_work).
    pub fn sample(Tiles { count: tiles, samples }: Tiles, under_way: UnderWay, share: f64) -> Option<Self> {
        let UnderWay { slots, rays } = under_way;
        let (tiles, edge) = (tiles as f64, slots as f64 / 2.0);
        let factor = (f64::from(rays).max(TILE) / f64::from(samples.max(1))).max(slots as f64 / SLOTS).max(1.0);
        let (shortest, longest) = (LENGTH.0 * factor, LENGTH.1 * factor);
        let length = (share * tiles / FEWEST_WINDOWS as f64).clamp(shortest, longest);
        let windows = ((share * tiles / length).round() as usize).max(FEWEST_WINDOWS);
        let warm_up_of = |length: f64| {
            let long = (length - shortest) / (longest - shortest);
            factor * (WARM_UP.0 + long * (WARM_UP.1 - WARM_UP.0))
        };
        let simulated = |windows: usize, length: f64| {
            windows as f64 * (length + warm_up_of(length)) + 2.0 * edge + warm_up_of(length)
        };
        if simulated(FEWEST_WINDOWS, shortest) > WORTH_AT_LEAST * tiles || simulated(windows, length) > WORTH * tiles {
            return None;
        }
        let (first, last, warm_up) = (edge, tiles - edge, warm_up_of(length));
        let window = |i: usize| {
            // Somewhere in the i-th of equal parts: multiples of the golden ratio are spread evenly, however many there are.
            let at = (i as f64 * 0.618_033_988_749_895).fract();
            let part = (last - first) / windows as f64;
            let from = first + i as f64 * part + at * (part - length);
            Place { begin: (from - warm_up).max(0.0), from, to: from + length, is_certain: false }
        };
        let start = Place { begin: 0.0, from: 0.0, to: first, is_certain: true };
        let end = Place { begin: last - warm_up, from: last, to: f64::INFINITY, is_certain: true };
        let list = std::iter::once(start).chain((0..windows).map(window)).chain([end]).collect();
        Some(Self { list, under_way, share: windows as f64 * length / tiles })
    }

    /// Windows that follow one another, so that all tiles are simulated; nothing for a frame that is too small.
    pub fn all(tiles: usize, under_way: UnderWay) -> Option<Self> {
        let slots = under_way.slots;
        let length = slots.max(4) * LONG_WINDOW;
        let windows = tiles / length;
        let window = |i: usize| {
            let from = (i * length) as f64;
            let to = if i + 1 == windows { f64::INFINITY } else { from + length as f64 };
            Place { begin: (from - LONG_WARM_UP * slots as f64).max(0.0), from, to, is_certain: true }
        };
        (windows >= 2).then(|| Self { list: (0..windows).map(window).collect(), under_way, share: 1.0 })
    }

    /// The windows of what a frame is to be simulated with, as [`Places::sample`] or [`Places::all`].
    pub fn of(detail: Detail, tiles: Tiles, under_way: UnderWay) -> Option<Self> {
        match detail {
            Detail::Full | Detail::Counts => None,
            Detail::All => Self::all(tiles.count, under_way),
            Detail::Sampled(share) => Self::sample(tiles, under_way, share.fraction()),
            Detail::Precision(_) => Self::sample(tiles, under_way, 0.0),
        }
    }

    /// As these, but measuring more by this factor; nothing if that is too much.
    pub fn more(&self, tiles: Tiles, factor: f64) -> Option<Self> {
        Self::sample(tiles, self.under_way, factor * self.share)
    }

    /// The same windows in a frame whose work is not the same in all tiles: each at its place among the work, and as long in it. Beginning
    /// and end stay, for they are those of a machine that works on so many tiles.
    #[must_use]
    pub fn by_work(mut self, line: &WorkLine) -> Self {
        let (Some(first), Some(last)) = (self.list.first(), self.list.last()) else { return self };
        let (first, last) = (first.to, last.from);
        let (from, to) = (line.work_at(first), line.work_at(last));
        let scale = (to - from) / (last - first);
        let place_of = |at: f64| line.tiles_at((from + (at - first) * scale).max(0.0));
        for place in &mut self.list {
            if place.is_certain {
                // The beginning has no warm-up.
                place.begin = if place.begin > 0.0 { place_of(place.begin) } else { 0.0 };
            } else {
                *place = Place {
                    begin: place_of(place.begin),
                    from: place_of(place.from),
                    to: place_of(place.to),
                    ..*place
                };
            }
        }
        self
    }

    /// The windows, in order.
    pub fn list(&self) -> &[Place] {
        &self.list
    }

    /// Tile slots of the machine.
    pub fn slots(&self) -> usize {
        self.under_way.slots
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const USUAL: UnderWay = UnderWay { slots: 8, rays: 1024 };

    fn tiles(count: usize) -> Tiles {
        Tiles { count, samples: 1024 }
    }

    #[test]
    fn small_tiles_make_windows_of_more() {
        let of = |samples| Places::sample(Tiles { count: 8192, samples }, USUAL, 0.05).unwrap().list[1];
        let (usual, small, large) = (of(1024), of(256), of(48 * 48));
        assert_eq!((usual.to - usual.from, usual.from - usual.begin), (4.0, 1.0));
        assert!((small.to - small.from - 16.0).abs() < 1e-9 && (small.from - small.begin - 4.0).abs() < 1e-9);
        assert_eq!(large, usual);
        assert_eq!(
            Places::sample(Tiles { count: 512, samples: 64 }, USUAL, 0.05),
            None,
            "too few for one window of each kind"
        );
    }

    #[test]
    fn short_windows_warm_up_for_longer() {
        let of = |count| {
            let place = Places::sample(tiles(count), USUAL, 0.05).unwrap().list[1];
            (place.to - place.from, place.from - place.begin)
        };
        let near = |(a, b): (f64, f64), (c, d): (f64, f64)| (a - c).abs() < 1e-9 && (b - d).abs() < 1e-9;
        assert!(near(of(512), (2.0, 2.0)) && near(of(2048), (4.0, 1.0)));
        assert!(near(of(1440), (3.0, 1.5)), "{:?}", of(1440));
    }

    #[test]
    fn windows_are_longer_where_more_is_under_way() {
        let length = |under_way| {
            let place = Places::sample(tiles(8192), under_way, 0.05).unwrap().list[1];
            (place.to - place.from, place.from - place.begin)
        };
        assert_eq!(length(USUAL), (4.0, 1.0));
        assert_eq!(length(UnderWay { slots: 2, rays: 64 }), (4.0, 1.0));
        for under_way in [UnderWay { slots: 16, ..USUAL }, UnderWay { rays: 2048, ..USUAL }] {
            let (measured, warm_up) = length(under_way);
            assert!((measured - 8.0).abs() < 1e-9 && (warm_up - 2.0).abs() < 1e-9, "{under_way:?}");
        }
        assert_eq!(Places::sample(tiles(625), UnderWay { slots: 64, ..USUAL }, 0.05), None);
    }

    #[test]
    fn windows_are_as_many_as_asked_for_and_evenly_spread() {
        let places = Places::sample(tiles(8192), USUAL, 0.05).unwrap();
        assert_eq!(places.list.len(), 102 + 2);
        let middle = &places.list[1..103];
        let part = 8184.0 / 102.0;
        for (i, place) in middle.iter().enumerate() {
            let begin = 4.0 + i as f64 * part;
            assert!(place.from >= begin && place.to <= begin + part + 1e-6, "{place:?}");
            assert!((place.to - place.from - LENGTH.1).abs() < 1e-9);
        }
        let mean = middle.iter().map(|place| place.from).sum::<f64>() / 102.0;
        assert!((mean - 4094.0).abs() < 2.0, "{mean}");
        assert_eq!((places.list[0].to, places.list[103].from), (4.0, 8188.0));
    }

    #[test]
    fn windows_are_of_the_same_work_wherever_they_lie() {
        // A third of the tiles trace nine times as much as the others.
        let rays: Vec<u64> = (0..2048).map(|tile| if tile % 1024 < 683 { 1000 } else { 9000 }).collect();
        let line = WorkLine::new(&rays, USUAL.slots);
        let even = Places::sample(tiles(2048), USUAL, 0.05).unwrap();
        let places = even.clone().by_work(&line);
        let work = |from: f64, to: f64| line.work_at(to) - line.work_at(from);
        let middle = |places: &Places| places.list[1..places.list.len() - 1].to_vec();
        let (whole, first) = (work(4.0, 2044.0) / 2040.0, middle(&places)[0]);
        for (place, even) in middle(&places).iter().zip(middle(&even)) {
            assert!((work(place.from, place.to) - whole * (even.to - even.from)).abs() < 1e-6, "{place:?}");
            assert!((work(place.begin, place.from) - whole * (even.from - even.begin)).abs() < 1e-6, "{place:?}");
        }
        assert!(first.to - first.from > 10.0, "among tiles of few rays a window takes many: {first:?}");
        let glass = middle(&places).iter().filter(|place| place.from as usize % 1024 >= 683).count();
        // Of the work 82 % lie there, of the tiles a third.
        assert!((20..=24).contains(&glass), "{glass} of 28 windows");
        // Beginning and end are those of so many tiles.
        assert_eq!((places.list[0], places.list[places.list.len() - 1].from), (even.list[0], 2044.0));
    }

    #[test]
    fn where_tiles_trace_alike_windows_stay() {
        let even = Places::sample(tiles(2048), USUAL, 0.05).unwrap();
        let same = even.clone().by_work(&WorkLine::new(&[77; 2048], USUAL.slots));
        for (a, b) in even.list.iter().zip(&same.list) {
            assert!((a.begin - b.begin).abs() < 1e-6 && (a.from - b.from).abs() < 1e-6, "{a:?} {b:?}");
            assert!(a.to == b.to || (a.to - b.to).abs() < 1e-6, "{a:?} {b:?}");
        }
    }

    #[test]
    fn more_is_more_than_was_asked_for() {
        let (frame, rays) = (tiles(8192), (0..8192).map(|tile| 100 + tile).collect::<Vec<u64>>());
        let places = Places::sample(frame, USUAL, 0.05).unwrap().by_work(&WorkLine::new(&rays, USUAL.slots));
        assert_eq!(places.list.len(), 102 + 2);
        assert_eq!(places.more(frame, 2.0).unwrap().list.len(), 204 + 2, "however long windows are in tiles");
    }

    #[test]
    fn small_frames_are_simulated_whole() {
        assert_eq!(Places::sample(tiles(64), USUAL, 0.1), None);
        assert_eq!(Places::sample(tiles(2048), USUAL, 0.5), None, "with warm-up that is all of it");
        assert!(Places::sample(tiles(512), USUAL, 0.1).is_some());
        assert!(Places::sample(tiles(303), USUAL, 0.05).is_some());
        assert_eq!(Places::sample(tiles(302), USUAL, 0.05), None);
        let small = |count| Places::sample(Tiles { count, samples: 256 }, USUAL, 0.05);
        assert!(small(1143).is_some() && small(1142).is_none());
        assert_eq!(Places::all(64, USUAL), None);
    }

    #[test]
    fn where_all_is_simulated_one_window_follows_the_other() {
        let places = Places::all(2050, USUAL).unwrap();
        assert_eq!(places.list.len(), 16);
        assert!(places.list.windows(2).all(|pair| pair[0].to == pair[1].from));
        assert_eq!((places.list[0].from, places.list[15].to), (0.0, f64::INFINITY));
    }
}
