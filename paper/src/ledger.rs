//! Which results are there, and where they are kept.

use std::path::Path;

use rayreel_study::files::write_whole;
use rayreel_study::point::details::Details;
use rayreel_study::point::key::Point;
use rayreel_study::point::store::Store;
use rayreel_study::point::task::{Computed, Missing};
use rayreel_study::sweep::reused::{RESULTS, ReusedRows};

use crate::error::{PaperError, Result};
use crate::frame::FrameView;
use crate::plan::{Plan, PlannedPoint};
use crate::results::{PointResult, Results};
use crate::setup::Folders;

/// How many points there were, and where their results came from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PointCounts {
    /// Points of the experiment.
    pub points: usize,
    /// Rows taken from the folders named for reuse.
    pub reused: usize,
    /// Points whose figures were computed.
    pub computed: usize,
    /// Points that were replayed for their pictures alone.
    pub shown: usize,
}

impl PointCounts {
    /// Points whose rows the cache had.
    pub fn kept(&self) -> usize {
        self.points.saturating_sub(self.computed + self.reused)
    }
}

/// The points of a plan with their results so far.
pub struct Ledger<'a> {
    plan: &'a Plan<'a>,
    out: &'a Path,
    store: Store,
    reused: ReusedRows,
    /// With their sources as they are known.
    points: Vec<Point>,
    results: Vec<PointResult>,
    counts: PointCounts,
}

impl<'a> Ledger<'a> {
    /// No result is there yet.
    ///
    /// # Errors
    /// A folder that cannot be read or made.
    pub fn open(plan: &'a Plan<'a>, folders: &'a Folders) -> Result<Self> {
        // Before a folder is made: these may be refused.
        let reused = ReusedRows::load(&folders.reuse)?;
        Ok(Self {
            plan,
            out: &folders.out,
            store: Store::open(&folders.cache.join(RESULTS))?,
            reused,
            points: plan.points.iter().map(|planned| planned.point.clone()).collect(),
            results: vec![PointResult::default(); plan.points.len()],
            counts: PointCounts { points: plan.points.len(), ..PointCounts::default() },
        })
    }

    /// Where results are kept.
    pub fn folder(&self) -> &Path {
        self.store.path()
    }

    /// The points on a capture, by number.
    pub fn points_on(&self, capture: usize) -> impl Iterator<Item = usize> {
        let on = move |(_, planned): &(usize, &PlannedPoint)| planned.capture == capture;
        self.plan.points.iter().enumerate().filter(on).map(|(i, _)| i)
    }

    /// Point number `i`.
    pub fn point(&self, i: usize) -> &Point {
        &self.points[i]
    }

    /// What is missing of point number `i`.
    pub fn missing(&self, i: usize) -> Missing {
        self.results[i].missing(&self.points[i])
    }

    /// Figures of the row of point number `i`, if they are there.
    pub fn row(&self, i: usize) -> Option<FrameView<'_>> {
        let figures = self.results[i].row.as_ref()?;
        Some(FrameView::new(figures, &self.points[i]))
    }

    /// The source of a capture is known: looks for the results of its points.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn look_up(&mut self, capture: usize, source: &str) -> Result<()> {
        let points: Vec<usize> = self.points_on(capture).collect();
        for i in points {
            source.clone_into(&mut self.points[i].source);
            self.results[i] = PointResult::default();
            self.look_up_row(i)?;
            self.look_up_details(i)?;
        }
        Ok(())
    }

    fn look_up_row(&mut self, i: usize) -> Result<()> {
        let (point, result) = (&self.points[i], &mut self.results[i]);
        let Some(key) = point.row_key() else { return Ok(()) };
        if let Some(row) = self.store.row(&key)
            && result.take_row(point, row)
        {
            return Ok(());
        }
        if let Some(row) = self.reused.rows.get(&key)
            && result.take_row(point, row.clone())
        {
            // The next run does without the other folder.
            self.store.keep_row(row, &self.reused.columns)?;
            self.counts.reused += 1;
        }
        Ok(())
    }

    fn look_up_details(&mut self, i: usize) -> Result<()> {
        let point = &self.points[i];
        let Some(key) = point.details_key() else { return Ok(()) };
        match self.store.details(&key, point.wanted.views.pictures.len()) {
            Some(details) => self.take_details(i, details),
            None => Ok(()),
        }
    }

    /// Keeps what was computed of point number `i`.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&mut self, i: usize, computed: Computed) -> Result<()> {
        let figures = self.missing(i).row || self.points[i].row_key().is_none();
        self.counts.computed += usize::from(figures);
        self.counts.shown += usize::from(!figures);
        if let Some((row, columns)) = computed.row {
            self.store.keep_row(&row, &columns)?;
            if !self.results[i].take_row(&self.points[i], row) {
                return Err(PaperError::Fault { detail: "a row does not hold all figures" });
            }
        }
        if let (Some(details), Some(key)) = (computed.details, self.points[i].details_key()) {
            self.store.keep_details(&key, &details)?;
            self.take_details(i, details)?;
        }
        Ok(())
    }

    /// Takes details; their pictures go into the output folder.
    fn take_details(&mut self, i: usize, mut details: Details) -> Result<()> {
        for (file, bytes) in self.plan.points[i].files.iter().zip(std::mem::take(&mut details.pictures)) {
            let path = self.out.join(file);
            if !bytes.is_empty() && !std::fs::read(&path).is_ok_and(|old| old == bytes) {
                write_whole(&path, &bytes)?;
            }
        }
        self.results[i].details = Some(details);
        Ok(())
    }

    /// The results of all points, and where they came from.
    ///
    /// # Errors
    /// Something is still missing: never after all of it was computed.
    pub fn finish(self) -> Result<(Results, PointCounts)> {
        let results = Results::new(self.points.into_iter().zip(self.results));
        let results = results.ok_or(PaperError::Fault { detail: "a replay gave no result" })?;
        Ok((results, self.counts))
    }
}
