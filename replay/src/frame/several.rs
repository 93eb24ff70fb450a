//! Several policies on one pass over the tiles of a frame: reading and decoding a tile costs more than deciding it.

use rayon::prelude::*;
use rayreel_formats::scene::Camera;
use rayreel_machine::work::check::PathCounts;

use super::band::{Band, Reader};
use super::canvas::FrameReplay;
use super::replayer::{Options, PassedFrame, Replayer, Row, next_row};
use crate::error::{ReplayError, Result};
use crate::image::Image;
use crate::policy::SamplePolicy;
use crate::source::{PackedTile, TileSource};
use crate::stop::Stop;

/// Replays one frame after the other under several policies at a time; each does as in a [`Replayer`] of its own.
///
/// ```
/// use rayreel_formats::{Limits, trace::Trace};
/// use rayreel_replay::{NamedPolicy, Options, Replayers, SamplePolicy};
///
/// let trace = Trace::open("../traces/v1_0_cornell.rtrace".as_ref(), Limits::default())?;
/// let policies = [NamedPolicy::load("full", &[])?, NamedPolicy::load("multirate", &[])?];
/// let policies: Vec<&dyn SamplePolicy> = policies.iter().map(|policy| policy as &dyn SamplePolicy).collect();
/// let frames = Replayers::new(&trace, &policies, Options::default())?.frame(0)?;
/// let traced: Vec<u64> = frames.iter().map(|frame| frame.stats.counts.rays_traced.total()).collect();
/// assert_eq!(traced, [10_051, 4254]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Replayers<'a, S: ?Sized> {
    source: &'a S,
    replayers: Vec<Replayer<'a, S>>,
    stop: Stop,
}

/// A policy in the middle of a frame.
struct InFrame<'r, 'a, S: ?Sized> {
    replayer: &'r mut Replayer<'a, S>,
    canvas: super::canvas::Canvas,
    /// The row that is still to be closed.
    above: Option<Band>,
}

impl<'a, S: TileSource + ?Sized> Replayers<'a, S> {
    /// Prepares `policies` for the frames of `source`.
    ///
    /// # Errors
    /// As [`Replayer::new`], for the first policy that does not suit.
    pub fn new(source: &'a S, policies: &[&dyn SamplePolicy], options: Options) -> Result<Self> {
        let replayers = policies.iter().map(|policy| Replayer::new(source, *policy, options)).collect::<Result<_>>()?;
        Ok(Self { source, replayers, stop: Stop::never() })
    }

    /// Looks at `stop` before each tile that it reads, and ends the frame with [`ReplayError::Interrupted`] once that is
    /// requested.
    #[must_use]
    pub fn with_stop(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// Replays frame `frame` under each policy, in their order.
    ///
    /// # Errors
    /// As [`Replayer::frame`]; of several policies that fail, the error of the first.
    pub fn frame(&mut self, frame: u32) -> Result<Vec<FrameReplay>> {
        let Some(first) = self.replayers.first() else { return Ok(Vec::new()) };
        self.stop.check()?;
        let camera = first.camera(frame)?;
        let (source, stop) = (self.source, &self.stop);
        let begin = |(i, replayer): (usize, _)| InFrame::new(i == 0, replayer, (frame, &camera));
        let mut runs: Vec<_> = self.replayers.iter_mut().enumerate().map(begin).collect();
        let rows = source.meta().tile_grid().1;
        let mut next = (rows > 0).then(|| read_row(source, frame, 0, stop));
        for row in 0..rows {
            let Some(read) = next.take() else { break };
            let tiles = read?;
            // The next row is read meanwhile: neither keeps all threads busy to its end.
            let ahead = || (row + 1 < rows).then(|| read_row(source, frame, row + 1, stop));
            let decide = || {
                let all = runs.par_iter_mut();
                all.map(|run| run.row((source, &camera, frame), row, &tiles, stop)).collect::<Vec<Result<()>>>()
            };
            let (read, decided) = rayon::join(ahead, decide);
            decided.into_iter().collect::<Result<()>>()?;
            next = read;
        }
        let closed = runs.par_iter_mut().map(|run| run.close((source, &camera, frame), stop));
        closed.collect::<Vec<Result<()>>>().into_iter().collect::<Result<()>>()?;
        // What is recorded is the same for all.
        let reference = runs[0].canvas.take_reference();
        let finished = runs.into_par_iter().map(|run| run.finish(frame, reference.as_ref()));
        finished.collect::<Vec<_>>().into_iter().collect()
    }
}

/// Reads the tiles of a row.
fn read_row<S: TileSource + ?Sized>(source: &S, frame: u32, row: u32, stop: &Stop) -> Result<Vec<PackedTile>> {
    let columns = source.meta().tile_grid().0;
    let read = |index: u32| {
        stop.check()?;
        let tile = source.shared_tile(frame, index).map_err(|e| ReplayError::tile((frame, index), e))?;
        Ok(PackedTile { tile, packed: None })
    };
    // Collected one by one before errors are looked at, so that the first tile's error is reported on any machine.
    let read: Vec<Result<PackedTile>> = (row * columns..(row + 1) * columns).into_par_iter().map(read).collect();
    read.into_iter().collect()
}

impl<'r, 'a, S: TileSource + ?Sized> InFrame<'r, 'a, S> {
    /// Only one policy makes the picture of `full`.
    fn new(first: bool, replayer: &'r mut Replayer<'a, S>, (frame, camera): (u32, &Camera)) -> Self {
        let canvas = replayer.canvas(first);
        replayer.sampler.begin_frame(frame, camera);
        Self { replayer, canvas, above: None }
    }

    /// Opens a row, whose tiles are read, and closes the row above it.
    fn row(
        &mut self,
        (source, camera, frame): (&S, &Camera, u32),
        row: u32,
        tiles: &[PackedTile],
        stop: &Stop,
    ) -> Result<()> {
        let first = row * source.meta().tile_grid().0;
        let read = |index: u32| Ok(tiles[(index - first) as usize].clone());
        let reader = Reader { source, camera, frame, read, keep: false, stop };
        self.step(&reader, Some(row))
    }

    /// Closes the last row.
    fn close(&mut self, (source, camera, frame): (&S, &Camera, u32), stop: &Stop) -> Result<()> {
        let read = |_| Err(rayreel_formats::Error::usage("all rows are read"));
        self.step(&Reader { source, camera, frame, read, keep: false, stop }, None)
    }

    fn step<R>(&mut self, reader: &Reader<'_, S, R>, row: Option<u32>) -> Result<()>
    where
        R: Fn(u32) -> rayreel_formats::Result<PackedTile> + Sync,
    {
        let (canvas, sampler) = (&mut self.canvas, &mut *self.replayer.sampler);
        let row = row.map_or(Row::End, Row::Next);
        next_row(reader, sampler, &mut self.above, row, &mut |closed| {
            canvas.add(&closed.band.tiles, closed.stats);
            Ok(())
        })
    }

    fn finish(self, frame: u32, reference: Option<&Image>) -> Result<FrameReplay> {
        self.replayer.finish(PassedFrame::new(frame, self.canvas.with_reference(reference), PathCounts::default()))
    }
}
