//! The animation: runs of consecutive frames of a camera path, and maps of the paper's frames.
//!
//! A run begins a frame or two early, so that a policy with feedback has a frame before it; these frames do not count.

use std::sync::Arc;

use rayreel_replay::Detail;
use rayreel_replay::image::psnr::{SquaredError, decibels};
use rayreel_study::point::key::Point;
use rayreel_study::point::wanted::{Compared, Figures, Kind, PictureWanted, Views, Wanted};
use rayreel_study::schema::{Map, Track, TrackFrame};

use crate::between::{self, EVERY};
use crate::plan::{Grid, Plan, TILE};
use crate::policies::MODES;
use crate::results::{FrameOf, Results};
use crate::setup::Setup;

/// The frames of the paper's Figure 4, from 1.
const PAPER_FRAMES: [u32; 6] = [1, 150, 340, 400, 600, 700];

/// The scene that the paper animates.
const SCENE: &str = "provence";

/// Frames of a run that count, by default.
const COUNTED: u32 = 2;

/// Frames before them, by default.
const EARLY: u32 = 2;

/// The same for the whole path: a run is what is lost when the program is killed.
const COUNTED_FULL: u32 = 70;
const EARLY_FULL: u32 = 2;

/// Largest picture of the animation, by default and with `--full`: there are many frames, and they are to be compared with each
/// other.
const SIZES: [(u32, u32); 2] = [(256, 128), (512, 256)];

/// Largest width of a map, pixels: they are many, and shown side by side.
const WIDTH_MAX: u32 = 512;

/// A run of frames, from 0.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Stretch {
    /// The first that is replayed.
    first: u32,
    /// The first that counts.
    counted: u32,
    /// The one after the last.
    end: u32,
}

impl Stretch {
    fn new(counted: u32, end: u32, early: u32) -> Self {
        Self { first: counted.saturating_sub(early), counted, end }
    }

    /// The frames that a machine simulates, of run number `run` over a path of `length` frames: of the whole path all that count, or a
    /// sample of them; by default every other of the paper's.
    fn simulated(&self, run: usize, length: u32, (full, detail): (bool, Detail)) -> Vec<u32> {
        // What is asked for is a share of the tiles: it is as well a sample of the frames of a long path.
        let every = match detail {
            Detail::Sampled(_) if length.div_ceil(EVERY) as usize >= between::FEWEST => EVERY,
            _ => 1,
        };
        match (full, run.is_multiple_of(2)) {
            (true, _) => (self.counted..self.end).filter(|f| f.is_multiple_of(every) || f + 1 == length).collect(),
            (false, true) => self.mapped(),
            (false, false) => Vec::new(),
        }
    }

    /// The frames of which there are maps.
    fn mapped(&self) -> Vec<u32> {
        PAPER_FRAMES.iter().map(|frame| frame - 1).filter(|frame| (self.counted..self.end).contains(frame)).collect()
    }
}

/// The runs over a path of `length` frames: all of it, or a few frames that end at each of the paper's.
fn stretches(length: u32, full: bool) -> Vec<Stretch> {
    if full {
        let starts = (0..length).step_by(COUNTED_FULL as usize);
        return starts.map(|start| Stretch::new(start, (start + COUNTED_FULL).min(length), EARLY_FULL)).collect();
    }
    let around = |frame: &u32| {
        let end = (*frame).max(COUNTED).min(length);
        Stretch::new(end.saturating_sub(COUNTED), end, EARLY)
    };
    PAPER_FRAMES.iter().filter(|frame| **frame <= length).map(around).collect()
}

/// Which frames count of a path of which only some do, in words.
fn in_words(runs: &[Stretch]) -> String {
    let (early, late): (Vec<&Stretch>, Vec<&Stretch>) = runs.iter().partition(|run| run.first == run.counted);
    let at_once = early.iter().map(|run| format!("the first {}", run.end - run.counted));
    let after = late.first().map(|run| {
        let (counted, all) = (run.end - run.counted, run.end - run.first);
        let of = if late.len() == 1 { "a run".to_owned() } else { format!("each of {} runs", late.len()) };
        format!("the last {counted} of {of} of {all} consecutive frames")
    });
    at_once.chain(after).collect::<Vec<_>>().join(", and ")
}

/// An animation that is planned.
pub struct Planned {
    scene: usize,
    /// By [`MODES`]. The whole path is undersampled: four times the samples would say the same of the policies.
    mode: usize,
    runs: Vec<Stretch>,
    tracks: Vec<(usize, Vec<usize>)>,
}

