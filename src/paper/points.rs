//! Every scene in both modes under every policy: the paper's Figure 7 and Table 1, and what goes beyond them.

use std::sync::Arc;

use rayreel_machine::config::NamedMachine;
use rayreel_replay::Policy;
use rayreel_study::schema::{Cost, Gain, Point, ViewerImages, ViewerSet};

use super::Setup;
use super::plan::{Compared, Grid, Job, Kind, Picture, Plan, TILE};
use super::policies::{MODES, PAPER};
use super::record::{Frame, Machine, Record};

/// Pictures larger than this many pixels are shown for two policies in one mode only: a page with all could not be opened.
const PIXELS_SHOWN: u64 = 1 << 20;

/// The policy that is shown beside the paper's where pictures are large.
const BEST: &str = "multirate";

/// A point that is planned.
pub struct Planned {
    scene: usize,
    mode: usize,
    policy: usize,
    /// Compared with `full`; on the whole machine, or the T&I units alone, if there is one.
    picture: usize,
    /// On the whole machine.
    gpu: Option<usize>,
    /// The T&I units alone.
    alone: Option<usize>,
    images: Option<ViewerImages>,
}

impl Planned {
    /// Whether it has pictures.
    pub fn is_shown(&self) -> bool {
        self.images.is_some()
    }
}

/// Plans all points.
pub fn plan(setup: &Setup<'_>, plan: &mut Plan<'_>) -> Vec<Planned> {
    let mut points = Vec::new();
    for scene in 0..setup.stages.len() {
        for (mode, own) in MODES.iter().enumerate() {
            let grid = Grid { scene, size: setup.size, samples: own.samples, tile: TILE, frames: (0, 1) };
            let shot = plan.shot(&grid, false);
            for (policy, (entry, named)) in setup.policies.iter().enumerate() {
                if !entry.modes[mode].now(setup.full) {
                    continue;
                }
                let (pictures, images) = if is_shown(setup, mode, policy) {
                    let (pictures, images) = pictures(setup, scene, mode, policy);
                    (pictures, Some(images))
                } else {
                    (Vec::new(), None)
                };
                let job = Job {
                    shot,
                    policy: Arc::clone(named),
                    machine: None,
                    simulated: Vec::new(),
                    compared: Compared::Seen,
                    tiles: images.is_some(),
                    pictures,
                };
                let (picture, gpu, alone) = simulations(setup, plan, job, entry.whole);
                points.push(Planned { scene, mode, policy, picture, gpu, alone, images });
            }
        }
    }
    points
}

/// The jobs of a point: the one that compares pictures, the one on the whole machine, the one of the T&I units alone.
fn simulations(setup: &Setup<'_>, plan: &mut Plan<'_>, job: Job, whole: bool) -> (usize, Option<usize>, Option<usize>) {
    let Some(machines) = &setup.machines else { return (plan.job(job), None, None) };
    let on =
        |machine: &Arc<NamedMachine>, job: Job| Job { machine: Some(Arc::clone(machine)), simulated: vec![0], ..job };
    if !whole {
        let alone = plan.job(on(&machines.alone, job));
        return (alone, None, Some(alone));
    }
    let bare = Job { compared: Compared::Not, tiles: false, pictures: Vec::new(), ..job.clone() };
    let (gpu, alone) = (plan.job(on(&machines.whole, job)), plan.job(on(&machines.alone, bare)));
    (gpu, Some(gpu), Some(alone))
}

/// Whether the pictures of a policy are shown.
fn is_shown(setup: &Setup<'_>, mode: usize, policy: usize) -> bool {
    let entry = setup.policies[policy].0;
    let large = u64::from(setup.size.0) * u64::from(setup.size.1) > PIXELS_SHOWN;
    if large { mode == 0 && [PAPER[0], BEST].contains(&entry.name) } else { entry.shown.now(setup.full) }
}

/// The pictures of a point, and where the report finds them. The reference comes with the paper's policy.
fn pictures(setup: &Setup<'_>, scene: usize, mode: usize, policy: usize) -> (Vec<Picture>, ViewerImages) {
    let entry = setup.policies[policy].0;
    let base = format!("{}-{}", setup.stages[scene].name, MODES[mode].name);
    let file = |what: &str| format!("{base}/{}-{what}.png", entry.name);
    let mut pictures = Vec::new();
    let mut add = |kind, file: String| {
        pictures.push(Picture { frame: 0, kind, shrink: 1, file: file.clone() });
        Some(file)
    };
    let mut images = ViewerImages {
        reference: Some(format!("{base}/reference.png")),
        result: add(Kind::Result, file("result")),
        error: add(Kind::Error, file("error")),
        similarity: add(Kind::Similarity, file("similarity")),
        rate: setup.has_rates(policy).then(|| add(Kind::Rate, file("rate"))).flatten(),
    };
    if entry.name == PAPER[mode] {
        images.reference = add(Kind::Reference, format!("{base}/reference.png"));
    }
    (pictures, images)
}

