//! The T&I unit without time: the operations of rays, and what its L1s find.

use super::features::Features;
use super::memory::TagMemory;
use super::warm::CoreTags;
use crate::config::{MachineConfig, Pipeline};
use crate::memory::{CacheCounters, Tags};
use crate::stats::CoreStats;
use crate::ti::{IstCounters, TrvCounters};
use crate::work::layout::{Layout, Lines, Region};
use crate::work::ops::{Op, OpKind};
use crate::work::topology::Topology;
use crate::work::{RayWork, TileWork};

/// A ray on its way, as far as its operations and its stack go.
#[derive(Clone, Copy, Debug)]
struct Cursor {
    /// Next operation and end, in the operations of the tile.
    at: u32,
    end: u32,
    /// Deferred children, and how many of them the short stack holds.
    deferred: u8,
    held: u8,
}

/// Takes the rays of a wave through the tree.
pub(super) struct RayTracer {
    layout: Layout,
    unified: bool,
    /// Entries of the short stack.
    short: u8,
    /// Lookups of a node visit: one a pass.
    passes: u64,
    rays_per_trv: usize,
    next_ist: usize,
    active: Vec<Cursor>,
}

/// What a traversal unit works with.
struct Unit<'a> {
    tree: &'a Topology,
    work: &'a TileWork,
    trv: &'a mut Tags,
    ist: &'a mut [Tags],
    l2: &'a mut Tags,
    memory: &'a mut TagMemory,
    events: TrvCounters,
    /// Lines of nodes that were looked up, and lines of triangles in a unified pipeline.
    node_lines: u64,
    triangle_lines: u64,
    /// What missed of these; hits are the rest.
    l1: CacheCounters,
    ist_events: &'a mut [IstEvents],
}

/// What the rays of a wave do in an intersection unit.
#[derive(Clone, Copy, Default)]
struct IstEvents {
    events: IstCounters,
    /// Lines of triangles that were looked up.
    lines: u64,
    /// What missed of these; hits are the rest.
    l1: CacheCounters,
}

impl RayTracer {
    pub fn new(config: &MachineConfig) -> Self {
        let ti = &config.ti;
        Self {
            layout: Layout::new(config),
            unified: ti.pipeline == Pipeline::Unified,
            short: if ti.stack_entries == 0 { u8::MAX } else { ti.stack_entries.min(255) as u8 },
            passes: (2 / ti.aabbs_per_cycle).into(),
            rays_per_trv: ti.rays_per_trv as usize,
            next_ist: 0,
            active: Vec::new(),
        }
    }

    /// Traces the rays of a wave.
    pub fn trace(
        &mut self,
        (tree, work, wave): (&Topology, &TileWork, &[u32]),
        tags: &mut CoreTags,
        (counted, l2, memory): (&mut CoreStats, &mut Tags, &mut TagMemory),
        features: &mut Features,
    ) {
        counted.ti.dispatch.rays += wave.len() as u64;
        fetch_ahead(work, wave);
        let units = tags.trv.len();
        let mut ist_events = vec![IstEvents::default(); tags.ist.len()];
        let (mut visits, mut tests, mut misses) = (0, 0, 0);
        for (index, trv) in tags.trv.iter_mut().enumerate() {
            let mut unit = Unit {
                tree,
                work,
                trv,
                ist: &mut tags.ist,
                l2,
                memory,
                events: TrvCounters::default(),
                node_lines: 0,
                triangle_lines: 0,
                l1: CacheCounters::default(),
                ist_events: &mut ist_events,
            };
            self.run(
                &mut unit,
                wave.iter().skip(index).step_by(units).map(|&ray| Cursor::new(&work.rays[ray as usize])),
            );
            let Unit { mut events, node_lines, triangle_lines, mut l1, .. } = unit;
            events.box_tests = 2 * events.node_visits;
            // The second pass of a visit finds what the first has brought.
            l1.looked_up(self.passes * node_lines + triangle_lines);
            visits += events.node_visits;
            tests += events.triangle_tests;
            misses += l1.misses;
            let counted = &mut counted.ti.trv[index];
            counted.buffer.record_writes += events.node_visits * self.passes + events.triangle_tests;
            counted.buffer.record_reads += events.node_visits * self.passes + events.triangle_tests;
            counted.events += events;
            counted.l1 += l1;
        }
        let mut ist_misses = 0;
        for (counted, IstEvents { events, lines, mut l1 }) in counted.ti.ist.iter_mut().zip(ist_events) {
            l1.looked_up(lines);
            tests += events.triangle_tests;
            ist_misses += l1.misses;
            counted.buffer.record_writes += events.triangle_tests;
            counted.buffer.record_reads += events.triangle_tests;
            counted.events += events;
            counted.l1 += l1;
        }
        features.add_traversal(visits, tests, wave.len() as u64);
        features.add_misses(misses, ist_misses);
    }

