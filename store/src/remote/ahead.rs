//! How much to fetch at once.
//!
//! A tile is some ten kilobytes: a distant store needs more time to answer than to send them. So where whole chunks are
//! read one after the other, each request takes twice as much as the one before, up to [`WINDOW_MAX`] and to the end of
//! the frame. A replay that needs one frame of many, or scattered tiles, still fetches little that it does not need.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};

use rayreel_formats::container::ChunkRecord;

/// Most bytes that a run of chunks takes in one request; a single chunk may be longer.
const WINDOW_MAX: u64 = 1 << 20;
/// Number of runs that are remembered: more than there are threads that read.
const RUNS: usize = 256;

/// A chunk: where it lies, and its frame.
#[derive(Debug)]
struct ChunkSpan {
    range: Range<u64>,
    frame: u32,
}

/// Remembers which chunks were read, so that a run of neighbours is noticed.
#[derive(Debug, Default)]
pub(super) struct ReadAhead {
    chunks: OnceLock<Vec<ChunkSpan>>,
    /// Last requests of whole chunks: where they ended, and how long they were.
    runs: Mutex<VecDeque<(u64, u64)>>,
}

impl ReadAhead {
    /// Notes where the chunks lie; they are in file order.
    pub(super) fn layout(&self, chunks: &[ChunkRecord]) {
        let span = |chunk: &ChunkRecord| ChunkSpan { range: chunk.offset..chunk.end(), frame: chunk.id.frame };
        // A second layout of one object would be the same.
        let _ = self.chunks.set(chunks.iter().map(span).collect());
    }

    /// What to fetch for `wanted`: that, and whole chunks behind it that are likely to be asked for next and are not
    /// `held`.
    pub(super) fn extend(&self, wanted: Range<u64>, held: impl Fn(&Range<u64>) -> bool) -> Range<u64> {
        let chunks = self.chunks.get().map_or(&[][..], Vec::as_slice);
        let at = chunks.partition_point(|chunk| chunk.range.start < wanted.start);
        let Some(first) = chunks.get(at).filter(|chunk| chunk.range == wanted) else { return wanted };
        let mut runs = self.runs.lock().unwrap_or_else(PoisonError::into_inner);
        let before = runs.iter().position(|&(end, _)| end == wanted.start).and_then(|at| runs.remove(at));
        // A run starts anew with each frame: the chunks before the first one are read once, when the trace is opened.
        let same_frame = at.checked_sub(1).is_some_and(|before| chunks[before].frame == first.frame);
        let window = before.filter(|_| same_frame).map_or(0, |(_, len)| (2 * len).min(WINDOW_MAX));
        let mut end = wanted.end;
        for chunk in &chunks[at + 1..] {
            if chunk.frame != first.frame || chunk.range.end - wanted.start > window || held(&chunk.range) {
                break;
            }
            end = chunk.range.end;
        }
        if runs.len() == RUNS {
            runs.pop_front();
        }
        runs.push_back((end, end - wanted.start));
        wanted.start..end
    }
}

#[cfg(test)]
mod tests {
    use rayreel_formats::container::ChunkId;

    use super::*;

    /// Two frames of ten chunks of 100 bytes each.
    fn ahead() -> ReadAhead {
        let record = |i: u64| ChunkRecord {
            id: ChunkId::tile((i / 10) as u32, (i % 10) as u32),
            encoding: 0,
            offset: 1000 + 100 * i,
            packed_len: 52,
            raw_len: 52,
            payload_crc: 0,
            directory_len: 8,
        };
        let ahead = ReadAhead::default();
        ahead.layout(&(0..20).map(record).collect::<Vec<_>>());
        ahead
    }

    #[test]
    fn scattered_chunks_are_fetched_alone() {
        let ahead = ahead();
        for start in [1300, 1700, 1100, 2500] {
            assert_eq!(ahead.extend(start..start + 100, |_| false), start..start + 100);
        }
    }

    #[test]
    fn runs_grow_and_end_with_the_frame() {
        let ahead = ahead();
        let mut at = 1000;
        for end in [1100, 1300, 1700, 2000, 2100, 2300, 2700] {
            assert_eq!(ahead.extend(at..at + 100, |_| false), at..end);
            at = end;
        }
    }

    #[test]
    fn a_run_ends_with_its_frame() {
        let ahead = ahead();
        assert_eq!(ahead.extend(1900..2000, |_| false), 1900..2000);
        assert_eq!(ahead.extend(2000..2100, |_| false), 2000..2100);
        assert_eq!(ahead.extend(2100..2200, |_| false), 2100..2300);
    }

    #[test]
    fn what_is_held_or_no_chunk_is_not_fetched_along() {
        let ahead = ahead();
        assert_eq!(ahead.extend(1000..1100, |_| false), 1000..1100);
        assert_eq!(ahead.extend(1100..1200, |range| range.start == 1200), 1100..1200);
        assert_eq!(ahead.extend(1200..1260, |_| false), 1200..1260, "a part of a chunk");
        assert_eq!(ReadAhead::default().extend(1..2, |_| false), 1..2, "before the index is known");
    }
}