/// Plans the animation of the paper's scene, or of the first that moves; nothing if none does.
pub fn plan(setup: &Setup, plan: &mut Plan<'_>) -> Option<Planned> {
    let moves = |scene: &usize| setup.stages[*scene].scene.cameras.len() > 1;
    let all = || (0..setup.stages.len()).filter(moves);
    let scene = all().find(|scene| setup.stages[*scene].name == SCENE).or_else(|| all().next())?;
    let length = setup.stages[scene].scene.cameras.len() as u32;
    let (runs, mode) = (stretches(length, setup.full), usize::from(setup.full));
    let mut tracks: Vec<(usize, Vec<usize>)> = Vec::new();
    for (i, run) in runs.iter().enumerate() {
        let frames = (run.first, run.end - run.first);
        let grid = Grid { scene, size: size(setup), samples: MODES[mode].samples, tile: TILE, frames };
        let capture = plan.capture(&grid, true);
        for (policy, (contender, named)) in setup.policies.iter().enumerate() {
            if !contender.is_animated(mode, setup.full) {
                continue;
            }
            let simulates = setup.machines.is_some() && contender.is_simulated(setup.full);
            let simulated = if simulates { run.simulated(i, length, (setup.full, setup.detail)) } else { Vec::new() };
            let shown = if contender.mapped { pictures(setup, scene, policy, run) } else { Vec::new() };
            let (pictures, files): (Vec<_>, Vec<_>) = shown.into_iter().unzip();
            let figures = Figures::Frames { compared: Compared::Valued, simulated };
            let wanted = Wanted { figures, views: Views { tiles: false, pictures } };
            let machine = setup.machines.as_ref().map(|machines| Arc::clone(machines.traversal()));
            let (source, named, detail) = (String::new(), Arc::clone(named), setup.detail);
            let point = Point { source, frames, machine, policy: named, detail, wanted };
            let point = plan.point(capture, point, files);
            match tracks.iter_mut().find(|(known, _)| *known == policy) {
                Some((_, points)) => points.push(point),
                None => tracks.push((policy, vec![point])),
            }
        }
    }
    Some(Planned { scene, mode, runs, tracks })
}

/// Picture size of the animation.
pub fn size(setup: &Setup) -> (u32, u32) {
    setup.size_within(SIZES[usize::from(setup.full)])
}

/// Where a map lies.
fn file(setup: &Setup, scene: usize, policy: usize, frame: u32, what: &str) -> String {
    let (scene, policy) = (&setup.stages[scene].name, setup.policies[policy].0.name);
    format!("{scene}-frames/{:04}-{policy}-{what}.png", frame + 1)
}

fn pictures(setup: &Setup, scene: usize, policy: usize, run: &Stretch) -> Vec<(PictureWanted, String)> {
    let mut all = Vec::new();
    let shrink = size(setup).0.div_ceil(WIDTH_MAX);
    for frame in run.mapped() {
        let mut add = |kind, what| {
            all.push((PictureWanted { frame, kind, shrink }, file(setup, scene, policy, frame, what)));
        };
        add(Kind::Result, "picture");
        add(Kind::Similarity, "similarity");
        if setup.has_rates(policy) {
            add(Kind::Rate, "rate");
        }
    }
    all
}

