//! The T&I unit without cycles: the operations of rays, and what its L1s find.

use std::collections::VecDeque;

use super::caches::CoreTags;
use super::features::Features;
use super::in_flight::InFlight;
use super::memory::TagMemory;
use super::pace::Turned;
use crate::config::{MachineConfig, Pipeline};
use crate::link::RayRef;
use crate::memory::{CacheCounters, Tags};
use crate::stats::CoreStats;
use crate::ti::{IstCounters, TrvCounters};
use crate::work::layout::{Layout, Region};
use crate::work::ops::{Op, OpKind};
use crate::work::topology::Topology;
use crate::work::{RayWork, TileWork};

/// A ray in a traversal unit, as far as its operations and its stack go.
#[derive(Clone, Copy, Debug)]
struct Flying {
    ray: RayRef,
    /// Next operation and end, in the operations of the tile.
    at: u32,
    end: u32,
    /// The next operation, read ahead: it is far away by the time that it is the ray's turn.
    next: Op,
    /// Deferred children, and how many of them the short stack holds.
    deferred: u8,
    held: u8,
}

/// The rays of a core's T&I unit.
#[derive(Clone, Debug)]
pub(super) struct RaysInside {
    /// By traversal unit.
    units: Vec<Vec<Flying>>,
    /// Not in a traversal unit yet.
    waiting: VecDeque<RayRef>,
    inside: usize,
    next_ist: usize,
}

/// Takes rays through the tree.
pub(super) struct RayTracer {
    layout: Layout,
    unified: bool,
    /// Rays keep their registers: there are no records.
    software: bool,
    /// Entries of the short stack.
    short: u8,
    /// Lookups of a node visit: one a pass.
    passes: u64,
    rays_per_trv: usize,
}

/// What a traversal unit works with.
struct Unit<'a> {
    tree: &'a Topology,
    trv: &'a mut Tags,
    ist: &'a mut [Tags],
    next_ist: &'a mut usize,
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

/// What rays do in an intersection unit.
#[derive(Clone, Copy, Default)]
struct IstEvents {
    events: IstCounters,
    /// Lines of triangles that were looked up.
    lines: u64,
    /// What missed of these; hits are the rest.
    l1: CacheCounters,
}

impl RaysInside {
    /// An empty unit of so many traversal units.
    pub fn new(units: usize) -> Self {
        Self { units: vec![Vec::new(); units], waiting: VecDeque::new(), inside: 0, next_ist: 0 }
    }

    /// Rays that came and have not finished.
    pub fn rays(&self) -> usize {
        self.inside
    }

    /// The rays that came and have not finished, of tile slot `slot`.
    pub fn of_slot(&self, slot: usize) -> impl Iterator<Item = u32> {
        let rays = self.units.iter().flatten().map(|flying| flying.ray).chain(self.waiting.iter().copied());
        rays.filter(move |ray| usize::from(ray.slot) == slot).map(|ray| ray.ray)
    }

    /// Takes rays of the tile in slot `slot`.
    pub fn enter(&mut self, work: &TileWork, slot: usize, rays: &[u32]) {
        fetch_ahead(work, rays);
        self.waiting.extend(rays.iter().map(|&ray| RayRef { slot: slot as u8, ray }));
        self.inside += rays.len();
    }

    /// The unit that has fewest rays gets the next, as long as one has room.
    fn deal(&mut self, slots: &[Option<InFlight>], room: usize) {
        while !self.waiting.is_empty() {
            let Some(unit) = self.units.iter_mut().min_by_key(|unit| unit.len()).filter(|unit| unit.len() < room)
            else {
                return;
            };
            let ray = self.waiting.pop_front();
            unit.extend(ray.and_then(|ray| Flying::new(ray, slots)));
        }
    }
}

impl RayTracer {
    pub fn new(config: &MachineConfig) -> Self {
        let ti = &config.ti;
        Self {
            layout: Layout::new(config),
            unified: matches!(ti.pipeline, Pipeline::Unified | Pipeline::Software | Pipeline::Gathering),
            software: ti.pipeline == Pipeline::Software,
            short: if ti.stack_entries == 0 { u8::MAX } else { ti.stack_entries.min(255) as u8 },
            // Units that gather rays, and programs, test both boxes of a node together.
            passes: match ti.pipeline {
                Pipeline::Software | Pipeline::Gathering => 1,
                _ => (2 / ti.aabbs_per_cycle).into(),
            },
            rays_per_trv: ti.rays_per_trv as usize,
        }
    }

