//! One ray alone takes the sum of its latencies, from the first cycle of its tile to the last. The sum is made here, from the
//! configuration and the operations of the path.

use std::collections::BTreeMap;

use rayreel_machine::config::{MachineConfig, MissHandling, Pipeline};
use rayreel_machine::memory::IdealMemory;
use rayreel_machine::work::layout::{Layout, Lines};
use rayreel_machine::work::ops::{Op, OpKind};
use rayreel_machine::work::synthetic::{Random, balanced_topology, random_path, tile_of};
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{NO_TRIANGLE, TileWork};

use super::harness::{SHAPE, chain, machine, random_machine, repeated, run};
use rayreel_formats::tile::step;

/// When each line is here; caches are larger than the tree.
type Cache = BTreeMap<u64, u64>;

struct Sum<'a> {
    config: &'a MachineConfig,
    tree: &'a Topology,
    layout: Layout,
    latency: u64,
    nodes: Cache,
    triangles: Cache,
    /// Depths of the inner, leaf and stack pipelines.
    inner: u64,
    leaf: u64,
    stack: u64,
}

impl<'a> Sum<'a> {
    fn new(config: &'a MachineConfig, tree: &'a Topology, latency: u64) -> Self {
        let ti = &config.ti;
        let [inner, leaf, stack, ist] =
            [ti.inner_cycles, ti.leaf_cycles, ti.stack_cycles, ti.ist_cycles].map(u64::from);
        let (inner, leaf, stack) = match ti.pipeline {
            Pipeline::Parallel => (inner, leaf, stack),
            Pipeline::Single => [inner + leaf + stack; 3].into(),
            Pipeline::Unified | Pipeline::Software | Pipeline::Gathering => [inner + leaf + stack + ist; 3].into(),
        };
        let layout = Layout::new(config);
        Self { config, tree, layout, latency, nodes: Cache::new(), triangles: Cache::new(), inner, leaf, stack }
    }

    /// An operation that needs `lines` arrives at the input buffer at `at`: the cycle in which it issues for good.
    fn fetch(&mut self, mut at: u64, lines: Lines, triangle: bool, depth: u64) -> u64 {
        let ti = &self.config.ti;
        let unified = ti.pipeline == Pipeline::Unified;
        let (l1, width) = match triangle && !unified {
            true => (&ti.ist_l1, ti.ist_lines_per_cycle),
            false => (&ti.trv_l1, ti.trv_lines_per_cycle),
        };
        let (hit, width) = (u64::from(l1.latency_cycles), u64::from(width));
        let cache = if triangle { &mut self.triangles } else { &mut self.nodes };
        loop {
            let mut last_line = 0;
            // Tags are looked up on arrival; data are read so many lines a cycle.
            for line in lines.first..=lines.last {
                let ready = *cache.entry(line).or_insert(at + self.latency);
                last_line = if ready > at { last_line.max(ready) } else { last_line };
            }
            let read = at + (lines.last - lines.first) / width + hit;
            let mode = if triangle && !unified { ti.ist_miss_handling } else { ti.miss_handling };
            match mode {
                // A missed operation passes the pipeline and looks up again.
                MissHandling::Retry if last_line > 0 => at = read + depth,
                MissHandling::Accumulate | MissHandling::Reorder if last_line > 0 => return last_line,
                _ => return read,
            }
        }
    }

    fn visit(&mut self, at: u64, node: u32) -> u64 {
        let passes = 2 / self.config.ti.aabbs_per_cycle;
        (0..passes).fold(at, |at, _| self.fetch(at, self.layout.node(node), false, self.inner) + self.inner)
    }

    fn leaf(&mut self, at: u64, first: u32, tests: u32) -> u64 {
        let ti = &self.config.ti;
        let triangles = (first..first + tests).map(|t| self.layout.triangle(t)).collect::<Vec<_>>();
        if ti.pipeline == Pipeline::Unified {
            return triangles.into_iter().fold(at, |at, t| self.fetch(at, t, true, self.inner) + self.inner);
        }
        if tests == 0 {
            return at + self.leaf;
        }
        let (crossbar, depth) = (u64::from(ti.crossbar_cycles), u64::from(ti.ist_cycles));
        // Triangles follow each other: each is looked up in the cycle after the one before issued.
        let mut next = at + self.leaf + crossbar;
        for triangle in triangles {
            next = self.fetch(next, triangle, true, depth) + 1;
        }
        next - 1 + depth + crossbar
    }

    /// From the cycle in which the ray is in the ray buffer to that in which its hit is known.
    fn unit(&mut self, at: u64, ops: &[Op]) -> u64 {
        let ti = &self.config.ti;
        let short = if ti.stack_entries == 0 { u32::MAX } else { ti.stack_entries };
        // Dispatched a cycle later.
        let (mut at, mut deferred, mut held) = (at + 1 + u64::from(ti.setup_cycles), 0_u32, 0_u32);
        for op in ops {
            match op.kind() {
                OpKind::Visit { node, defers } => {
                    at = self.visit(at, node);
                    deferred += u32::from(defers);
                    held = (held + u32::from(defers)).min(short);
                }
                OpKind::Leaf { triangle, tests } => at = self.leaf(at, triangle, tests.into()),
                OpKind::End => at += self.stack,
                OpKind::Pop { node } | OpKind::Cull { node } => {
                    at += self.stack;
                    deferred -= 1;
                    if held > 0 {
                        held -= 1;
                        continue;
                    }
                    // Lost: down again from the root.
                    let mut way = vec![node];
                    while way[way.len() - 1] != 0 {
                        way.push(self.tree.parents[way[way.len() - 1] as usize]);
                    }
                    at = way.into_iter().rev().fold(at, |at, node| self.visit(at, node));
                    held = deferred.min(short);
                }
            }
        }
        at
    }