impl Planned {
    /// The frames of a track that count.
    fn frames<'a>(&'a self, points: &'a [usize], results: &'a Results) -> impl Iterator<Item = FrameOf<'a>> {
        let counted = |(run, point): (&'a Stretch, &usize)| {
            results.frames(*point).filter(|frame| (run.counted..run.end).contains(&frame.frame))
        };
        self.runs.iter().zip(points).flat_map(counted)
    }

    /// How many frames count, and of how many.
    pub fn extent(&self, setup: &Setup) -> (usize, usize) {
        let counted = self.runs.iter().map(|run| (run.end - run.counted) as usize).sum();
        (counted, setup.stages[self.scene].scene.cameras.len())
    }

    /// Which frames count, if not all of them do: a run that is not the beginning of the path has frames before them.
    pub fn part(&self, setup: &Setup) -> Option<String> {
        let (counted, all) = self.extent(setup);
        (counted < all).then(|| in_words(&self.runs))
    }

    /// How many frames a machine simulates.
    pub fn simulated(&self, setup: &Setup) -> usize {
        let (length, how) = (setup.stages[self.scene].scene.cameras.len() as u32, (setup.full, setup.detail));
        self.runs.iter().enumerate().map(|(i, run)| run.simulated(i, length, how).len()).sum()
    }

    /// Whether the frames that are not simulated are estimated.
    pub fn estimates(&self, setup: &Setup) -> bool {
        setup.full && self.simulated(setup) < self.extent(setup).0
    }

    /// Name of the scene.
    pub fn scene<'a>(&self, setup: &'a Setup) -> &'a str {
        &setup.stages[self.scene].name
    }

    /// The figures over the frames.
    pub fn tracks(&self, setup: &Setup, results: &Results) -> Vec<Track> {
        let track = |(policy, points): &(usize, Vec<usize>)| {
            let frames: Vec<FrameOf<'_>> = self.frames(points, results).collect();
            let mut shown: Vec<TrackFrame> = frames.iter().map(track_frame).collect();
            let interval = if self.estimates(setup) { between::estimate(&mut shown) } else { None };
            Track {
                scene: self.scene(setup).into(),
                policy: setup.policies[*policy].1.name.clone(),
                mode: MODES[self.mode].name.into(),
                frames: shown,
                interval,
                flicker: squared(frames.iter().filter_map(|f| f.flicker)).map(SquaredError::rms),
                psnr_db: squared(frames.iter().filter_map(|f| f.error)).and_then(|sum| decibels(sum.sum, sum.values)),
            }
        };
        self.tracks.iter().map(track).collect()
    }

    /// The maps of the paper's frames.
    pub fn maps(&self, setup: &Setup, results: &Results) -> Vec<Map> {
        let mut maps = Vec::new();
        for (policy, points) in self.tracks.iter().filter(|(policy, _)| setup.policies[*policy].0.mapped) {
            for frame in
                self.frames(points, results).filter(|f| self.runs.iter().any(|r| r.mapped().contains(&f.frame)))
            {
                let file = |what| file(setup, self.scene, *policy, frame.frame, what);
                maps.push(Map {
                    scene: self.scene(setup).into(),
                    policy: setup.policies[*policy].1.name.clone(),
                    frame: frame.frame + 1,
                    similarity: file("similarity"),
                    rate: setup.has_rates(*policy).then(|| file("rate")),
                    picture: Some(file("picture")),
                    similarity_ratio: frame.view.similarity_ratio(),
                    mean_rate: frame.view.mean_rate(),
                    paper_ratio: None,
                });
            }
        }
        maps
    }
}

fn squared(parts: impl Iterator<Item = (u64, u64)>) -> Option<SquaredError> {
    parts.map(|(sum, values)| SquaredError { sum, values }).reduce(|a, b| a + b)
}

