//! A point under way: its frames go in, its results come out.

use crate::error::Result;
use crate::point::details::{Details, FrameDetails, FrameFigures, TileFigures, no_origin};
use crate::point::key::Point;
use crate::point::pictures::FramePictures;
use crate::point::row::{Column, Row};
use crate::point::wanted::{Compared, Figures};
use crate::report::Report;
use rayreel_machine::system::Probe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::counts::FrameStats;
use rayreel_replay::sequence::{FrameLoop, FrameResult, Simulator};
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::source::PathSource;
use rayreel_replay::{Options, Stop};

/// Which results of a point are missing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Missing {
    /// Its row.
    pub row: bool,
    /// Its details.
    pub details: bool,
}

impl Missing {
    /// All that is wanted of a point.
    pub fn all(point: &Point) -> Self {
        Self { row: point.row_key().is_some(), details: point.details_key().is_some() }
    }

    /// Whether something is.
    pub fn any(self) -> bool {
        self.row || self.details
    }
}

/// The results of a point that were missing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Computed {
    /// Its row, with what its columns are.
    pub row: Option<(Row, Vec<Column>)>,
    /// Its details.
    pub details: Option<Details>,
}

/// A point under way. Its frames are given to it in order; one pass gives all that is missing of it.
pub struct PointTask<'a, S: ?Sized> {
    point: &'a Point,
    missing: Missing,
    source: &'a S,
    frames: FrameLoop<'a, S>,
    /// Of the frames so far, for the row.
    counted: Vec<FrameStats>,
    runs: Vec<MachineRun>,
    details: Details,
}

impl<'a, S: PathSource + ?Sized> PointTask<'a, S> {
    /// Begins a point on its source. `stop` ends a frame early.
    ///
    /// # Errors
    /// A policy that does not fit the source.
    pub fn new(point: &'a Point, missing: Missing, source: &'a S, stop: &Stop) -> Result<Self> {
        let compared = compared(point, missing);
        let options = Options { reference: compared != Compared::Not, perception: compared == Compared::Seen };
        let frames = FrameLoop::new(source, &point.policy.policy, options, stop)?;
        let pictures = vec![Vec::new(); if missing.details { point.wanted.views.pictures.len() } else { 0 }];
        let details = Details { frames: Vec::new(), pictures };
        Ok(Self { point, missing, source, frames, counted: Vec::new(), runs: Vec::new(), details })
    }

    /// Whether a machine simulates any frame: [`Self::frame`] then needs the source's topology.
    pub fn simulates(point: &Point, missing: Missing) -> bool {
        (missing.row && point.simulates_row()) || (missing.details && point.wanted.figures.simulates_details())
    }

    /// Replays the next frame; `probe` watches the machine. Without `tree` nothing is simulated.
    ///
    /// # Errors
    /// A machine that cannot run the policy; a source that cannot be read; an interruption.
    pub fn frame<P: Probe>(&mut self, frame: u32, tree: Option<&Topology>, probe: &mut P) -> Result<()> {
        let machine = self.point.machine.as_deref().filter(|_| self.is_simulated(frame));
        let simulator = machine.zip(tree).map(|(machine, tree)| Simulator { machine, tree, detail: self.point.detail });
        let result = self.frames.step(frame, simulator, probe)?;
        if self.missing.details {
            self.detail(&result)?;
        }
        if self.missing.row {
            self.counted.push(result.replay.stats);
            self.runs.extend(result.run);
        }
        Ok(())
    }

    fn is_simulated(&self, frame: u32) -> bool {
        match &self.point.wanted.figures {
            Figures::Row => self.missing.row,
            Figures::Frames { simulated, .. } => simulated.contains(&frame),
        }
    }

    /// Takes what is wanted of a frame beside the row.
    fn detail(&mut self, result: &FrameResult) -> Result<()> {
        let (point, meta, frame) = (self.point, self.source.meta(), result.replay.frame);
        let stats = &result.replay.stats;
        let by_frame = matches!(point.wanted.figures, Figures::Frames { .. });
        if by_frame || point.wanted.views.tiles {
            let figures = by_frame.then(|| FrameFigures::new(point, meta, stats, result.run.as_ref()));
            let tiles = point.wanted.views.tiles.then(|| TileFigures::of_frame(point, meta, stats));
            self.details.frames.push(FrameDetails { frame, figures, tiles: tiles.unwrap_or_default() });
        }
        let pictures = FramePictures::new(&result.replay, meta.samples);
        for (wanted, bytes) in point.wanted.views.pictures.iter().zip(&mut self.details.pictures) {
            if wanted.frame == frame {
                *bytes = pictures.png(wanted)?;
            }
        }
        Ok(())
    }

    /// What came of it.
    pub fn finish(self) -> Computed {
        let details = self.missing.details.then_some(self.details);
        let key = self.point.row_key().filter(|_| self.missing.row);
        let row = key.map(|key| {
            let report = Report::new(&no_origin(), &self.point.policy, self.source.meta(), &self.counted);
            let report = report.without_tiles();
            Row::new(
                key,
                &match self.point.machine.as_deref() {
                    Some(machine) => report.with_machine(machine, &self.runs),
                    None => report,
                },
            )
        });
        Computed { row, details }
    }
}

/// How the frames of a point have to be compared with those of `full` for what is missing.
fn compared(point: &Point, missing: Missing) -> Compared {
    let wanted = &point.wanted;
    match &wanted.figures {
        Figures::Row if missing.row => Compared::Seen,
        Figures::Row => wanted.views.needs(),
        Figures::Frames { compared, .. } => *compared,
    }
}
