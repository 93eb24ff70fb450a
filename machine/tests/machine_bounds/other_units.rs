//! Processors and gathering units, cycle by cycle: sums made here, from the configuration and the operations of the paths.

use std::collections::BTreeSet;

use rayreel_machine::component::{Component, Tick};
use rayreel_machine::config::{Block, MachineConfig};
use rayreel_machine::link::{RayRef, RayUnit};
use rayreel_machine::memory::{IdealMemory, Port};
use rayreel_machine::ti::{TiContext, TiStats};
use rayreel_machine::time::TiCycle;
use rayreel_machine::traversal::ProcessorCounters;
use rayreel_machine::traversal::TracingUnit;
use rayreel_machine::work::TileWork;
use rayreel_machine::work::layout::{Layout, Lines, Region};
use rayreel_machine::work::ops::{Op, OpKind};
use rayreel_machine::work::synthetic::{Random, balanced_topology, random_path, tile_of};
use rayreel_machine::work::topology::Topology;

use super::harness::{chain, machine, path, repeated};
use rayreel_formats::tile::step;

/// What a unit did with all rays of a tile.
struct Done {
    /// When the hit of each ray left, in the order in which they did.
    at: Vec<u64>,
    ti: TiStats,
    processors: ProcessorCounters,
}

/// All rays of a tile, pushed in cycle 0, as far as there is room, before a memory of fixed latency.
fn through(config: &MachineConfig, tree: &Topology, tile: &TileWork, latency: u64) -> Done {
    let (layout, tiles) = (Layout::new(config), vec![tile.clone()]);
    let (mut memory, mut unit) = (IdealMemory::new(latency), TracingUnit::new(config, Port(0)));
    let (mut sent, mut now, mut arrived, mut at) = (0, TiCycle(0), Vec::new(), Vec::new());
    loop {
        memory.tick(now, &mut arrived);
        arrived.drain(..).for_each(|r| unit.fill(now, r.port, r.line));
        while sent < tile.rays.len() as u32 && unit.has_room() {
            unit.push(now, RayRef { slot: 0, ray: sent });
            sent += 1;
        }
        unit.tick(now, TiContext { tree, layout: &layout, tiles: &tiles, memory: &mut memory });
        at.extend(unit.results().drain(..).map(|message| message.at.0));
        if sent as usize == tile.rays.len() && unit.rays_inside() == 0 {
            let mut processors = ProcessorCounters::default();
            unit.processor_report(now).iter().for_each(|p| processors += p.counters);
            return Done { at, ti: unit.report(now), processors };
        }
        now = unit.next_event(now).min(memory.next_event(now)).after(now).cycle().unwrap();
    }
}

fn instructions(block: &Block) -> u64 {
    let Block { add, multiply, compare, integer, special, memory, .. } = *block;
    [add, multiply, compare, integer, special, memory].map(u64::from).iter().sum()
}

/// Lines that are here: caches are larger than tree and code.
struct Cold<'a> {
    config: &'a MachineConfig,
    here: BTreeSet<u64>,
    latency: u64,
}

impl Cold<'_> {
    /// Cycles until all lines are here.
    fn wait(&mut self, lines: impl Iterator<Item = Lines>) -> u64 {
        let missed = lines.flat_map(|l| l.first..=l.last).filter(|line| self.here.insert(*line)).count();
        if missed > 0 { self.latency } else { 0 }
    }

    /// Cycles of a thread in a block; its code is `skip` instructions behind the first.
    fn block(&mut self, block: &Block, skip: u64, data: Option<Lines>) -> u64 {
        let layout = Layout::new(self.config);
        let bytes = u64::from(self.config.processor.code.instruction_bytes);
        let code = layout.lines(Region::Code.base() + skip * bytes, instructions(block) * bytes);
        let waited = self.wait([code].into_iter().chain(data));
        let load = if block.memory > 0 { u64::from(self.config.ti.trv_l1.latency_cycles) } else { 0 };
        waited + instructions(block) + u64::from(block.stall_cycles) + load
    }
}

/// A thread by itself, from the cycle in which its ray comes to the one in which the hit leaves.
fn thread_alone(config: &MachineConfig, ops: &[Op], latency: u64) -> u64 {
    let (code, layout) = (&config.processor.code, Layout::new(config));
    let mut cold = Cold { config, here: BTreeSet::new(), latency };
    let [ray, visit, triangle] = [&code.ray, &code.visit, &code.triangle].map(instructions);
    // Dispatched a cycle later.
    let mut cycles = 1 + cold.block(&code.ray, 0, None);
    for op in ops {
        cycles += match op.kind() {
            OpKind::Visit { node, .. } => cold.block(&code.visit, ray, Some(layout.node(node))),
            OpKind::Leaf { triangle: first, tests } => (first..first + u32::from(tests))
                .map(|t| cold.block(&code.triangle, ray + visit, Some(layout.triangle(t))))
                .sum(),
            _ => cold.block(&code.pop, ray + visit + triangle, None),
        };
    }
    cycles
}

#[test]
fn a_thread_alone_takes_the_sum_of_its_blocks() {
    let config = machine("mimd-trax", &["gpu.cores=1", "ti.trv_l1.size=1MiB", "processor.code_l1.mshrs=64"]);
    let mut tests = 0;
    for seed in 0..200 {
        let mut random = Random(seed);
        let tree = balanced_topology(2 + random.below(5), random.below(4));
        let tile = tile_of(0, 0, &[random_path(&tree, false, &mut random)]);
        let latency = 1 + u64::from(random.below(60));
        let done = through(&config, &tree, &tile, latency);
        assert_eq!(done.at, [thread_alone(&config, tile.path(0), latency)], "seed {seed}");
        tests += done.ti.trv[0].events.triangle_tests;
    }
    assert!(tests > 200, "{tests}");
}

