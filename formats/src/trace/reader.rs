//! An open trace: typed access to what a file holds, tile by tile, in any order and from any thread.

use std::path::Path;
use std::sync::OnceLock;

use super::codec::{PackedColumn, Scratch, TileCodec};
use crate::bvh::Bvh;
use crate::columns::classes::CodingOrder;
use crate::columns::paths::{BvhTopology, PathSink, SharedPaths};
use crate::container::{ChunkRecord, ColumnTotals, Reader, Source, TileDirectory, TilePayload};
use crate::error::{Error, Missing, Place, Result, check_limit};
use crate::id::{ChunkId, ChunkKind};
use crate::limits::Limits;
use crate::rays::{Geometry, TileRays};
use crate::scene::{Camera, Meta};
use crate::tile::{Column, Paths, Tile};

/// An open trace.
#[derive(Debug)]
pub struct Trace {
    reader: Reader,
    meta: Meta,
    bvh: Bvh,
    topology: BvhTopology,
    /// Frames that the file holds, ascending: a file pays for what it holds, not for what its metadata claims.
    frames: Vec<FrameEntry>,
    lacking: Vec<(Column, u64)>,
}

/// A frame of the file. Its camera is read when it is first asked for: cameras lie among the tiles, and of a trace far
/// away each costs a request.
#[derive(Debug)]
struct FrameEntry {
    record: ChunkRecord,
    camera: OnceLock<Camera>,
}

impl Trace {
    /// Opens a finished trace: reads the index, the metadata and the BVH, no camera and no tile.
    ///
    /// # Errors
    /// When the file cannot be read, is not a trace, has no index or is damaged in one of these parts.
    pub fn open(path: &Path, limits: Limits) -> Result<Self> {
        Self::from_reader(Reader::open(path, limits)?)
    }

    /// As [`Trace::open`], on bytes in memory.
    ///
    /// # Errors
    /// As there.
    pub fn from_bytes(bytes: Vec<u8>, limits: Limits) -> Result<Self> {
        Self::from_reader(Reader::from_bytes(bytes, limits)?)
    }

    /// As [`Trace::open`], on any source of bytes; `name` stands for the file in errors.
    ///
    /// # Errors
    /// As there.
    pub fn from_source(source: Box<dyn Source>, name: &Path, limits: Limits) -> Result<Self> {
        Self::from_reader(Reader::from_source(source, name, limits)?)
    }

    /// The file, as errors name it.
    pub fn path(&self) -> &Path {
        self.reader.path()
    }

    fn from_reader(reader: Reader) -> Result<Self> {
        let limits = reader.limits().clone();
        let record = reader.require(ChunkId::META)?;
        let here = |error: Error| error.at(&Place::new(reader.path(), record.offset));
        let meta = Meta::from_payload(&reader.read(record)?, &limits).map_err(here)?;
        let tiles = u64::from(meta.tile_count()).saturating_mul(u64::from(meta.frames));
        check_limit("number of tiles", tiles, Limits::tiles_max(reader.chunks().len() as u64))
            .map_err(|error| error.at(&Place::new(reader.path(), 0)))?;
        let bvh = read_bvh(&reader, &limits)?;
        let topology = BvhTopology::new(&bvh);
        let frames = reader.chunks().iter().filter(|record| record.id.kind == ChunkKind::FRAM);
        let mut frames: Vec<FrameEntry> =
            frames.map(|&record| FrameEntry { record, camera: OnceLock::new() }).collect();
        frames.sort_by_key(|frame| frame.record.id.frame);
        let lacking = lacking(&reader);
        let trace = Self { reader, meta, bvh, topology, frames, lacking };
        trace.check_chunks()?;
        Ok(trace)
    }

    /// The same error, said to be of this file, frame and tile where it does not say so yet.
    fn in_tile(&self, error: Error, frame: u32, tile: u32) -> Error {
        let id = ChunkId::tile(frame, tile);
        let offset = self.reader.find(id).map(|record| record.offset);
        error.at(&Place { offset, ..Place::new(self.path(), 0) }.of(id))
    }