impl Setup<'_> {
    /// Whether a policy has rates that vary over the picture.
    pub fn has_rates(&self, policy: usize) -> bool {
        !matches!(self.policies[policy].1.policy.kind(), "full" | "adaptive")
    }
}

/// The points with what their records hold.
pub fn points(setup: &Setup<'_>, planned: &[Planned], records: &[Record]) -> Vec<Point> {
    let frame = |job: usize| &records[job].frames[0];
    let cost = |point: &Planned| {
        let alone = point.alone.and_then(|job| frame(job).machine.as_ref()).and_then(|machine| machine.ti);
        let whole = point.gpu.and_then(|job| frame(job).machine.as_ref()).and_then(|machine| machine.gpu);
        (alone, whole)
    };
    let full = |scene: usize, mode: usize| {
        planned.iter().find(|p| (p.scene, p.mode, p.policy) == (scene, mode, 0)).map_or((None, None), &cost)
    };
    let one = |p: &Planned| {
        let ((ti, gpu), (full_ti, full_gpu), (fsaa, _)) = (cost(p), full(p.scene, p.mode), full(p.scene, 0));
        let mut point = figures(frame(p.picture), p.gpu.and_then(|job| frame(job).machine.clone()));
        let named = &setup.policies[p.policy].1;
        point.scene.clone_from(&setup.stages[p.scene].name);
        point.mode = MODES[p.mode].name.into();
        point.policy.clone_from(&named.name);
        point.machine = setup.machines.as_ref().map(|m| m.whole.name.clone());
        point.block = block(&named.policy);
        point.kind = named.policy.kind().into();
        (point.ti, point.gpu) = (ti, gpu);
        (point.ti_gain, point.gpu_gain) = (gain(ti, full_ti), gain(gpu, full_gpu));
        point.fsaa_gain = gain(ti, fsaa);
        point
    };
    planned.iter().map(one).collect()
}

/// What the frame itself says of a point, and the whole machine.
fn figures(frame: &Frame, machine: Option<Machine>) -> Point {
    let (units, energy, srp) = machine.map(|m| (m.units, m.energy, m.srp)).unwrap_or_default();
    Point {
        rays_full: frame.rays_full,
        rays_traced: frame.rays_traced,
        samples_full: frame.samples_full,
        samples_traced: frame.samples_traced,
        mean_rate: frame.mean_rate(),
        quality: frame.quality,
        units,
        energy,
        srp,
        ..Point::default()
    }
}

/// Block edge of a policy whose blocks are all alike.
fn block(policy: &Policy) -> Option<u32> {
    match policy {
        Policy::Adaptive(own) => Some(own.block),
        _ => None,
    }
}

/// Factors over a reference.
fn gain(own: Option<Cost>, reference: Option<Cost>) -> Option<Gain> {
    let (own, reference) = (own?, reference?);
    Some(Gain {
        performance: reference.time_ms / own.time_ms,
        power: own.power_w / reference.power_w,
        perf_per_watt: own.perf_per_watt / reference.perf_per_watt,
    })
}

/// The pictures of the points that have some.
pub fn viewer(setup: &Setup<'_>, planned: &[Planned], records: &[Record]) -> Vec<ViewerSet> {
    let set = |p: &Planned| {
        Some(ViewerSet {
            scene: setup.stages[p.scene].name.clone(),
            mode: MODES[p.mode].name.into(),
            policy: setup.policies[p.policy].1.name.clone(),
            width: setup.size.0,
            height: setup.size.1,
            tile_px: TILE / MODES[p.mode].samples,
            images: p.images.clone()?,
            tiles: records[p.picture].frames[0].tiles.clone(),
        })
    };
    planned.iter().filter_map(set).collect()
}

/// Rays of all samples of a scene, by mode.
pub fn rays_full(planned: &[Planned], records: &[Record], scene: usize) -> Vec<(usize, u64)> {
    let full = planned.iter().filter(|p| p.scene == scene && p.policy == 0);
    full.map(|p| (p.mode, records[p.picture].frames[0].rays_full)).collect()
}
