//! What is worked is the same on every machine; and every cycle and every joule is accounted for.

use std::collections::BTreeSet;

use rayreel_machine::config::{Divergence, MachineConfig, PRESETS, Pipeline, PrimaryVisibility};
use rayreel_machine::energy::{EnergyReport, Group, watts};
use rayreel_machine::srp::{Needs, missing_kernels};
use rayreel_machine::stats::Stats;
use rayreel_machine::work::synthetic::Random;
use rayreel_machine::work::{NO_TRIANGLE, TileWork};

use super::bounds::{Demand, intervals_and_ops};
use super::harness::{SHAPE, machine, random_machine, random_work, recorded, run_real};

/// The same counts as they stand in the counters.
fn done(stats: &Stats) -> Demand {
    let mut sum = Demand::default();
    for core in &stats.cores {
        for unit in &core.ti.trv {
            let e = unit.events;
            sum.rays += e.rays;
            sum.visits += e.node_visits - e.restart_visits;
            sum.leaves += e.leaves;
            sum.tests += e.triangle_tests;
            sum.stack += e.stack_operations;
            sum.culled += e.culled;
        }
        sum.tests += core.ti.ist.iter().map(|unit| unit.events.triangle_tests).sum::<u64>();
        core.srp.kernels.iter().zip(&mut sum.items).for_each(|(kernel, items)| *items += kernel.items);
    }
    sum
}

/// What no counter counts alone is left out: on restarts children are pushed again.
fn assert_work(what: &str, config: &MachineConfig, tiles: &[TileWork], stats: &Stats) {
    let asked = Demand { pushes: 0, ends: 0, lights: 0, secondary: 0, ..Demand::of(config, tiles) };
    assert_eq!(done(stats), asked, "{what}");
    let sum = |of: &dyn Fn(&rayreel_machine::stats::CoreStats) -> u64| stats.cores.iter().map(of).sum::<u64>();
    assert_eq!(sum(&|c| c.ti.dispatch.rays), asked.rays, "{what}");
    assert_eq!((sum(&|c| c.srp.interface.rays), sum(&|c| c.srp.interface.hits)), (asked.rays, asked.rays), "{what}");
    assert_eq!(sum(&|c| c.srp.local.tiles), tiles.len() as u64, "{what}");
    assert_histories(what, config, tiles, stats);
    let (k, demand) = (&config.srp.kernels, Demand::of(config, tiles));
    let ops: u64 = asked.items.iter().zip(intervals_and_ops(config)).map(|(n, k)| n * k.1).sum();
    let rays = demand.lights * u64::from(k.light.ops) + demand.secondary * u64::from(k.secondary.ops);
    // Predicated branches cost operations too, by the batches that they come in.
    let ran = sum(&|c| c.srp.kernels.iter().map(|k| k.ops).sum());
    match config.srp.divergence {
        Divergence::Inspector => {
            let sorted = (asked.items[1] + asked.items[4]) * u64::from(config.srp.inspector_ops);
            assert_eq!(ran, ops + rays + sorted, "{what}");
        }
        Divergence::Naive => {
            // Tiles of more than one material have mixed batches, unless batches are of one item.
            let materials = |tile: &TileWork| {
                let hits = tile.rays.iter().filter(|ray| ray.triangle != NO_TRIANGLE);
                hits.map(|ray| ray.material).collect::<BTreeSet<_>>().len() as u64
            };
            let most = tiles.iter().map(materials).max().unwrap_or(0).max(2);
            assert!(ran <= (ops + rays) * most, "{what}: all branches of every batch");
            let alone = config.srp.gather_entries == 1
                || config.ti.pipeline == Pipeline::Software && config.processor.lanes == 1;
            assert!(if alone { ran == ops + rays } else { ran >= ops + rays }, "{what}");
        }
    }
    let boxes = sum(&|c| c.ti.trv.iter().map(|t| t.events.box_tests).sum());
    let visits = sum(&|c| c.ti.trv.iter().map(|t| t.events.node_visits).sum());
    assert_eq!(boxes, 2 * visits, "{what}: two boxes a visit");
}