    /// One memory operation of each ray of a unit. Rays that finish go to `finished`. Gives what was done.
    pub fn trace(
        &self,
        (tree, slots, inside): (&Topology, &[Option<InFlight>], &mut RaysInside),
        tags: &mut CoreTags,
        (counted, l2, memory): (&mut CoreStats, &mut Tags, &mut TagMemory),
        (features, finished): (&mut Features, &mut Vec<RayRef>),
    ) -> Turned {
        let ops: Vec<&[Op]> =
            slots.iter().map(|tile| tile.as_ref().map_or(&[][..], |tile| &tile.rest.work.ops)).collect();
        let mut ist_events = vec![IstEvents::default(); tags.ist.len()];
        let (mut visits, mut tests, mut misses) = (0, 0, 0);
        let (before, lines) = (finished.len(), memory.lines());
        inside.deal(slots, self.rays_per_trv);
        let mut turned = Turned { rays: inside.units.iter().map(|unit| unit.len() as u64).sum(), ..Turned::default() };
        let RaysInside { units, next_ist, .. } = inside;
        for ((index, trv), flying) in tags.trv.iter_mut().enumerate().zip(units) {
            let mut unit = Unit {
                tree,
                trv,
                ist: &mut tags.ist,
                next_ist,
                l2,
                memory,
                events: TrvCounters::default(),
                node_lines: 0,
                triangle_lines: 0,
                l1: CacheCounters::default(),
                ist_events: &mut ist_events,
            };
            // Each ray is read and written once. `Vec::retain_mut` reads it again to move it up, before the processor has what was written.
            let mut kept = 0;
            for at in 0..flying.len() {
                let ray = flying[at];
                if let Some(ray) = self.step(ray, ops[usize::from(ray.ray.slot)], &mut unit) {
                    flying[kept] = ray;
                    kept += 1;
                } else {
                    finished.push(ray.ray);
                }
            }
            flying.truncate(kept);
            let Unit { mut events, node_lines, triangle_lines, mut l1, .. } = unit;
            events.box_tests = 2 * events.node_visits;
            // The second pass of a visit finds what the first has brought.
            l1.looked_up(self.passes * node_lines + triangle_lines);
            visits += events.node_visits;
            tests += events.triangle_tests;
            misses += l1.misses;
            turned.issued = turned.issued.max(events.node_visits * self.passes + events.triangle_tests);
            turned.leaves += events.leaves;
            turned.stack_operations += events.stack_operations;
            let counted = &mut counted.ti.trv[index];
            if !self.software {
                counted.buffer.record_writes += events.node_visits * self.passes + events.triangle_tests;
                counted.buffer.record_reads += events.node_visits * self.passes + events.triangle_tests;
            }
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
        let rays = (finished.len() - before) as u64;
        inside.inside -= rays as usize;
        counted.ti.dispatch.rays += rays;
        features.add_traversal(visits, tests, rays);
        features.add_misses(misses, ist_misses);
        (turned.visits, turned.tests, turned.misses) =
            (visits, if self.unified { 0 } else { tests }, misses + ist_misses);
        Turned { lines: memory.lines() - lines, ..turned }
    }

    /// Goes on to the next operation that reads memory; nothing at the end.
    #[inline(always)]
    fn step(&self, ray: Flying, ops: &[Op], unit: &mut Unit<'_>) -> Option<Flying> {
        let Flying { ray, mut at, end, mut next, mut deferred, mut held } = ray;
        while at < end {
            let op = next;
            at += 1;
            // Behind the last operation of a ray stands that of another one, or none.
            next = ops.get(at as usize).copied().unwrap_or(Op::END);
            match op.kind() {
                OpKind::Visit { node, defers } => {
                    self.visit(node, unit);
                    let pushed = u8::from(defers);
                    unit.events.pushes += u64::from(pushed);
                    (deferred, held) = (deferred + pushed, (held + pushed).min(self.short));
                    return Some(Flying { ray, at, end, next, deferred, held });
                }
                OpKind::Leaf { triangle, tests } => {
                    unit.events.leaves += 1;
                    if tests > 0 {
                        self.leaf(triangle, tests, unit);
                        return Some(Flying { ray, at, end, next, deferred, held });
                    }
                }
                OpKind::Pop { node } | OpKind::Cull { node } => {
                    unit.events.stack_operations += 1;
                    unit.events.culled += u64::from(matches!(op.kind(), OpKind::Cull { .. }));
                    if held > 0 {
                        (deferred, held) = (deferred - 1, held - 1);
                    } else {
                        (deferred, held) = self.restart(node, deferred, unit);
                    }
                }
                OpKind::End => unit.events.stack_operations += 1,
            }
        }
        unit.events.rays += 1;
        None
    }

    #[inline(always)]
    fn visit(&self, node: u32, unit: &mut Unit<'_>) {
        unit.events.node_visits += 1;
        let lines = self.layout.node(node);
        unit.node_lines += lines.count();
        lines.each(|line| unit.memory.look_up((unit.trv, unit.l2), line, Region::Node, &mut unit.l1));
    }

    #[inline(always)]
    fn leaf(&self, triangle: u32, tests: u8, unit: &mut Unit<'_>) {
        let tests = u32::from(tests);
        let (tags, lines, l1) = if self.unified {
            unit.events.triangle_tests += u64::from(tests);
            (&mut *unit.trv, &mut unit.triangle_lines, &mut unit.l1)
        } else {
            let next = if *unit.next_ist + 1 < unit.ist.len() { *unit.next_ist + 1 } else { 0 };
            *unit.next_ist = next;
            let IstEvents { events, lines, l1 } = &mut unit.ist_events[next];
            events.tasks += 1;
            events.triangle_tests += u64::from(tests);
            (&mut unit.ist[next], lines, l1)
        };
        let mut of_leaf = self.layout.triangle(triangle);
        *lines += of_leaf.count();
        for next in triangle + 1..triangle + tests {
            let next = self.layout.triangle(next);
            *lines += next.count();
            of_leaf.last = next.last;
        }
        // Triangles that lie side by side share lines. Who finds again what was looked up just before changes nothing.
        of_leaf.each(|line| unit.memory.look_up((tags, unit.l2), line, Region::Triangle, l1));
    }

    /// The short stack has lost the child that `node` deferred: the way down to it is walked again. Gives how many children of the
    /// ray are deferred then, and how many of them the short stack holds.
    #[cold]
    fn restart(&self, mut node: u32, deferred: u8, unit: &mut Unit<'_>) -> (u8, u8) {
        unit.events.restarts += 1;
        let mut trail = vec![node];
        while node != 0 {
            node = unit.tree.parents[node as usize];
            trail.push(node);
        }
        unit.events.restart_visits += trail.len() as u64;
        trail.iter().rev().for_each(|&node| self.visit(node, unit));
        let left = deferred - 1;
        unit.events.pushes += u64::from(left);
        (left, left.min(self.short))
    }
}

/// Reads one word of each cache line of the operations that come next. Another thread wrote them, and one line after the other
/// they come at the rate of the memory; in turns of rays each would be waited for.
fn fetch_ahead(work: &TileWork, wave: &[u32]) {
    const LINE: usize = 64 / size_of::<Op>();
    let operations = wave.iter().flat_map(|&ray| work.path(ray).iter().step_by(LINE));
    std::hint::black_box(operations.fold(0, |sum, op| sum ^ op.bits()));
}

impl Flying {
    fn new(ray: RayRef, slots: &[Option<InFlight>]) -> Option<Self> {
        let work = &slots[usize::from(ray.slot)].as_ref()?.rest.work;
        let RayWork { ops_start: at, ops_len, .. } = work.rays[ray.ray as usize];
        let next = work.ops.get(at as usize).copied().unwrap_or(Op::END);
        Some(Self { ray, at, end: at + ops_len, next, deferred: 0, held: 0 })
    }
}