    /// Refuses tiles and frames that the metadata does not know of.
    fn check_chunks(&self) -> Result<()> {
        for record in self.reader.chunks() {
            let ChunkId { kind, frame, tile } = record.id;
            let foreign = match kind {
                ChunkKind::FRAM => !self.meta.frame_numbers().contains(&frame),
                ChunkKind::TILE => !self.meta.frame_numbers().contains(&frame) || tile >= self.meta.tile_count(),
                _ => false,
            };
            if foreign {
                let error = Error::decode("index", format!("a {} is outside what the metadata says", record.id));
                return Err(error.at(&Place::new(self.path(), record.offset)));
            }
        }
        Ok(())
    }

    /// What was captured.
    pub fn meta(&self) -> &Meta {
        &self.meta
    }

    /// The acceleration structure.
    pub fn bvh(&self) -> &Bvh {
        &self.bvh
    }

    /// The file.
    pub fn reader(&self) -> &Reader {
        &self.reader
    }

    /// What each column takes in the file.
    pub fn column_totals(&self) -> &[ColumnTotals] {
        self.reader.column_totals()
    }

    /// Whether the trace holds frame `frame`, that is, its camera.
    pub fn has_frame(&self, frame: u32) -> bool {
        self.reader.find(ChunkId::frame(frame)).is_some()
    }

    /// The camera of frame `frame`.
    ///
    /// # Errors
    /// When the trace does not hold that frame, or its camera is damaged.
    pub fn camera(&self, frame: u32) -> Result<Camera> {
        let Ok(at) = self.frames.binary_search_by_key(&frame, |frame| frame.record.id.frame) else {
            return Err(Error::missing(self.reader.path(), ChunkId::frame(frame)));
        };
        let FrameEntry { record, camera } = &self.frames[at];
        if let Some(camera) = camera.get() {
            return Ok(*camera);
        }
        let here = |error: Error| error.at(&Place::new(self.path(), record.offset).of(record.id));
        let read = Camera::from_payload(&self.reader.read(record)?, self.reader.limits()).map_err(here)?;
        Ok(*camera.get_or_init(|| read))
    }

    /// Tiles (and frames, as their first tile) that a complete trace would hold and this one does not.
    pub fn missing_tiles(&self) -> Vec<(u32, u32)> {
        let mut missing = Vec::new();
        for frame in self.meta.frame_numbers() {
            let camera = self.has_frame(frame);
            for tile in 0..self.meta.tile_count() {
                if !camera || self.reader.find(ChunkId::tile(frame, tile)).is_none() {
                    missing.push((frame, tile));
                }
            }
        }
        missing
    }

    /// Columns that some tiles lack, with how many do. Only other writers than ours leave columns out.
    pub fn lacking(&self) -> &[(Column, u64)] {
        &self.lacking
    }

    /// The columns of a tile that can be read: those that it holds, as far as it holds what they need.
    ///
    /// # Errors
    /// When the trace does not hold the tile, or its directory is damaged.
    pub fn readable(&self, frame: u32, index: u32) -> Result<Vec<Column>> {
        let record = self.reader.require(ChunkId::tile(frame, index))?;
        if self.lacking().is_empty() {
            return Ok(Column::ALL.to_vec());
        }
        let directory = self.reader.tile_directory(record)?;
        let held = |column: &Column| directory.column(*column as u8).is_some();
        Ok(Column::ALL.into_iter().filter(|column| held(column) && column.needs().iter().all(held)).collect())
    }

    /// Reads the columns of a tile that `columns` name, and those they need; the others stay empty.
    ///
    /// # Errors
    /// When the trace does not hold the tile, or it is damaged.
    pub fn tile(&self, frame: u32, index: u32, columns: &[Column]) -> Result<Tile> {
        self.tile_with(frame, index, columns, &mut Scratch::default())
    }

