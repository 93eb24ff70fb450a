//! Each event costs its price, in its component and nowhere else; each part leaks what its size says.

use super::*;
use crate::config::NamedMachine;
use crate::counters::Activity;
use crate::memory::{L2Counters, MemoryStats, Traffic};
use crate::stats::CoreStats;

fn machine(overrides: &[&str]) -> MachineConfig {
    let overrides: Vec<_> = overrides.iter().map(ToString::to_string).collect();
    NamedMachine::load("sgrt-ti2", &overrides).unwrap().config
}

/// What a case counts.
type Change = fn(&mut Run);

/// Owned counts of a machine with one core that has one unit of each sort.
#[derive(Clone, Default)]
struct Run {
    cycles: u64,
    ti: TiStats,
    srp: SrpStats,
    srp_l1: CacheCounters,
    l2: L2Counters,
    dram: ChannelCounters,
    traffic: Traffic,
}

impl Run {
    fn new(change: impl FnOnce(&mut Self)) -> Self {
        let ti = TiStats { trv: vec![TrvStats::default()], ist: vec![IstStats::default()], ..TiStats::default() };
        let mut run = Self { ti, ..Self::default() };
        change(&mut run);
        run
    }

    fn energy(&self, config: &MachineConfig) -> EnergyReport {
        let core = CoreStats { ti: self.ti.clone(), srp: self.srp, srp_l1: self.srp_l1, ..CoreStats::default() };
        let memory = MemoryStats { l2: self.l2, channels: vec![self.dram], traffic: self.traffic };
        let stats = Stats { cycles: self.cycles, cores: vec![core], memory, ..Stats::default() };
        EnergyReport::new(config, &stats)
    }
}

/// A price with the clock tree, where that is not paid by the cycle.
fn with_tree(name: &str, price: u128) -> u128 {
    if ["trv", "ist", "srp"].contains(&name) { price } else { price * 6 / 5 }
}

/// A stage that had rays for so many cycles, and then none.
fn running(cycles: u64) -> Vec<(&'static str, Activity)> {
    vec![("inner", Activity { busy: 2, starved: cycles - 2, idle: 100, ..Activity::default() })]
}

#[test]
fn each_event_of_a_processor_and_of_a_rasteriser_costs_what_the_preset_says() {
    let software = NamedMachine::load("mimd-trax", &[]).unwrap().config;
    let hybrid = NamedMachine::load("hybrid-raster", &[]).unwrap().config;
    type Change = fn(&mut CoreStats);
    let cases: [(Change, &str, u128); 12] = [
        (|c| c.processors[0].counters.instructions = 1, "processors", 1_600),
        (|c| c.processors[0].counters.lane_instructions = 1, "processors", 680),
        (|c| c.processors[0].counters.add = 1, "processors", 450),
        (|c| c.processors[0].counters.multiply = 1, "processors", 850),
        (|c| c.processors[0].counters.compare = 1, "processors", 50),
        (|c| c.processors[0].counters.integer = 1, "processors", 40),
        (|c| c.processors[0].counters.special = 1, "processors", 8_000),
        (|c| c.processors[0].counters.lanes_off = 1, "processors", 0),
        (|c| c.processors[0].counters.words = 10, "data_l1", 19_000 * 120 / 100),
        // 4 KiB: 9,506 of the 19,238 that CACTI has for the 16 KiB that 11.5 pJ are of.
        (|c| c.processors[0].code_l1.fills = 10, "code_l1", 56_820 * 120 / 100),
        (|c| c.ti.trv[0].stages[0].1.busy = 10, "processors", 146_000),
        (|c| c.ti.trv[0].l1.hits = 10, "data_l1", 0),
    ];
    for (i, (change, name, fj)) in cases.into_iter().enumerate() {
        let mut stats = Stats::shaped(&software);
        change(&mut stats.cores[0]);
        let report = EnergyReport::new(&software, &stats);
        assert_eq!(report.component(name).map(|c| c.dynamic_fj), Some(fj), "case {i}");
        assert_eq!((report.gpu_fj(), report.ti_fj(), report.ti_with_memory_fj()), (fj, 0, 0), "case {i}");
    }
    let mut stats = Stats::shaped(&hybrid);
    stats.cores[0].srp.raster = crate::srp::RasterCounters { triangles: 10, samples: 100 };
    let report = EnergyReport::new(&hybrid, &stats);
    assert_eq!(report.component("rasteriser").map(|c| c.dynamic_fj), Some((1_600_000 + 1_050_000) * 120 / 100));
    assert!(EnergyReport::new(&software, &Stats::shaped(&software)).component("rasteriser").is_none());
}

#[test]
fn a_bypass_pays_for_every_stage_of_its_pipeline() {
    let bypass = |overrides: &[&str]| {
        let report = Run::new(|r| r.ti.trv[0].events.bypasses = 1).energy(&machine(overrides));
        report.component("trv").unwrap().total_fj()
    };
    assert_eq!(bypass(&["ti.pipeline=single"]), 18 * 1_020);
    assert_eq!(bypass(&["ti.pipeline=unified", "ti.ist=0"]), 48 * 1_020);
}

