//! A request to stop ends a replay with an error of its own, and nothing is read after it.

use std::path::Path;
use std::sync::atomic::{AtomicU32, Ordering};

use rayreel_formats::Limits;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::Trace;
use rayreel_replay::{Options, PathSource, Policy, ReplayError, Replayer, Stop, TileSource};
use rayreel_testkit::synthetic::{Look, Synthetic};

/// A source that counts what is read, and requests a stop when its tile `at` is.
struct Counted {
    source: Synthetic,
    stop: Stop,
    at: Option<u32>,
    cameras: AtomicU32,
    tiles: AtomicU32,
}

impl Counted {
    /// Frames 5 to 7 of 4 x 4 tiles.
    fn new(stop: &Stop, at: Option<u32>) -> Self {
        let source = Synthetic::new(Look::Discs, (64, 64), 1, 16, 1);
        Self { source, stop: stop.clone(), at, cameras: AtomicU32::new(0), tiles: AtomicU32::new(0) }
    }

    fn read(&self) -> (u32, u32) {
        (self.cameras.load(Ordering::SeqCst), self.tiles.load(Ordering::SeqCst))
    }
}

impl TileSource for Counted {
    fn meta(&self) -> &Meta {
        self.source.meta()
    }
    fn object_of(&self, triangle: u32) -> u32 {
        self.source.object_of(triangle)
    }
    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.cameras.fetch_add(1, Ordering::SeqCst);
        self.source.camera(frame)
    }
    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        self.tiles.fetch_add(1, Ordering::SeqCst);
        if self.at == Some(index) {
            self.stop.request();
        }
        self.source.tile(frame, index)
    }
}

fn replayer<'a>(source: &'a Counted, stop: &Stop) -> Replayer<'a, Counted> {
    Replayer::new(source, &Policy::Full, Options::default()).unwrap().with_stop(stop.clone())
}

#[test]
fn before_a_frame_nothing_of_it_is_read() {
    let stop = Stop::never();
    let source = Counted::new(&stop, None);
    let mut replayer = replayer(&source, &stop);
    replayer.frame(5).unwrap();
    assert_eq!(source.read(), (1, 16));
    stop.request();
    for _ in 0..2 {
        assert!(matches!(replayer.frame(6), Err(ReplayError::Interrupted)));
        assert_eq!(source.read(), (1, 16));
    }
}

#[test]
fn within_a_frame_no_further_row_is_read() {
    for at in [0, 5, 11] {
        let stop = Stop::never();
        let source = Counted::new(&stop, Some(at));
        assert!(matches!(replayer(&source, &stop).frame(5), Err(ReplayError::Interrupted)));
        // Other tiles of the row may be at work already.
        let (_, tiles) = source.read();
        assert!((at / 4 * 4 + 1..=(at / 4 + 1) * 4).contains(&tiles), "{tiles} tiles are read, stopped at {at}");
    }
}

#[test]
fn a_machine_is_not_fed_after_it() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace");
    let trace = Trace::open(&path, Limits::default()).unwrap();
    let (frame, tree) = (trace.meta().first_frame, trace.topology());
    for last in [0, 1, trace.meta().tile_count() - 2] {
        let (stop, mut fed) = (Stop::never(), 0);
        let mut replayer = Replayer::new(&trace, &Policy::Full, Options::default()).unwrap().with_stop(stop.clone());
        let ended = replayer.frame_with(frame, &tree, |work| {
            fed += 1;
            if work.tile == last {
                stop.request();
            }
            Ok(())
        });
        assert!(matches!(ended, Err(ReplayError::Interrupted)));
        assert_eq!(fed, last + 1);
    }
}