    /// As [`Trace::tile`], with memory that is reused from call to call.
    ///
    /// # Errors
    /// As there.
    pub fn tile_with(&self, frame: u32, index: u32, columns: &[Column], scratch: &mut Scratch) -> Result<Tile> {
        let record = *self.reader.require(ChunkId::tile(frame, index))?;
        let camera = self.camera(frame)?;
        let wanted = |column: Column| columns.contains(&column) || columns.iter().any(|c| c.needs().contains(&column));
        let wanted: Vec<Column> =
            Column::ALL.into_iter().filter(|&column| column == Column::Tree || wanted(column)).collect();
        let source = self.columns(&record, &wanted)?;
        let mut decode = || {
            let codec = self.codec(&camera);
            let mut tile = self.decode(&record, &source, &wanted, &codec)?;
            if wanted.contains(&Column::Paths) {
                let packed = self.column(&record, &source, Column::Paths)?;
                tile.paths = codec.decode_paths(&tile, &packed, scratch)?;
            }
            Ok(tile)
        };
        decode().map_err(|error| self.in_tile(error, frame, index))
    }

    /// A tile with the bytes of its paths, to be decoded when they are needed: they take many times as much memory.
    ///
    /// # Errors
    /// As [`Trace::tile`].
    pub fn packed_tile(&self, frame: u32, index: u32) -> Result<(Tile, PackedColumn)> {
        let record = *self.reader.require(ChunkId::tile(frame, index))?;
        let camera = self.camera(frame)?;
        let source = self.columns(&record, &Column::ALL)?;
        let decode = || {
            let tile = self.decode(&record, &source, &Column::ALL, &self.codec(&camera))?;
            Ok((tile, self.column(&record, &source, Column::Paths)?))
        };
        decode().map_err(|error| self.in_tile(error, frame, index))
    }

    /// How many rays a tile has. The tile is read whole, as whoever asks is about to: a source far away then fetches it once.
    ///
    /// # Errors
    /// As [`Trace::tile`].
    pub fn ray_count(&self, frame: u32, index: u32) -> Result<u64> {
        let record = *self.reader.require(ChunkId::tile(frame, index))?;
        let camera = self.camera(frame)?;
        let source = self.columns(&record, &Column::ALL)?;
        let decoded = self.decode(&record, &source, &[Column::Tree], &self.codec(&camera));
        decoded.map(|tile| tile.tree.ray_count()).map_err(|error| self.in_tile(error, frame, index))
    }

    /// The paths of a tile from the bytes that [`Trace::packed_tile`] gave.
    ///
    /// # Errors
    /// When they are damaged.
    pub fn paths(&self, tile: &Tile, packed: &PackedColumn, scratch: &mut Scratch) -> Result<Paths> {
        let camera = self.camera(tile.frame)?;
        let decoded = self.codec(&camera).decode_paths(tile, packed, scratch);
        decoded.map_err(|error| self.in_tile(error, tile.frame, tile.index))
    }

    /// As [`Trace::paths`], but the paths go to `sink`, each once. Only paths by [`Codec::Context`](super::Codec::Context) do: of others nobody
    /// knows that they lead through the tree.
    ///
    /// # Errors
    /// As there; some paths may have gone to `sink` then.
    pub fn paths_to<S: PathSink>(
        &self,
        tile: &Tile,
        packed: &PackedColumn,
        scratch: &mut Scratch,
        sink: &mut S,
    ) -> Result<SharedPaths> {
        let camera = self.camera(tile.frame)?;
        let decoded = self.codec(&camera).decode_paths_to(tile, packed, scratch, sink);
        decoded.map_err(|error| self.in_tile(error, tile.frame, tile.index))
    }

