//! Several policies on one pass do as each would alone.

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_replay::{
    FrameReplay, NamedPolicy, Options, ReplayError, Replayer, Replayers, SamplePolicy, Stop, TileSource,
};
use rayreel_testkit::synthetic::{Look, Synthetic};

const POLICIES: [&str; 11] = [
    "multirate",
    "temporal",
    "foveated",
    "full",
    "paper-ss",
    "adaptive",
    "quality",
    "whitted1980",
    "mitchell1987",
    "jin2009",
    "kim2016",
];

fn policies() -> Vec<NamedPolicy> {
    POLICIES.iter().map(|name| NamedPolicy::load(name, &[]).unwrap()).collect()
}

fn dynamic(policies: &[NamedPolicy]) -> Vec<&dyn SamplePolicy> {
    policies.iter().map(|policy| policy as &dyn SamplePolicy).collect()
}

fn source(look: Look, size: (u32, u32), samples: u32) -> Synthetic {
    let mut source = Synthetic::new(look, size, samples, 16, 5);
    (source.meta.first_frame, source.meta.frames) = (0, 3);
    source
}

#[test]
fn together_is_as_alone() {
    // A tile of 16 samples ends within a pixel of 3.
    for (look, size, samples) in [(Look::Trees, (47, 33), 1), (Look::Discs, (20, 21), 3), (Look::Noise, (16, 70), 2)] {
        let (source, all) = (source(look, size, samples), policies());
        for options in [Options::default(), Options { reference: false, perception: false, traced: true }] {
            let mut together = Replayers::new(&source, &dynamic(&all), options).unwrap();
            let mut alone: Vec<_> = all.iter().map(|policy| Replayer::new(&source, policy, options).unwrap()).collect();
            for frame in source.meta.frame_numbers() {
                let expected: Vec<FrameReplay> = alone.iter_mut().map(|one| one.frame(frame).unwrap()).collect();
                let found = together.frame(frame).unwrap();
                assert_eq!(found.len(), expected.len());
                for ((name, found), expected) in POLICIES.iter().zip(&found).zip(&expected) {
                    assert!(found == expected, "{name}, frame {frame} of {size:?}");
                    assert_eq!(found.reference.is_some(), options.reference);
                }
            }
        }
    }
}

/// A source that lacks some tiles.
struct Holes(Synthetic);

impl TileSource for Holes {
    fn meta(&self) -> &Meta {
        self.0.meta()
    }
    fn object_of(&self, triangle: u32) -> u32 {
        self.0.object_of(triangle)
    }
    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.0.camera(frame)
    }
    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        if index >= 5 { Err(rayreel_formats::Error::usage("a hole")) } else { self.0.tile(frame, index) }
    }
}

#[test]
fn errors_end_all_of_them() {
    let (holes, all) = (Holes(source(Look::Discs, (64, 64), 1)), policies());
    let error = Replayers::new(&holes, &dynamic(&all), Options::default()).unwrap().frame(0).unwrap_err();
    assert!(matches!(&error, ReplayError::Trace { what, frame: 0, .. } if what == "tile 5"), "{error}");
    let whole = source(Look::Discs, (64, 64), 1);
    let stop = Stop::never();
    stop.request();
    let mut replayers = Replayers::new(&whole, &dynamic(&all), Options::default()).unwrap().with_stop(stop);
    assert!(matches!(replayers.frame(0), Err(ReplayError::Interrupted)));
    let mut replayers = Replayers::new(&whole, &dynamic(&all), Options::default()).unwrap();
    assert!(matches!(replayers.frame(9), Err(ReplayError::Request(_))));
    assert!(Replayers::new(&whole, &[], Options::default()).unwrap().frame(0).unwrap().is_empty());
}
