//! The machine without cycles: what it counts whenever things happen, its caches as tags alone, and clocks that only keep the order.
//!
//! Tiles go through one after the other. What does not depend on time is exact: rays, visits, tests, stack operations, items of
//! kernels, lines of transfers. What the caches find is nearly so, for the order of their accesses is made up:
//!
//! - the cores take turns, the one first whose clock is furthest behind. A clock goes by what the unit and the SRP would take if
//!   nothing else held them up (`pace.rs`);
//! - when its SRP is free it runs a batch, by the rules of the SRP, as long as the rays find room in the output queue; else the unit
//!   works;
//! - a ray goes to the traversal unit that has fewest, and a unit takes one memory operation of each of its rays in turn;
//! - leaf tasks are dealt to the intersection units in turn, and a line that misses is there for the next access;
//! - DRAM serves lines in the order in which they are asked for.
//!
//! So a simulation of every cycle counts the same work, and somewhat other misses. With a [`Checkpoint`] a
//! [`System`](crate::system::System) may start in the middle of a frame.

mod batches;
mod caches;
mod exact;
mod features;
mod in_flight;
mod memory;
mod pace;
mod rays;
mod reads;
mod shader;
#[cfg(test)]
mod tests;

pub use caches::CacheState;
pub(crate) use caches::CoreTags;
pub use exact::{counted_counters, exact_counters};
pub use features::{FEATURES, Features};

use std::sync::Arc;

use crate::config::{MachineConfig, TileDispatch};
use crate::link::RayRef;
use crate::srp::{FrameShape, KernelId, QueueId, RestOfTile};
use crate::stats::Stats;
use crate::work::TileWork;
use crate::work::topology::Topology;
use batches::{Batches, Turn};
use in_flight::InFlight;
use memory::TagMemory;
use pace::Pace;
use rays::{RayTracer, RaysInside};
use shader::Shader;

/// A machine that counts.
pub struct FunctionalMachine<'a> {
    tree: &'a Topology,
    rays: RayTracer,
    shader: Shader,
    warm: CacheState,
    memory: TagMemory,
    cores: Vec<Core>,
    /// Tiles that were given.
    given: usize,
    dispatch: TileDispatch,
    batches: Batches,
    pace: Pace,
    batch: Vec<u32>,
    sent: Vec<u32>,
    finished: Vec<RayRef>,
    stats: Stats,
    done: Features,
    /// Tiles that are done, parts of tiles included.
    progress: f64,
    /// Of the tiles that were given, in order.
    sizes: Vec<f64>,
}

/// A core and its tiles.
#[derive(Clone, Debug)]
struct Core {
    slots: Vec<Option<InFlight>>,
    inside: RaysInside,
    /// How far its T&I unit is, T&I cycles.
    time: f64,
    /// How far its SRP is. A batch may have begun during the last turn of the unit, which took so long.
    srp: f64,
    last: f64,
}

/// A machine in the middle of a frame: what its caches hold, and what is left of the tiles that it works on.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    pub(crate) warm: CacheState,
    /// What is left of the tiles, each with its core, by core.
    pub tiles: Vec<(usize, RestOfTile)>,
}

impl<'a> FunctionalMachine<'a> {
    /// A machine with cold caches for a frame of `shape`.
    pub fn new(config: &MachineConfig, tree: &'a Topology, shape: FrameShape) -> Self {
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        let inside = RaysInside::new(config.ti.trv as usize);
        let core = Core { slots: vec![None; slots], inside, time: 0.0, srp: 0.0, last: 0.0 };
        Self {
            tree,
            rays: RayTracer::new(config),
            shader: Shader::new(config, shape),
            warm: CacheState::cold(config),
            memory: TagMemory::new(config),
            cores: vec![core; config.gpu.cores as usize],
            given: 0,
            dispatch: config.gpu.tile_dispatch,
            batches: Batches::new(config),
            pace: Pace::new(config),
            batch: Vec::new(),
            sent: Vec::new(),
            finished: Vec::new(),
            stats: Stats::shaped(config),
            done: Features::default(),
            progress: 0.0,
            sizes: Vec::new(),
        }
    }

    /// The same with what the caches hold already.
    #[must_use]
    pub fn with_caches(self, caches: CacheState) -> Self {
        Self { warm: caches, ..self }
    }

    /// What the caches hold.
    pub fn caches(&self) -> &CacheState {
        &self.warm
    }

    /// The core that takes the next tile, if one has a free slot.
    fn free_core(&self) -> Option<usize> {
        self.dispatch.choose(self.cores.iter().map(|core| core.slots.iter().filter(|slot| slot.is_none()).count()))
    }

    /// Whether a slot is free.
    pub fn has_room(&self) -> bool {
        self.free_core().is_some()
    }

    /// Takes the next tile, once a slot is free.
    pub fn feed(&mut self, work: Arc<TileWork>) {
        let at = loop {
            if let Some(core) = self.free_core() {
                break core;
            }
            self.take_turn();
        };
        let now = self.now();
        let core = &mut self.cores[at];
        if core.slots.iter().all(Option::is_none) {
            core.time = core.time.max(now);
        }
        let slot = core.slots.iter().position(Option::is_none).unwrap_or(0);
        let tile = InFlight::new(work, self.given);
        self.sizes.push(tile.size);
        core.slots[slot] = Some(tile);
        self.given += 1;
    }

    /// Works until all tiles are done.
    pub fn finish(&mut self) {
        while self.take_turn() {}
    }

