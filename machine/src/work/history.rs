//! What a tile has to do with the histories of its frame and of the one before.
//!
//! A history has an entry for some samples of a frame: the primary hit, and behind all entries of a tile the hits below. Two
//! histories take turns, each with a part of its own for each tile. A tile reads the entries that it looks at before its first round, each
//! once, as if it knew them beforehand, and writes its own at its end. (Estimate.)

use crate::config::SampleFields;

/// Entries of a history that stand side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct HistorySpan {
    /// The tile that they belong to.
    pub tile: u32,
    /// Hits below primary ones; else these.
    pub below: bool,
    /// The first, among those of the tile.
    pub first: u32,
    /// How many.
    pub count: u32,
}

/// What a tile reads of the history of the frame before, and keeps for the next frame.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct HistoryWork {
    /// What it reads.
    pub reads: Vec<HistorySpan>,
    /// Samples that it keeps.
    pub kept: u32,
    /// Hits below these that it keeps.
    pub kept_below: u32,
}

/// Bytes a sample from the history of a tile to that of the next: room for a primary hit and twenty below it. More of them run on
/// into the next tile's part.
const SAMPLE_BYTES: u64 = 256;
/// And so many more: then it is an odd number of lines, and tiles do not all begin in the same sets and banks.
const TILE_GAP: u64 = 0x1040;
/// From one history to the other.
const TURN: u64 = 1 << 39;

/// Where histories lie in their region.
#[derive(Clone, Copy, Debug)]
pub struct HistoryLayout {
    /// Bytes of a primary hit, and of a hit below one.
    hit_bytes: [u64; 2],
    /// From the entries of a tile to the hits below them, and to the entries of the next tile.
    below: u64,
    tile: u64,
}

impl HistoryLayout {
    /// For samples of these fields, in tiles of `tile_samples`: object, normal, shadow bits and the length of the ray; flags have the
    /// age of an entry, and its position follows from place and length.
    pub fn new(fields: &SampleFields, tile_samples: u32) -> Self {
        let hit = u64::from(fields.object + fields.normal + fields.shadow + fields.distance);
        let (entry, samples) = (hit + u64::from(fields.flags), u64::from(tile_samples));
        let below = (samples * entry).next_multiple_of(SAMPLE_BYTES);
        Self { hit_bytes: [entry, hit], below, tile: samples * SAMPLE_BYTES + TILE_GAP }
    }

    /// What a tile of `frame` reads: offset in the region and bytes.
    pub fn reads(&self, frame: u32, work: &HistoryWork) -> impl Iterator<Item = (u64, u64)> {
        work.reads.iter().map(move |span| self.span(frame.wrapping_sub(1), *span))
    }

    /// What tile `tile` of `frame` writes, as [`HistoryLayout::reads`].
    pub fn writes(&self, frame: u32, tile: u32, work: &HistoryWork) -> impl Iterator<Item = (u64, u64)> + use<> {
        let all = [(false, work.kept), (true, work.kept_below)];
        let spans = all.map(|(below, count)| self.span(frame, HistorySpan { tile, below, first: 0, count }));
        spans.into_iter().filter(|(_, bytes)| *bytes > 0)
    }

    fn span(&self, frame: u32, HistorySpan { tile, below, first, count }: HistorySpan) -> (u64, u64) {
        let bytes = self.hit_bytes[usize::from(below)];
        let part = if below { self.below } else { 0 };
        let turn = u64::from(frame & 1) * TURN;
        (turn + u64::from(tile) * self.tile + part + u64::from(first) * bytes, u64::from(count) * bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn histories_take_turns_and_never_meet() {
        let (object, normal, position, shadow, colour, flags) = (4, 4, 6, 1, 4, 1);
        let fields =
            SampleFields { object, normal, position, shadow, colour, flags, distance: 2, local: 4, weights: 8 };
        let layout = HistoryLayout::new(&fields, 1024);
        let (tile, below) = (1024 * 256 + 65 * 64, 12 * 1024);
        let span = |tile, below| HistorySpan { tile, below, first: 3, count: 5 };
        let work = HistoryWork { reads: vec![span(7, false), span(7, true)], kept: 1024, kept_below: 9 };
        let reads: Vec<_> = layout.reads(4, &work).collect();
        assert_eq!(reads, [(TURN + 7 * tile + 36, 60), (TURN + 7 * tile + below + 33, 55)]);
        let writes: Vec<_> = layout.writes(3, 7, &work).collect();
        assert_eq!(writes, [(TURN + 7 * tile, 12 * 1024), (TURN + 7 * tile + below, 99)]);
        assert_eq!(layout.writes(4, 0, &HistoryWork { kept_below: 0, ..work }).collect::<Vec<_>>(), [(0, 12 * 1024)]);
    }

    /// The largest tiles there are, all of whose samples are kept, and twenty hits below each.
    #[test]
    fn tiles_of_any_size_have_room() {
        let (object, normal, position, shadow, colour, flags) = (4, 4, 6, 1, 4, 1);
        let fields =
            SampleFields { object, normal, position, shadow, colour, flags, distance: 2, local: 4, weights: 8 };
        for samples in [1, 9, 64, 1024, 1 << 20] {
            let layout = HistoryLayout::new(&fields, samples);
            let work = HistoryWork { kept: samples, kept_below: 20 * samples, ..HistoryWork::default() };
            let [(entries, bytes), (below, bytes_below)] =
                layout.writes(0, 3, &work).collect::<Vec<_>>().try_into().unwrap();
            let (next, _) = layout.writes(0, 4, &work).next().unwrap();
            assert!(entries + bytes <= below && below + bytes_below <= next, "{samples}");
            assert!((next - entries) / 64 % 2 == 1 && (next - entries).is_multiple_of(64), "an odd number of lines");
        }
    }
}
