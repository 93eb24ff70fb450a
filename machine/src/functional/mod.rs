//! The machine without time: what it counts whenever things happen, and its caches as tags alone.
//!
//! Tiles go through one after the other. What does not depend on time is exact: rays, visits, tests, stack operations, items of
//! kernels, lines of transfers. What the caches find is nearly so, for the order of their accesses is made up:
//!
//! - the cores take turns, a batch of an SRP each; the core that has done least comes first. As in the SRP the longest queue is
//!   next, of the tile that came first; the rays that a batch sends are traced at once, and what they bring is queued;
//! - rays are dealt to the traversal units in turn, and a unit takes one memory operation of each of its rays in turn;
//! - leaf tasks are dealt to the intersection units in turn, and a line that misses is there for the next access;
//! - DRAM serves lines in the order in which they are asked for.
//!
//! So a simulation of every cycle counts the same work, and somewhat other misses. With a [`Checkpoint`] a
//! [`System`](crate::system::System) may start in the middle of a frame.

mod exact;
mod features;
mod in_flight;
mod memory;
mod rays;
mod shader;
#[cfg(test)]
mod tests;
mod warm;

pub use exact::exact_counters;
pub(crate) use features::cost;
pub use features::{FEATURES, Features};
pub use in_flight::RestOfTile;
use warm::WarmState;

use std::cmp::Reverse;
use std::sync::Arc;

use crate::config::MachineConfig;
use crate::srp::{FrameShape, KernelId, QueueId, READERS};
use crate::stats::Stats;
use crate::work::TileWork;
use crate::work::topology::Topology;
use in_flight::InFlight;
use memory::TagMemory;
use rays::RayTracer;
use shader::Shader;

/// A machine that counts.
pub struct FunctionalMachine<'a> {
    tree: &'a Topology,
    rays: RayTracer,
    shader: Shader,
    warm: WarmState,
    memory: TagMemory,
    cores: Vec<Core>,
    /// Tiles that were given.
    given: usize,
    /// The SRP takes no time.
    is_ideal: bool,
    /// Most items of a batch.
    batch_max: usize,
    batch: Vec<u32>,
    sent: Vec<u32>,
    stats: Stats,
    done: Features,
    /// Tiles that are done, parts of tiles included.
    progress: f64,
    /// Of the tiles that were given, in order; complete for those that are done.
    features: Vec<Features>,
}

/// A core and its tiles.
#[derive(Clone, Debug)]
struct Core {
    slots: Vec<Option<InFlight>>,
    /// How much it has done.
    time: f64,
}

/// Which queue comes first: the largest rank.
type Rank = (bool, usize, Reverse<usize>);

/// A machine in the middle of a frame: what its caches hold, and what is left of the tiles that it works on.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    pub(crate) warm: WarmState,
    /// What is left of the tiles, each with its core, by core.
    pub tiles: Vec<(usize, RestOfTile)>,
}

impl<'a> FunctionalMachine<'a> {
    /// A machine with cold caches for a frame of `shape`.
    pub fn new(config: &MachineConfig, tree: &'a Topology, shape: FrameShape) -> Self {
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        let core = Core { slots: vec![None; slots], time: 0.0 };
        Self {
            tree,
            rays: RayTracer::new(config),
            shader: Shader::new(config, shape),
            warm: WarmState::cold(config),
            memory: TagMemory::new(config),
            cores: vec![core; config.gpu.cores as usize],
            given: 0,
            is_ideal: config.srp.ideal,
            batch_max: config.srp.batch_max.max(1) as usize,
            batch: Vec::new(),
            sent: Vec::new(),
            stats: Stats::shaped(config),
            done: Features::default(),
            progress: 0.0,
            features: Vec::new(),
        }
    }

    /// The first core with a free slot.
    fn free_core(&self) -> Option<usize> {
        self.cores.iter().position(|core| core.slots.iter().any(Option::is_none))
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
        core.slots[slot] = Some(InFlight::new(work, self.given));
        self.given += 1;
        self.features.push(Features::default());
    }

    /// Works until all tiles are done.
    pub fn finish(&mut self) {
        while self.take_turn() {}
    }

