//! Every scene in both modes under every policy: the paper's Figure 7 and Table 1, and what goes beyond them.

use std::sync::Arc;

use rayreel_machine::config::NamedMachine;
use rayreel_replay::{NamedPolicy, Policy};
use rayreel_study::point::key::Point as StudyPoint;
use rayreel_study::point::wanted::{Kind, PictureWanted, Views, Wanted};
use rayreel_study::schema::{Point, ViewerImages, ViewerSet};

use crate::frame::{FrameView, tile};
use crate::plan::{Grid, Plan, TILE};
use crate::policies::{MODES, Mode, PAPER};
use crate::results::Results;
use crate::setup::Setup;

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

/// Plans all points.
pub fn plan(setup: &Setup, plan: &mut Plan<'_>) -> Vec<Planned> {
    let mut points = Vec::new();
    for scene in 0..setup.stages.len() {
        for (mode, Mode { samples, .. }) in MODES.iter().enumerate() {
            let grid = Grid { scene, size: setup.size, samples: *samples, tile: TILE, frames: (0, 1) };
            let capture = plan.capture(&grid, false);
            for (policy, (entry, named)) in setup.policies.iter().enumerate() {
                if !entry.modes[mode].now(setup.full) {
                    continue;
                }
                let shown = is_shown(setup, mode, policy).then(|| pictures(setup, scene, mode, policy));
                let (pictures, images) = shown.unzip();
                let (picture, gpu, alone) =
                    simulations(setup, plan, (capture, named), pictures.unwrap_or_default(), entry.whole);
                points.push(Planned { scene, mode, policy, picture, gpu, alone, images });
            }
        }
    }
    points
}

/// Pictures with their files.
type Pictures = Vec<(PictureWanted, String)>;

/// The planned points of a point: the one that shows pictures, the one on the whole machine, the one of the T&I units alone.
fn simulations(
    setup: &Setup,
    plan: &mut Plan<'_>,
    (capture, policy): (usize, &Arc<NamedPolicy>),
    shown: Pictures,
    whole: bool,
) -> (usize, Option<usize>, Option<usize>) {
    let mut point = |machine: Option<&Arc<NamedMachine>>, shown: Pictures| {
        let (pictures, files): (Vec<_>, Vec<_>) = shown.into_iter().unzip();
        let views = Views { tiles: !pictures.is_empty(), pictures };
        let wanted = Wanted { views, ..Wanted::default() };
        let (machine, policy) = (machine.cloned(), Arc::clone(policy));
        let detail = setup.detail;
        let point = StudyPoint { source: String::new(), frames: (0, 1), machine, policy, detail, wanted };
        plan.point(capture, point, files)
    };
    let Some(machines) = &setup.machines else { return (point(None, shown), None, None) };
    match &machines.alone {
        Some(alone) if !whole => {
            let alone = point(Some(alone), shown);
            (alone, None, Some(alone))
        }
        alone => {
            let gpu = point(Some(&machines.whole), shown);
            (gpu, Some(gpu), alone.as_ref().map(|alone| point(Some(alone), Vec::new())))
        }
    }
}

/// Whether the pictures of a policy are shown.
fn is_shown(setup: &Setup, mode: usize, policy: usize) -> bool {
    let entry = setup.policies[policy].0;
    let large = u64::from(setup.size.0) * u64::from(setup.size.1) > PIXELS_SHOWN;
    if large { mode == 0 && [PAPER[0], BEST].contains(&entry.name) } else { entry.shown.now(setup.full) }
}

/// The pictures of a point, and where the report finds them. The reference comes with the paper's policy.
fn pictures(setup: &Setup, scene: usize, mode: usize, policy: usize) -> (Pictures, ViewerImages) {
    let entry = setup.policies[policy].0;
    let base = format!("{}-{}", setup.stages[scene].name, MODES[mode].name);
    let file = |what: &str| format!("{base}/{}-{what}.png", entry.name);
    let mut pictures = Vec::new();
    let mut add = |kind, file: String| {
        pictures.push((PictureWanted { frame: 0, kind, shrink: 1 }, file.clone()));
        Some(file)
    };
    let mut images = ViewerImages {
        reference: Some(format!("{base}/reference.png")),
        result: add(Kind::Result, file("result")),
        error: add(Kind::Error, file("error")),
        flip: add(Kind::Flip, file("flip")),
        similarity: add(Kind::Similarity, file("similarity")),
        rate: setup.has_rates(policy).then(|| add(Kind::Rate, file("rate"))).flatten(),
    };
    if entry.name == PAPER[mode] {
        images.reference = add(Kind::Reference, format!("{base}/reference.png"));
    }
    (pictures, images)
}

