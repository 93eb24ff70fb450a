//! The one loop over frames: each is replayed and, where a machine is given, simulated.

use rayreel_machine::config::NamedMachine;
use rayreel_machine::system::Probe;
use rayreel_machine::work::topology::Topology;

use crate::counts::FrameStats;
use crate::detail::Detail;
use crate::error::{ReplayError, RequestError, Result};
use crate::frame::{FrameReplay, Options, Replayer};
use crate::policy::SamplePolicy;
use crate::simulate::{MachineRun, simulate_all};
use crate::source::{PathSource, TileSource};
use crate::stop::Stop;
use crate::windows::simulate_estimated;

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
    /// How much of a frame is simulated cycle by cycle.
    pub detail: Detail,
}

impl<'a, S: TileSource + ?Sized> FrameLoop<'a, S> {
    /// Prepares `policy` for the frames of `source`. `stop` ends a frame early.
    ///
    /// # Errors
    /// A policy that does not fit the source.
    pub fn new<P: SamplePolicy + ?Sized>(source: &'a S, policy: &P, options: Options, stop: &Stop) -> Result<Self> {
        Ok(Self { replayer: Replayer::new(source, policy, options)?.with_stop(stop.clone()) })
    }

    /// Does `step` for each of `frames` and gives what comes of it to `sink`.
    fn each<T, E: From<ReplayError>>(
        &mut self,
        frames: impl IntoIterator<Item = u32>,
        mut step: impl FnMut(&mut Self, u32) -> Result<T>,
        mut sink: impl FnMut(T) -> Result<(), E>,
    ) -> Result<(), E> {
        let mut any = false;
        for frame in frames {
            any = true;
            sink(step(self, frame)?)?;
        }
        if any { Ok(()) } else { Err(ReplayError::from(RequestError::Nothing { what: "no frame was chosen" }).into()) }
    }
}

impl<S: PathSource + ?Sized> FrameLoop<'_, S> {
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
        let Some(Simulator { machine, tree, detail }) = simulator else {
            return Ok(FrameResult { replay: self.replayer.frame(frame)?, run: None });
        };
        let (replay, mut runs) = self.step_on(frame, &[machine], (tree, detail), probe)?;
        Ok(FrameResult { replay, run: runs.pop() })
    }

    /// Replays the next frame once, on several machines: each does all its work. `probe` may watch the first.
    ///
    /// # Errors
    /// As [`Self::step`], of whichever machine fails first.
    pub fn step_on<P: Probe>(
        &mut self,
        frame: u32,
        machines: &[&NamedMachine],
        (tree, detail): (&Topology, Detail),
        probe: &mut P,
    ) -> Result<(FrameReplay, Vec<MachineRun>)> {
        let named: Vec<_> = machines.iter().map(|machine| (machine.name.as_str(), &machine.config)).collect();
        match detail {
            Detail::Full => simulate_all(&mut self.replayer, frame, tree, &named, probe),
            _ => simulate_estimated(&mut self.replayer, frame, tree, &named, detail, probe),
        }
    }

    /// All of `frames`, each given to `sink`.
    ///
    /// # Errors
    /// As [`Self::step`]; what `sink` returns; [`RequestError::Nothing`] if there is no frame.
    pub fn run<P: Probe, E: From<ReplayError>>(
        &mut self,
        frames: impl IntoIterator<Item = u32>,
        simulator: Option<Simulator<'_>>,
        probe: &mut P,
        sink: impl FnMut(FrameResult) -> Result<(), E>,
    ) -> Result<(), E> {
        self.each(frames, |this, frame| this.step(frame, simulator, probe), sink)
    }
}

/// Several replayed frames, all in memory.
#[derive(Clone, Debug, PartialEq)]
pub struct Replay {
    /// The frames, in the order asked for.
    pub frames: Vec<FrameReplay>,
}

impl Replay {
    /// The statistics of all frames, as a report takes them.
    pub fn stats(&self) -> Vec<FrameStats> {
        self.frames.iter().map(|f| f.stats.clone()).collect()
    }
}

/// Replays `frames` without a machine and keeps them all.
///
/// # Errors
/// As [`FrameLoop::new`] and [`FrameLoop::run`].
pub fn replay<S: TileSource + ?Sized, P: SamplePolicy + ?Sized>(
    source: &S,
    policy: &P,
    frames: impl IntoIterator<Item = u32>,
    options: Options,
) -> Result<Replay> {
    let mut kept = Vec::new();
    let mut all = FrameLoop::new(source, policy, options, &Stop::never())?;
    let keep = |frame| {
        kept.push(frame);
        Ok::<_, ReplayError>(())
    };
    all.each(frames, |this, frame| this.replayer.frame(frame), keep)?;
    Ok(Replay { frames: kept })
}
