//! Policy to machine: the work that tiles become, on the golden traces, and paths that are checked against the tree.

mod walks;

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{RayKind, Tile};
use rayreel_formats::trace::Trace;
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::synthetic::{Random, balanced_topology, random_tile};
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{NO_RAY, TileWork};
use rayreel_replay::counts::RayCounts;
use rayreel_replay::error::ReplayError;
use rayreel_replay::policy::view::SampleState;
use rayreel_replay::policy::{Apron, Policy, Refine};
use rayreel_replay::{FrameReplay, Options, PathSource, Replayer, TileSource};
use rayreel_testkit::policy;
use walks::independent;

fn golden(name: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&path, Limits::default()).unwrap()
}

fn traces() -> Vec<Trace> {
    ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"].map(golden).into()
}

type Run = (FrameReplay, PathCounts, Vec<TileWork>);

fn run<S: PathSource>(source: &S, policy: &Policy) -> Result<Run, ReplayError> {
    let frame = source.meta().first_frame;
    let mut works = Vec::new();
    let mut replayer = Replayer::new(source, policy, Options::default())?;
    let (replay, paths) = replayer.frame_with(frame, &source.topology(), |work| {
        works.push(work);
        Ok(())
    })?;
    Ok((replay, paths, works))
}

fn policies() -> Vec<Policy> {
    let mut list = vec![Policy::Full];
    for (block, refine) in [(2, Refine::Direct), (4, Refine::Direct), (4, Refine::Hierarchical)] {
        list.extend([Apron::Share, Apron::Retrace].map(|apron| policy(block, refine, apron)));
    }
    list
}

fn kinds(work: &TileWork) -> RayCounts {
    let number = |kind| work.rays.iter().filter(|ray| ray.kind == kind).count() as u64;
    RayCounts {
        primary: number(RayKind::Primary),
        reflection: number(RayKind::Reflection),
        refraction: number(RayKind::Refraction),
        shadow: number(RayKind::Shadow),
    }
}

/// Every ray hangs on exactly one other, or is a primary ray of exactly one round.
fn assert_linked(work: &TileWork) {
    let mut named = vec![0; work.rays.len()];
    for (i, ray) in work.rays.iter().enumerate() {
        for child in [ray.reflect, ray.refract].into_iter().filter(|&c| c != NO_RAY) {
            named[child as usize] += 1;
            assert_eq!(work.rays[child as usize].depth, ray.depth + 1);
        }
        for (shadow, named) in named.iter_mut().enumerate().skip(i + 1).take(ray.shadows.into()) {
            *named += 1;
            assert_eq!((work.rays[shadow].kind, work.rays[shadow].depth), (RayKind::Shadow, ray.depth));
        }
    }
    for &primary in work.rounds.iter().flat_map(|round| &round.starts) {
        named[primary as usize] += 1;
        assert_eq!(work.rays[primary as usize].kind, RayKind::Primary);
    }
    assert!(named.iter().all(|&n| n == 1), "a ray is named {named:?} times");
}

/// The tile that brings the R-samples behind sample (`x`, `y`), for blocks of `block` samples.
fn closing_tile(meta: &Meta, block: u32, (x, y): (u32, u32)) -> u32 {
    let (width, height) = meta.grid();
    let tile = |at: u32, end: u32| at.next_multiple_of(block).min(end - 1) / meta.tile;
    tile(y, height) * meta.tile_grid().0 + tile(x, width)
}

/// The samples of a tile's rounds are those of the state map; gives how many were found outside the tile, to its right or below.
fn assert_rounds(work: &TileWork, frame: &FrameReplay) -> u32 {
    let rect = work.rect;
    let mut outside = 0;
    for (number, round) in work.rounds.iter().enumerate() {
        let mut last = None;
        for &primary in &round.starts {
            let (x, y) = (work.rays[primary as usize].x, work.rays[primary as usize].y);
            assert_ne!(frame.states.state(x, y), SampleState::Interpolated);
            assert_eq!(usize::from(frame.states.round(x, y)), number);
            if is_inside(work, primary) {
                assert!(last < Some((y, x)) && outside_is_last(work, round.starts.as_slice(), primary));
                last = Some((y, x));
            } else if x >= rect.x + rect.width || y >= rect.y + rect.height {
                outside += 1;
            }
        }
    }
    outside
}

/// Samples of other tiles stand behind those of the tile in every round: their rays come later.
fn outside_is_last(work: &TileWork, primaries: &[u32], last: u32) -> bool {
    primaries.iter().take_while(|&&ray| ray != last).all(|&ray| is_inside(work, ray))
}