    /// The whole run of a tile of one primary ray.
    fn run(&mut self, tile: &TileWork) -> u64 {
        let (gpu, srp) = (&self.config.gpu, &self.config.srp);
        let (f, ti) = (u64::from(srp.clock_mhz), u64::from(self.config.ti.clock_mhz));
        let to_ti = |srp: u64| (srp * ti).div_ceil(f);
        let to_srp = |at: u64| (at * f).div_ceil(ti);
        let link = |bytes: u32| u64::from(bytes.div_ceil(gpu.interface_bytes_per_cycle) + gpu.interface_latency_cycles);
        let [raygen, shade, miss, resolve] =
            [srp.kernels.raygen, srp.kernels.shade, srp.kernels.miss, srp.kernels.resolve]
                .map(|k| u64::from(k.prologue_cycles + k.ii_cycles));
        let (ray_link, hit_link) = (link(gpu.ray_message_bytes), link(gpu.hit_message_bytes));
        let inspector = u64::from(srp.inspector_cycles);
        let known = self.unit(to_ti(raygen) + ray_link, tile.path(0));
        let here = known + hit_link;
        let done = match tile.rays[0].triangle {
            NO_TRIANGLE => to_srp(here) + miss,
            // Attributes and a texel are looked up one a SRP cycle, and their data awaited.
            triangle => {
                let lines = self.layout.attribute(triangle);
                let last = to_srp(here) + lines.last - lines.first + 1;
                let read = to_srp(last * ti / f + self.latency);
                (to_srp(here) + inspector + shade).max(read)
            }
        };
        // Resolve; the pixel is written; its slot is free a cycle later, and the run is over a cycle after that.
        to_ti(done + resolve) + 2
    }
}

#[test]
fn one_ray_alone_takes_the_sum_of_its_latencies() {
    let (mut restarts, mut hits) = (0, 0);
    for seed in 0..500 {
        let mut random = Random(seed);
        let mut config = random_machine(&mut random);
        config.gpu.cores = 1;
        // An operation of two lines asks for both.
        (config.ti.trv_l1.mshrs, config.ti.ist_l1.mshrs) = (4, 4);
        let tree = balanced_topology(2 + random.below(5), random.below(4));
        let tile = tile_of(0, 0, &[random_path(&tree, false, &mut random)]);
        let latency = 1 + u64::from(random.below(60));
        let stats = run(&config, (&tree, std::slice::from_ref(&tile)), SHAPE, IdealMemory::new(latency));
        let sum = Sum::new(&config, &tree, latency).run(&tile);
        assert_eq!(stats.cycles, sum, "seed {seed}: latency {latency}, {:?}, {:#?}", tile.path(0), config.ti);
        restarts += stats.cores[0].ti.trv.iter().map(|t| t.events.restarts).sum::<u64>();
        hits += u64::from(tile.rays[0].triangle != NO_TRIANGLE);
    }
    assert!(restarts > 50 && hits > 50, "{restarts} restarts, {hits} hits");
}

/// The frame that MODEL.md works by hand: one sample whose ray visits one node and hits the triangle of its leaf, on one core,
/// before a memory that answers after 50 cycles.
#[test]
fn a_frame_worked_by_hand() {
    let (tree, steps) = (chain(1), [step::LEFT, step::HIT]);
    let tile = repeated(&tree, &steps, 1);
    let config = machine("sgrt-ti2", &["gpu.cores=1"]);
    let stats = run(&config, (&tree, std::slice::from_ref(&tile)), SHAPE, IdealMemory::new(50));
    let ti = &stats.cores[0].ti;
    let trv = ti.trv.iter().find(|unit| unit.events.rays > 0).unwrap();
    let activity = |unit: &str| trv.stages.iter().find(|(name, _)| *name == unit).unwrap().1;
    assert_eq!(stats.cycles, 259);
    assert_eq!((trv.events.bypasses, trv.l1.misses, ti.ist[0].l1.misses), (5, 1, 1));
    // In the unit from its dispatch in cycle 16 to its end in cycle 200.
    assert_eq!(trv.events.ray_cycles, 200 - 16);
    let (inner, leaf, stack) = (activity("inner"), activity("leaf"), activity("stack"));
    assert_eq!((inner.busy, inner.bypass, leaf.busy, stack.busy), (1, 5, 1, 1));
    let srp = &stats.cores[0].srp.activity;
    assert_eq!((srp.raygen, srp.inspector, srp.shade, srp.resolve), (25, 1, 88, 9));
    // From 493, when the shading is done, to 504, when the texel is here; from 25 to 404 the ray is out.
    assert_eq!((srp.memory, srp.unit), (504 - 493, 404 - 25));
    let page = include_str!("../../MODEL.md");
    assert!(page.contains("| 257 | the pixel is written"), "the table of MODEL.md");
}