/// Every line with an entry that is read or kept goes through memory once for each run of entries: a primary hit is object, normal, shadow
/// bits, length and flags, one below it the same without the flags, each side by side from a line's beginning.
fn assert_histories(what: &str, config: &MachineConfig, tiles: &[TileWork], stats: &Stats) {
    let (sample, line) = (&config.srp.sample, config.l2.line_bytes);
    let bytes = |below: bool| {
        let flags = if below { 0 } else { sample.flags };
        sample.object + sample.normal + sample.shadow + sample.distance + flags
    };
    let lines = |below: bool, first: u32, count: u32| {
        let end = ((first + count) * bytes(below)).div_ceil(line);
        if count == 0 { 0 } else { u64::from((end - first * bytes(below) / line) * line) }
    };
    let read = tiles.iter().flat_map(|tile| &tile.history.reads).map(|span| lines(span.below, span.first, span.count));
    let kept = tiles.iter().map(|tile| lines(false, 0, tile.history.kept) + lines(true, 0, tile.history.kept_below));
    let dma = stats.cores.iter().map(|core| (core.srp.dma.history_read, core.srp.dma.history_written));
    let moved = dma.fold((0, 0), |sum, core| (sum.0 + core.0, sum.1 + core.1));
    assert_eq!(moved, (read.sum(), kept.sum()), "{what}: histories");
}

/// Every cycle of every stage is in one class.
fn assert_accounts(what: &str, config: &MachineConfig, stats: &Stats) {
    for core in &stats.cores {
        for (name, activity) in core.ti.trv.iter().flat_map(|unit| &unit.stages) {
            assert_eq!(activity.total(), stats.cycles, "{what}: {name}");
        }
        for unit in &core.ti.ist {
            assert_eq!(unit.activity.total(), stats.cycles, "{what}: triangles");
        }
        assert_eq!(core.srp.activity.total(), core.srp_cycles, "{what}: SRP");
        for processor in &core.processors {
            let c = processor.counters;
            let warps = u64::from(config.ti.rays_per_trv / config.processor.lanes);
            let spent = c.executing + c.units + c.memory + c.empty;
            assert_eq!(spent, warps * stats.cycles, "{what}: cycles of warps");
            let lanes = u64::from(config.processor.lanes);
            assert_eq!(c.lane_instructions + c.lanes_off, lanes * c.instructions, "{what}: lanes");
        }
        let l1s = core.ti.trv.iter().map(|t| t.l1).chain(core.ti.ist.iter().map(|i| i.l1)).chain([core.srp_l1]);
        for l1 in l1s {
            assert_eq!(l1.lookups, l1.hits + l1.misses + l1.merges, "{what}");
            assert_eq!(l1.misses, l1.fills + l1.dropped, "{what}: every line arrived");
        }
    }
    let l2 = stats.memory.l2;
    assert_eq!((l2.lookups, l2.misses), (l2.hits + l2.misses + l2.merges, l2.fills), "{what}: L2");
    let asked: u64 = stats.cores.iter().flat_map(|c| c.ti.trv.iter().map(|t| t.l1.misses)).sum::<u64>()
        + stats.cores.iter().flat_map(|c| c.ti.ist.iter().map(|i| i.l1.misses)).sum::<u64>()
        + stats.processors().map(|p| p.code_l1.misses).sum::<u64>()
        + stats.cores.iter().map(|c| c.srp_l1.misses).sum::<u64>();
    assert_eq!(l2.lookups, asked, "{what}: the L2 is asked for what the L1s miss");
    for c in &stats.memory.channels {
        // Rows may be open for writes that wait at the end.
        let (rows, lines) = (c.row_hits + c.row_closed + c.row_conflicts, c.read_lines + c.write_lines);
        assert!(lines <= rows && rows <= lines + 32, "{what}: {rows} rows, {lines} lines");
    }
}