fn is_inside(work: &TileWork, ray: u32) -> bool {
    let (ray, rect) = (&work.rays[ray as usize], work.rect);
    (rect.x..rect.x + rect.width).contains(&ray.x) && (rect.y..rect.y + rect.height).contains(&ray.y)
}

#[test]
fn rays_and_rounds_are_those_of_the_policy() {
    for trace in traces() {
        for policy in policies() {
            let (frame, paths, works) = run(&trace, &policy).unwrap();
            let plain = Replayer::new(&trace, &policy, Options::default()).unwrap().frame(frame.frame).unwrap();
            assert_eq!(frame, plain, "a machine changes no picture");
            assert!(works.iter().map(|w| w.tile).eq(0..trace.meta().tile_count()));
            let (mut rays, mut interpolated) = (0, 0);
            let again = matches!(&policy, Policy::Adaptive(adaptive) if adaptive.apron == Apron::Retrace);
            let block = if let Policy::Adaptive(adaptive) = &policy { adaptive.block } else { 1 };
            for (work, stats) in works.iter().zip(&frame.stats.tiles) {
                let counts = &stats.counts;
                let mut primaries = work.rays.iter().filter(|ray| ray.kind == RayKind::Primary);
                if again {
                    assert_eq!(kinds(work), counts.rays_traced + counts.rays_apron, "{policy:?}");
                } else {
                    assert!(primaries.all(|ray| closing_tile(trace.meta(), block, (ray.x, ray.y)) == work.tile));
                }
                assert_eq!(u64::from(work.apron_samples), counts.samples_apron);
                assert_linked(work);
                assert_eq!(assert_rounds(work, &frame), work.apron_samples);
                interpolated += work.rounds.iter().map(|w| u64::from(w.interpolated)).sum::<u64>();
                rays += work.rays.len() as u64;
            }
            assert_eq!(paths.rays, rays);
            let all = works.iter().map(kinds).sum::<RayCounts>();
            let counts = &frame.stats.counts;
            assert_eq!(all, counts.rays_traced + counts.rays_apron, "{policy:?}");
            let primaries: usize = works.iter().flat_map(|work| &work.rounds).map(|round| round.starts.len()).sum();
            assert_eq!(primaries as u64, counts.samples_traced + counts.samples_apron);
            assert!(interpolated == frame.stats.counts.samples_interpolated || again && interpolated > 0, "{policy:?}");
        }
    }
}

#[test]
fn paths_are_the_recorded_ones() {
    let trace = golden("v1_0_teapot.rtrace");
    let (_, paths, works) = run(&trace, &Policy::Full).unwrap();
    let mut sum = PathCounts::default();
    for work in &works {
        let tile = trace.tile_with_paths(work.frame, work.tile).unwrap();
        assert_eq!(work.rounds.len(), 1);
        assert_eq!(work.rays.len(), tile.paths.spans.len());
        for (i, ray) in (0..).zip(&work.rays) {
            let steps = tile.paths.ray(i as usize);
            let (counts, ops) = independent(&trace.topology(), steps, ray.kind == RayKind::Shadow).unwrap();
            assert_eq!(work.path(i), ops);
            sum += counts;
        }
    }
    assert_eq!(paths, sum);
}

/// Direct refinement tests each gap once, so the number of tests is known beforehand.
#[test]
fn tests_are_counted_by_round() {
    for trace in traces() {
        let (w, h) = trace.meta().grid();
        let (columns, rows) = trace.meta().tile_grid();
        let n = 4;
        let lines = |len: u32| (0..len).filter(|i| i % n == 0 || i + 1 == len).collect::<Vec<_>>();
        let gaps = |len: u32| lines(len).windows(2).filter(|pair| pair[1] - pair[0] >= 2).count() as u32;
        for apron in [Apron::Share, Apron::Retrace] {
            let (frame, _, works) = run(&trace, &policy(n, Refine::Direct, apron)).unwrap();
            let tests = |round: usize| works.iter().filter_map(|w| w.rounds.get(round)).map(|w| w.tests).sum::<u32>();
            let again = if apron == Apron::Retrace { (rows - 1) * gaps(w) } else { 0 };
            assert_eq!([tests(0), tests(1), tests(2)], [0, lines(h).len() as u32 * gaps(w) + again, w * gaps(h)]);
            assert!(works.iter().all(|w| w.rounds.len() <= 3));
            for work in &works {
                let (left, above) = (work.tile % columns > 0, work.tile >= columns);
                let r_rows =
                    (work.rect.y..work.rect.y + work.rect.height).filter(|&y| y % n == 0 || y + 1 == h).count();
                let shared = u32::from(left) * r_rows as u32 + u32::from(above) * work.rect.width;
                assert_eq!(work.border_samples, if apron == Apron::Share { shared } else { 0 });
            }
            let [read, kept] = [|w: &TileWork| w.border_samples, |w: &TileWork| w.kept_samples]
                .map(|of| works.iter().map(of).sum::<u32>());
            assert_eq!(read, kept, "what is kept is read");
            assert!(frame.stats.counts.samples_interpolated > 0, "something to interpolate");
        }
    }
}

