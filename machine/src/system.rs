//! The whole machine and its clock: cores, memory, the queue of tiles, and the loop that jumps from event to event.
//!
//! A cycle goes: memory brings what has arrived; each core's SRP takes finished rays, runs kernels and sends rays; each core's
//! T&I unit runs. What one of them sends, another sees a cycle later, so the order within a cycle is no more than a tie-break:
//! memory requests of one cycle are served by core and unit. A core with a free tile slot takes the next tile of the frame;
//! of several `gpu.tile_dispatch` chooses one. Every frame begins with empty pipelines, and with cold caches unless they are warmed.

use std::iter::Peekable;
use std::sync::Arc;

use crate::component::{Component, Tick};
use crate::config::{MachineConfig, TileDispatch};
use crate::error::{MachineError, Result};
use crate::functional::{CacheState, Checkpoint, CoreTags};
use crate::link::RayUnit;
use crate::memory::{Memory, MemorySystem, Port, Response};
use crate::srp::{FrameShape, Srp, SrpContext, SrpPorts, SrpReport};
use crate::stats::{CoreStats, Stats};
use crate::ti::{TiContext, Tiles};
use crate::time::{TiCycle, When};
use crate::traversal::TracingUnit;
use crate::work::layout::Layout;
use crate::work::topology::Topology;
use crate::work::{TileWork, cost};

/// Steps without any finished ray, tile or memory response after which the machine is taken to stand still, if nothing is under way in
/// the memory either. Steps, not cycles: a batch of a slow SRP, or a line of a slow DRAM, may take any time, but takes it in few of them.
const DEADLOCK_STEPS: u64 = 4_000_000;
/// The same however busy the memory is: it may do something for ever and answer nobody.
const BUSY_STEPS: u64 = 64 * DEADLOCK_STEPS;

/// Events between two looks at how much is done.
const EVENTS_BETWEEN_LOOKS: u32 = 32;

/// Ports that a core's SRP takes: its L1 and its DMA.
pub(crate) const SRP_PORTS: u16 = 2;

/// One core.
pub struct Core {
    /// The programmable shader with its tiles.
    pub srp: Srp,
    /// The T&I unit, or what stands in its place.
    pub ti: TracingUnit,
    srp_wake: When,
    ti_wake: When,
}

/// The machine at work on one frame.
pub struct System<'a, M> {
    tree: &'a Topology,
    layout: Layout,
    cores: Vec<Core>,
    ports_per_core: u16,
    dispatch: TileDispatch,
    memory: M,
    now: TiCycle,
    arrived: Vec<Response>,
    /// Steps since a tile was given, a ray finished or a line arrived.
    idle_steps: u64,
    tiles: u64,
    /// Runs a cycle. Called through a pointer, for that is most of the simulator: with the memory of this crate it is compiled here,
    /// once, and not again in every crate that simulates.
    step: fn(&mut Self),
}

impl Core {
    fn tick_srp<M: Memory>(&mut self, now: TiCycle, memory: &mut M) {
        let (inside, room) = (self.ti.rays_inside(), self.ti.job_room());
        self.srp.tick(now, SrpContext { unit: &mut self.ti, memory });
        self.srp_wake = self.srp.next_event(now);
        if self.ti.rays_inside() != inside || self.ti.job_room() != room {
            self.ti_wake = self.ti_wake.min(self.ti.next_event(now));
        }
    }

    /// Returns whether a ray has finished.
    fn tick_ti<M: Memory>(&mut self, now: TiCycle, tree: &Topology, layout: &Layout, memory: &mut M) -> bool {
        let (room, results, jobs) = (self.ti.has_room(), self.ti.results().len(), self.ti.job_room());
        self.ti.tick(now, TiContext { tree, layout, tiles: &self.srp, memory });
        self.ti_wake = self.ti.next_event(now);
        let finished = self.ti.results().len() > results || self.ti.has_finished_jobs();
        if finished || self.ti.has_room() != room || self.ti.job_room() != jobs {
            self.srp_wake = When::at(now + 1);
        }
        finished
    }

