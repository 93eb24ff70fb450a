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

/// From the history of a tile to that of the next: an odd number of lines, so that tiles do not all begin in the same sets and banks.
const TILE_BYTES: u64 = (1 << 20) + 0x1040;
/// From the entries of a tile to the hits below them.
const BELOW: u64 = 1 << 19;
/// From one history to the other.
const TURN: u64 = 1 << 36;

/// Where histories lie in their region.
#[derive(Clone, Copy, Debug)]
pub struct HistoryLayout {
    /// Bytes of a primary hit, and of a hit below one.
    hit_bytes: [u64; 2],
}

impl HistoryLayout {
    /// For samples of these fields: object, normal, shadow bits and the length of the ray; flags have the age of an entry, and its
    /// position follows from place and length.
    pub fn new(fields: &SampleFields) -> Self {
        let hit = u64::from(fields.object + fields.normal + fields.shadow + fields.distance);
        Self { hit_bytes: [hit + u64::from(fields.flags), hit] }
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
        let part = if below { BELOW } else { 0 };
        let turn = u64::from(frame & 1) * TURN;
        (turn + u64::from(tile) * TILE_BYTES + part + u64::from(first) * bytes, u64::from(count) * bytes)
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
        let layout = HistoryLayout::new(&fields);
        let span = |tile, below| HistorySpan { tile, below, first: 3, count: 5 };
        let work = HistoryWork { reads: vec![span(7, false), span(7, true)], kept: 1024, kept_below: 9 };
        let reads: Vec<_> = layout.reads(4, &work).collect();
        assert_eq!(reads, [(TURN + 7 * TILE_BYTES + 36, 60), (TURN + 7 * TILE_BYTES + BELOW + 33, 55)]);
        let writes: Vec<_> = layout.writes(3, 7, &work).collect();
        assert_eq!(writes, [(TURN + 7 * TILE_BYTES, 12 * 1024), (TURN + 7 * TILE_BYTES + BELOW, 99)]);
        assert_eq!(layout.writes(4, 0, &HistoryWork { kept_below: 0, ..work }).collect::<Vec<_>>(), [(0, 12 * 1024)]);
    }
}