fn track_frame(frame: &FrameOf<'_>) -> TrackFrame {
    let view = frame.view;
    let cost = view.ti();
    TrackFrame {
        frame: frame.frame + 1,
        rays_full: view.rays_full(),
        rays_traced: view.rays_traced(),
        power_w: cost.map(|c| c.power_w),
        time_ms: cost.map(|c| c.time_ms),
        energy_mj: cost.map(|c| c.energy_mj),
        interval: cost.and_then(|c| c.interval),
        psnr_db: view.quality().and_then(|q| q.psnr_db),
        mean_rate: view.mean_rate(),
        similarity_ratio: view.similarity_ratio(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_default_a_run_ends_at_each_of_the_papers_frames() {
        let runs = stretches(700, false);
        assert_eq!(runs.len(), PAPER_FRAMES.len());
        assert_eq!(runs[0], Stretch { first: 0, counted: 0, end: COUNTED });
        assert_eq!(runs[5], Stretch { first: 700 - COUNTED - EARLY, counted: 700 - COUNTED, end: 700 });
        let mapped: Vec<u32> = runs.iter().flat_map(Stretch::mapped).collect();
        assert_eq!(mapped, PAPER_FRAMES.map(|frame| frame - 1));
        let sampled = Detail::Sampled("5%".parse().unwrap());
        let simulated = runs.iter().enumerate().flat_map(|(i, run)| run.simulated(i, 700, (false, sampled)));
        let simulated: Vec<u32> = simulated.collect();
        assert_eq!(simulated, [0, 339, 599]);
        // A short path has what there is of it.
        assert_eq!(stretches(2, false), [Stretch { first: 0, counted: 0, end: 2 }]);
    }

    /// Of the first frames nothing was replayed before them, and of a short path there are no others.
    #[test]
    fn frames_that_count_are_said_as_they_are() {
        let said = |length| in_words(&stretches(length, false));
        assert_eq!(said(700), "the first 2, and the last 2 of each of 5 runs of 4 consecutive frames");
        assert_eq!(said(200), "the first 2, and the last 2 of a run of 4 consecutive frames");
        assert_eq!(said(100), "the first 2");
    }

    #[test]
    fn the_whole_path_is_counted_once() {
        let runs = stretches(700, true);
        let counted: Vec<u32> = runs.iter().flat_map(|run| run.counted..run.end).collect();
        assert_eq!(counted, (0..700).collect::<Vec<_>>());
        assert!(runs[1..].iter().all(|run| run.first + EARLY_FULL == run.counted));
        assert_eq!(runs.iter().flat_map(Stretch::mapped).count(), PAPER_FRAMES.len());
        let simulated = |length, detail| -> Vec<u32> {
            stretches(length, true).iter().flat_map(|run| run.simulated(1, length, (true, detail))).collect()
        };
        assert_eq!(simulated(700, Detail::Full), (0..700).collect::<Vec<_>>());
        // A sample of the tiles is one of the frames, if the path is long enough.
        let sampled = Detail::Sampled("5%".parse().unwrap());
        let some = simulated(700, sampled);
        assert_eq!((some.len(), &some[..3], &some[62..]), (65, &[0, 11, 22][..], &[682, 693, 699][..]));
        assert_eq!(simulated(209, sampled), (0..209).collect::<Vec<_>>());
        assert_eq!(simulated(210, sampled).len(), 20);
    }

    /// A box seen from a camera that goes by, under policies of one sample a pixel.
    fn flight(detail: Detail) -> Vec<Track> {
        let mut scene = rayreel_scenes::load("cornell").unwrap();
        let camera = scene.cameras[0];
        let passing = |frame: u32| {
            let (mut camera, aside) = (camera, 0.002 * f64::from(frame));
            camera.eye[0] += aside as f32;
            camera
        };
        scene.cameras = (0..EVERY * between::FEWEST as u32).map(passing).collect();
        let machines = crate::Machines::load("sgrt-ti2", false).unwrap();
        let setup = Setup::new([scene], Some(machines)).unwrap();
        let setup = Setup { size: (16, 8), full: true, detail, ..setup };
        let place = tempfile::tempdir().unwrap();
        let folders =
            crate::Folders { cache: place.path().join("cache"), out: place.path().join("out"), reuse: Vec::new() };
        crate::run(&setup, &folders, 2, &rayreel_replay::Stop::never(), &mut |_| {}).unwrap().study.tracks
    }

    #[test]
    fn an_estimated_flight_is_near_that_of_every_frame() {
        let (estimated, whole) = (flight(crate::detail()), flight(Detail::Full));
        let mut simulated = 0;
        for (estimated, whole) in estimated.iter().zip(&whole) {
            assert_eq!((&estimated.policy, whole.interval), (&whole.policy, None));
            let Some(interval) = estimated.interval else {
                assert!(estimated.frames.iter().all(|frame| frame.energy_mj.is_none()), "{}", estimated.policy);
                continue;
            };
            simulated += 1;
            for (of, is) in estimated.frames.iter().zip(&whole.frames) {
                let is_simulated = (of.frame - 1).is_multiple_of(EVERY) || of.frame as usize == whole.frames.len();
                assert!(is_simulated == of.interval.is_none() && (!is_simulated || of == is), "{of:?} {is:?}");
                // Rays and pictures are those of every frame.
                let exact = |f: &TrackFrame| (f.rays_traced, f.psnr_db, f.similarity_ratio);
                assert_eq!(exact(of), exact(is));
            }
            let sum = |track: &Track, of: fn(&TrackFrame) -> Option<f64>| {
                track.frames.iter().map(|frame| of(frame).unwrap()).sum::<f64>()
            };
            let off = |of| (sum(estimated, of) / sum(whole, of) - 1.0).abs();
            let (energy, time) = (off(|f| f.energy_mj), off(|f| f.time_ms));
            assert!(energy <= interval.energy_mj && time <= interval.cycles, "{}: {energy}, {time}", whole.policy);
        }
        assert_eq!(simulated, 6);
    }
}
