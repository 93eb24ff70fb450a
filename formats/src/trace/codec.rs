//! Tiles to columns and back, by either codec.

use crate::budget::Share;
use crate::bvh::Bvh;
use crate::columns::classes::CodingOrder;
use crate::columns::paths::{BvhTopology, PathScratch, PathSink, SharedPaths};
use crate::columns::{hits, paths, radiance, tree};
use crate::container::{ColumnEntry, EncodedChunk, compress, decompress};
use crate::error::{Error, Result, check_limit};
use crate::id::{ChunkId, NONE};
use crate::limits::Limits;
use crate::payload::canonical;
use crate::rays::{Geometry, RayRebuilder};
use crate::scene::{Camera, Meta, Rect};
use crate::tile::{Column, Hit, Paths, Radiance, Tile, Tree};

/// How the columns of a tile are coded.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codec {
    /// Canonical bytes in a zstd frame of this level: simple to read anywhere, two to three times the size.
    Plain(i32),
    /// The column codec: adaptive range coding in the context of neighbouring rays.
    Context,
}

impl Codec {
    /// Code of [`Codec::Plain`] in a column directory.
    pub const PLAIN: u8 = 0;
    /// Code of [`Codec::Context`] in a column directory.
    pub const CONTEXT: u8 = 1;

    /// The code in a column directory.
    pub fn code(self) -> u8 {
        match self {
            Self::Plain(_) => Self::PLAIN,
            Self::Context => Self::CONTEXT,
        }
    }
}

/// Memory that coding a tile needs, reused from tile to tile.
#[derive(Debug, Default)]
pub struct Scratch {
    paths: PathScratch,
}

/// What coding a tile of one frame needs beside the tile.
#[derive(Clone, Copy, Debug)]
pub struct TileCodec<'a> {
    /// Lights, depth and tile layout.
    pub meta: &'a Meta,
    /// Triangles and materials.
    pub bvh: &'a Bvh,
    /// The tree, packed for walking.
    pub topology: &'a BvhTopology,
    /// The frame's camera.
    pub camera: &'a Camera,
    /// What decoding may cost.
    pub limits: &'a Limits,
}

/// A column as it was read from a file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PackedColumn {
    /// Code of its codec; see [`Codec::code`].
    pub codec: u8,
    /// Length of its canonical bytes, as the directory promises.
    pub raw_len: u64,
    /// The coded bytes.
    pub bytes: Vec<u8>,
}

