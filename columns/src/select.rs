//! Which frames and tiles of a trace.

use std::ops::Range;

use rayreel_formats::scene::Meta;

use crate::error::{ColumnsError, Result};

/// Frames and tiles that are in a trace.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Selection {
    /// Frame numbers, ascending.
    pub frames: Range<u32>,
    /// Tile numbers, ascending, of each frame.
    pub tiles: Vec<u32>,
    /// Whether somebody chose them, even if all were chosen: that is refused where a table has none.
    chosen: Chosen,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Chosen {
    frames: bool,
    tiles: bool,
}

impl Selection {
    /// All that a trace says it holds.
    pub fn all(meta: &Meta) -> Self {
        Self { frames: meta.frame_numbers(), tiles: (0..meta.tile_count()).collect(), chosen: Chosen::default() }
    }

    /// Only these frames.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] for frames that the trace does not have.
    pub fn frames(self, wanted: Range<u32>) -> Result<Self> {
        let held = &self.frames;
        if wanted.is_empty() || wanted.start < held.start || wanted.end > held.end {
            let frame = if held.contains(&wanted.start) { wanted.end.saturating_sub(1) } else { wanted.start };
            let (first, last) = (held.start, held.end.saturating_sub(1));
            return Err(ColumnsError::Request(format!(
                "frame {frame} is not in the trace, which holds frames {first} to {last}; choose one of these"
            )));
        }
        Ok(Self { frames: wanted, chosen: Chosen { frames: true, ..self.chosen }, ..self })
    }

    /// Only these tiles: numbers and ranges `A..B` without B, separated by commas, such as `0..8,17`.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] for text that says something else, and for tiles that the frames do not have.
    pub fn tiles(self, text: &str) -> Result<Self> {
        let wrong = || {
            let detail = "give tiles as numbers and ranges A..B with A below B, such as 0..8,17";
            ColumnsError::Request(format!("{detail}, not {text:?}"))
        };
        let number = |text: &str| text.trim().parse::<u32>().map_err(|_| wrong());
        let mut wanted = Vec::new();
        for part in text.split(',') {
            let (first, end) = match part.split_once("..") {
                Some((first, end)) => (number(first)?, number(end)?),
                None => (number(part)?, number(part)?.checked_add(1).ok_or_else(wrong)?),
            };
            if first >= end {
                return Err(wrong());
            }
            let count = self.tiles.len() as u32;
            if end > count {
                let tile = first.max(count);
                let last = count.saturating_sub(1);
                return Err(ColumnsError::Request(format!(
                    "tile {tile} is not in the trace, whose frames have tiles 0 to {last}; choose some of these"
                )));
            }
            wanted.extend(first..end);
        }
        wanted.sort_unstable();
        wanted.dedup();
        Ok(Self { tiles: wanted, chosen: Chosen { tiles: true, ..self.chosen }, ..self })
    }

    /// Whether frames were chosen, or only some are left.
    pub fn chooses_frames(&self, meta: &Meta) -> bool {
        self.chosen.frames || self.frames != meta.frame_numbers()
    }

    /// Whether tiles were chosen, or only some are left.
    pub fn chooses_tiles(&self, meta: &Meta) -> bool {
        self.chosen.tiles || !self.is_whole(meta)
    }

    /// Whether all tiles of a frame are wanted.
    pub fn is_whole(&self, meta: &Meta) -> bool {
        self.tiles.len() == meta.tile_count() as usize
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_numbers_and_ranges() {
        let all = Selection { frames: 3..5, tiles: (0..20).collect(), chosen: Chosen::default() };
        let tiles = |text: &str| all.clone().tiles(text).map(|chosen| chosen.tiles);
        assert_eq!(tiles("4").unwrap(), [4]);
        assert_eq!(tiles("17,2..5, 3").unwrap(), [2, 3, 4, 17]);
        assert_eq!(tiles("0..20").unwrap().len(), 20);
        for wrong in ["", "a", "3..3", "5..4", "1,", "..", "4294967295"] {
            assert!(tiles(wrong).unwrap_err().to_string().contains("such as 0..8,17"), "{wrong:?}");
        }
        assert!(tiles("3,18..21").unwrap_err().to_string().starts_with("tile 20 is not in the trace"));
        assert_eq!(all.clone().frames(4..5).unwrap().frames, 4..5);
        for (frames, name) in [(2..4, 2), (4..6, 5), (9..10, 9)] {
            let error = all.clone().frames(frames).unwrap_err().to_string();
            assert_eq!(
                error,
                format!("frame {name} is not in the trace, which holds frames 3 to 4; choose one of these")
            );
        }
    }
}
