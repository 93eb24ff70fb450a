//! Small traces in files and in memory, and everything that one says.

use std::path::PathBuf;

use rayreel_formats::bvh::Bvh;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec, Trace, TraceWriter};
use rayreel_formats::{Limits, Result};
use tempfile::TempDir;

use super::tiles::Look;
use super::{Random, soup, tiles};

/// All that goes into a trace.
#[derive(Debug)]
pub struct Content {
    pub meta: Meta,
    pub bvh: Bvh,
    pub cameras: Vec<Camera>,
    pub tiles: Vec<Tile>,
}

impl PartialEq for Content {
    fn eq(&self, other: &Self) -> bool {
        let same = self.meta == other.meta && self.bvh == other.bvh && self.cameras == other.cameras;
        same && self.tiles == other.tiles
    }
}

/// A new folder, in memory where there is such a place.
pub fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder can be made")
}

impl Content {
    pub fn random(seed: u64, size: (u32, u32), tile: u32, triangles: u32, depth: u32, lights: u32) -> Self {
        let random = &mut Random(seed);
        let bvh = soup::bvh(random, triangles);
        let meta = soup::meta(random, size, tile, depth, lights);
        let cameras: Vec<Camera> = meta.frame_numbers().map(|_| soup::camera(random)).collect();
        let look = Look { child_in: 3, news_in: 1 + random.below(4) };
        let mut tiles = Vec::new();
        for (frame, camera) in meta.frame_numbers().zip(&cameras) {
            for index in 0..meta.tile_count() {
                tiles.push(tiles::tile(random, look, &bvh, &meta, camera, index, frame));
            }
        }
        Self { meta, bvh, cameras, tiles }
    }

    /// Calls `f` with a codec for each tile.
    pub fn each(&self, limits: &Limits, mut f: impl FnMut(&TileCodec<'_>, &Tile)) {
        let topology = BvhTopology::new(&self.bvh);
        for tile in &self.tiles {
            let camera = &self.cameras[(tile.frame - self.meta.first_frame) as usize];
            f(&TileCodec { meta: &self.meta, bvh: &self.bvh, topology: &topology, camera, limits }, tile);
        }
    }

    /// The trace as a file; `codec` chooses by tile.
    pub fn write(&self, codec: impl Fn(&Tile) -> Codec) -> (TempDir, PathBuf) {
        let folder = folder();
        let path = folder.path().join("trace.rtrace");
        let mut writer = TraceWriter::create(&path, &self.meta, &self.bvh, 3).expect("a new file");
        let mut scratch = Scratch::default();
        self.each(&Limits::default(), |coder, tile| {
            writer.frame(tile.frame, coder.camera).expect("a frame can be written");
            let chunk = coder.encode(tile, codec(tile), &mut scratch).expect("a tile can be coded");
            writer.tile(&chunk).expect("a tile can be written");
        });
        let finished = writer.finish().expect("the file can be finished");
        (folder, finished.path)
    }

    pub fn bytes(&self, codec: impl Fn(&Tile) -> Codec) -> Vec<u8> {
        let (_folder, path) = self.write(codec);
        std::fs::read(path).expect("the file can be read")
    }
}

/// Everything that an open trace says, tiles read in two ways.
pub fn read(trace: &Trace) -> Result<Content> {
    let mut scratch = Scratch::default();
    let (mut cameras, mut tiles) = (Vec::new(), Vec::new());
    let missing = trace.missing_tiles();
    for frame in trace.meta().frame_numbers() {
        if trace.has_frame(frame) {
            cameras.push(trace.camera(frame)?);
        }
        for index in (0..trace.meta().tile_count()).filter(|&i| missing.binary_search(&(frame, i)).is_err()) {
            let tile = trace.tile_with(frame, index, &Column::ALL, &mut scratch)?;
            for column in Column::ALL {
                trace.tile(frame, index, &[column])?;
            }
            tiles.push(tile);
        }
    }
    Ok(Content { meta: trace.meta().clone(), bvh: trace.bvh().clone(), cameras, tiles })
}

pub fn read_bytes(bytes: Vec<u8>, limits: &Limits) -> Result<Content> {
    read(&Trace::from_bytes(bytes, limits.clone())?)
}