impl TileCodec<'_> {
    fn geometry(&self) -> Geometry<'_> {
        Geometry { bvh: self.bvh, camera: *self.camera }
    }

    fn lights(&self) -> usize {
        self.meta.lights.len()
    }

    /// Codes a whole tile as a chunk.
    ///
    /// # Errors
    /// When a column does not fit the tile's tree or the BVH, zstd or the container refuses.
    pub fn encode(&self, tile: &Tile, codec: Codec, scratch: &mut Scratch) -> Result<EncodedChunk> {
        self.encode_columns(tile, codec, scratch, false)
    }

    /// [`TileCodec::encode`] of a tile that a tracer has just made: distances, normals and weights are what the functions
    /// in [`rays`](crate::rays) and [`intersect`](crate::intersect) gave, and are not computed again to see it. The bytes
    /// are the same, if that is true; a debug build checks it.
    ///
    /// # Errors
    /// As [`TileCodec::encode`].
    pub fn encode_traced(&self, tile: &Tile, codec: Codec, scratch: &mut Scratch) -> Result<EncodedChunk> {
        let chunk = self.encode_columns(tile, codec, scratch, true)?;
        debug_assert_eq!(Ok(&chunk), self.encode(tile, codec, scratch).as_ref().map_err(|_| ()), "it was not traced");
        Ok(chunk)
    }

    fn encode_columns(&self, tile: &Tile, codec: Codec, scratch: &mut Scratch, traced: bool) -> Result<EncodedChunk> {
        let order = CodingOrder::new(&tile.tree, tile.rect);
        let mut code = |column| self.column(tile, &order, column, codec, scratch, traced);
        let columns: Vec<ColumnEntry> = Column::ALL.into_iter().map(&mut code).collect::<Result<_>>()?;
        EncodedChunk::tile(ChunkId::tile(tile.frame, tile.index), &columns)
    }

    /// Codes one column of a tile; errors name frame, tile and column.
    fn column(
        &self,
        tile: &Tile,
        order: &CodingOrder<'_>,
        column: Column,
        codec: Codec,
        scratch: &mut Scratch,
        traced: bool,
    ) -> Result<ColumnEntry> {
        named(column, check_size(tile, column))
            .and_then(|()| self.code_column(tile, order, column, codec, scratch, traced))
            .map_err(|error| error.in_tile(tile.frame, tile.index))
    }

    fn code_column(
        &self,
        tile: &Tile,
        order: &CodingOrder<'_>,
        column: Column,
        codec: Codec,
        scratch: &mut Scratch,
        traced: bool,
    ) -> Result<ColumnEntry> {
        let (code, raw_len, packed) = match codec {
            Codec::Plain(level) => {
                let raw = tile.canonical_bytes(column);
                (Codec::PLAIN, raw.len() as u64, compress(&raw, level)?)
            }
            Codec::Context => {
                let packed = named(column, self.context(tile, order, column, scratch, traced))?;
                (Codec::CONTEXT, canonical::length(tile, column), packed)
            }
        };
        Ok(ColumnEntry { id: column as u8, codec: code, raw_len, packed })
    }

    /// How many bytes a column of a tile takes, coded by `codec`.
    ///
    /// # Errors
    /// As [`TileCodec::encode`].
    pub fn column_bytes(&self, tile: &Tile, column: Column, codec: Codec, scratch: &mut Scratch) -> Result<usize> {
        self.column(tile, &CodingOrder::new(&tile.tree, tile.rect), column, codec, scratch, false)
            .map(|entry| entry.packed.len())
    }

    /// Codes one column with the column codec.
    fn context(
        &self,
        tile: &Tile,
        order: &CodingOrder<'_>,
        column: Column,
        scratch: &mut Scratch,
        traced: bool,
    ) -> std::result::Result<Vec<u8>, String> {
        match column {
            Column::Tree => Ok(tree::encode(order, self.lights())),
            Column::Hits => hits::encode(order, &tile.hits, self.geometry(), traced),
            Column::Radiance => {
                let rays = (!traced).then(|| RayRebuilder::of(order.tree, order.rect, self.geometry(), &tile.hits));
                Ok(radiance::encode(order, &tile.hits, &tile.radiance, self.bvh, rays.as_ref()))
            }
            Column::Paths => paths::encode(&tile.paths, order, self.lights(), self.topology, &mut scratch.paths),
        }
    }

    /// Decodes the tree column.
    ///
    /// # Errors
    /// When it is damaged or over a limit.
    pub fn decode_tree(&self, rect: Rect, packed: &PackedColumn) -> Result<Tree> {
        check_limit("samples per tile", rect.len() as u64, self.limits.max_samples_per_tile)?;
        let depth = self.meta.max_depth;
        let _share = self.reserve(packed, packed.raw_len.saturating_mul(12))?;
        // A node takes a canonical byte at least, so none beyond that number is decoded.
        let nodes = self.limits.max_nodes_per_tile.min(packed.raw_len);
        let limits = Limits { max_nodes_per_tile: nodes, ..self.limits.clone() };
        let decoded = decode(
            packed,
            |bytes| tree::decode(bytes, rect, self.lights(), depth, &limits),
            |bytes| canonical::parse_tree(bytes, rect.len(), self.lights(), depth),
            canonical::tree_length,
        );
        let tree = named(Column::Tree, decoded)?;
        check_limit("ray-tree nodes per tile", tree.nodes.len() as u64, self.limits.max_nodes_per_tile)?;
        Ok(tree)
    }

    /// Decodes the hits column, and rebuilds the rays that others hang on.
    ///
    /// # Errors
    /// When it is damaged.
    pub(super) fn decode_hits(
        &self,
        order: &CodingOrder<'_>,
        packed: &PackedColumn,
    ) -> Result<(Vec<Hit>, RayRebuilder<'_>)> {
        named(Column::Hits, promises(packed, canonical::hits_length(order.tree)))?;
        // A hit comes to 72 bytes with what its ray is rebuilt from. A miss has no canonical byte, and its place in these lists all the same.
        let misses = order.tree.nodes.iter().filter(|node| !node.hit).count() as u64;
        let _share = self.reserve(packed, packed.raw_len.saturating_mul(6).saturating_add(28 * misses))?;
        let decoded = decode(
            packed,
            |bytes| {
                let mut rays = RayRebuilder::new(order.tree, order.rect, self.geometry());
                Ok((hits::decode(bytes, order, &mut rays)?, rays))
            },
            |bytes| {
                let hits = canonical::parse_hits(bytes, order.tree, self.bvh.triangles.len())?;
                let rays = RayRebuilder::of(order.tree, order.rect, self.geometry(), &hits);
                Ok((hits, rays))
            },
            |_| canonical::hits_length(order.tree),
        );
        named(Column::Hits, decoded)
    }

    /// Decodes the radiance column; hits and rays are those of the hits column.
    ///
    /// # Errors
    /// When it is damaged.
    pub(super) fn decode_radiance(
        &self,
        order: &CodingOrder<'_>,
        (hits, rays): (&[Hit], &RayRebuilder<'_>),
        packed: &PackedColumn,
    ) -> Result<Vec<Radiance>> {
        named(Column::Radiance, promises(packed, canonical::radiance_length(order.tree)))?;
        let _share = self.reserve(packed, packed.raw_len.saturating_mul(3))?;
        let decoded = decode(
            packed,
            |bytes| radiance::decode(bytes, order, hits, rays),
            |bytes| canonical::parse_radiance(bytes, order.tree),
            |_| canonical::radiance_length(order.tree),
        );
        named(Column::Radiance, decoded)
    }

    /// Decodes the paths column of a tile whose tree is there.
    ///
    /// # Errors
    /// When it is damaged or over a limit.
    pub fn decode_paths(&self, tile: &Tile, packed: &PackedColumn, scratch: &mut Scratch) -> Result<Paths> {
        let (tree, rect, lights) = (&tile.tree, tile.rect, self.lights());
        let limits = self.paths_limits(tree, packed)?;
        let _share = self.reserve_paths(tree, packed)?;
        let scratch = &mut scratch.paths;
        let decoded = decode(
            packed,
            |bytes| paths::decode(bytes, &CodingOrder::new(tree, rect), lights, self.topology, &limits, scratch),
            |bytes| canonical::parse_paths(bytes, tree.ray_count() as usize),
            canonical::paths_length,
        );
        let paths = named(Column::Paths, decoded)?;
        check_limit("path steps per tile", paths.steps.len() as u64, self.limits.max_path_steps_per_tile)?;
        Ok(paths)
    }
}

