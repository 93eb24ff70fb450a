//! Nine policies on six architectures: the samplers and the machines that the paper stands beside.

use std::fmt::Write as _;
use std::sync::Arc;

use rayreel_machine::config::{NamedMachine, Pipeline};
use rayreel_replay::NamedPolicy;
use rayreel_study::analysis::systems::{Pair, STATEMENTS, Systems};
use rayreel_study::point::key::Point;
use rayreel_study::point::wanted::Wanted;
use rayreel_study::schema::{Study, SystemPoint};

use crate::error::Result;
use crate::frame::FrameView;
use crate::plan::{Grid, Plan, TILE};
use crate::policies::MODES;
use crate::results::Results;
use crate::setup::{Setup, lacking};

/// The machines: the paper's, its rasterising and its rival hardware, and those without ray hardware.
const MACHINES: [&str; 6] = ["sgrt-ti2", "hybrid-raster", "gr6500", "raycore", "mimd-trax", "simt-mimd"];

/// The policies: the reference, the paper's, the samplers that it builds on, and what goes beyond it.
const POLICIES: [&str; 9] =
    ["full", "paper-ss", "kim2016", "jin2009", "whitted1980", "mitchell1987", "multirate", "quality", "aggressive"];

/// A point that is planned.
pub struct Planned {
    scene: usize,
    machine: usize,
    policy: usize,
    /// On the whole machine.
    gpu: usize,
    /// The T&I units alone.
    alone: Option<usize>,
}

/// Plans all points, if they are asked for.
///
/// # Errors
/// Never for presets of this version.
pub fn plan(setup: &Setup, plan: &mut Plan<'_>) -> Result<Vec<Planned>> {
    if !setup.systems || setup.machines.is_none() {
        return Ok(Vec::new());
    }
    let load = |name: &str, ideal: &[String]| NamedMachine::load(name, ideal).map(Arc::new);
    let mut machines = Vec::new();
    for name in MACHINES {
        let whole = load(name, &[])?;
        let has_units = whole.config.ti.pipeline != Pipeline::Software;
        let alone = if has_units { Some(load(name, &["srp.ideal=true".to_owned()])?) } else { None };
        machines.push((whole, alone));
    }
    let policies: Vec<_> =
        POLICIES.iter().map(|name| Ok(Arc::new(NamedPolicy::load(name, &[])?))).collect::<Result<_>>()?;
    let mut planned = Vec::new();
    for scene in 0..setup.stages.len() {
        let grid = Grid { scene, size: setup.size, samples: MODES[0].samples, tile: TILE, frames: (0, 1) };
        let capture = plan.capture(&grid, false);
        for (machine, (whole, alone)) in machines.iter().enumerate() {
            for (policy, named) in policies.iter().enumerate() {
                if POLICIES[policy] != "full" && !lacking(&whole.config).is_empty() {
                    continue;
                }
                let mut point = |machine: &Arc<NamedMachine>| {
                    let (machine, policy, detail) = (Some(Arc::clone(machine)), Arc::clone(named), setup.detail);
                    let wanted = Wanted::default();
                    let point = Point { source: String::new(), frames: (0, 1), machine, policy, detail, wanted };
                    plan.point(capture, point, Vec::new())
                };
                let (gpu, alone) = (point(whole), alone.as_ref().map(&mut point));
                planned.push(Planned { scene, machine, policy, gpu, alone });
            }
        }
    }
    Ok(planned)
}