    /// What was counted before cycle `end`.
    pub fn report(&self, end: TiCycle) -> CoreStats {
        let SrpReport { stats, l1, cycles } = self.srp.report(end);
        let processors = self.ti.processor_report(end);
        CoreStats { ti: self.ti.report(end), processors, srp: stats, srp_l1: l1, srp_cycles: cycles }
    }

    fn finish(&mut self, end: TiCycle) -> CoreStats {
        let SrpReport { stats, l1, cycles } = self.srp.finish(end);
        let processors = self.ti.processor_report(end);
        CoreStats { ti: self.ti.finish(end), processors, srp: stats, srp_l1: l1, srp_cycles: cycles }
    }
}

impl Tiles for Srp {
    #[inline]
    fn work(&self, slot: u8) -> &TileWork {
        self.work(slot)
    }
}

/// Looks at the machine from time to time; see `timeline`.
pub trait Probe {
    /// A frame begins; its time begins at cycle 0. Told once a frame, before anything of it is looked at.
    fn begin(&mut self, _frame: u32) {}
    /// So many tiles of the frame have passed; told where there is no machine to look at.
    fn passed(&mut self, _tiles: u64) {}
    /// The next cycle at which it wants to look.
    fn due(&self) -> When;
    /// It is cycle `now`, the first at or after the one asked for at which anything happened. `bytes` went to or came from
    /// DRAM so far.
    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64);
}

/// A probe that never looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    fn due(&self) -> When {
        When::NEVER
    }
    fn look(&mut self, _: TiCycle, _: &[Core], _: u64) {}
}

impl<'a> System<'a, MemorySystem> {
    /// An empty machine for a frame of `shape`.
    pub fn new(config: &MachineConfig, tree: &'a Topology, shape: FrameShape) -> Self {
        Self::assemble(config, tree, shape, MemorySystem::new(config), Self::step)
    }

    /// A machine that goes on from a checkpoint: with its caches, and with its tiles and what waits for their SRPs. Nothing is
    /// under way in the T&I units.
    pub fn resume(config: &MachineConfig, tree: &'a Topology, shape: FrameShape, from: &Checkpoint) -> Self {
        let mut system = Self::new(config, tree, shape);
        system.warm(&from.warm);
        for (core, rest) in &from.tiles {
            system.cores[*core].srp.resume(rest);
            system.tiles += 1;
        }
        system
    }

    /// Fills the caches, which are empty.
    pub fn warm(&mut self, caches: &CacheState) {
        for (core, tags) in self.cores.iter_mut().zip(&caches.cores) {
            core.ti.warm(&tags.trv, &tags.ist);
            core.srp.warm(&tags.srp);
        }
        self.memory.warm(&caches.l2);
    }

    /// What the caches hold, once all tiles are done.
    pub fn caches(&self) -> CacheState {
        let core = |core: &Core| {
            let [trv, ist] = core.ti.tags();
            CoreTags { trv, ist, srp: core.srp.l1().tags().clone() }
        };
        CacheState { cores: self.cores.iter().map(core).collect(), l2: self.memory.l2().tags().clone() }
    }

    /// What was counted before the cycle at hand. Operations that are certain to issue later are in it already.
    pub fn measure(&self) -> Stats {
        let cores = self.cores.iter().map(|core| core.report(self.now)).collect();
        Stats { cycles: self.now.0, tiles: self.tiles, cores, memory: self.memory.report(self.now) }
    }

    /// Takes tiles as it has room, and works until so much is done, or all. What it has no room for stays with `tiles`.
    ///
    /// # Errors
    /// [`MachineError::Deadlock`] if the machine stands still.
    pub fn work_until<I>(&mut self, done: f64, tiles: &mut Peekable<I>) -> Result<()>
    where
        I: Iterator<Item = Arc<TileWork>>,
    {
        loop {
            // Looking at all units takes as long as a short event.
            for _ in 0..EVENTS_BETWEEN_LOOKS {
                if let Some(core) = self.free_core()
                    && let Some(work) = tiles.next()
                {
                    self.give(core, work);
                    continue;
                }
                let more = tiles.peek().is_some();
                if !more && self.is_done() {
                    return Ok(());
                }
                self.advance(more, &mut NoProbe)?;
            }
            if self.done() >= done {
                return Ok(());
            }
        }
    }

