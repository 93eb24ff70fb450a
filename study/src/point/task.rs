//! Points under way: frames go in, results come out.

use crate::error::{Result, StudyError};
use crate::point::details::{Details, FrameDetails, FrameFigures, TileFigures, no_origin};
use crate::point::key::Point;
use crate::point::pictures::FramePictures;
use crate::point::row::{Column, Row};
use crate::point::wanted::{Compared, Figures};
use crate::report::Report;
use rayreel_formats::scene::Meta;
use rayreel_machine::system::Probe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::counts::FrameStats;
use rayreel_replay::sequence::FrameLoop;
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::source::PathSource;
use rayreel_replay::{FrameReplay, Options, Stop};

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

/// Points under way that share a replay: frames are given to them in order, and one pass gives all that is missing of each.
pub struct PointTask<'a, S: ?Sized> {
    members: Vec<Member<'a>>,
    source: &'a S,
    frames: FrameLoop<'a, S>,
    /// Of the frames so far, for the rows.
    counted: Vec<FrameStats>,
}

/// One of the points.
struct Member<'a> {
    point: &'a Point,
    missing: Missing,
    runs: Vec<MachineRun>,
    details: Details,
}

impl<'a, S: PathSource + ?Sized> PointTask<'a, S> {
    /// Begins points on their source, of which there is at least one. They share a replay ([`Point::shares_replay`]). `stop` ends a
    /// frame early.
    ///
    /// # Errors
    /// A policy that does not fit the source.
    pub fn new(points: &[(&'a Point, Missing)], source: &'a S, stop: &Stop) -> Result<Self> {
        let first = points
            .first()
            .map(|(point, _)| *point)
            .filter(|first| points[1..].iter().all(|(point, _)| point.shares_replay(first)));
        let first = first.ok_or_else(|| StudyError::Usage { detail: "points that do not share a replay".into() })?;
        let compared = points.iter().map(|(point, missing)| compared(point, *missing)).max().unwrap_or(Compared::Not);
        let options = Options {
            reference: compared != Compared::Not,
            perception: compared == Compared::Seen,
            ..Options::default()
        };
        let frames = FrameLoop::new(source, &first.policy.policy, options, stop)?;
        let member = |(point, missing): &(&'a Point, Missing)| {
            let pictures = if missing.details { point.wanted.views.pictures.len() } else { 0 };
            let details = Details { frames: Vec::new(), pictures: vec![Vec::new(); pictures] };
            Member { point, missing: *missing, runs: Vec::new(), details }
        };
        Ok(Self { members: points.iter().map(member).collect(), source, frames, counted: Vec::new() })
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
        let machine = |member: &Member<'a>| member.point.machine.as_deref().filter(|_| member.is_simulated(frame));
        let machines: Vec<_> = self.members.iter().filter_map(machine).collect();
        let (replay, runs) = match tree.filter(|_| !machines.is_empty()) {
            Some(tree) => self.frames.step_on(frame, &machines, (tree, self.members[0].point.detail), probe)?,
            None => (self.frames.step(frame, None, probe)?.replay, Vec::new()),
        };
        let mut runs = runs.into_iter();
        for member in &mut self.members {
            let run = machine(member).and_then(|_| runs.next());
            if member.missing.details {
                member.detail(self.source.meta(), &replay, run.as_ref())?;
            }
            member.runs.extend(run.filter(|_| member.missing.row));
        }
        // Of a long flight of which no row is wanted, the tiles of all frames would only take memory.
        if self.members.iter().any(|member| member.missing.row) {
            self.counted.push(replay.stats);
        }
        Ok(())
    }

    /// What came of them, in their order.
    pub fn finish(self) -> Vec<Computed> {
        let Self { members, source, counted, .. } = self;
        members.into_iter().map(|member| member.finish(source.meta(), &counted)).collect()
    }
}

impl Member<'_> {
    fn is_simulated(&self, frame: u32) -> bool {
        match &self.point.wanted.figures {
            Figures::Row => self.missing.row,
            Figures::Frames { simulated, .. } => simulated.contains(&frame),
        }
    }

    /// Takes what is wanted of a frame beside the row.
    fn detail(&mut self, meta: &Meta, replay: &FrameReplay, run: Option<&MachineRun>) -> Result<()> {
        let (point, frame, stats) = (self.point, replay.frame, &replay.stats);
        let by_frame = matches!(point.wanted.figures, Figures::Frames { .. });
        if by_frame || point.wanted.views.tiles {
            let figures = by_frame.then(|| FrameFigures::new(point, meta, stats, run));
            let tiles = point.wanted.views.tiles.then(|| TileFigures::of_frame(point, meta, stats));
            self.details.frames.push(FrameDetails { frame, figures, tiles: tiles.unwrap_or_default() });
        }
        let pictures = FramePictures::new(replay, meta.samples);
        for (wanted, bytes) in point.wanted.views.pictures.iter().zip(&mut self.details.pictures) {
            if wanted.frame == frame {
                *bytes = pictures.png(wanted)?;
            }
        }
        Ok(())
    }

    /// What came of it, of frames with these counts.
    fn finish(self, meta: &Meta, counted: &[FrameStats]) -> Computed {
        let details = self.missing.details.then_some(self.details);
        let key = self.point.row_key().filter(|_| self.missing.row);
        let row = key.map(|key| {
            let report = Report::new(&no_origin(), &self.point.policy, meta, counted).without_tiles();
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