/// Threads that want one kind of unit, of which there is one: it works in every cycle from the first visit on.
#[test]
fn a_unit_that_all_threads_want_is_never_idle() {
    let (tree, config) = (chain(20), machine("mimd-trax", &["gpu.cores=1", "processor.units.multiply=1"]));
    let steps: Vec<u8> = [vec![step::RIGHT; 19], vec![step::LEFT, step::HIT]].concat();
    let tile = repeated(&tree, &steps, 32);
    let done = through(&config, &tree, &tile, 1);
    let code = &config.processor.code;
    let wanted: u64 =
        [(code.ray, 1), (code.visit, 20), (code.triangle, 1), (code.pop, done.ti.trv[0].events.stack_operations / 32)]
            .iter()
            .map(|(block, times)| 32 * times * u64::from(block.multiply))
            .sum();
    let last = *done.at.last().unwrap();
    assert_eq!(done.processors.multiply, wanted);
    // Before the first multiplication a ray is dispatched and its code comes; after the last its block goes on.
    assert!(last >= wanted && last <= wanted + 300, "{last} cycles for {wanted} multiplications");
    assert!(done.processors.units > done.processors.executing, "most of the time threads wait for it");
}

/// Two lanes, of which one tests a triangle and the other visits another node: what one does, the other waits for.
#[test]
fn lanes_that_part_wait_for_each_other() {
    let (tree, config) = (
        chain(2),
        machine(
            "simt-mimd",
            &[
                "gpu.cores=1",
                "processor.lanes=2",
                "ti.rays_per_trv=2",
                "ti.trv_l1.size=16KiB",
                "layout.triangle_bytes=64",
            ],
        ),
    );
    let near = path(&tree, &[step::LEFT, step::HIT]);
    let far = path(&tree, &[step::RIGHT, step::LEFT, step::HIT]);
    let same = |paths: [&_; 2]| tile_of(0, 0, &paths.map(Clone::clone));
    let code = &config.processor.code;
    let [ray, visit, triangle, pop] = [&code.ray, &code.visit, &code.triangle, &code.pop].map(instructions);
    let parted = through(&config, &tree, &same([&near, &far]), 1);
    // Both are set up and visit the root; one visits the second node while the other waits; both test their triangles, and find
    // their stacks empty.
    assert_eq!(parted.processors.instructions, ray + 2 * visit + triangle + pop);
    assert_eq!(parted.processors.lanes_off, visit);
    let together = through(&config, &tree, &same([&far, &far]), 1);
    assert_eq!(
        (together.processors.instructions, together.processors.lanes_off),
        (ray + 2 * visit + triangle + pop, 0)
    );
    assert_eq!(parted.at, together.at, "the longer way is what both take");
    // A node that both read is looked up once.
    assert_eq!((together.ti.trv[0].l1.lookups, parted.ti.trv[0].l1.lookups), (3, 4));
    let alone = machine("simt-mimd-vector", &["gpu.cores=1", "processor.lanes=1", "ti.rays_per_trv=8"]);
    let vector = through(&alone, &tree, &same([&near, &near]), 1).processors;
    let by_three = |block: &Block| {
        let [add, multiply, compare] =
            [block.add, block.multiply, block.compare].map(|count| u64::from(count.div_ceil(3)));
        add + multiply + compare + u64::from(block.integer + block.special + block.memory)
    };
    assert_eq!(
        vector.instructions,
        2 * [&code.ray, &code.visit, &code.triangle, &code.pop].map(by_three).iter().sum::<u64>()
    );
    assert_eq!(vector.add, 2 * u64::from(code.ray.add + code.visit.add + code.triangle.add), "the same operations");
}

/// Rays that need the same are tested together: so many a cycle, with one lookup; a ray alone waits for company.
#[test]
fn rays_of_one_way_are_gathered() {
    let config =
        machine("gr6500", &["gpu.cores=1", "ti.gather_boxes=4", "ti.gather_triangles=2", "ti.gather_wait_cycles=30"]);
    let ti = &config.ti;
    let [setup, inner, ist] = [ti.setup_cycles, ti.inner_cycles, ti.ist_cycles].map(u64::from);
    let tree = chain(1);
    let steps = [step::LEFT, step::HIT];
    // One ray: dispatched a cycle later, set up; its node misses, but company is awaited longer; so is its triangle.
    let one = through(&config, &tree, &repeated(&tree, &steps, 1), 5);
    let ends = one.ti.trv[0].events.stack_operations;
    assert_eq!(one.at, [1 + setup + 30 + inner + 30 + ist + ends * u64::from(ti.stack_cycles)]);
    // Eight rays, a ray a cycle: two nodes' worth of four, four triangles' worth of two.
    let eight = through(&config, &tree, &repeated(&tree, &steps, 8), 5);
    let unit = &eight.ti.trv[0];
    assert_eq!((unit.stages[0].1.busy, unit.stages[1].1.busy), (2, 4));
    assert_eq!((unit.events.node_visits, unit.events.triangle_tests), (8, 8));
    // The node's line is asked for when the first ray is set up, and comes 5 cycles later: four of the six rays that wait by then are
    // tested, which read it. Two cycles later there are four again, which read it again. The triangle's is read four times.
    let node = 1 + setup + 5;
    assert_eq!((unit.l1.lookups, unit.l1.misses, unit.buffer.late_reads), (2, 2, 2 + 4));
    // So for the triangle, whose line comes when all eight wait for it: two a cycle.
    let triangle = node + inner + 5;
    let end = |pair: u64| triangle + pair + ist + ends * u64::from(ti.stack_cycles);
    assert_eq!(eight.at, [0, 0, 1, 1, 2, 2, 3, 3].map(end));
}
