//! Everything that a machine counted, by name: summed over cores and units, and each unit's own account of its cycles.

use serde_json::{Map, Value, json};

use rayreel_machine::config::MachineConfig;
use rayreel_machine::counters::{Activity, Counter};
use rayreel_machine::energy::RASTERISER;
use rayreel_machine::functional::counted_counters;
use rayreel_machine::memory::CacheCounters;
use rayreel_machine::srp::{KernelId, SrpStats};
use rayreel_machine::stats::Stats;
use rayreel_machine::traversal::ProcessorCounters;
use rayreel_machine::work::layout::Region;
use rayreel_replay::simulate::MachineRun;

/// All counters: `group/name` to value, unit and description.
pub(super) fn counters(run: &MachineRun) -> Value {
    let mut all = List::default();
    let stats = &run.stats;
    all.one("run/cycles", "cycles", "length of the run, T&I clock", stats.cycles);
    all.one("run/tiles", "tiles", "tiles of the frames", stats.tiles);
    all.add("paths", run.paths.list());
    ti(&mut all, stats);
    srp(&mut all, stats);
    if run.energy.component(RASTERISER).is_some() {
        all.add("srp/raster", srp_sum(stats).raster.list());
    }
    all.add("l2", stats.memory.l2.list());
    all.add("dram", stats.memory.dram().list());
    let has_processors = stats.processors().next().is_some();
    // Instructions are read by processors only.
    for (region, what) in REGIONS.into_iter().filter(|(region, _)| has_processors || *region != Region::Code) {
        let traffic = &stats.memory.traffic;
        let name = region.name();
        let (read, written) = (traffic.read[region as usize], traffic.written[region as usize]);
        all.one(&format!("traffic/{name}_read"), "bytes", &format!("read from DRAM: {what}"), read);
        all.one(&format!("traffic/{name}_written"), "bytes", &format!("written to DRAM: {what}"), written);
    }
    Value::Object(all.0)
}

/// The same where no cycle was simulated: what takes time to count is null.
pub(super) fn timeless(config: &MachineConfig, run: &MachineRun) -> Value {
    let marks = counters(&MachineRun { stats: counted_counters(config), ..MachineRun::default() });
    let mut all = counters(run);
    for (name, counter) in all.as_object_mut().into_iter().flatten() {
        if !name.starts_with("paths/") && marks[name]["value"].as_u64() == Some(0) {
            counter["value"] = Value::Null;
        }
    }
    all
}

/// What traffic is for.
const REGIONS: [(Region, &str); 11] = [
    (Region::Node, "inner nodes"),
    (Region::Triangle, "triangles"),
    (Region::Attribute, "vertex attributes"),
    (Region::Texture, "texels"),
    (Region::Ray, "rays and hits on their way through memory"),
    (Region::Sample, "sample attributes that the tile buffer does not hold"),
    (Region::Border, "sample attributes kept for neighbouring tiles"),
    (Region::GBuffer, "the G-buffer of the rasteriser"),
    (Region::Framebuffer, "pixels"),
    (Region::Code, "instructions"),
    (Region::History, "samples kept for the next frame"),
];

/// Counters in order of the report.
#[derive(Default)]
struct List(Map<String, Value>);

impl List {
    fn one(&mut self, name: &str, unit: &str, description: &str, value: u64) {
        self.0.insert(name.into(), json!({ "value": value, "unit": unit, "description": description }));
    }

    fn add(&mut self, group: &str, counters: Vec<Counter>) {
        for Counter { name, unit, description, value } in counters {
            self.one(&format!("{group}/{name}"), unit, description, value);
        }
    }
}

/// Adds a group of counters over units.
fn sum<T: Default + std::ops::AddAssign>(values: impl IntoIterator<Item = T>) -> T {
    let mut total = T::default();
    values.into_iter().for_each(|value| total += value);
    total
}

fn ti(all: &mut List, stats: &Stats) {
    all.add("ti/dispatch", sum(stats.cores.iter().map(|core| core.ti.dispatch)).list());
    for (name, activity) in stages(stats) {
        all.add(&format!("ti/trv/{name}"), activity.list());
    }
    all.add("ti/trv", sum(stats.trv().map(|unit| unit.events)).list());
    all.add("ti/trv/buffer", sum(stats.trv().map(|unit| unit.buffer)).list());
    all.add("ti/trv/l1", trv_l1(stats).list());
    all.add("ti/ist/test", ist_activity(stats).list());
    all.add("ti/ist", sum(stats.ist().map(|unit| unit.events)).list());
    all.add("ti/ist/buffer", sum(stats.ist().map(|unit| unit.buffer)).list());
    all.add("ti/ist/l1", ist_l1(stats).list());
    if stats.processors().next().is_some() {
        all.add("processors", processors(stats).list());
        all.add("processors/code_l1", code_l1(stats).list());
    }
}

