//! One choice changed at a time.

use std::sync::Arc;

use anyhow::Result;
use rayreel_machine::config::NamedMachine;
use rayreel_replay::NamedPolicy;
use rayreel_study::schema::Ablation;

use super::Setup;
use super::plan::{Compared, Grid, Job, Plan, TILE};
use super::policies::MODES;
use super::record::Record;

/// The scenes: one hard and one smooth.
const SCENES: [&str; 2] = ["chess", "car"];

/// Largest picture of an ablation, by default and with `--full`: what one shows depends little on the size, and there are many.
const SIZES: [(u32, u32); 2] = [(96, 48), (512, 256)];

/// A choice.
struct Variant {
    group: &'static str,
    name: &'static str,
    note: &'static str,
    policy: &'static str,
    /// Overrides of the policy.
    rules: &'static [&'static str],
    /// Overrides of the machine.
    machine: &'static [&'static str],
    tile: u32,
    base: bool,
}

const fn base(group: &'static str, name: &'static str, policy: &'static str) -> Variant {
    Variant { group, name, note: "", policy, rules: &[], machine: &[], tile: TILE, base: true }
}

impl Variant {
    const fn rules(mut self, name: &'static str, rules: &'static [&'static str]) -> Self {
        (self.name, self.rules, self.base) = (name, rules, false);
        self
    }

    const fn machine(mut self, name: &'static str, machine: &'static [&'static str]) -> Self {
        (self.name, self.machine, self.base) = (name, machine, false);
        self
    }

    const fn tile(mut self, name: &'static str, tile: u32) -> Self {
        (self.name, self.tile, self.base) = (name, tile, false);
        self
    }

    const fn note(mut self, note: &'static str) -> Self {
        self.note = note;
        self
    }
}

/// The paper's policy, and the one that goes beyond it.
const PAPER: &str = "paper-ss";
const BEST: &str = "multirate";

const fn buffer() -> Variant {
    base("tile buffer", "on chip", PAPER)
}
const fn apron() -> Variant {
    base("apron", "shared", PAPER)
}
const fn divergence() -> Variant {
    base("branch divergence", "inspector-executor", PAPER)
}
const fn tile() -> Variant {
    base("tile size", "32", PAPER)
}
const fn block() -> Variant {
    base("block size", "2x2", PAPER)
}
const fn paper_tests() -> Variant {
    base("similarity tests of the paper", "all", PAPER)
}
const fn tests() -> Variant {
    base("similarity tests beyond the paper", "all", BEST)
}
const fn refine() -> Variant {
    base("refinement", "hierarchical", BEST)
}
const fn correction() -> Variant {
    base("correction", "on", BEST)
}
const fn secondary() -> Variant {
    base("secondary", "on", BEST)
}

/// All choices, each group with its unchanged one first.
const VARIANTS: &[Variant] = &[
    buffer(),
    buffer().machine("external", &["gpu.geometry_buffer=external"]).note("the geometry buffer lies in DRAM"),
    apron(),
    apron().rules("traced again", &["apron=retrace"]).note("by each tile, for itself"),
    divergence(),
    divergence().machine("naive", &["srp.divergence=naive"]).note("every item pays for every branch in its batch"),
    tile(),
    tile().tile("16", 16),
    tile().tile("64", 64),
    block(),
    block().rules("4x4", &["block=4"]),
    block().rules("8x8", &["block=8"]),
    paper_tests(),
    paper_tests().rules("without object id", &["similarity.object_id=false"]),
    paper_tests().rules("without normal", &["similarity.normal_deg=off"]),
    paper_tests().rules("without shadow bits", &["similarity.shadow=false"]),
    tests(),
    tests().rules("without colour", &["similarity.colour=off"]),
    tests().rules("without secondary hits", &["similarity.secondary=false"]),
    tests().rules("without prediction", &["similarity.predict=false"]),
    tests().rules("with texture", &["similarity.texture=0.05"]).note("local colours within 0.05 as displayed"),
    refine(),
    refine().rules("direct", &["refine=direct"]),
    correction(),
    correction().rules("off", &["correct.passes=0"]),
    secondary(),
    secondary().rules("off", &["secondary=false"]).note("a sample is traced whole or not at all"),
];

/// An ablation that is planned: index into [`VARIANTS`], scene, name of the policy, job.
pub struct Planned {
    variant: usize,
    scene: usize,
    job: usize,
}

/// Plans all ablations of [`SCENES`], or of the first scene if none of them is there.
///
/// # Errors
/// A machine that cannot take an override.
pub fn plan(setup: &Setup<'_>, plan: &mut Plan<'_>) -> Result<Vec<Planned>> {
    let mut scenes: Vec<usize> =
        (0..setup.stages.len()).filter(|i| SCENES.contains(&setup.stages[*i].name.as_str())).collect();
    if scenes.is_empty() {
        scenes.push(0);
    }
    let size = size(setup);
    let mut planned = Vec::new();
    for (variant, own) in VARIANTS.iter().enumerate() {
        if setup.machines.is_none() && needs_machine(own.group) {
            continue;
        }
        let strings = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let policy = Arc::new(NamedPolicy::load(own.policy, &strings(own.rules))?);
        let machine = match (&setup.machines, own.machine) {
            (None, _) => None,
            (Some(machines), []) => Some(Arc::clone(&machines.whole)),
            (Some(machines), changes) => Some(Arc::new(NamedMachine::load(&machines.spec, &strings(changes))?)),
        };
        for &scene in &scenes {
            let grid = Grid { scene, size, samples: MODES[0].samples, tile: own.tile, frames: (0, 1) };
            let job = Job {
                shot: plan.shot(&grid, false),
                policy: Arc::clone(&policy),
                machine: machine.clone(),
                simulated: if machine.is_some() { vec![0] } else { Vec::new() },
                compared: Compared::Seen,
                tiles: false,
                pictures: Vec::new(),
            };
            planned.push(Planned { variant, scene, job: plan.job(job) });
        }
    }
    Ok(planned)
}

/// Whether a group changes the machine, so that it shows nothing without one.
fn needs_machine(group: &str) -> bool {
    VARIANTS.iter().any(|own| own.group == group && !own.machine.is_empty())
}

/// The ablations with what their records hold.
pub fn ablations(setup: &Setup<'_>, planned: &[Planned], records: &[Record]) -> Vec<Ablation> {
    let row = |p: &Planned| {
        let (own, frame) = (&VARIANTS[p.variant], &records[p.job].frames[0]);
        let cost = frame.machine.as_ref().and_then(|machine| machine.gpu);
        Ablation {
            group: own.group.into(),
            name: own.name.into(),
            note: own.note.into(),
            scene: setup.stages[p.scene].name.clone(),
            mode: MODES[0].name.into(),
            policy: own.policy.into(),
            base: own.base,
            rays_traced: frame.rays_traced,
            rays_full: frame.rays_full,
            cycles: cost.map(|c| c.cycles),
            power_w: cost.map(|c| c.power_w),
            perf_per_watt: cost.map(|c| c.perf_per_watt),
            psnr_db: frame.quality.and_then(|q| q.psnr_db),
        }
    };
    planned.iter().map(row).collect()
}

/// Picture size of the ablations.
pub fn size(setup: &Setup<'_>) -> (u32, u32) {
    let most = SIZES[usize::from(setup.full)];
    (setup.size.0.min(most.0), setup.size.1.min(most.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_begins_with_what_is_unchanged() {
        let mut group = "";
        for own in VARIANTS {
            assert_eq!(own.base, own.group != group, "{} {}", own.group, own.name);
            group = own.group;
            let changes = own.rules.len() + own.machine.len() + usize::from(own.tile != TILE);
            assert_eq!(changes, usize::from(!own.base), "{} {}: one choice", own.group, own.name);
        }
    }
}
