//! A frame through policy and machine.
//!
//! ```
//! use rayreel_formats::{Limits, trace::Trace};
//! use rayreel_machine::{config::NamedMachine, system::NoProbe};
//! use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer, simulate::simulate};
//!
//! let trace = Trace::open("../traces/v1_0_cornell.rtrace".as_ref(), Limits::default())?;
//! let (policy, machine) = (NamedPolicy::load("multirate", &[])?, NamedMachine::load("sgrt-ti2", &[])?);
//! let mut replayer = Replayer::new(&trace, &policy, Options::default())?;
//! let named = (machine.name.as_str(), &machine.config);
//! let frame = simulate(&mut replayer, 0, &trace.topology(), named, &mut NoProbe)?;
//! assert_eq!((frame.stats.cycles, frame.stats.rays()), (40_787, 4254));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

use crate::detail::Estimate;
use crate::error::{ReplayError, RequestError, Result};
use crate::frame::{FrameReplay, PassedFrame, Replayer};
use crate::source::PathSource;
use rayreel_formats::scene::Meta;
use rayreel_machine::config::{Framebuffer, MachineConfig};
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::memory::{Memory, MemorySystem};
use rayreel_machine::ports::tells_lookups;
use rayreel_machine::srp::{FrameShape, Needs, missing_kernels};
use rayreel_machine::stats::Stats;
use rayreel_machine::system::{NoProbe, Probe, System};
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{PolicyReads, TileWork};

/// A replayed frame with what it cost on a machine.
#[derive(Clone, Debug)]
pub struct MachineFrame {
    /// Picture and counts.
    pub replay: FrameReplay,
    /// What the machine did.
    pub stats: Stats,
    /// What it cost.
    pub energy: EnergyReport,
    /// What the paths asked for, whatever machine does it.
    pub paths: PathCounts,
    /// What is known of the figures, if not every cycle was simulated.
    pub estimate: Option<Estimate>,
}

/// What a machine did with a frame, without its picture.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MachineRun {
    /// What the machine did.
    pub stats: Stats,
    /// What it cost.
    pub energy: EnergyReport,
    /// What the paths asked for, whatever machine does it.
    pub paths: PathCounts,
    /// What is known of the figures, if not every cycle was simulated.
    pub estimate: Option<Estimate>,
}

impl MachineRun {
    /// Adds another frame of the same machine.
    pub fn add(&mut self, other: &Self) {
        self.stats.add(&other.stats);
        self.energy.add(&other.energy);
        self.paths += other.paths;
        match (&mut self.estimate, &other.estimate) {
            (Some(sum), Some(more)) => sum.add(more),
            (sum, more) => *sum = sum.take().or_else(|| more.clone()),
        }
    }
}

/// Replays frame `frame` and runs its rays through a machine. Its caches are empty at first, or hold what the frame before left if
/// they keep it (`gpu.warm_caches`). `probe` may watch, and is told that the frame begins.
///
/// # Errors
/// As [`Replayer::frame_with`]; [`RequestError::MissingKernel`] if the machine cannot run the policy; [`ReplayError::Machine`] if
/// the machine stands still.
pub fn simulate<S: PathSource + ?Sized, P: Probe>(
    replayer: &mut Replayer<'_, S>,
    frame: u32,
    tree: &Topology,
    machine: (&str, &MachineConfig),
    probe: &mut P,
) -> Result<MachineFrame> {
    let (replay, runs) = simulate_all(replayer, frame, tree, &[machine], probe)?;
    let MachineRun { stats, energy, paths, estimate } = only(runs)?;
    Ok(MachineFrame { replay, stats, energy, paths, estimate })
}

/// The run of the one machine that was simulated.
pub(crate) fn only(mut runs: Vec<MachineRun>) -> Result<MachineRun> {
    runs.pop().ok_or_else(|| ReplayError::Usage { detail: "a machine was simulated, and gave nothing".into() })
}

/// The same on several machines: the frame is replayed once, and each of them does all its work. `probe` watches the first.
///
/// # Errors
/// As [`simulate`], of whichever machine fails first.
pub fn simulate_all<S: PathSource + ?Sized, P: Probe>(
    replayer: &mut Replayer<'_, S>,
    frame: u32,
    tree: &Topology,
    machines: &[(&str, &MachineConfig)],
    probe: &mut P,
) -> Result<(FrameReplay, Vec<MachineRun>)> {
    probe.begin(frame);
    let (passed, runs) = pass_all(replayer, frame, tree, machines, probe)?;
    Ok((replayer.finish(passed)?, runs))
}

