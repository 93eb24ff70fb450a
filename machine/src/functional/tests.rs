use std::sync::Arc;

use super::*;
use crate::config::NamedMachine;
use crate::system::{NoProbe, System};
use crate::work::PolicyReads;
use crate::work::synthetic::{Random, balanced_topology, random_tile};

const SHAPE: FrameShape = FrameShape {
    width_pixels: 128,
    samples_per_axis: 1,
    pixel_bytes: 4,
    tile_bytes: 0,
    tile_samples: 1024,
    policy: PolicyReads::PAPER,
};

fn tiles(tree: &Topology, count: u32) -> Vec<Arc<TileWork>> {
    let mut random = Random(7);
    (0..count).map(|tile| Arc::new(random_tile(tree, tile, 64, 2, &mut random))).collect()
}

fn config(sets: &[&str]) -> MachineConfig {
    let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
    NamedMachine::load("sgrt-ti2", &sets).unwrap().config
}

fn sum(stats: &Stats, of: impl Fn(&crate::ti::TrvStats) -> u64) -> u64 {
    stats.trv().map(of).sum()
}

#[test]
fn features_and_progress_add_up_to_what_was_counted() {
    let (tree, config) = (balanced_topology(8, 2), config(&[]));
    let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
    tiles(&tree, 20).into_iter().for_each(|tile| machine.feed(tile));
    machine.finish();
    let all = machine.done();
    assert!((machine.progress() - 20.0).abs() < 1e-9, "{}", machine.progress());
    assert_eq!(machine.sizes().len(), 20);
    let stats = machine.stats();
    let tests: u64 = stats.ist().map(|unit| unit.events.triangle_tests).sum();
    let visits = sum(&stats, |unit| unit.events.node_visits);
    assert_eq!(all.cost(), visits as f64 + 1.5 * tests as f64 + 4.0 * stats.rays() as f64);
    let misses: u64 = stats.ist().map(|unit| unit.l1.misses).sum();
    assert_eq!(all.0[1..4], [tests as f64, sum(&stats, |unit| unit.l1.misses) as f64, misses as f64]);
    let dram = stats.memory.dram();
    assert_eq!(all.0[4], (dram.read_lines + dram.write_lines) as f64);
    assert_eq!(all.0[6], stats.rays() as f64);
    assert_eq!(dram.row_hits + dram.activates, dram.read_lines + dram.write_lines);
}

#[test]
fn caches_that_hold_everything_miss_each_line_once() {
    let (tree, config) =
        (balanced_topology(5, 1), config(&["ti.trv_l1.size=256KiB", "l2.size=4MiB", "ti.trv=1", "gpu.cores=1"]));
    let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
    let work = tiles(&tree, 4);
    let mut lines = std::collections::BTreeSet::new();
    let layout = crate::work::layout::Layout::new(&config);
    for tile in work {
        for op in &tile.ops {
            if let crate::work::ops::OpKind::Visit { node, .. } = op.kind() {
                lines.extend(layout.node(node).first..=layout.node(node).last);
            }
        }
        machine.feed(tile);
    }
    machine.finish();
    assert_eq!(sum(&machine.stats(), |unit| unit.l1.misses), lines.len() as u64);
}

#[test]
fn what_is_done_and_what_is_left_at_a_checkpoint_is_all() {
    let (tree, config) = (balanced_topology(8, 2), config(&["gpu.cores=2"]));
    let work = tiles(&tree, 9);
    let run = |tiles: &[Arc<TileWork>]| {
        let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
        tiles.iter().for_each(|tile| machine.feed(Arc::clone(tile)));
        machine
    };
    let mut machine = run(&work);
    while !machine.has_room() {
        machine.take_turn();
    }
    let checkpoint = machine.checkpoint();
    assert_eq!(checkpoint.tiles.len(), 3);
    let before = machine.stats();
    machine.finish();
    let after = machine.stats();
    let mut rest = System::resume(&config, &tree, SHAPE, &checkpoint);
    rest.make_room(&mut NoProbe).unwrap();
    let (rest, _) = rest.finish(&mut NoProbe).unwrap();
    assert_eq!(before.rays() + rest.rays(), after.rays());
    let visits = |stats: &Stats| sum(stats, |unit| unit.events.node_visits);
    // Rays that were on their way begin again.
    let again = visits(&before) + visits(&rest) - visits(&after);
    assert!(again < visits(&after) / 20, "{again} of {}", visits(&after));
    assert!(rest.tiles == 3 && visits(&rest) > 0 && visits(&before) > 0);
}