impl TileCodec<'_> {
    /// A share of the memory for decoding a column that comes to so many bytes beside its packed ones. More than its directory promises
    /// is not decoded, and a column that has less is refused.
    fn reserve(&self, packed: &PackedColumn, bytes: u64) -> Result<Share<'_>> {
        self.limits.reserve(bytes.saturating_add(packed.bytes.len() as u64))
    }

    /// A share for paths: of a list of steps that grows half is in use, and every ray has its place in lists, whatever its steps.
    fn reserve_paths(&self, tree: &Tree, packed: &PackedColumn) -> Result<Share<'_>> {
        self.reserve(packed, packed.raw_len.saturating_mul(2).saturating_add(28 * tree.ray_count()))
    }

    /// What decoding the paths of this tree may cost. Their canonical bytes are a length (4 bytes) for each ray and a byte for each
    /// step, so more steps than that leaves are not decoded. Paths that rays share are decoded once and count for each ray.
    fn paths_limits(&self, tree: &Tree, packed: &PackedColumn) -> Result<Limits> {
        let (rays, promised) = (tree.ray_count(), packed.raw_len);
        let steps = promised.checked_sub(4 * rays).ok_or_else(|| {
            let detail = format!("the {promised} bytes that the directory promises are too few for {rays} rays");
            Error::column(NONE, NONE, Column::Paths.name(), detail)
        })?;
        let most = self.limits.max_path_steps_per_tile.min(steps);
        Ok(Limits { max_path_steps_per_tile: most, ..self.limits.clone() })
    }

    /// As [`TileCodec::decode_paths`], but the paths go to `sink`, each once. Only paths by the column codec are known to
    /// lead through the tree; others go to no sink.
    ///
    /// # Errors
    /// As there; some paths have gone to `sink` then.
    pub fn decode_paths_to<S: PathSink>(
        &self,
        tile: &Tile,
        packed: &PackedColumn,
        scratch: &mut Scratch,
        sink: &mut S,
    ) -> Result<SharedPaths> {
        let limits = self.paths_limits(&tile.tree, packed)?;
        let _share = self.reserve_paths(&tile.tree, packed)?;
        let (order, lights, scratch) = (CodingOrder::new(&tile.tree, tile.rect), self.lights(), &mut scratch.paths);
        let decoded = decode(
            packed,
            |bytes| paths::decode_to(bytes, &order, lights, self.topology, &limits, scratch, sink),
            |_| Err("plain paths are not known to lead through the tree".into()),
            |paths| paths.rays.iter().map(|&path| 4 + u64::from(paths.steps[path as usize])).sum(),
        );
        let shared = named(Column::Paths, decoded)?;
        let steps = shared.steps.iter().map(|&steps| u64::from(steps)).sum();
        check_limit("path steps per tile", steps, self.limits.max_path_steps_per_tile)?;
        Ok(shared)
    }
}

