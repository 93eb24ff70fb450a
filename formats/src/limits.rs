//! What a reader is willing to spend on a file it does not trust.
//!
//! Every decoder of this crate takes a [`Limits`]. A length found in a file is compared with its limit before anything
//! is allocated, and even then memory grows only as data really arrives. The fields on disk are wider than these
//! limits: a limit can be raised without a change of format.

/// Upper bounds on what a file may ask for; a file that asks for more gives
/// [`Error::LimitExceeded`](crate::Error::LimitExceeded).
///
/// The defaults hold every trace that Rayreel writes, with room to spare. Raise a field for an unusual trace, lower
/// them for untrusted input on a small machine.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Longest payload of one chunk as it lies in the file, in bytes. Default 1 GiB.
    pub max_chunk_packed_bytes: u64,
    /// Longest payload of one chunk after decompression, in bytes; also the longest decoded column. Default 2 GiB.
    pub max_chunk_raw_bytes: u64,
    /// Most chunks in one file, without the index itself. Default 64 Mi; each costs a reader 52 bytes of memory.
    pub max_index_entries: u64,
    /// Most columns in one `TILE` chunk. Default 32; the format can hold 255.
    pub max_columns_per_tile: u32,
    /// Most samples in one tile. Default 2^20, a tile of 1024 x 1024 samples.
    pub max_samples_per_tile: u64,
    /// Most ray-tree nodes (closest-hit rays) in one tile. Default 2^24, 16 rays for each of 2^20 samples.
    pub max_nodes_per_tile: u64,
    /// Most traversal steps in one tile. Default 2^28.
    pub max_path_steps_per_tile: u64,
    /// Most nodes in the BVH. Default 2^28.
    pub max_bvh_nodes: u64,
    /// Most triangles in the BVH. Default 2^28.
    pub max_triangles: u64,
    /// Most bytes that decoding one metadata chunk may allocate. Default 64 MiB.
    pub max_metadata_bytes: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            max_chunk_packed_bytes: 1 << 30,
            max_chunk_raw_bytes: 2 << 30,
            max_index_entries: 64 << 20,
            max_columns_per_tile: 32,
            max_samples_per_tile: 1 << 20,
            max_nodes_per_tile: 1 << 24,
            max_path_steps_per_tile: 1 << 28,
            max_bvh_nodes: 1 << 28,
            max_triangles: 1 << 28,
            max_metadata_bytes: 1 << 26,
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

    /// Most path steps of a tile whose paths take so many bytes.
    pub(crate) fn path_steps_max(&self, bytes: usize) -> u64 {
        self.max_path_steps_per_tile.min((4_u64 << 20).saturating_add((bytes as u64).saturating_mul(1024)))
    }

    /// Most tiles of a trace that holds so many chunks: others may be missing, but not without end.
    pub(crate) fn tiles_max(chunks: u64) -> u64 {
        (4_u64 << 20).saturating_add(chunks.saturating_mul(64))
    }
}

#[cfg(test)]
mod tests {
    use super::Limits;

    /// The index keeps positions of chunks as `u32`, and a directory counts its columns in a `u8`.
    #[test]
    fn defaults_fit_the_fields_that_hold_them() {
        let limits = Limits::default();
        assert!(limits.max_index_entries <= u64::from(u32::MAX));
        assert!(limits.max_columns_per_tile <= u32::from(u8::MAX));
    }
}