    /// All rays of a tile, rebuilt, with what each met.
    ///
    /// # Errors
    /// As [`Trace::tile`].
    pub fn rays(&self, frame: u32, index: u32) -> Result<TileRays<'_>> {
        let tile = self.tile(frame, index, &[Column::Hits])?;
        let geometry = Geometry { bvh: &self.bvh, camera: self.camera(frame)? };
        Ok(TileRays::new(tile, geometry, &self.meta.lights))
    }

    /// Reads the whole tile if its paths are wanted, which are most of it; else announces the wanted columns.
    fn columns(&self, record: &ChunkRecord, wanted: &[Column]) -> Result<ColumnSource> {
        if wanted.contains(&Column::Paths) {
            return Ok(ColumnSource::Whole(self.reader.read_tile(record)?));
        }
        let directory = self.reader.tile_directory(record)?;
        let ids: Vec<u8> = wanted.iter().map(|&column| column as u8).collect();
        self.reader.announce_columns(record, &directory, &ids)?;
        Ok(ColumnSource::Single(directory))
    }

    /// All wanted columns but the paths.
    fn decode(
        &self,
        record: &ChunkRecord,
        source: &ColumnSource,
        wanted: &[Column],
        codec: &TileCodec<'_>,
    ) -> Result<Tile> {
        let ChunkId { frame, tile: index, .. } = record.id;
        let read = |column: Column| self.column(record, source, column);
        let rect = self.meta.tile_rect(index);
        let tree = codec.decode_tree(rect, &read(Column::Tree)?)?;
        let (mut hits, mut radiance) = (Vec::new(), Vec::new());
        if wanted.contains(&Column::Hits) {
            let order = CodingOrder::new(&tree, rect);
            let rays;
            (hits, rays) = codec.decode_hits(&order, &read(Column::Hits)?)?;
            if wanted.contains(&Column::Radiance) {
                radiance = codec.decode_radiance(&order, (&hits, &rays), &read(Column::Radiance)?)?;
            }
        }
        let tile = Tile { frame, index, rect, tree, hits, radiance, paths: Paths::default() };
        Ok(tile)
    }

    fn codec<'a>(&'a self, camera: &'a Camera) -> TileCodec<'a> {
        TileCodec { meta: &self.meta, bvh: &self.bvh, topology: &self.topology, camera, limits: self.reader.limits() }
    }

    fn column(&self, record: &ChunkRecord, source: &ColumnSource, column: Column) -> Result<PackedColumn> {
        let id = column as u8;
        let found = match source {
            ColumnSource::Whole(payload) => payload.column(id).map(|(info, bytes)| (*info, bytes.to_vec())),
            ColumnSource::Single(directory) => {
                let info = directory.column(id).copied();
                info.zip(self.reader.read_column(record, directory, id)?)
            }
        };
        match found {
            Some((info, bytes)) => Ok(PackedColumn { codec: info.codec, raw_len: info.raw_len, bytes }),
            None => {
                let missing = Missing::Column { tile: record.id, column: column.name() };
                Err(Error::Incomplete { path: self.reader.path().to_path_buf(), missing })
            }
        }
    }
}

/// The tree. Unpacking it and decoding it take shares of the memory, one after the other.
fn read_bvh(reader: &Reader, limits: &Limits) -> Result<Bvh> {
    let record = reader.require(ChunkId::BVH)?;
    let at = |error: Error| error.at(&Place::new(reader.path(), record.offset).of(record.id));
    // What no memory helps against comes first.
    let earned = Limits::unpacked_max(record.packed_len).min(limits.max_chunk_raw_bytes);
    check_limit("raw length of a chunk in bytes", record.raw_len, earned).map_err(at)?;
    let share = limits.reserve(record.raw_len).map_err(at)?;
    let payload = reader.read(record)?;
    drop(share);
    Bvh::from_payload(&payload, limits).map_err(at)
}

/// Columns that fewer tiles have than there are.
fn lacking(reader: &Reader) -> Vec<(Column, u64)> {
    let tiles = reader.chunks().iter().filter(|record| record.id.kind == ChunkKind::TILE).count() as u64;
    let held = |column: Column| reader.column_totals().iter().find(|t| t.id == column as u8).map_or(0, |t| t.tiles);
    let lacking = Column::ALL.into_iter().map(|column| (column, tiles.saturating_sub(held(column))));
    lacking.filter(|(_, tiles)| *tiles > 0).collect()
}

/// Where the columns of a tile come from: one read of everything, or one read each.
enum ColumnSource {
    Whole(TilePayload),
    Single(TileDirectory),
}
