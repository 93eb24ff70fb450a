//! The whole machine and its clock: cores, memory, the queue of tiles, and the loop that jumps from event to event.
//!
//! A cycle goes: memory brings what has arrived; each core's SRP takes finished rays, runs kernels and sends rays; each core's
//! T&I unit runs. What one of them sends, another sees a cycle later, so the order within a cycle is no more than a tie-break:
//! memory requests of one cycle are served by core and unit. A core whose tile slot is free takes the next tile of the frame,
//! the first core first. Every frame begins with cold caches and empty pipelines.

use super::config::MachineConfig;
use super::link::RayUnit;
use super::memory::{Cycle, Memory, Port, Response};
use super::srp::{FrameShape, Srp, SrpPorts};
use super::stats::{CoreStats, Stats};
use super::ti::{Context, TiUnit, Tiles};
use super::work::TileWork;
use super::work::layout::Layout;
use super::work::topology::Topology;
use crate::error::{MachineError, Result};

/// Cycles without any finished ray, tile or memory response after which the machine is taken to stand still. The longest
/// legal silence is that of a refresh or of a full kernel batch, thousands of cycles.
const PATIENCE_CYCLES: Cycle = 4_000_000;

/// Ports that a core's SRP takes: its L1 and its DMA.
const SRP_PORTS: u16 = 2;

/// One core.
pub struct Core {
    /// The programmable shader with its tiles.
    pub srp: Srp,
    /// The T&I unit.
    pub ti: TiUnit,
    srp_wake: Cycle,
    ti_wake: Cycle,
}

/// The machine at work on one frame.
pub struct System<'a, M> {
    tree: &'a Topology,
    layout: Layout,
    cores: Vec<Core>,
    ports_per_core: u16,
    memory: M,
    now: Cycle,
    arrived: Vec<Response>,
    progress: Cycle,
    tiles: u64,
}

impl Tiles for Srp {
    #[inline]
    fn work(&self, slot: u8) -> &TileWork {
        self.work(slot)
    }
}

/// Looks at the machine from time to time; see `timeline`.
pub trait Probe {
    /// A frame begins; its time begins at cycle 0.
    fn begin(&mut self, _frame: u32) {}
    /// The next cycle at which it wants to look.
    fn due(&self) -> Cycle;
    /// It is cycle `now`, the first at or after the one asked for at which anything happened. `bytes` went to or came from
    /// DRAM so far.
    fn look(&mut self, now: Cycle, cores: &[Core], bytes: u64);
}

/// A probe that never looks.
#[derive(Clone, Copy, Debug, Default)]
pub struct NoProbe;

impl Probe for NoProbe {
    fn due(&self) -> Cycle {
        Cycle::MAX
    }
    fn look(&mut self, _: Cycle, _: &[Core], _: u64) {}
}

impl<'a, M: Memory> System<'a, M> {
    /// An empty machine in front of `memory`, for a frame of `shape`.
    pub fn new(config: &MachineConfig, tree: &'a Topology, shape: FrameShape, memory: M) -> Self {
        let layout = Layout::new(config);
        let ti_ports = TiUnit::ports(config);
        let ports_per_core = ti_ports + SRP_PORTS;
        let core = |i: u32| {
            let first = i as u16 * ports_per_core;
            let ports = SrpPorts { l1: Port(first + ti_ports), dma: Port(first + ti_ports + 1) };
            Core {
                srp: Srp::new(config, layout, i, ports, shape),
                ti: TiUnit::new(config, Port(first)),
                srp_wake: 0,
                ti_wake: 0,
            }
        };
        Self {
            tree,
            layout,
            cores: (0..config.gpu.cores).map(core).collect(),
            ports_per_core,
            memory,
            now: 0,
            arrived: Vec::new(),
            progress: 0,
            tiles: 0,
        }
    }

    /// Runs until a core has a free tile slot and gives it `work`: the first such core, at the first such cycle.
    ///
    /// # Errors
    /// [`MachineError::Stuck`] if the machine stands still.
    pub fn feed<P: Probe>(&mut self, work: TileWork, probe: &mut P) -> Result<()> {
        loop {
            if let Some(core) = self.cores.iter_mut().find(|core| core.srp.wants_tile()) {
                core.srp.give_tile(self.now, work);
                core.srp_wake = self.now;
                self.tiles += 1;
                self.progress = self.now;
                return Ok(());
            }
            self.advance(true, probe)?;
        }
    }