fn srp(all: &mut List, stats: &Stats) {
    let srp = srp_sum(stats);
    all.add("srp/activity", srp.activity.list());
    for kernel in KernelId::ALL {
        all.add(&format!("srp/kernel/{}", kernel.name()), srp.kernels[kernel as usize].list());
    }
    all.add("srp/interface", srp.interface.list());
    all.add("srp/dma", srp.dma.list());
    all.add("srp/local", srp.local.list());
    all.add("srp/l1", srp_l1(stats).list());
}

/// Activity of each issue stage of the traversal units, all units together.
pub(super) fn stages(stats: &Stats) -> Vec<(&'static str, Activity)> {
    let mut stages: Vec<(&'static str, Activity)> = Vec::new();
    for (name, activity) in stats.trv().flat_map(|unit| unit.stages.iter().copied()) {
        match stages.iter_mut().find(|(known, _)| *known == name) {
            Some((_, total)) => *total += activity,
            None => stages.push((name, activity)),
        }
    }
    stages
}

/// Activity of the intersection units.
pub(super) fn ist_activity(stats: &Stats) -> Activity {
    sum(stats.ist().map(|unit| unit.activity))
}

/// L1s of the traversal units.
pub(super) fn trv_l1(stats: &Stats) -> CacheCounters {
    sum(stats.trv().map(|unit| unit.l1))
}

/// L1s of the intersection units.
pub(super) fn ist_l1(stats: &Stats) -> CacheCounters {
    sum(stats.ist().map(|unit| unit.l1))
}

/// Instructions and warps of all processors.
pub(super) fn processors(stats: &Stats) -> ProcessorCounters {
    sum(stats.processors().map(|processor| processor.counters))
}

/// Instruction caches of the processors.
pub(super) fn code_l1(stats: &Stats) -> CacheCounters {
    sum(stats.processors().map(|processor| processor.code_l1))
}

/// L1s of the SRPs.
pub(super) fn srp_l1(stats: &Stats) -> CacheCounters {
    sum(stats.cores.iter().map(|core| core.srp_l1))
}

/// All SRPs.
pub(super) fn srp_sum(stats: &Stats) -> SrpStats {
    let mut total = SrpStats::default();
    for srp in stats.cores.iter().map(|core| &core.srp) {
        total.kernels.iter_mut().zip(&srp.kernels).for_each(|(sum, more)| *sum += *more);
        total.activity += srp.activity;
        total.interface += srp.interface;
        total.dma += srp.dma;
        total.raster += srp.raster;
        total.local += srp.local;
    }
    total
}

/// Each issue stage of each unit with the cycles that it spent in each class. The classes of a stage add up to the run.
pub(super) fn units(stats: &Stats) -> Value {
    let mut rows = Vec::new();
    let mut row = |core: usize, unit: &str, index: usize, stage: &str, cycles: u64, classes: Vec<Counter>| {
        let classes: Map<_, _> = classes.into_iter().map(|c| (c.name.to_owned(), c.value.into())).collect();
        rows.push(json!({
            "core": core, "unit": unit, "index": index, "stage": stage, "cycles": cycles, "classes": classes,
        }));
    };
    for (i, core) in stats.cores.iter().enumerate() {
        for (j, unit) in core.ti.trv.iter().enumerate() {
            unit.stages.iter().for_each(|(name, activity)| row(i, "trv", j, name, stats.cycles, activity.list()));
        }
        for (j, unit) in core.ti.ist.iter().enumerate() {
            row(i, "ist", j, "test", stats.cycles, unit.activity.list());
        }
        row(i, "srp", 0, "array", core.srp_cycles, core.srp.activity.list());
    }
    Value::Array(rows)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use rayreel_machine::config::NamedMachine;
    use rayreel_machine::energy::EnergyReport;

    use super::*;

    /// Whatever a machine counts changes a counter of its report, or of that of a machine that has the unit: nothing is priced that
    /// nobody can look up.
    #[test]
    fn every_counter_of_a_machine_has_a_name() {
        // The length of the run in the SRP's clock stands with the units.
        const SRP_CYCLES: usize = 2;
        let mut seen: BTreeMap<usize, bool> = BTreeMap::new();
        for machine in ["sgrt-ti2", "hybrid-raster", "mimd-trax"] {
            let config = NamedMachine::load(machine, &[]).unwrap().config;
            let shaped = Stats::shaped(&config);
            let energy = EnergyReport::new(&config, &shaped);
            let report = |stats| counters(&MachineRun { stats, energy: energy.clone(), ..MachineRun::default() });
            let (nothing, none) = (report(shaped.clone()), shaped.list());
            let mut kinds = Vec::new();
            shaped.clone().each_mut(|kind, _| kinds.push(kind));
            for (place, kind) in kinds.iter().enumerate() {
                // One unit stands for all of its kind.
                if seen.get(kind) == Some(&true) || kinds[..place].contains(kind) {
                    continue;
                }
                let mut list = none.clone();
                list[place] = 1.0;
                seen.insert(*kind, report(shaped.with_list(&list)) != nothing);
            }
        }
        let unseen: Vec<usize> = seen.into_iter().filter_map(|(kind, seen)| (!seen).then_some(kind)).collect();
        assert_eq!(unseen, [SRP_CYCLES]);
    }
}
