//! The machine without time: what it counts whenever things happen, and its caches as tags alone.
//!
//! Tiles go through one after the other. What does not depend on time is exact: rays, visits, tests, stack operations, items of
//! kernels, lines of transfers. What the caches find is nearly so, for the order of their accesses is made up:
//!
//! - the cores take turns, each as many rays of a tile as its T&I unit holds, and a core takes turns between its tiles; the core
//!   that has done least comes first;
//! - of a round first the rays that the SRP starts are traced, then those that their hits send, then those that these send. Rays
//!   are dealt to the traversal units in turn, and a unit takes one memory operation of each of its rays in turn;
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
pub use features::{FEATURES, Features};
pub use in_flight::RestOfTile;
use warm::WarmState;

use std::sync::Arc;

use crate::config::MachineConfig;
use crate::srp::FrameShape;
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
    /// Rays that a core takes at a time.
    turn: usize,
    stats: Stats,
    /// Of the tiles that were given, in order; complete for those that are done.
    features: Vec<Features>,
}

/// A core and its tiles.
#[derive(Clone, Debug)]
struct Core {
    slots: Vec<Option<InFlight>>,
    /// The slot that is next in turn.
    next: usize,
    /// How much it has done.
    time: f64,
}

/// A machine in the middle of a frame: what its caches hold, and what is left of the tiles that it works on.
#[derive(Clone, Debug)]
pub struct Checkpoint {
    pub(crate) warm: WarmState,
    /// What is left of the tiles, by core.
    pub tiles: Vec<RestOfTile>,
}

impl<'a> FunctionalMachine<'a> {
    /// A machine with cold caches for a frame of `shape`.
    pub fn new(config: &MachineConfig, tree: &'a Topology, shape: FrameShape) -> Self {
        let slots = config.gpu.tiles_in_flight.clamp(1, 255) as usize;
        let core = Core { slots: vec![None; slots], next: 0, time: 0.0 };
        Self {
            tree,
            rays: RayTracer::new(config),
            shader: Shader::new(config, shape),
            warm: WarmState::cold(config),
            memory: TagMemory::new(config),
            cores: vec![core; config.gpu.cores as usize],
            given: 0,
            turn: (config.ti.trv * config.ti.rays_per_trv) as usize,
            stats: Stats::shaped(config),
            features: Vec::new(),
        }
    }

    /// Works until a slot is free, and says which core has it: the first one, as in the simulated machine.
    pub fn make_room(&mut self) -> usize {
        loop {
            if let Some(core) = self.cores.iter().position(|core| core.slots.iter().any(Option::is_none)) {
                return core;
            }
            self.take_turn();
        }
    }

    /// Takes the next tile, once a slot is free.
    pub fn feed(&mut self, work: Arc<TileWork>) {
        let at = self.make_room();
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
        while self.cores.iter().any(|core| core.slots.iter().any(Option::is_some)) {
            self.take_turn();
        }
    }

    /// The machine as it is, for a simulation to go on from.
    pub fn checkpoint(&self) -> Checkpoint {
        let tiles = self
            .cores
            .iter()
            .enumerate()
            .flat_map(|(number, core)| core.slots.iter().flatten().map(move |tile| tile.rest(number)));
        Checkpoint { warm: self.warm.clone(), tiles: tiles.collect() }
    }

    /// What is characteristic of each tile, in the order in which they were given.
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

    /// Lets the core that has done least work on its next tile.
    fn take_turn(&mut self) {
        let now = self.now();
        let busy = |core: &Core| core.slots.iter().any(Option::is_some) && core.time <= now;
        let Some(number) = self.cores.iter().position(busy) else { return };
        let core = &mut self.cores[number];
        let slots = core.slots.len();
        let mine = (0..slots).map(|i| (core.next + i) % slots).find(|&slot| core.slots[slot].is_some());
        let Some(slot) = mine else { return };
        core.next = (slot + 1) % slots;
        let Some(mut tile) = core.slots[slot].take() else { return };
        let before = tile.features.cost();
        let done = self.work_on(number, &mut tile);
        // A turn takes some time even where nothing is traced.
        self.cores[number].time += (tile.features.cost() - before).max(1.0);
        if done {
            self.features[tile.number] = tile.features;
            self.stats.tiles += 1;
        } else {
            self.cores[number].slots[slot] = Some(tile);
        }
    }

    /// The next rays of a tile; whether it is done.
    fn work_on(&mut self, core: usize, tile: &mut InFlight) -> bool {
        let Self { tree, rays, shader, warm, memory, stats, turn, .. } = self;
        let (tags, counted) = (&mut warm.cores[core], &mut stats.cores[core]);
        let InFlight { work, round, wave, sent, next, started, written_bytes, features, .. } = tile;
        let lines = memory.lines();
        if *sent == wave.len() {
            std::mem::swap(wave, next);
            next.clear();
            (*sent, *started) = (0, false);
        }
        if wave.is_empty() {
            // The wave before was the last one of its round.
            if let Some(done) = round.checked_sub(1).and_then(|done| work.rounds.get(done)) {
                *written_bytes += shader.end_round(done, *written_bytes, counted, memory);
            }
            let Some(begun) = work.rounds.get(*round) else {
                shader.end_tile(work, counted, memory, features);
                warm.drop_evicted(memory.evicted());
                features.add_lines(memory.lines() - lines);
                return true;
            };
            shader.begin_round(begun, counted, memory, features);
            wave.extend_from_slice(&begun.starts);
            (*round, *started) = (*round + 1, true);
        }
        let end = wave.len().min(*sent + *turn);
        let mine = &mut wave[*sent..end];
        let traced = shader.send(work, mine, *started, counted, memory);
        rays.trace((tree, work, &mine[traced..]), tags, (counted, &mut warm.l2, memory), features);
        shader.shade((work, mine, next), tags, (counted, &mut warm.l2, memory), features);
        *sent = end;
        warm.drop_evicted(memory.evicted());
        features.add_lines(memory.lines() - lines);
        false
    }
}