    /// The work that is done, as [`crate::functional::Features::size`] counts it.
    pub fn done(&self) -> f64 {
        // A primary that is rasterised counts as a ray that is not traced: else tiles without other rays would count for nothing.
        let done =
            |Core { ti, srp, .. }: &Core| ti.done() + cost(0, 0, srp.primaries_delivered()) + srp.work_done() as f64;
        self.cores.iter().map(done).sum()
    }
}

impl<'a, M: Memory> System<'a, M> {
    /// An empty machine in front of another memory than its own.
    pub fn with_memory(config: &MachineConfig, tree: &'a Topology, shape: FrameShape, memory: M) -> Self {
        Self::assemble(config, tree, shape, memory, Self::step)
    }

    fn assemble(config: &MachineConfig, tree: &'a Topology, shape: FrameShape, memory: M, step: fn(&mut Self)) -> Self {
        let layout = Layout::new(config);
        let ti_ports = TracingUnit::ports(config);
        let ports_per_core = ti_ports + SRP_PORTS;
        let core = |i: u32| {
            let first = i as u16 * ports_per_core;
            let ports = SrpPorts { l1: Port(first + ti_ports), dma: Port(first + ti_ports + 1) };
            Core {
                srp: Srp::new(config, layout, i, ports, shape),
                ti: TracingUnit::new(config, Port(first)),
                srp_wake: When::at(TiCycle(0)),
                ti_wake: When::at(TiCycle(0)),
            }
        };
        Self {
            tree,
            layout,
            cores: (0..config.gpu.cores).map(core).collect(),
            ports_per_core,
            dispatch: config.gpu.tile_dispatch,
            memory,
            now: TiCycle(0),
            arrived: Vec::new(),
            idle_steps: 0,
            tiles: 0,
            step,
        }
    }

    /// The memory, to take from it what it has written down.
    pub fn memory_mut(&mut self) -> &mut M {
        &mut self.memory
    }

    /// Runs until a core has a free tile slot and gives it `work`, at the first such cycle.
    ///
    /// # Errors
    /// [`MachineError::Deadlock`] if the machine stands still.
    pub fn feed<P: Probe>(&mut self, work: impl Into<Arc<TileWork>>, probe: &mut P) -> Result<()> {
        let core = self.make_room(probe)?;
        self.give(core, work.into());
        Ok(())
    }

    /// Gives a tile to a core with a free slot.
    fn give(&mut self, core: usize, work: Arc<TileWork>) {
        let core = &mut self.cores[core];
        core.srp.give_tile(self.now, work);
        core.srp_wake = When::at(self.now);
        self.tiles += 1;
        self.idle_steps = 0;
    }

    /// Runs until a core has a free tile slot, and says which, at the first such cycle.
    ///
    /// # Errors
    /// [`MachineError::Deadlock`] if the machine stands still.
    pub fn make_room<P: Probe>(&mut self, probe: &mut P) -> Result<usize> {
        loop {
            if let Some(core) = self.free_core() {
                return Ok(core);
            }
            self.advance(true, probe)?;
        }
    }

    /// The core that takes the next tile, if one has a free slot.
    fn free_core(&self) -> Option<usize> {
        self.dispatch.choose(self.cores.iter().map(|core| core.srp.free_slots()))
    }

    /// Runs until all tiles are done.
    ///
    /// # Errors
    /// As [`System::finish`].
    pub fn drain<P: Probe>(&mut self, probe: &mut P) -> Result<()> {
        while !self.is_done() {
            self.advance(false, probe)?;
        }
        Ok(())
    }