#[test]
fn power_down_lowers_the_background() {
    // 1600 M cycles of a channel at 1600 MHz are a second.
    let second = |down| {
        let run = Run::new(|r| (r.cycles, r.dram.powered_down) = (500_000_000, down));
        run.energy(&machine(&[])).component("dram").unwrap().leakage_fj / 1_000_000_000
    };
    assert_eq!((second(0), second(1_600_000_000)), (4 * 38_000, 3 * 38_000 + 12_900));
}

#[test]
fn each_event_costs_its_price_in_its_component() {
    // Prices in fJ, before the clock tree of 20 %, which traversal units, intersection units and SRPs do not pay.
    #[rustfmt::skip]
    let cases: &[(Change, &[(&str, u128)])] = &[
        (|r| r.ti.trv[0].events.box_tests = 2, &[("trv", 30_000)]),
        (|r| r.ti.trv[0].events.triangle_tests = 1, &[("trv", 42_000)]),
        (|r| r.ti.trv[0].events.bypasses = 1, &[("trv", 10 * 1_020)]),
        (|r| r.ti.trv[0].events.pushes = 1, &[("stacks", 470)]),
        (|r| r.ti.trv[0].events.stack_operations = 1, &[("stacks", 260)]),
        (|r| r.ti.trv[0].l1.hits = 1, &[("trv_l1", 5_700)]),
        (|r| r.ti.trv[0].l1.misses = 1, &[("trv_l1", 600)]),
        (|r| r.ti.trv[0].l1.merges = 1, &[("trv_l1", 600)]),
        (|r| r.ti.trv[0].l1.fills = 1, &[("trv_l1", 11_500)]),
        (|r| r.ti.trv[0].l1.full = 9, &[]),
        (|r| r.ti.trv[0].buffer.late_reads = 1, &[("trv_l1", 5_700)]),
        (|r| r.ti.trv[0].buffer.record_reads = 1, &[("ray_buffers", 6_500)]),
        (|r| r.ti.ist[0].buffer.record_writes = 1, &[("ray_buffers", 8_000)]),
        (|r| r.ti.trv[0].buffer.parked = 1, &[("ray_buffers", 1_700)]),
        (|r| r.ti.ist[0].buffer.slot_updates = 1, &[("ray_buffers", 100)]),
        (|r| r.ti.dispatch.rays = 1, &[("trv", 27_000), ("ray_buffers", 14_500)]),
        (|r| r.ti.ist[0].events.tasks = 1, &[("crossbar", 16_000)]),
        (|r| r.ti.ist[0].events.triangle_tests = 1, &[("ist", 42_000)]),
        (|r| r.ti.ist[0].events.bypasses = 1, &[("ist", 30 * 1_020)]),
        (|r| r.ti.ist[0].l1.hits = 1, &[("ist_l1", 5_700)]),
        (|r| r.srp.kernels[3].ops = 1, &[("srp", 3_500)]),
        (|r| r.srp_l1.hits = 1, &[("srp_l1", 5_700)]),
        (|r| r.srp.local.reads = 1, &[("local_memory", 1_800)]),
        (|r| r.srp.local.writes = 1, &[("local_memory", 1_900)]),
        (|r| r.srp.interface.ray_bytes = 10, &[("interface", 13_000)]),
        (|r| r.srp.interface.hit_bytes = 10, &[("interface", 13_000)]),
        (|r| r.l2.hits = 1, &[("l2", 21_000)]),
        (|r| r.l2.misses = 1, &[("l2", 2_100)]),
        (|r| r.l2.fills = 1, &[("l2", 87_000)]),
        (|r| r.l2.lookups = 1, &[("network", 72 * 1_300)]),
        (|r| r.ti.trv[0].stages = running(7), &[("trv", 7 * 6_000)]),
        (|r| r.ti.ist[0].activity = running(7)[0].1, &[("ist", 7 * 8_400)]),
        (|r| (r.srp.activity.unit, r.srp.activity.idle) = (7, 9), &[("srp", 7 * 5_600)]),
    ];
    let config = machine(&[]);
    for (i, (change, expected)) in cases.iter().enumerate() {
        let report = Run::new(change).energy(&config);
        for component in &report.components {
            let price = expected.iter().find(|(name, _)| *name == component.name).map_or(0, |(_, fj)| *fj);
            assert_eq!(component.total_fj(), with_tree(component.name, price), "case {i}: {}", component.name);
        }
        let all: u128 = expected.iter().map(|(name, fj)| with_tree(name, *fj)).sum();
        assert_eq!(report.gpu_fj(), all, "case {i}: no other component");
    }
}

#[test]
fn memory_pays_no_clock_tree() {
    let config = machine(&[]);
    #[rustfmt::skip]
    let cases: &[(Change, u128, u128)] = &[
        (|r| r.dram.activates = 1, 1_200_000, 0),
        (|r| r.dram.reads = 1, 2_170_000, 32 * 28_000),
        (|r| r.dram.writes = 1, 1_290_000, 32 * 28_000),
        (|r| r.dram.refreshes = 1, 22_400_000, 0),
        (|r| r.dram.precharges = 1, 0, 0),
    ];
    for (i, (change, dram, phy)) in cases.iter().enumerate() {
        let report = Run::new(change).energy(&config);
        let of = |name| report.component(name).unwrap().dynamic_fj;
        assert_eq!((of("dram"), of("dram_phy"), report.gpu_fj()), (*dram, *phy, dram + phy), "case {i}");
    }
}