/// The points with what their results hold.
pub fn systems(setup: &Setup, planned: &[Planned], results: &Results) -> Vec<SystemPoint> {
    let frames = |p: &Planned| (results.frame(p.gpu), p.alone.map(|alone| results.frame(alone)));
    let full =
        |p: &Planned| planned.iter().find(|f| (f.scene, f.machine, f.policy) == (p.scene, p.machine, 0)).map(frames);
    let point = |p: &Planned| {
        let (gpu, alone) = frames(p);
        let full = full(p).filter(|_| p.policy != 0);
        SystemPoint {
            scene: setup.stages[p.scene].name.clone(),
            machine: MACHINES[p.machine].into(),
            policy: POLICIES[p.policy].into(),
            rays_full: gpu.rays_full(),
            rays_traced: gpu.rays_traced(),
            psnr_db: gpu.quality().and_then(|quality| quality.psnr_db),
            gpu: gpu.gpu(),
            ti: alone.and_then(FrameView::ti),
            gpu_gain: full.and_then(|(full, _)| gpu.gpu_gain(full)),
            ti_gain: full.and_then(|(_, full)| alone?.ti_gain(full?)),
        }
    };
    planned.iter().map(point).collect()
}

/// The results for people; nothing if there are none.
pub fn table(study: &Study) -> String {
    let Some(systems) = Systems::of(&study.systems) else { return String::new() };
    let pairs = systems.pairs();
    let others: Vec<usize> = (0..systems.policies.len()).filter(|p| systems.policies[*p] != "full").collect();
    let pair = |machine: usize, policy: usize| pairs.iter().find(|p| (p.machine, p.policy) == (machine, policy));
    let mut text = format!(
        "\npolicies on machines, {}; means of {}; frames a joule over full on the same machine, whole GPU (T&I units \
         alone)\n\n{:<14} {:>9}",
        MODES[0].name,
        match systems.scenes.len() {
            1 => "one scene".into(),
            scenes => format!("{scenes} scenes"),
        },
        "machine",
        "full"
    );
    others.iter().for_each(|policy| {
        let _ = write!(text, " {:>13}", systems.policies[*policy]);
    });
    text += "\n";
    let full = systems.policies.iter().position(|policy| *policy == "full").unwrap_or(0);
    for (machine, name) in systems.machines.iter().enumerate() {
        let merit = pair(machine, full).map_or("-".into(), |pair| format!("{:.3}", pair.merit));
        let _ = write!(text, "{name:<14} {merit:>9}");
        for policy in &others {
            let cell = |pair: &Pair| {
                let alone = pair.ti_gain.map_or(String::new(), |v| format!(" ({v:.2})"));
                format!("{:.2}{alone}", pair.gain)
            };
            let _ = write!(text, " {:>13}", pair(machine, *policy).map_or("-".into(), cell));
        }
        text += "\n";
    }
    let _ = write!(text, "{:<14} {:>9}", "PSNR, dB", "same");
    for policy in &others {
        let psnr = pairs.iter().find(|pair| pair.policy == *policy).map_or("-".into(), psnr);
        let _ = write!(text, " {psnr:>13}");
    }
    let first = systems.machines.first().copied().unwrap_or_default();
    let _ = write!(
        text,
        "\n\nunder full: frames a joule over {first}\n\nbeaten by nothing in both frames a joule and PSNR\n"
    );
    for pair in systems.frontier() {
        let (policy, machine) = (systems.policies[pair.policy], systems.machines[pair.machine]);
        let _ = writeln!(text, "  {policy:<13} on {machine:<14} {:>6.2}  {:>6}", pair.merit, psnr(&pair));
    }
    text + &verdicts(&systems)
}

fn psnr(pair: &Pair) -> String {
    if pair.psnr_db.is_finite() { format!("{:.2}", pair.psnr_db) } else { "same".into() }
}

fn verdicts(systems: &Systems<'_>) -> String {
    let verdicts = systems.verdicts();
    let mut text =
        "\nwhat the paper states or expects: value, and whether it holds; T&I units alone / whole GPU\n".to_owned();
    for (i, statement) in STATEMENTS.iter().enumerate() {
        let _ = writeln!(text, "  {statement}");
        for verdict in &verdicts {
            let part = |value: Option<(bool, f64)>| {
                value.map_or("-".into(), |(holds, v)| format!("{v:.2} {}", if holds { "yes" } else { "no" }))
            };
            let [ti, gpu] = verdict.holds[i].map(part);
            let _ = writeln!(text, "    {:<14} {ti:>9} / {gpu}", systems.machines[verdict.machine]);
        }
    }
    text
}