    /// The machine as it is, for a simulation to go on from.
    pub fn checkpoint(&self) -> Checkpoint {
        let tiles = self.cores.iter().enumerate().flat_map(|(number, core)| {
            let mut tiles: Vec<&InFlight> = core.slots.iter().flatten().collect();
            tiles.sort_by_key(|tile| tile.number);
            tiles.into_iter().map(move |tile| (number, tile.rest.clone()))
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

    /// What is characteristic of each tile, in the order in which they were given; nothing yet of those that are not done.
    pub fn features(&self) -> &[Features] {
        &self.features
    }

    /// What was counted so far; whatever needs time is 0.
    pub fn stats(&self) -> Stats {
        Stats { memory: self.memory.stats(), ..self.stats.clone() }
    }

    /// How far the core is that has done least.
    fn now(&self) -> f64 {
        let busy = self.cores.iter().filter(|core| core.slots.iter().any(Option::is_some));
        let now = busy.map(|core| core.time).fold(f64::INFINITY, f64::min);
        if now.is_finite() { now } else { 0.0 }
    }

    /// Lets the core that has done least run its next batch, or a tile take its next step. False where nothing is left.
    pub fn take_turn(&mut self) -> bool {
        let now = self.now();
        let busy = |core: &Core| core.slots.iter().any(Option::is_some) && core.time <= now;
        let Some(number) = self.cores.iter().position(busy) else { return false };
        let core = &mut self.cores[number];
        let Some((slot, queue)) = core.choose(self.is_ideal) else { return false };
        let Some(mut tile) = core.slots[slot].take() else { return false };
        let before = tile.features;
        let lines = self.memory.lines();
        let done = match queue {
            Some(queue) => {
                self.run_batch(number, &mut tile, queue);
                self.progress += tile.traced(&self.sent);
                false
            }
            None => self.step(number, &mut tile),
        };
        self.warm.drop_evicted(self.memory.evicted());
        tile.features.add_lines(self.memory.lines() - lines);
        self.done.add_part(&tile.features, 1.0);
        self.done.add_part(&before, -1.0);
        // A turn takes some time even where nothing is traced.
        self.cores[number].time += (tile.features.cost() - before.cost()).max(1.0);
        if done {
            self.progress += tile.rest_of_size();
            self.features[tile.number] = tile.features;
            self.stats.tiles += 1;
        } else {
            self.cores[number].slots[slot] = Some(tile);
        }
        true
    }

    /// The next step of a tile of which nothing waits: ends a round, and begins the next. Whether the tile is done.
    fn step(&mut self, core: usize, tile: &mut InFlight) -> bool {
        let Self { shader, memory, stats, .. } = self;
        let (InFlight { rest, features, .. }, counted) = (tile, &mut stats.cores[core]);
        let RestOfTile { work, begun, queues, written_bytes } = rest;
        if let Some(round) = begun.checked_sub(1).and_then(|done| work.rounds.get(done)) {
            *written_bytes += shader.end_round(round, *written_bytes, counted, memory);
        }
        let Some(round) = work.rounds.get(*begun) else {
            shader.end_tile(work, counted, memory, features);
            return true;
        };
        *begun += 1;
        shader.begin_round(work, round, queues, (counted, memory), features);
        false
    }

    /// Runs a batch of a tile: items of hits and misses are done, and what they send is traced.
    fn run_batch(&mut self, core: usize, tile: &mut InFlight, queue: QueueId) {
        let Self { tree, rays, shader, warm, memory, stats, batch_max, batch, sent, .. } = self;
        let (tags, counted) = (&mut warm.cores[core], &mut stats.cores[core]);
        let (InFlight { rest, features, .. }, kernel) = (tile, queue.kernel);
        let RestOfTile { work, queues, .. } = rest;
        let most = if kernel == KernelId::Shade { (*batch_max).min(READERS) } else { *batch_max };
        batch.clear();
        sent.clear();
        queues.take(queue, most, batch);
        if kernel == KernelId::Raygen {
            shader.generate(batch.len(), counted, features);
            std::mem::swap(batch, sent);
        } else {
            shader.run((work, kernel, batch, sent), tags, (counted, &mut warm.l2, memory), features);
        }
        shader.send(sent.len(), counted, memory);
        rays.trace((tree, work, sent), tags, (counted, &mut warm.l2, memory), features);
        sent.iter().for_each(|&ray| shader.queue(work, ray, queues));
    }
}

impl Core {
    /// The slot that is next, and which of its queues; none where nothing of the tile waits. Nothing if there is no tile.
    /// An ideal SRP takes hits first, and starts rays as far as there is room for them beside those.
    fn choose(&self, is_ideal: bool) -> Option<(usize, Option<QueueId>)> {
        let mut best: Option<(Rank, usize, QueueId)> = None;
        for (slot, tile) in self.slots.iter().enumerate() {
            let Some(tile) = tile else { continue };
            if tile.rest.queues.items() == 0 {
                return Some((slot, None));
            }
            tile.rest.queues.each(|queue, items| {
                // Without time nothing is gained by long queues.
                let items = if is_ideal { usize::MAX - slot } else { items };
                let rank = (is_ideal && queue.kernel != KernelId::Raygen, items, Reverse(tile.number));
                if best.as_ref().is_none_or(|(other, ..)| rank > *other) {
                    best = Some((rank, slot, queue));
                }
            });
        }
        best.map(|(_, slot, queue)| (slot, Some(queue)))
    }
}