#[test]
fn interface_through_memory_is_paid_at_the_dram() {
    let report = Run::new(|r| r.srp.interface.ray_bytes = 1000).energy(&machine(&["gpu.interface=memory"]));
    assert_eq!(report.gpu_fj(), 0);
}

#[test]
fn a_second_leaks_microwatts_times_a_second() {
    // 500 M cycles at 500 MHz are a second; 1 uW s = 1e9 fJ.
    let leakage = |config: &MachineConfig| {
        let report = Run::new(|r| r.cycles = 500_000_000).energy(config);
        let of = |name: &str| (name.to_owned(), report.component(name).unwrap().leakage_fj / 1_000_000_000);
        let names =
            ["trv", "stacks", "ist", "trv_l1", "ist_l1", "ray_buffers", "srp", "srp_l1", "local_memory", "l2", "dram"];
        names.map(of)
    };
    let expect = |list: [(&str, u128); 11]| list.map(|(name, uw)| (name.to_owned(), uw));
    assert_eq!(
        leakage(&machine(&[])),
        expect([
            ("trv", 4 * 4 * 245),
            ("stacks", 16 * 2 * 20),
            ("ist", 4 * 275),
            ("trv_l1", 16 * 16 * 20),
            ("ist_l1", 4 * 16 * 20),
            // Four ray buffers of 2 KiB, sixteen input buffers of 4 KiB, four of 2 KiB and accumulation rows of 1 KiB.
            ("ray_buffers", (4 * 2 + 16 * 4 + 4 * 2 + 4) * 20),
            ("srp", 4 * 4000),
            ("srp_l1", 4 * 16 * 20),
            ("local_memory", 4 * 64 * 20),
            ("l2", 256 * 20),
            ("dram", 4 * 38_000),
        ])
    );
    // Accumulation rows hold a line each: 16 x 64 B in each of 20 units.
    let rows = leakage(&machine(&["ti.miss_handling=accumulate"]));
    assert_eq!(rows[5].1, (4 * 2 + 16 * 4 + 4 * 2 + 20) * 20);
    let full = leakage(&machine(&["ti.stack_entries=0"]));
    assert_eq!(full[1].1, 16 * 16 * 20, "64 rays x 64 entries x 4 B");
}

#[test]
fn the_whole_is_the_sum_of_its_parts_and_power_times_time() {
    let config = machine(&[]);
    let run = Run::new(|r| {
        r.cycles = 1_234_567;
        r.ti.trv[0].events.box_tests = 1_000_003;
        r.ti.trv[0].l1.misses = 30;
        r.srp.kernels[0].ops = 77_777;
        (r.l2.lookups, r.l2.hits, r.l2.fills) = (90, 60, 30);
        (r.dram.reads, r.dram.activates) = (60, 7);
        r.traffic.read[Region::Node as usize] = 960;
        r.traffic.written[Region::Framebuffer as usize] = 960;
    });
    let report = run.energy(&config);
    let groups = [Group::Ti, Group::Srp, Group::Memory].map(|g| report.group_fj(g));
    assert_eq!(groups.iter().sum::<u128>(), report.gpu_fj());
    assert_eq!(report.components.iter().map(|c| c.dynamic_fj + c.leakage_fj).sum::<u128>(), report.gpu_fj());
    let dynamic = |name| report.component(name).unwrap().dynamic_fj;
    assert_eq!(
        report.ti_with_memory_fj() - report.ti_fj(),
        (dynamic("l2") + dynamic("network")) / 3 + (dynamic("dram") + dynamic("dram_phy")) / 2,
        "30 of 90 lookups, 960 of 1920 bytes"
    );
    let seconds = 1_234_567.0 / 500e6;
    let joules = report.gpu_fj() as f64 * 1e-15;
    let power = watts(report.gpu_fj(), run.cycles, 500);
    assert!((power * seconds / joules - 1.0).abs() < 1e-12, "{power} W");
    assert!(watts(5, 0, 500).total_cmp(&0.0).is_eq());

    let mut twice = EnergyReport::default();
    twice.add(&report);
    twice.add(&report);
    assert_eq!((twice.gpu_fj(), twice.ti_memory_fj), (2 * report.gpu_fj(), 2 * report.ti_memory_fj));
}

#[test]
fn rounding_is_to_the_nearest_femtojoule() {
    let config = machine(&["energy.reorder_pj=0.001", "energy.clock_tree_percent=50"]);
    let of = |events: u64| {
        let report = Run::new(|r| r.ti.trv[0].buffer.slot_updates = events).energy(&config);
        report.component("ray_buffers").unwrap().dynamic_fj
    };
    assert_eq!((of(1), of(2), of(3)), (2, 3, 5), "1.5, 3 and 4.5 fJ");
}