/// Decodes by the codec that the directory names, and checks that the canonical length is the one it promises: paths
/// may share their steps, so only this bounds what the column comes to when they are written out.
fn decode<T>(
    packed: &PackedColumn,
    context: impl FnOnce(&[u8]) -> std::result::Result<T, String>,
    plain: impl FnOnce(&[u8]) -> std::result::Result<T, String>,
    length: impl FnOnce(&T) -> u64,
) -> std::result::Result<T, String> {
    let PackedColumn { codec, raw_len, bytes } = packed;
    let decoded = match *codec {
        Codec::PLAIN if *raw_len > Limits::column_max(bytes.len() as u64) => {
            return Err(format!("{} bytes are too few for the {raw_len} that the directory promises", bytes.len()));
        }
        Codec::PLAIN => plain(&decompress(bytes, *raw_len).map_err(|e| e.to_string())?)?,
        Codec::CONTEXT => context(bytes)?,
        other => return Err(format!("coded by codec {other}, which this build does not know; use a newer rayreel")),
    };
    promises(packed, length(&decoded)).map(|()| decoded)
}

/// Refuses a column that has another number of canonical bytes than its directory promises.
fn promises(packed: &PackedColumn, length: u64) -> std::result::Result<(), String> {
    match packed.raw_len {
        promised if promised == length => Ok(()),
        promised => Err(format!("it has {length} canonical bytes, not the {promised} that the directory promises")),
    }
}

/// Refuses a column that has another number of entries than the tile's tree asks for.
fn check_size(tile: &Tile, column: Column) -> std::result::Result<(), String> {
    let (nodes, rays) = (tile.tree.nodes.len(), tile.tree.ray_count() as usize);
    let (found, wanted, of) = match column {
        Column::Tree => (tile.tree.samples(), tile.rect.len(), "samples"),
        Column::Hits => (tile.hits.len(), nodes, "nodes"),
        Column::Radiance => (tile.radiance.len(), nodes, "nodes"),
        Column::Paths => (tile.paths.spans.len(), rays, "rays"),
    };
    if found != wanted {
        return Err(format!("it has {found} entries for {wanted} {of}"));
    }
    let outside = |&(start, length): &(u32, u32)| u64::from(start) + u64::from(length) > tile.paths.steps.len() as u64;
    match (column, tile.paths.spans.iter().position(outside)) {
        (Column::Paths, Some(ray)) => Err(format!("the path of ray {ray} is not among its steps")),
        _ => Ok(()),
    }
}

fn named<T>(column: Column, result: std::result::Result<T, String>) -> Result<T> {
    result.map_err(|detail| Error::column(NONE, NONE, column.name(), detail))
}