/// However often it stops on the way, every tile is worked on.
#[test]
fn a_simulation_that_works_in_steps_loses_no_tile() {
    let (tree, config) = (balanced_topology(8, 2), config(&[]));
    let work = tiles(&tree, 12);
    let mut system = System::<crate::memory::MemorySystem>::new(&config, &tree, SHAPE);
    let mut left = work.iter().map(Arc::clone).peekable();
    let mut steps = 0;
    while left.peek().is_some() {
        system.work_until(system.done() + 1000.0, &mut left).unwrap();
        steps += 1;
    }
    let in_steps = system.finish(&mut NoProbe).unwrap().0;
    let at_once = simulated(&config, &tree, &work);
    assert!(steps > 3, "{steps}");
    assert_eq!((in_steps.tiles, in_steps.rays()), (at_once.tiles, at_once.rays()));
    assert_eq!(in_steps.cycles, at_once.cycles);
}

#[test]
fn a_machine_that_begins_warm_misses_less() {
    let (tree, config) = (balanced_topology(8, 2), config(&[]));
    let work = tiles(&tree, 16);
    let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
    work.iter().for_each(|tile| machine.feed(Arc::clone(tile)));
    machine.finish();
    let warm = machine.checkpoint();
    assert!(warm.tiles.is_empty());
    let misses = |mut system: System<'_, crate::memory::MemorySystem>| {
        work[..4].iter().for_each(|tile| system.feed(TileWork::clone(tile), &mut NoProbe).unwrap());
        system.finish(&mut NoProbe).unwrap().0.memory.l2.misses
    };
    let cold = misses(System::new(&config, &tree, SHAPE));
    let resumed = misses(System::resume(&config, &tree, SHAPE, &warm));
    assert!(resumed < cold, "{resumed} of {cold}");
}

/// The same tiles through every cycle.
fn simulated(config: &MachineConfig, tree: &Topology, work: &[Arc<TileWork>]) -> Stats {
    let mut system = System::<crate::memory::MemorySystem>::new(config, tree, SHAPE);
    work.iter().for_each(|tile| system.feed(TileWork::clone(tile), &mut NoProbe).unwrap());
    system.finish(&mut NoProbe).unwrap().0
}

/// Where one ray is out at a time only the order of the rays is left, and that is the SRP's.
#[test]
fn one_ray_at_a_time_finds_what_a_simulation_finds() {
    let alone = ["gpu.cores=1", "ti.trv=1", "ti.rays_per_trv=1", "ti.ray_fifo_entries=1", "gpu.tiles_in_flight=1"];
    let small = ["ti.trv_l1.size=4KiB", "ti.ist_l1.size=2KiB", "l2.size=32KiB"];
    let (tree, config) = (balanced_topology(9, 2), config(&[&alone[..], &small].concat()));
    let work = tiles(&tree, 12);
    let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
    work.iter().for_each(|tile| machine.feed(Arc::clone(tile)));
    machine.finish();
    let (counted, simulated) = (machine.stats(), simulated(&config, &tree, &work));
    let misses = |stats: &Stats| {
        let ist: u64 = stats.ist().map(|unit| unit.l1.misses).sum();
        [sum(stats, |unit| unit.l1.misses), ist, stats.memory.l2.lookups, stats.memory.l2.misses]
    };
    for (counted, simulated) in misses(&counted).into_iter().zip(misses(&simulated)) {
        assert!(simulated > 1000 && counted.abs_diff(simulated) * 50 < simulated, "{counted} of {simulated}");
    }
}

/// An ideal link carries the same bytes, and is never busy.
#[test]
fn the_interface_is_busy_as_long_as_that_of_a_simulation() {
    for (sets, is_busy) in [(&[][..], true), (&["srp.ideal=true"], false), (&["gpu.interface=memory"], false)] {
        let (tree, config) = (balanced_topology(8, 2), config(sets));
        let work = tiles(&tree, 6);
        let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
        work.iter().for_each(|tile| machine.feed(Arc::clone(tile)));
        machine.finish();
        let of = |stats: &Stats| {
            let mut sum = crate::srp::InterfaceCounters::default();
            stats.cores.iter().for_each(|core| sum += core.srp.interface);
            sum
        };
        let (counted, simulated) = (of(&machine.stats()), of(&simulated(&config, &tree, &work)));
        assert_eq!(counted, simulated, "{sets:?}");
        assert!((counted.ray_busy > 0) == is_busy && counted.ray_bytes > 0, "{sets:?}: {counted:?}");
    }
}

#[test]
fn the_clock_is_near_that_of_a_simulation() {
    for sets in
        [&[][..], &["srp.clock_mhz=250"], &["srp.ideal=true"], &["ti.rays_per_trv=8"], &["gpu.cores=2", "ti.ist=2"]]
    {
        let (tree, config) = (balanced_topology(8, 2), config(sets));
        let work = tiles(&tree, 60);
        let mut machine = FunctionalMachine::new(&config, &tree, SHAPE);
        work.iter().for_each(|tile| machine.feed(Arc::clone(tile)));
        machine.finish();
        let clock = machine.done().0[8] / f64::from(config.gpu.cores);
        let cycles = simulated(&config, &tree, &work).cycles as f64;
        assert!((0.7..1.1).contains(&(clock / cycles)), "{sets:?}: {clock} of {cycles}");
    }
}