/// E = sum of parts, by component and by group; power x time = E.
fn assert_energy(what: &str, config: &MachineConfig, stats: &Stats) {
    let report = EnergyReport::new(config, stats);
    let parts: u128 = report.components.iter().map(|c| c.dynamic_fj + c.leakage_fj).sum();
    let groups: u128 = [Group::Ti, Group::Srp, Group::Memory].map(|g| report.group_fj(g)).iter().sum();
    assert!(parts > 0 && parts == report.gpu_fj() && groups == parts, "{what}");
    let with_memory = report.ti_with_memory_fj();
    assert!(report.ti_fj() <= with_memory && with_memory < parts, "{what}");
    // Twice the time at the same counts: leakage doubles to a rounding a component, nothing else moves.
    let mut longer = Stats { cycles: 2 * stats.cycles, ..stats.clone() };
    longer.memory.channels.iter_mut().for_each(|channel| channel.powered_down *= 2);
    let twice = EnergyReport::new(config, &longer);
    for (one, two) in report.components.iter().zip(&twice.components) {
        assert_eq!(one.dynamic_fj, two.dynamic_fj, "{what}: {}", one.name);
        assert!((2 * one.leakage_fj).abs_diff(two.leakage_fj) <= 2, "{what}: {}", one.name);
    }
    let seconds = stats.cycles as f64 / (f64::from(config.ti.clock_mhz) * 1e6);
    let watts = watts(report.gpu_fj(), stats.cycles, config.ti.clock_mhz);
    let joules: f64 = report.components.iter().map(|c| (c.dynamic_fj + c.leakage_fj) as f64 * 1e-15).sum();
    assert!((watts * seconds / joules - 1.0).abs() < 1e-9 && watts > 0.01 && watts < 20.0, "{what}: {watts} W");
}

fn assert_all(what: &str, config: &MachineConfig, tiles: &[TileWork], stats: &Stats) {
    assert_work(what, config, tiles, stats);
    assert_accounts(what, config, stats);
    assert_energy(what, config, stats);
}

#[test]
fn every_preset_does_the_recorded_work() {
    let mut refused = 0;
    for (i, work) in recorded().iter().enumerate() {
        let sum = Demand::of(&machine("sgrt-ti2", &[]), &work.tiles);
        let paths = &work.paths;
        assert_eq!(
            (sum.rays, sum.visits, sum.tests, sum.pushes, sum.culled, sum.stack - sum.culled - sum.ends),
            (paths.rays, paths.node_visits, paths.triangle_tests, paths.pushes, paths.culled, paths.pops)
        );
        // Some tiles of the Cornell box under both policies, the teapot under the adaptive one.
        let tiles = if i < 2 { &work.tiles[5..7] } else { &work.tiles[..] };
        if i == 2 {
            continue;
        }
        for (name, _) in PRESETS {
            let config = machine(name, &[]);
            let needs = tiles.iter().map(Needs::of).fold(Needs::default(), Needs::or);
            if missing_kernels(&config, &needs).is_empty() {
                let stats = run_real(&config, (&work.tree, tiles), work.shape);
                assert_all(&format!("{}, {name}", work.name), &config, tiles, &stats);
            } else {
                refused += 1;
            }
        }
    }
    assert_eq!(refused, 2, "RayCore cannot interpolate, and every other machine can");
}

#[test]
fn random_machines_do_the_same_work() {
    let (mut naives, mut dearer) = (0, 0);
    for seed in 0..30 {
        let (tree, tiles) = random_work(seed);
        let mut config = random_machine(&mut Random(seed + 77));
        config.l2.inclusive = seed % 3 == 0;
        if seed % 5 == 0 {
            config.gpu.primary_visibility = PrimaryVisibility::Raster;
        }
        let stats = run_real(&config, (&tree, &tiles), SHAPE);
        assert_all(&format!("seed {seed}"), &config, &tiles, &stats);
        if config.srp.gather_entries > 1 {
            let ops = |stats: &Stats| stats.cores.iter().flat_map(|c| &c.srp.kernels).map(|k| k.ops).sum::<u64>();
            config.srp.divergence = Divergence::Naive;
            let naive = run_real(&config, (&tree, &tiles), SHAPE);
            assert_all(&format!("seed {seed}, naive"), &config, &tiles, &naive);
            let inspector = u64::from(config.srp.inspector_ops);
            let sorted = |k: usize| stats.cores.iter().map(|c| c.srp.kernels[k].items).sum::<u64>() * inspector;
            dearer += u32::from(ops(&naive) > ops(&stats) - sorted(1) - sorted(4));
            naives += 1;
        }
    }
    assert!(naives > 10 && dearer * 2 > naives, "batches of several materials pay for all: {dearer} of {naives}");
}