    /// Runs until all tiles are done and closes the accounts; gives what was counted, and the memory.
    ///
    /// # Errors
    /// [`MachineError::Stuck`] if the machine stands still with work left.
    pub fn finish<P: Probe>(mut self, probe: &mut P) -> Result<(Stats, M)> {
        while !self.is_done() {
            self.advance(false, probe)?;
        }
        let cycles = self.now;
        // Writes that still wait for DRAM belong to this frame's energy, but nothing waits for them.
        while !self.memory.is_idle() {
            self.now = self.memory.next_event().unwrap_or(0).max(self.now + 1);
            self.memory.tick(self.now, &mut self.arrived);
        }
        probe.look(cycles, &self.cores, self.memory.bytes_moved());
        let close = |core: &mut Core| {
            core.srp.finish(cycles);
            CoreStats {
                ti: core.ti.finish(cycles),
                srp: *core.srp.stats(),
                srp_l1: *core.srp.l1().counters(),
                srp_cycles: core.srp.cycles(cycles),
            }
        };
        let cores = self.cores.iter_mut().map(close).collect();
        Ok((Stats { cycles, tiles: self.tiles, cores, ..Stats::default() }, self.memory))
    }

    /// Runs the cycle at hand and goes to the next one at which something happens; `feeding` says that a tile waits to be taken.
    fn advance<P: Probe>(&mut self, feeding: bool, probe: &mut P) -> Result<()> {
        self.step();
        if probe.due() <= self.now {
            probe.look(self.now, &self.cores, self.memory.bytes_moved());
        }
        let takes = feeding && self.cores.iter().any(|core| core.srp.wants_tile());
        let next = if takes || self.is_done() { Some(self.now + 1) } else { self.next_event() };
        let next = next.ok_or_else(|| self.stuck())?;
        debug_assert!(next > self.now, "an event in the past");
        if next - self.progress > PATIENCE_CYCLES {
            return Err(self.stuck());
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
            // A refused request, or a ray without room, has no event of its own: it is tried again whenever something happens.
            if core.srp_wake <= now || core.srp.waits() {
                core.srp.tick(now, &mut core.ti, &mut self.memory);
                core.srp_wake = core.srp.next_event().map_or(Cycle::MAX, |at| at.max(now + 1));
                core.ti_wake = core.ti_wake.min(core.ti.next_event(now).unwrap_or(Cycle::MAX));
            }
            if core.ti_wake <= now {
                let (room, results) = (core.ti.has_room(), core.ti.results().len());
                let context = Context { tree: self.tree, layout: &self.layout, tiles: &core.srp };
                core.ti.tick(now, &context, &mut self.memory);
                core.ti_wake = core.ti.next_event(now).unwrap_or(Cycle::MAX);
                if core.ti.results().len() > results {
                    self.progress = now;
                    core.srp_wake = now + 1;
                }
                if core.ti.has_room() != room {
                    core.srp_wake = now + 1;
                }
            }
        }
    }

    fn deliver(&mut self) {
        for response in self.arrived.drain(..) {
            let core = &mut self.cores[usize::from(response.port.0 / self.ports_per_core)];
            self.progress = self.now;
            if response.port.0 % self.ports_per_core < self.ports_per_core - SRP_PORTS {
                core.ti.fill(self.now, response.port, response.line);
                core.ti_wake = self.now;
            } else {
                core.srp.respond(self.now, response);
                core.srp_wake = self.now;
            }
        }
    }

    fn next_event(&self) -> Option<Cycle> {
        let cores = self.cores.iter().map(|core| core.srp_wake.min(core.ti_wake)).min().unwrap_or(Cycle::MAX);
        let next = cores.min(self.memory.next_event().map_or(Cycle::MAX, |at| at.max(self.now + 1)));
        (next != Cycle::MAX).then_some(next)
    }

    fn is_done(&self) -> bool {
        self.cores.iter().all(|core| core.srp.is_done() && core.ti.rays_inside() == 0)
    }

    fn stuck(&self) -> MachineError {
        let cores = self.cores.iter().enumerate();
        let state: Vec<_> =
            cores.map(|(i, core)| format!("core {i}: {}; {}", core.ti.describe(), core.srp.describe())).collect();
        MachineError::Stuck { cycle: self.now, state: state.join("; ") }
    }
}