    /// Runs until all tiles are done and closes the accounts; gives what was counted, and the memory.
    ///
    /// # Errors
    /// [`MachineError::Deadlock`] if the machine stands still with work left.
    pub fn finish<P: Probe>(mut self, probe: &mut P) -> Result<(Stats, M)> {
        self.drain(probe)?;
        let end = self.now;
        // Writes that still wait for DRAM belong to this frame's energy, but nothing waits for them.
        while !self.memory.is_idle(self.now)
            && let Some(next) = self.memory.next_event(self.now).cycle()
        {
            self.now = next;
            self.memory.tick(next, &mut self.arrived);
        }
        probe.look(end, &self.cores, self.memory.bytes_moved());
        let cores = self.cores.iter_mut().map(|core| core.finish(end)).collect();
        Ok((Stats { cycles: end.0, tiles: self.tiles, cores, memory: self.memory.finish(end) }, self.memory))
    }

    /// Runs the cycle at hand and goes to the next one at which something happens; `feeding` says that a tile waits to be taken.
    fn advance<P: Probe>(&mut self, feeding: bool, probe: &mut P) -> Result<()> {
        (self.step)(self);
        if probe.due().is_due(self.now) {
            probe.look(self.now, &self.cores, self.memory.bytes_moved());
        }
        let takes = feeding && self.cores.iter().any(|core| core.srp.wants_tile());
        let next = if takes || self.is_done() { When::at(self.now + 1) } else { self.next_event() };
        let next = next.cycle().ok_or_else(|| self.deadlock())?;
        debug_assert!(next > self.now, "an event in the past");
        self.idle_steps += 1;
        let is_still = self.idle_steps > DEADLOCK_STEPS && self.memory.is_idle(self.now);
        if is_still || self.idle_steps > BUSY_STEPS {
            return Err(self.deadlock());
        }
        self.now = next;
        Ok(())
    }

    /// Runs cycle `now`.
    fn step(&mut self) {
        let now = self.now;
        self.memory.tick(now, &mut self.arrived);
        self.deliver();
        for line in self.memory.take_evicted() {
            self.cores.iter_mut().for_each(|core| core.ti.invalidate(line));
            self.cores.iter_mut().for_each(|core| core.srp.l1_mut().invalidate(line));
        }
        for core in &mut self.cores {
            // A refused request, or a ray without room, has no event: it is tried again whenever something happens.
            if core.srp_wake.is_due(now) || core.srp.waits() {
                core.tick_srp(now, &mut self.memory);
            }
            if core.ti_wake.is_due(now) && core.tick_ti(now, self.tree, &self.layout, &mut self.memory) {
                self.idle_steps = 0;
            }
        }
        self.release_tiles();
    }

    /// Lets tiles go on whose neighbours are far enough.
    fn release_tiles(&mut self) {
        let is_open = |cores: &[Core], neighbour| cores.iter().any(|core| core.srp.is_open(neighbour));
        for core in 0..self.cores.len() {
            while let Some(slot) = self.cores[core].srp.released(|neighbour| is_open(&self.cores, neighbour)) {
                self.cores[core].srp.release(self.now, slot);
                self.cores[core].srp_wake = When::at(self.now + 1);
            }
        }
    }

    fn deliver(&mut self) {
        for response in self.arrived.drain(..) {
            let core = &mut self.cores[usize::from(response.port.0 / self.ports_per_core)];
            self.idle_steps = 0;
            if response.port.0 % self.ports_per_core < self.ports_per_core - SRP_PORTS {
                core.ti.fill(self.now, response.port, response.line);
                core.ti_wake = When::at(self.now);
            } else {
                core.srp.respond(self.now, response);
                core.srp_wake = When::at(self.now);
            }
        }
    }

    fn next_event(&self) -> When {
        let memory = self.memory.next_event(self.now).after(self.now);
        self.cores.iter().map(|core| core.srp_wake.min(core.ti_wake)).fold(memory, When::min)
    }

    fn is_done(&self) -> bool {
        self.cores.iter().all(|core| core.srp.is_done() && core.ti.rays_inside() == 0)
    }

    fn deadlock(&self) -> MachineError {
        let cores = self.cores.iter().enumerate();
        let state: Vec<_> =
            cores.map(|(i, core)| format!("core {i}: {}; {}", core.ti.describe(), core.srp.describe())).collect();
        MachineError::Deadlock { cycle: self.now.0, state: state.join("; ") }
    }
}