    /// The machine as it is, for a simulation to go on from.
    pub fn checkpoint(&self) -> Checkpoint {
        let rest = |core: &Core, slot: usize, tile: &InFlight| RestOfTile {
            rays_out: core.inside.of_slot(slot).collect(),
            ..tile.rest.clone()
        };
        let tiles = self.cores.iter().enumerate().flat_map(|(number, core)| {
            let tiles = core.slots.iter().enumerate().filter_map(|(slot, tile)| Some((slot, tile.as_ref()?)));
            let mut tiles: Vec<_> = tiles.collect();
            tiles.sort_by_key(|(_, tile)| tile.number);
            tiles.into_iter().map(move |(slot, tile)| (number, rest(core, slot, tile)))
        });
        Checkpoint { warm: self.warm.clone(), tiles: tiles.collect() }
    }

    /// Tiles that are done, parts of tiles included: as many as were given in the end.
    pub fn progress(&self) -> f64 {
        self.progress
    }

    /// What is characteristic of all that is done.
    pub fn done(&self) -> &Features {
        &self.done
    }

    /// The sizes of the tiles that were given, in operations about.
    pub fn sizes(&self) -> &[f64] {
        &self.sizes
    }

    /// What was counted so far; whatever needs time is 0.
    pub fn stats(&self) -> Stats {
        Stats { memory: self.memory.stats(), ..self.stats.clone() }
    }

    /// How far the core is that is furthest behind.
    fn now(&self) -> f64 {
        let busy = self.cores.iter().filter(|core| core.slots.iter().any(Option::is_some));
        let now = busy.map(|core| core.time).fold(f64::INFINITY, f64::min);
        if now.is_finite() { now } else { 0.0 }
    }

    /// Lets the core that is furthest behind take its next turn. False where nothing is left.
    pub fn take_turn(&mut self) -> bool {
        let now = self.now();
        let busy = |core: &Core| core.slots.iter().any(Option::is_some) && core.time <= now;
        let Some(number) = self.cores.iter().position(busy) else { return false };
        let (before, lines) = (self.done.srp_cycles(), self.memory.lines());
        let core = &mut self.cores[number];
        let began = core.time;
        if core.inside.rays() == 0 {
            // The unit waits for the SRP.
            core.time = core.time.max(core.srp);
        }
        let mut prologue = 0.0;
        match self.batches.next(&core.slots, core.inside.rays(), core.srp <= core.time) {
            Turn::Step(slot) => self.step(number, slot),
            Turn::Batch(slot, queue, most) => {
                prologue = self.shader.prologue(queue.kernel);
                self.run_batch(number, slot, queue, most);
            }
            Turn::Trace => self.trace(number),
        }
        self.warm.drop_evicted(self.memory.evicted());
        self.done.add_lines(self.memory.lines() - lines);
        let (core, cycles) = (&mut self.cores[number], self.pace.of_srp(prologue + self.done.srp_cycles() - before));
        self.done.add_cycles(core.time - began);
        if cycles > 0.0 {
            core.srp = core.srp.max(core.time - core.last) + cycles;
        }
        true
    }

    /// The next step of a tile of which nothing waits: ends a round and begins the next, or ends the tile.
    fn step(&mut self, core: usize, slot: usize) {
        let Self { shader, memory, stats, done, progress, cores, .. } = self;
        let Some(tile) = &mut cores[core].slots[slot] else { return };
        let RestOfTile { work, begun, queues, written_bytes, .. } = &mut tile.rest;
        let counted = &mut stats.cores[core];
        if let Some(round) = begun.checked_sub(1).and_then(|done| work.rounds.get(done)) {
            *written_bytes += shader.end_round(round, *written_bytes, counted, memory);
        }
        if let Some(round) = work.rounds.get(*begun) {
            let number = *begun;
            *begun += 1;
            shader.begin_round(work, (number, round), queues, (counted, memory), done);
            return;
        }
        shader.end_tile(work, counted, memory, done);
        *progress += tile.rest_of_size();
        stats.tiles += 1;
        cores[core].slots[slot] = None;
    }

    /// Runs a batch of a tile: items of hits and misses are done, and what they send goes to the T&I unit.
    fn run_batch(&mut self, core: usize, slot: usize, queue: QueueId, most: usize) {
        let Self { shader, warm, memory, stats, batch, sent, cores, done, .. } = self;
        let (tags, counted) = (&mut warm.cores[core], &mut stats.cores[core]);
        let Core { slots, inside, .. } = &mut cores[core];
        let Some(tile) = &mut slots[slot] else { return };
        let RestOfTile { work, queues, .. } = &mut tile.rest;
        batch.clear();
        sent.clear();
        queues.take(queue, most, batch);
        if queue.kernel == KernelId::Raygen {
            shader.generate(batch.len(), counted, done);
            std::mem::swap(batch, sent);
        } else {
            shader.run((work, queue.kernel, batch, sent), tags, (counted, &mut warm.l2, memory), done);
        }
        shader.send(sent.len(), counted, memory);
        inside.enter(work, slot, sent);
        tile.rays_out += sent.len();
    }

    /// Lets the T&I unit work.
    fn trace(&mut self, core: usize) {
        let Self { tree, rays, shader, warm, memory, stats, finished, cores, done, progress, pace, .. } = self;
        let (tags, counted) = (&mut warm.cores[core], &mut stats.cores[core]);
        let Core { slots, inside, time, last, .. } = &mut cores[core];
        finished.clear();
        let turned = rays.trace((tree, slots, inside), tags, (counted, &mut warm.l2, memory), (done, finished));
        *last = pace.of_turn(&turned).max(1.0);
        *time += *last;
        for RayRef { slot, ray } in finished.iter() {
            let Some(tile) = &mut slots[usize::from(*slot)] else { continue };
            let RestOfTile { work, queues, .. } = &mut tile.rest;
            shader.queue(work, *ray, queues);
            *progress += tile.traced(*ray);
        }
    }
}
