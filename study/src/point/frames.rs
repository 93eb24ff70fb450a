//! The loop over the frames of a point: each is replayed and, where a machine is named for it, simulated.

use crate::error::Result;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::system::Probe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::error::RequestError;
use rayreel_replay::policy::Policy;
use rayreel_replay::simulate::{MachineFrame, MachineRun, simulate};
use rayreel_replay::source::PathSource;
use rayreel_replay::{FrameReplay, Options, ReplayError, Replayer, Stop};

/// Replays frames of a source one after the other.
pub struct FrameLoop<'a, S: ?Sized> {
    replayer: Replayer<'a, S>,
}

/// What came of a frame.
#[derive(Clone, Debug)]
pub struct FrameResult {
    /// Picture and counts.
    pub replay: FrameReplay,
    /// What the machine did, if the frame was simulated.
    pub run: Option<MachineRun>,
}

/// A machine with the tree that its rays are traced through.
#[derive(Clone, Copy, Debug)]
pub struct Simulator<'a> {
    /// The machine.
    pub machine: &'a NamedMachine,
    /// The source's [`PathSource::topology`].
    pub tree: &'a Topology,
}

impl<'a, S: PathSource + ?Sized> FrameLoop<'a, S> {
    /// Prepares `policy` for the frames of `source`. `stop` ends a frame early.
    ///
    /// # Errors
    /// A policy that does not fit the source.
    pub fn new(source: &'a S, policy: &Policy, options: Options, stop: &Stop) -> Result<Self> {
        Ok(Self { replayer: Replayer::new(source, policy, options)?.with_stop(stop.clone()) })
    }

    /// Replays the next frame, on a machine if there is one; `probe` may watch.
    ///
    /// # Errors
    /// A frame that the source does not hold or that cannot be read; a machine that cannot run the policy;
    /// [`ReplayError::Interrupted`].
    pub fn step<P: Probe>(
        &mut self,
        frame: u32,
        simulator: Option<Simulator<'_>>,
        probe: &mut P,
    ) -> Result<FrameResult> {
        let Some(Simulator { machine, tree }) = simulator else {
            return Ok(FrameResult { replay: self.replayer.frame(frame)?, run: None });
        };
        probe.begin(frame);
        let named = (machine.name.as_str(), &machine.config);
        let MachineFrame { replay, stats, energy, paths } = simulate(&mut self.replayer, frame, tree, named, probe)?;
        Ok(FrameResult { replay, run: Some(MachineRun { stats, energy, paths }) })
    }

    /// All of `frames`, each given to `sink`.
    ///
    /// # Errors
    /// As [`Self::step`]; what `sink` returns; [`ReplayError::Nothing`] if there is no frame.
    pub fn run<P: Probe>(
        &mut self,
        frames: impl IntoIterator<Item = u32>,
        simulator: Option<Simulator<'_>>,
        probe: &mut P,
        mut sink: impl FnMut(FrameResult) -> Result<()>,
    ) -> Result<()> {
        let mut any = false;
        for frame in frames {
            any = true;
            sink(self.step(frame, simulator, probe)?)?;
        }
        if any { Ok(()) } else { Err(ReplayError::from(RequestError::Nothing { what: "no frame was chosen" }).into()) }
    }
}
