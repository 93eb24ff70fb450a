//! What a trace says, as one hash a column: independent of codec, compression level, thread count and chunk order.

use rayon::prelude::*;

use super::codec::Scratch;
use super::reader::Trace;
use crate::error::{Result, first_error};
use crate::scene::Meta;
use crate::tile::Column;

/// The hashes of a trace, BLAKE3.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Digest {
    /// Metadata, without the name of the program that wrote it.
    pub meta: blake3::Hash,
    /// The BVH payload before compression.
    pub bvh: blake3::Hash,
    /// Cameras, by frame.
    pub cameras: blake3::Hash,
    /// Each column, over all tiles by frame and number: frame, tile, and the hash of the column's canonical bytes.
    pub columns: [blake3::Hash; 4],
}

impl Digest {
    /// All parts with their names, in a fixed order.
    pub fn parts(&self) -> Vec<(&'static str, blake3::Hash)> {
        let mut parts = vec![("meta", self.meta), ("bvh", self.bvh), ("cameras", self.cameras)];
        parts.extend(Column::ALL.iter().zip(self.columns).map(|(column, hash)| (column.name(), hash)));
        parts
    }

    /// One hash over all parts, in the order of [`Digest::parts`].
    pub fn total(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        for (_, hash) in self.parts() {
            hasher.update(hash.as_bytes());
        }
        hasher.finalize()
    }
}

/// Digests a trace. Tiles that it does not hold are left out (see [`Trace::missing_tiles`]), and of a tile the columns that
/// cannot be read (see [`Trace::readable`]).
///
/// # Errors
/// When a tile is damaged.
pub fn digest(trace: &Trace) -> Result<Digest> {
    let missing = trace.missing_tiles();
    let meta = Meta { tool: String::new(), ..trace.meta().clone() };
    let mut cameras = blake3::Hasher::new();
    let mut columns = [(); 4].map(|()| blake3::Hasher::new());
    for frame in trace.meta().frame_numbers() {
        if !trace.has_frame(frame) {
            continue;
        }
        let camera = trace.camera(frame)?;
        cameras.update(&frame.to_le_bytes());
        cameras.update(&camera.to_payload()?);
        let tiles: Vec<u32> =
            (0..trace.meta().tile_count()).filter(|&t| missing.binary_search(&(frame, t)).is_err()).collect();
        let hash = |scratch: &mut Scratch, &tile: &u32| -> Result<[Option<blake3::Hash>; 4]> {
            let readable = trace.readable(frame, tile)?;
            if readable.is_empty() {
                return Ok([None; 4]);
            }
            let content = trace.tile_with(frame, tile, &readable, scratch)?;
            let hash = |column| readable.contains(&column).then(|| blake3::hash(&content.canonical_bytes(column)));
            Ok(Column::ALL.map(hash))
        };
        let hashes = first_error(tiles.par_iter().map_init(Scratch::default, hash))?;
        for (tile, hashes) in tiles.iter().zip(hashes) {
            for (hasher, hash) in columns.iter_mut().zip(hashes).filter_map(|(hasher, hash)| Some((hasher, hash?))) {
                hasher.update(&frame.to_le_bytes());
                hasher.update(&tile.to_le_bytes());
                hasher.update(hash.as_bytes());
            }
        }
    }
    Ok(Digest {
        meta: blake3::hash(&meta.to_payload()?),
        bvh: blake3::hash(&trace.bvh().to_payload()?),
        cameras: cameras.finalize(),
        columns: columns.map(|hasher| hasher.finalize()),
    })
}
