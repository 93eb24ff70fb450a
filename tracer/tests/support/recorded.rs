//! Captures small traces and writes changed ones.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::scene::Meta;
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec, Trace, TraceWriter};
use rayreel_scenes::Scene;
use rayreel_tracer::capture::capture;
use rayreel_tracer::{Built, CaptureOutcome, CaptureOutput, SampleGrid, TraceSettings, build};
use tempfile::TempDir;

/// A trace, in a folder that goes with it.
pub struct Recorded {
    pub trace: Trace,
    _folder: TempDir,
}

fn folder() -> TempDir {
    tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).expect("a folder can be made")
}

fn open(folder: TempDir, path: &Path) -> Recorded {
    Recorded { trace: Trace::open(path, Limits::default()).expect("it opens"), _folder: folder }
}

/// A sample grid of one frame.
pub fn grid(width: u32, height: u32, samples: u32, tile: u32) -> SampleGrid {
    SampleGrid { width, height, samples, tile, first_frame: 0, frames: 1 }
}

pub fn record(scene: &Scene, grid: SampleGrid, max_depth: u32, codec: Codec) -> Recorded {
    let built: Built = build(scene).expect("a tree");
    let meta: Meta = grid.meta(scene, TraceSettings { max_depth, ..TraceSettings::default() }, "test");
    let folder = folder();
    let path = folder.path().join("trace.rtrace");
    let output = CaptureOutput::new(path.clone(), codec, 1);
    let outcome = capture(scene, &built, &meta, &output, |_| true).expect("it captures");
    assert!(matches!(outcome, CaptureOutcome::Finished(_)));
    open(folder, &path)
}

/// All tiles of a trace.
pub fn tiles(trace: &Trace) -> Vec<Tile> {
    let numbers = trace.meta().frame_numbers().flat_map(|f| (0..trace.meta().tile_count()).map(move |t| (f, t)));
    numbers.map(|(frame, tile)| trace.tile(frame, tile, &Column::ALL).expect("it decodes")).collect()
}

/// The same trace with other tiles. They are coded plainly, because the context codec codes only paths that fit the
/// tree.
pub fn rewrite(trace: &Trace, tiles: &[Tile]) -> Recorded {
    let folder = folder();
    let path = folder.path().join("changed.rtrace");
    let mut writer = TraceWriter::create(&path, trace.meta(), trace.bvh(), 1).expect("a new file");
    let (topology, limits) = (BvhTopology::new(trace.bvh()), Limits::default());
    for tile in tiles {
        let camera = trace.camera(tile.frame).expect("the frame is there");
        writer.frame(tile.frame, &camera).expect("it is written");
        let coder =
            TileCodec { meta: trace.meta(), bvh: trace.bvh(), topology: &topology, camera: &camera, limits: &limits };
        let chunk = coder.encode(tile, Codec::Plain(1), &mut Scratch::default()).expect("it encodes");
        writer.tile(&chunk).expect("it is written");
    }
    let path = writer.finish().expect("a whole file").path;
    open(folder, &path)
}