/// The producer decides in rayon's global pool, whose size is fixed once a process: so this test runs itself in two others.
#[test]
fn threads_do_not_change_the_work() {
    const CHILD: &str = "RAYREEL_TEST_WORK_DIGEST";
    let name = "threads_do_not_change_the_work";
    if std::env::var_os(CHILD).is_some() {
        let works = run(&golden("v1_0_cornell.rtrace"), &policy(4, Refine::Hierarchical, Apron::Retrace)).unwrap();
        // FNV-1a over everything there is.
        let hash = format!("{works:?}")
            .bytes()
            .fold(0xcbf2_9ce4_8422_2325u64, |h, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        println!("digest {} {hash:x}", works.2.len());
        return;
    }
    let with = |threads: &str| {
        let mut child = std::process::Command::new(std::env::current_exe().unwrap());
        child.args(["--exact", name, "--nocapture"]).env(CHILD, "1").env("RAYON_NUM_THREADS", threads);
        let text = String::from_utf8(child.output().unwrap().stdout).unwrap();
        text.split_once("digest ").expect("a digest").1.lines().next().unwrap().to_owned()
    };
    assert_eq!(with("1"), with("3"));
}

/// A trace in which some steps were changed.
struct Broken<'a> {
    trace: &'a Trace,
    seed: u64,
}

impl TileSource for Broken<'_> {
    fn meta(&self) -> &Meta {
        self.trace.meta()
    }
    fn object_of(&self, triangle: u32) -> u32 {
        self.trace.object_of(triangle)
    }
    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.trace.camera(frame)
    }
    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        TileSource::tile(self.trace, frame, index)
    }
}

impl PathSource for Broken<'_> {
    fn topology(&self) -> Topology {
        self.trace.topology()
    }
    fn material_of(&self, triangle: u32) -> u32 {
        self.trace.material_of(triangle)
    }
    fn tile_with_paths(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        let mut tile = self.trace.tile_with_paths(frame, index)?;
        let mut random = Random(self.seed);
        let steps = tile.paths.steps.len() as u32;
        if index == 1 && steps > 0 {
            match self.seed % 4 {
                0 => tile.paths.spans[0].1 += 1 + random.below(9),
                1 => tile.paths.spans[0] = (steps, 7),
                2 => _ = tile.paths.spans.pop(),
                _ => tile.paths.steps[random.below(steps) as usize] = random.below(12) as u8,
            }
        }
        Ok(tile)
    }
}

#[test]
fn broken_paths_are_errors() {
    let trace = golden("v1_0_cornell.rtrace");
    let mut refused = 0;
    for seed in 0..40 {
        match run(&Broken { trace: &trace, seed }, &Policy::Full) {
            Ok(_) => assert_eq!(seed % 4, 3, "only a single step may happen to stay valid"),
            Err(ReplayError::Corrupt { tile: 1, ray: Some(_), .. }) => refused += 1,
            Err(ReplayError::Corrupt { tile: 1, ray: None, .. }) if seed % 4 == 2 => {}
            Err(error) => panic!("{error}"),
        }
    }
    assert!(refused >= 25, "{refused} of 40 refused");
}

#[test]
fn a_consumer_that_stops_ends_the_replay() {
    let trace = golden("v1_0_cornell.rtrace");
    let tree = trace.topology();
    let last = trace.meta().tile_count() - 1;
    for stop in [0, 1, last] {
        let mut seen = 0;
        let mut replayer = Replayer::new(&trace, &Policy::Full, Options::default()).unwrap();
        let result = replayer.frame_with(trace.meta().first_frame, &tree, |work| {
            seen += 1;
            if work.tile == stop { Err(ReplayError::Usage { detail: "enough".into() }) } else { Ok(()) }
        });
        assert!(matches!(result, Err(ReplayError::Usage { detail }) if detail == "enough"));
        assert_eq!(seen, stop + 1);
    }
}

#[test]
fn synthetic_tiles_are_whole() {
    let tree = balanced_topology(6, 2);
    let make = || random_tile(&tree, 3, 100, 2, &mut Random(5));
    let work = make();
    assert_eq!(work, make());
    assert_linked(&work);
    assert!(work.rays.iter().any(|ray| ray.shadows > 0) && work.rays.iter().any(|ray| ray.depth == 2));
    assert!((0..work.rays.len()).all(|ray| !work.path(ray as u32).is_empty()));
}