    /// The rays of a unit: as many as it holds at a time, one memory operation of each in turn.
    fn run(&mut self, unit: &mut Unit<'_>, mut rays: impl Iterator<Item = Cursor>) {
        let mut active = std::mem::take(&mut self.active);
        active.extend(rays.by_ref().take(self.rays_per_trv));
        while !active.is_empty() {
            let mut i = 0;
            while i < active.len() {
                if self.step(&mut active[i], unit) {
                    i += 1;
                    continue;
                }
                unit.events.rays += 1;
                match rays.next() {
                    Some(ray) => active[i] = ray,
                    None => _ = active.swap_remove(i),
                }
            }
        }
        self.active = active;
    }

    /// Goes on to the next operation that reads memory; false at the end.
    #[inline]
    fn step(&mut self, ray: &mut Cursor, unit: &mut Unit<'_>) -> bool {
        while ray.at < ray.end {
            let op = unit.work.ops[ray.at as usize];
            ray.at += 1;
            match op.kind() {
                OpKind::Visit { node, defers } => {
                    self.visit(node, unit);
                    if defers {
                        unit.events.pushes += 1;
                        ray.deferred += 1;
                        ray.held = (ray.held + 1).min(self.short);
                    }
                    return true;
                }
                OpKind::Leaf { triangle, tests } => {
                    unit.events.leaves += 1;
                    if tests > 0 {
                        self.leaf(triangle, tests, unit);
                        return true;
                    }
                }
                OpKind::Pop { node } | OpKind::Cull { node } => {
                    unit.events.stack_operations += 1;
                    unit.events.culled += u64::from(matches!(op.kind(), OpKind::Cull { .. }));
                    if ray.held > 0 {
                        ray.held -= 1;
                        ray.deferred -= 1;
                    } else {
                        self.restart(node, ray, unit);
                    }
                }
                OpKind::End => unit.events.stack_operations += 1,
            }
        }
        false
    }

    #[inline]
    fn visit(&self, node: u32, unit: &mut Unit<'_>) {
        unit.events.node_visits += 1;
        let Lines { first, last } = self.layout.node(node);
        unit.node_lines += last - first + 1;
        for line in first..=last {
            unit.memory.look_up((unit.trv, unit.l2), line, Region::Node, &mut unit.l1);
        }
    }

    #[inline]
    fn leaf(&mut self, triangle: u32, tests: u8, unit: &mut Unit<'_>) {
        let tests = u32::from(tests);
        let (tags, lines, l1) = if self.unified {
            unit.events.triangle_tests += u64::from(tests);
            (&mut *unit.trv, &mut unit.triangle_lines, &mut unit.l1)
        } else {
            self.next_ist = if self.next_ist + 1 < unit.ist.len() { self.next_ist + 1 } else { 0 };
            let IstEvents { events, lines, l1 } = &mut unit.ist_events[self.next_ist];
            events.tasks += 1;
            events.triangle_tests += u64::from(tests);
            (&mut unit.ist[self.next_ist], lines, l1)
        };
        for triangle in triangle..triangle + tests {
            let Lines { first, last } = self.layout.triangle(triangle);
            *lines += last - first + 1;
            for line in first..=last {
                unit.memory.look_up((tags, unit.l2), line, Region::Triangle, l1);
            }
        }
    }

    /// The short stack has lost the child that `node` deferred: the way down to it is walked again.
    #[cold]
    fn restart(&self, mut node: u32, ray: &mut Cursor, unit: &mut Unit<'_>) {
        unit.events.restarts += 1;
        let mut trail = vec![node];
        while node != 0 {
            node = unit.tree.parents[node as usize];
            trail.push(node);
        }
        unit.events.restart_visits += trail.len() as u64;
        trail.iter().rev().for_each(|&node| self.visit(node, unit));
        ray.deferred -= 1;
        ray.held = ray.deferred.min(self.short);
        unit.events.pushes += u64::from(ray.deferred);
    }
}

/// Reads one word of each cache line of the operations that come next. Another thread wrote them, and one line after the other
/// they come at the rate of the memory; in turns of rays each would be waited for.
fn fetch_ahead(work: &TileWork, wave: &[u32]) {
    const LINE: usize = 64 / size_of::<Op>();
    let operations = wave.iter().flat_map(|&ray| work.path(ray).iter().step_by(LINE));
    std::hint::black_box(operations.fold(0, |sum, op| sum ^ op.bits()));
}

impl Cursor {
    fn new(ray: &RayWork) -> Self {
        Self { at: ray.ops_start, end: ray.ops_start + ray.ops_len, deferred: 0, held: 0 }
    }
}