/// The points with what their results hold.
pub fn points(setup: &Setup, planned: &[Planned], results: &Results) -> Vec<Point> {
    let frames = |point: &Planned| [point.alone, point.gpu].map(|point| point.map(|point| results.frame(point)));
    let full = |scene: usize, mode: usize| {
        planned.iter().find(|p| (p.scene, p.mode, p.policy) == (scene, mode, 0)).map_or([None; 2], frames)
    };
    let one = |p: &Planned| {
        let ([ti, gpu], [full_ti, full_gpu], [fsaa, _]) = (frames(p), full(p.scene, p.mode), full(p.scene, 0));
        let named = &setup.policies[p.policy].1;
        Point {
            scene: setup.stages[p.scene].name.clone(),
            mode: MODES[p.mode].name.into(),
            policy: named.name.clone(),
            machine: setup.machines.as_ref().map(|m| m.whole.name.clone()),
            block: block(&named.policy),
            kind: named.policy.kind().into(),
            ti: ti.and_then(FrameView::ti),
            gpu: gpu.and_then(FrameView::gpu),
            ti_gain: ti.zip(full_ti).and_then(|(frame, full)| frame.ti_gain(full)),
            gpu_gain: gpu.zip(full_gpu).and_then(|(frame, full)| frame.gpu_gain(full)),
            fsaa_gain: ti.zip(fsaa).and_then(|(frame, full)| frame.ti_gain(full)),
            ..figures(results.frame(p.picture), p.gpu.map(|point| results.frame(point)))
        }
    };
    planned.iter().map(one).collect()
}

/// What the frame itself says of a point, and the whole machine.
fn figures(frame: FrameView<'_>, machine: Option<FrameView<'_>>) -> Point {
    Point {
        rays_full: frame.rays_full(),
        rays_traced: frame.rays_traced(),
        samples_full: frame.samples_full(),
        samples_traced: frame.samples_traced(),
        mean_rate: frame.mean_rate(),
        quality: frame.quality(),
        units: machine.map(FrameView::units).unwrap_or_default(),
        energy: machine.map(FrameView::energy).unwrap_or_default(),
        srp: machine.map(FrameView::srp).unwrap_or_default(),
        ..Point::default()
    }
}

/// Block edge of a policy whose blocks are all alike.
fn block(policy: &Policy) -> Option<u32> {
    match policy {
        Policy::Adaptive(rules) => Some(rules.block),
        _ => None,
    }
}

/// What there is to say of a point as soon as point number `finished` is: gains over `full`.
/// `row` gives the figures of points that are finished.
pub fn found<'a>(
    setup: &Setup,
    planned: &[Planned],
    finished: usize,
    row: impl Fn(usize) -> Option<FrameView<'a>>,
) -> Vec<String> {
    let line = |of: &Planned| {
        let full = planned.iter().find(|p| (p.scene, p.mode, p.policy) == (of.scene, of.mode, 0))?;
        let [alone, full] = [of.alone?, full.alone?];
        // Whichever of the two comes last.
        let now = alone != full && [alone, full].contains(&finished);
        if now { gained(setup, of, row(alone)?, row(full)?) } else { None }
    };
    planned.iter().filter_map(line).collect()
}

/// The gain of a point over `full` in words.
fn gained(setup: &Setup, of: &Planned, view: FrameView<'_>, full: FrameView<'_>) -> Option<String> {
    let gain = view.ti_gain(full)?;
    let within = gain.interval.map_or_else(String::new, |i| format!(" ±{:.1}%", 100.0 * i.perf_per_watt));
    let psnr = view.quality()?.psnr_db.map_or_else(String::new, |db| format!(", PSNR {db:.2} dB"));
    let (scene, mode, policy) = (&setup.stages[of.scene].name, MODES[of.mode].name, &setup.policies[of.policy].1.name);
    let factor = gain.perf_per_watt;
    Some(format!(
        "{scene} {mode} under {policy}: T&I units {factor:.2}{within} x the performance per watt of full{psnr}"
    ))
}

/// The pictures of the points that have some.
pub fn viewer(setup: &Setup, planned: &[Planned], results: &Results) -> Vec<ViewerSet> {
    let set = |p: &Planned| {
        Some(ViewerSet {
            scene: setup.stages[p.scene].name.clone(),
            mode: MODES[p.mode].name.into(),
            policy: setup.policies[p.policy].1.name.clone(),
            width: setup.size.0,
            height: setup.size.1,
            tile_px: TILE / MODES[p.mode].samples,
            images: p.images.clone()?,
            tiles: results.tiles(p.picture).iter().map(tile).collect(),
        })
    };
    planned.iter().filter_map(set).collect()
}

/// Rays of all samples of a scene, by mode.
pub fn rays_full(planned: &[Planned], results: &Results, scene: usize) -> Vec<(usize, u64)> {
    let full = planned.iter().filter(|p| p.scene == scene && p.policy == 0);
    full.map(|p| (p.mode, results.frame(p.picture).rays_full())).collect()
}
