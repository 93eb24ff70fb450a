//! What a reader is willing to spend on a file it does not trust.
//!
//! Every decoder of this crate takes a [`Limits`]. A length found in a file is compared with its limit before anything
//! is allocated, and even then memory grows only as data really arrives. The fields on disk are wider than these
//! limits: a limit can be raised without a change of format. Some have a hard end, and their fields
//! say which: numbers in memory have 32 bits, and a reference to a child has 28.

use std::sync::Arc;

use crate::budget::{Budget, Share};
use crate::error::{Error, Result};

/// What an error says of [`Limits::memory`].
pub const MEMORY: &str = "memory for decoding, in bytes,";

/// Upper bounds on what a file may ask for; a file that asks for more gives
/// [`Error::LimitExceeded`].
///
/// The defaults hold every trace that Rayreel writes, with room to spare. Raise a field for an unusual trace, lower
/// them for untrusted input on a small machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Longest payload of one chunk as it lies in the file, in bytes. Default 1 GiB.
    pub max_chunk_packed_bytes: u64,
    /// Longest payload of one chunk after decompression, in bytes; also the longest decoded column. Default 2 GiB.
    pub max_chunk_raw_bytes: u64,
    /// Most chunks in one file, without the index itself. Default 64 Mi; each costs a reader 52 bytes of memory. Set no
    /// more than 2^32 - 1.
    pub max_index_entries: u64,
    /// Most pixels of a frame. Default 2^27, which is also the most that `rayreel` captures: a replay holds pictures of 12 bytes a pixel, and
    /// two bytes a sample.
    pub max_pixels: u64,
    /// Most columns in one `TILE` chunk. Default 32; the format can hold 255.
    pub max_columns_per_tile: u32,
    /// Most samples in one tile. Default 2^20, a tile of 1024 x 1024 samples, which is also the largest there is.
    pub max_samples_per_tile: u64,
    /// Most ray-tree nodes (closest-hit rays) in one tile. Default 2^24, 16 rays for each of 2^20 samples. Set no more than 2^27: a node has
    /// up to 17 rays, which are numbered with 32 bits.
    pub max_nodes_per_tile: u64,
    /// Most traversal steps in one tile. Default 2^28. Never more than 2^32 - 1.
    pub max_path_steps_per_tile: u64,
    /// Most nodes in the BVH. Default 2^28, and never more.
    pub max_bvh_nodes: u64,
    /// Most triangles in the BVH. Default 2^28, and never more.
    pub max_triangles: u64,
    /// Most bytes that decoding one metadata chunk may allocate. Default 64 MiB.
    pub max_metadata_bytes: u64,
    /// What tiles and trees being decoded at a time may take, of all traces that are opened with these limits and with clones of them.
    /// Default 1 GiB. What was decoded is its holder's.
    pub memory: Arc<Budget>,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_chunk_packed_bytes: 1 << 30,
            max_chunk_raw_bytes: 2 << 30,
            max_index_entries: 64 << 20,
            max_pixels: 1 << 27,
            max_columns_per_tile: 32,
            max_samples_per_tile: 1 << 20,
            max_nodes_per_tile: 1 << 24,
            max_path_steps_per_tile: 1 << 28,
            max_bvh_nodes: 1 << 28,
            max_triangles: 1 << 28,
            max_metadata_bytes: 1 << 26,
            memory: Arc::new(Budget::new(1 << 30)),
        }
    }
}

/// What any file may ask for, and what each of its bytes earns beyond: a small file cannot ask for much.
///
/// Files that Rayreel writes stay far below: a byte of a coded column holds tens of rays or hundreds of steps at most, and zstd makes
/// a tenth of a BVH.
impl Limits {
    /// Most bytes that so many packed bytes of a chunk may unpack to.
    pub(crate) fn unpacked_max(packed: u64) -> u64 {
        (16_u64 << 20).saturating_add(packed.saturating_mul(256))
    }

    /// Most bytes that so many packed bytes of a column may unpack to.
    pub(crate) fn column_max(packed: u64) -> u64 {
        (64_u64 << 20).saturating_add(packed.saturating_mul(256))
    }

    /// Most ray-tree nodes of a tile whose tree takes so many bytes.
    pub(crate) fn nodes_max(&self, bytes: usize) -> u64 {
        self.max_nodes_per_tile.min((2_u64 << 20).saturating_add((bytes as u64).saturating_mul(64)))
    }

    /// Most path steps of a tile of so many rays whose paths take so many bytes. Paths that are like a neighbour's cost nothing, so a
    /// uniform tile stays far below.
    pub(crate) fn path_steps_max(&self, bytes: usize, rays: u64) -> u64 {
        let earned = (bytes as u64).saturating_mul(1024).saturating_add(rays.saturating_mul(16));
        // Spans of paths are `u32`.
        self.max_path_steps_per_tile.min(u32::MAX.into()).min((16_u64 << 20).saturating_add(earned))
    }

    /// A share of the memory for something that says that it needs so many bytes.
    pub(crate) fn reserve(&self, bytes: u64) -> Result<Share<'_>> {
        self.memory.take(bytes).ok_or_else(|| Error::limit(MEMORY, bytes, self.memory.total()))
    }

    /// Most tiles of a trace that holds so many chunks: others may be missing, as of a long capture that was repaired, but not without
    /// end. 700 frames of 2048 x 1024 pixels have 5.7 million; a list of 16 Mi takes 128 MiB.
    pub(crate) fn tiles_max(chunks: u64) -> u64 {
        (16_u64 << 20).saturating_add(chunks.saturating_mul(64))
    }
}

#[cfg(test)]
mod tests {
    use super::Limits;

    /// What a tile of no bytes may have, what bytes and rays add, and where it ends.
    #[test]
    fn what_bytes_and_rays_earn() {
        let limits = Limits::default();
        assert_eq!(limits.path_steps_max(0, 0), 16 << 20);
        assert_eq!(limits.path_steps_max(1000, 1 << 21), (16 << 20) + 1_024_000 + (32 << 20));
        assert_eq!(limits.path_steps_max(usize::MAX, 1), limits.max_path_steps_per_tile, "never more than that");
        let raised = Limits { max_path_steps_per_tile: u64::MAX, ..Limits::default() };
        assert_eq!(raised.path_steps_max(usize::MAX, 1), u64::from(u32::MAX), "spans of paths hold no more");
        assert_eq!((limits.nodes_max(0), limits.nodes_max(1000)), (2 << 20, (2 << 20) + 64_000));
        assert_eq!((Limits::tiles_max(10), Limits::unpacked_max(1)), ((16 << 20) + 640, (16 << 20) + 256));
        assert!(limits.nodes_max(12_000) * 40 < 1 << 30, "12 KB earn less than a gigabyte");
    }

    /// The second call would wait for ever if the first share were not given back.
    #[test]
    fn a_share_is_given_back_and_too_much_is_refused() {
        let limits = Limits { memory: std::sync::Arc::new(super::Budget::new(100)), ..Limits::default() };
        drop(limits.reserve(80).unwrap());
        drop(limits.clone().reserve(80).unwrap());
        let error = limits.reserve(101).unwrap_err().to_string();
        assert!(error.contains("memory for decoding, in bytes, is 101, over the limit of 100"), "{error}");
    }

    /// The index keeps positions of chunks as `u32`, and a directory counts its columns in a `u8`.
    #[test]
    fn defaults_fit_the_fields_that_hold_them() {
        let limits = Limits::default();
        assert!(limits.max_index_entries <= u64::from(u32::MAX));
        assert!(limits.max_columns_per_tile <= u32::from(u8::MAX));
    }
}