/// As [`simulate_all`], without the end of the frame; the probe has been told of its beginning.
pub(crate) fn pass_all<S: PathSource + ?Sized, P: Probe>(
    replayer: &mut Replayer<'_, S>,
    frame: u32,
    tree: &Topology,
    machines: &[(&str, &MachineConfig)],
    probe: &mut P,
) -> Result<(PassedFrame, Vec<MachineRun>)> {
    let meta = replayer.source().meta();
    let reads = replayer.reads();
    let mut systems = Vec::new();
    for (_, config) in machines {
        let mut system = System::new(config, tree, frame_shape(meta, config, reads));
        if let Some(caches) = replayer.caches.of(config, frame) {
            system.warm(&caches);
        }
        systems.push(system);
    }
    let passed = replayer.pass(frame, tree, |work| {
        machines.iter().try_for_each(|machine| check_kernels(*machine, &work))?;
        let Some((first, others)) = systems.split_first_mut() else { return Ok(()) };
        others.iter_mut().try_for_each(|system| system.feed(work.clone(), &mut NoProbe))?;
        Ok(first.feed(work, probe)?)
    })?;
    let mut runs = Vec::new();
    for (i, (mut system, (_, config))) in systems.into_iter().zip(machines).enumerate() {
        if i == 0 {
            system.drain(probe)?;
        }
        system.drain(&mut NoProbe)?;
        replayer.caches.keep(config, frame, || system.caches());
        let (stats, _) = if i == 0 { system.finish(probe)? } else { system.finish(&mut NoProbe)? };
        let energy = EnergyReport::new(config, &stats);
        runs.push(MachineRun { stats, energy, paths: passed.paths, estimate: None });
    }
    Ok((passed, runs))
}

/// As [`simulate`] in front of a memory that `memory` makes of the machine's. After each tile that the machine takes, and at the end, `each`
/// may take from memory and probe what they have written down. Caches are empty at first, whatever `gpu.warm_caches` says. Gives
/// what the machine did.
///
/// # Errors
/// As [`simulate`]; what `each` returns; [`RequestError::NothingTold`] for a memory that wants to be told of lookups
/// ([`Memory::wants_lookups`]), if the machine tells none ([`tells_lookups`]).
pub fn simulate_in_front_of<S: PathSource + ?Sized, M: Memory, P: Probe, E: From<ReplayError>>(
    replayer: &mut Replayer<'_, S>,
    (frame, tree): (u32, &Topology),
    machine: (&str, &MachineConfig),
    (memory, probe): (impl FnOnce(MemorySystem) -> M, &mut P),
    mut each: impl FnMut(&mut M, &mut P) -> Result<(), E>,
) -> Result<Stats, E> {
    let (meta, config) = (replayer.source().meta(), machine.1);
    let shape = frame_shape(meta, config, replayer.reads());
    let memory = memory(MemorySystem::new(config));
    if memory.wants_lookups() && !tells_lookups(config) {
        return Err(ReplayError::from(RequestError::NothingTold { machine: machine.0.into() }).into());
    }
    let mut system = System::with_memory(config, tree, shape, memory);
    probe.begin(frame);
    // An error of `each` ends the frame; what the replay says of that is of no interest.
    let mut stopped = None;
    let replayed = replayer.frame_with(frame, tree, |work| {
        check_kernels(machine, &work)?;
        system.feed(work, probe)?;
        each(system.memory_mut(), probe).map_err(|error| {
            stopped = Some(error);
            ReplayError::Interrupted
        })
    });
    if let Some(error) = stopped {
        return Err(error);
    }
    replayed?;
    let (stats, mut memory) = system.finish(probe).map_err(ReplayError::from)?;
    each(&mut memory, probe)?;
    Ok(stats)
}

/// The framebuffer of a trace's frames on a machine, for a policy that reads so much ([`Replayer::reads`]).
pub fn frame_shape(meta: &Meta, config: &MachineConfig, policy: PolicyReads) -> FrameShape {
    let (pixel_bytes, samples) = (config.layout.pixel_bytes, meta.samples.max(1));
    let pixels = u64::from(meta.tile.div_ceil(samples)).pow(2);
    let (line, tile_samples) = (u64::from(config.l2.line_bytes), meta.tile * meta.tile);
    let tile_bytes = match config.layout.framebuffer {
        Framebuffer::Tiled => (pixels * u64::from(pixel_bytes)).next_multiple_of(line),
        Framebuffer::Linear => 0,
    };
    FrameShape {
        width_pixels: meta.width,
        samples_per_axis: meta.samples,
        pixel_bytes,
        tile_bytes,
        tile_samples,
        policy,
    }
}

/// An error if a machine lacks a kernel that a tile needs.
pub(crate) fn check_kernels((name, config): (&str, &MachineConfig), work: &TileWork) -> Result<()> {
    let missing = missing_kernels(config, &Needs::of(work));
    if missing.is_empty() {
        return Ok(());
    }
    Err(RequestError::MissingKernel { machine: name.into(), kernels: missing.join(" and ") }.into())
}
