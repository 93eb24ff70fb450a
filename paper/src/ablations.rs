//! One choice changed at a time.

use std::sync::Arc;

use rayreel_machine::config::{Divergence, GeometryBuffer, MachineConfig, NamedMachine, Pipeline};
use rayreel_replay::NamedPolicy;
use rayreel_study::point::key::Point;
use rayreel_study::point::wanted::Wanted;
use rayreel_study::schema::Ablation;

use crate::error::Result;
use crate::plan::{Grid, Plan, TILE};
use crate::policies::MODES;
use crate::results::Results;
use crate::setup::Setup;

/// The scenes: one hard and one smooth.
const SCENES: [&str; 2] = ["chess", "car"];

/// Largest picture of an ablation, by default and with `--full`: what one shows depends little on the size, and there are many.
const SIZES: [(u32, u32); 2] = [(128, 64), (512, 256)];

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
/// Of 32 no block of 3 is a part.
const fn thirds() -> Variant {
    Variant { tile: 48, ..base("blocks in tiles of 48", "2x2", PAPER) }
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
    thirds(),
    thirds().rules("3x3", &["block=3"]),
    thirds().rules("4x4", &["block=4"]),
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

/// An ablation that is planned.
pub struct Planned {
    /// Index into [`VARIANTS`].
    variant: usize,
    scene: usize,
    point: usize,
}

/// Plans all ablations of [`SCENES`], or of the first scene if none of them is there.
///
/// # Errors
/// A machine that cannot take an override.
pub fn plan(setup: &Setup, plan: &mut Plan<'_>) -> Result<Vec<Planned>> {
    let mut scenes: Vec<usize> =
        (0..setup.stages.len()).filter(|i| SCENES.contains(&setup.stages[*i].name.as_str())).collect();
    if scenes.is_empty() {
        scenes.push(0);
    }
    let mut planned = Vec::new();
    for (number, variant) in VARIANTS.iter().enumerate() {
        if needs_machine(variant.group)
            && !setup.machines.as_ref().is_some_and(|m| has_base(&m.whole.config, variant.group))
        {
            continue;
        }
        let policy = Arc::new(NamedPolicy::load(variant.policy, &strings(variant.rules))?);
        let machine = machine(setup, variant)?;
        for &scene in &scenes {
            let grid = Grid { scene, size: size(setup), samples: MODES[0].samples, tile: variant.tile, frames: (0, 1) };
            let (policy, machine) = (Arc::clone(&policy), machine.clone());
            let (source, detail, wanted) = (String::new(), setup.detail, Wanted::default());
            let point = Point { source, frames: (0, 1), machine, policy, detail, wanted };
            let capture = plan.capture(&grid, false);
            planned.push(Planned { variant: number, scene, point: plan.point(capture, point, Vec::new()) });
        }
    }
    Ok(planned)
}

/// The machine of a variant, if there is one.
fn machine(setup: &Setup, variant: &Variant) -> Result<Option<Arc<NamedMachine>>> {
    Ok(match (&setup.machines, variant.machine) {
        (None, _) => None,
        (Some(machines), []) => Some(Arc::clone(&machines.whole)),
        (Some(machines), changes) => Some(Arc::new(NamedMachine::load(&machines.spec, &strings(changes))?)),
    })
}

fn strings(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

/// Whether the unchanged variant of a group that changes the machine is what its name says, on this machine.
fn has_base(config: &MachineConfig, group: &str) -> bool {
    match group {
        "tile buffer" => config.gpu.geometry_buffer == GeometryBuffer::OnChip,
        // Processors do without an SRP whose lanes could diverge.
        "branch divergence" => {
            config.srp.divergence == Divergence::Inspector && config.ti.pipeline != Pipeline::Software
        }
        _ => true,
    }
}

/// Whether a group changes the machine, so that it shows nothing without one.
fn needs_machine(group: &str) -> bool {
    VARIANTS.iter().any(|variant| variant.group == group && !variant.machine.is_empty())
}

/// The ablations with what their results hold.
pub fn ablations(setup: &Setup, planned: &[Planned], results: &Results) -> Vec<Ablation> {
    // The unchanged one of its group and scene.
    let base = |p: &Planned| {
        let same = |b: &&Planned| {
            let (variant, base) = (&VARIANTS[p.variant], &VARIANTS[b.variant]);
            base.base && base.group == variant.group && b.scene == p.scene
        };
        planned.iter().find(same).map(|b| results.frame(b.point))
    };
    let row = |p: &Planned| {
        let (variant, frame) = (&VARIANTS[p.variant], results.frame(p.point));
        let cost = frame.gpu();
        let gain = base(p).filter(|_| !variant.base).and_then(|base| frame.gpu_gain(base));
        Ablation {
            group: variant.group.into(),
            name: variant.name.into(),
            note: variant.note.into(),
            scene: setup.stages[p.scene].name.clone(),
            mode: MODES[0].name.into(),
            policy: variant.policy.into(),
            base: variant.base,
            rays_traced: frame.rays_traced(),
            rays_full: frame.rays_full(),
            cycles: cost.map(|c| c.cycles),
            power_w: cost.map(|c| c.power_w),
            perf_per_watt: cost.map(|c| c.perf_per_watt),
            interval: cost.and_then(|c| c.interval),
            gain_interval: gain.and_then(|g| g.interval),
            psnr_db: frame.quality().and_then(|q| q.psnr_db),
        }
    };
    planned.iter().map(row).collect()
}

/// Picture size of the ablations.
pub fn size(setup: &Setup) -> (u32, u32) {
    setup.size_within(SIZES[usize::from(setup.full)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_group_begins_with_what_is_unchanged() {
        let (mut group, mut tile) = ("", TILE);
        for variant in VARIANTS {
            assert_eq!(variant.base, variant.group != group, "{} {}", variant.group, variant.name);
            if variant.base {
                (group, tile) = (variant.group, variant.tile);
            }
            let changes = variant.rules.len() + variant.machine.len() + usize::from(variant.tile != tile);
            assert_eq!(changes, usize::from(!variant.base), "{} {}: one choice", variant.group, variant.name);
        }
    }
}
