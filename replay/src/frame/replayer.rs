//! One frame after the other under a policy, with or without a machine that takes the tiles as work.

use rayon::prelude::*;
use rayreel_formats::scene::Camera;
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{PolicyReads, TileWork};

use super::band::{AdjacentBands, Band, Reader};
use super::caches::KeptCaches;
use super::canvas::{Canvas, FrameReplay};
use super::states::Blocks;
use crate::counts::TileStats;
use crate::error::{ReplayError, RequestError, Result};
use crate::image::compare::Comparer;
use crate::policy::{SamplePolicy, Sampler};
use crate::source::{PackedTile, PathSource, TileSource};
use crate::stop::Stop;
use crate::work::build::Builder;
use crate::work::part::Built;
use crate::work::stream::{Output, ahead};

/// Memory for tiles that wait for their machine, bytes: thirty million operations, seconds of simulation. That bridges the
/// reading of the next row of tiles, whose own operations may all fit, or take almost 1 GB (`lab`, `full`, 2048x1024).
const BYTES_AHEAD: usize = 128 << 20;

/// What a replay also makes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Options {
    /// Make the picture of `full` too, and compare with it.
    pub reference: bool,
    /// Compare as a viewer does too, by SSIM and FLIP: that takes longer than all other figures together.
    pub perception: bool,
    /// Tell how many rays were traced for each sample ([`FrameReplay::traced`]): 8 bytes a sample.
    pub traced: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self { reference: true, perception: true, traced: false }
    }
}

/// Replays one frame after the other. Policies may learn from the frame before, so frames are best given in order.
pub struct Replayer<'a, S: ?Sized> {
    source: &'a S,
    pub(super) sampler: Box<dyn Sampler>,
    options: Options,
    comparer: Comparer,
    stop: Stop,
    /// What machines keep from frame to frame.
    pub(crate) caches: KeptCaches,
}

impl<'a, S: TileSource + ?Sized> Replayer<'a, S> {
    /// Prepares `policy` for the frames of `source`.
    ///
    /// # Errors
    /// A value of the policy out of range, blocks that do not fit the tiles, a trace without samples.
    pub fn new<P: SamplePolicy + ?Sized>(source: &'a S, policy: &P, options: Options) -> Result<Self> {
        let meta = source.meta();
        let (width, height) = meta.grid();
        if width == 0 || height == 0 || meta.tile == 0 {
            return Err(RequestError::Nothing { what: "the sample grid of the trace is empty" }.into());
        }
        let (sampler, comparer) = (policy.sampler(meta)?, Comparer::new(meta, options.perception));
        Ok(Self { source, sampler, options, comparer, stop: Stop::never(), caches: KeptCaches::default() })
    }

    /// Looks at `stop` before each tile that it reads or hands to a machine, and ends the frame with
    /// [`ReplayError::Interrupted`] once that is requested.
    #[must_use]
    pub fn with_stop(mut self, stop: Stop) -> Self {
        self.stop = stop;
        self
    }

    /// What is replayed.
    pub fn source(&self) -> &'a S {
        self.source
    }

    /// Replays frame `frame`.
    ///
    /// # Errors
    /// A frame that the trace does not hold, or that cannot be read; [`ReplayError::Interrupted`].
    pub fn frame(&mut self, frame: u32) -> Result<FrameReplay> {
        let (source, camera) = (self.source, self.camera(frame)?);
        let mut canvas = self.canvas(true);
        let read = |index| Ok(PackedTile { tile: source.shared_tile(frame, index)?, packed: None });
        let reader = Reader { source, camera: &camera, frame, read, keep: false, stop: &self.stop };
        bands(&reader, &mut *self.sampler, |closed| {
            canvas.add(&closed.band.tiles, closed.stats);
            Ok(())
        })?;
        self.finish(PassedFrame::new(frame, canvas, PathCounts::default()))
    }

    /// What a frame is put together on; `first` of those who share one picture of `full`, if it is wanted.
    pub(super) fn canvas(&self, first: bool) -> Canvas {
        Canvas::new(self.source.meta(), self.options.reference && first, self.options.traced)
    }

    /// The camera of a frame that is about to begin.
    pub(super) fn camera(&self, frame: u32) -> Result<Camera> {
        self.stop.check()?;
        let meta = self.source.meta();
        if !meta.frame_numbers().contains(&frame) {
            let (first, last) = (meta.first_frame, meta.first_frame + meta.frames.saturating_sub(1));
            return Err(RequestError::NoSuchFrame { frame, first, last }.into());
        }
        self.source.camera(frame).map_err(|e| ReplayError::Trace {
            what: "the camera".into(),
            frame,
            source: Box::new(e),
        })
    }

    /// How many rays each tile of a frame has.
    pub(crate) fn ray_counts(&self, frame: u32) -> Result<Vec<u64>> {
        self.camera(frame)?;
        let count = |index| {
            self.stop.check()?;
            self.source.ray_count(frame, index).map_err(|e| ReplayError::tile((frame, index), e))
        };
        // The first tile that cannot be read tells, whichever thread finds it first.
        let counts: Vec<_> = (0..self.source.meta().tile_count()).into_par_iter().map(count).collect();
        counts.into_iter().collect()
    }

    /// Ends a frame.
    pub(crate) fn finish(&mut self, PassedFrame { frame, canvas, .. }: PassedFrame) -> Result<FrameReplay> {
        self.sampler.end_frame(&canvas.tiles);
        let meta = self.source.meta();
        let blocks = (0..meta.tile_count()).map(|tile| self.sampler.block(tile)).collect();
        canvas.finish(frame, Blocks::new(blocks, meta), &mut self.comparer)
    }
}

impl<S: PathSource + ?Sized> Replayer<'_, S> {
    /// Replays frame `frame` and gives its tiles to `consume` as work for a machine, in tile order. `tree` is the source's
    /// topology. Later tiles are read, decided and made work of in the background meanwhile, some rows of tiles ahead as long
    /// as their work is small. Gives also what the paths of all tiles ask for, to be compared with what a machine did.
    ///
    /// # Errors
    /// As [`Replayer::frame`]; a path that does not lead through the tree; and what `consume` returns, after which it is not
    /// called again.
    pub fn frame_with(
        &mut self,
        frame: u32,
        tree: &Topology,
        consume: impl FnMut(TileWork) -> Result<()>,
    ) -> Result<(FrameReplay, PathCounts)> {
        let passed = self.pass(frame, tree, consume)?;
        let paths = passed.paths;
        Ok((self.finish(passed)?, paths))
    }

    /// As [`Replayer::frame_with`], without the end of the frame.
    pub(crate) fn pass(
        &mut self,
        frame: u32,
        tree: &Topology,
        mut consume: impl FnMut(TileWork) -> Result<()>,
    ) -> Result<PassedFrame> {
        let (source, camera) = (self.source, self.camera(frame)?);
        let mut canvas = self.canvas(true);
        let read = |index| source.packed_tile(frame, index);
        let (stop, sampler) = (&self.stop, &mut *self.sampler);
        let reader = Reader { source, camera: &camera, frame, read, keep: true, stop };
        let samples_a_pixel = source.meta().samples.pow(2);
        let builder = Builder { source, tree, samples_a_pixel };
        let produce = |output: &Output<'_, Built>| {
            let mut above = None;
            bands(&reader, sampler, |Closed { sampler, band, stats, below }| {
                canvas.add(&band.tiles, stats);
                let adjacent = AdjacentBands { below, above: above.take() };
                above = Some(band.work(&builder, sampler, adjacent, |tile| output.put(tile))?);
                Ok(())
            })
        };
        let mut paths = PathCounts::default();
        ahead(BYTES_AHEAD, produce, |tile| {
            stop.check()?;
            paths += tile.paths;
            consume(tile.work)
        })?;
        Ok(PassedFrame::new(frame, canvas, paths))
    }

    /// What the policy reads of hits.
    pub fn reads(&self) -> PolicyReads {
        self.sampler.reads()
    }

    /// What the policy has learnt so far, to begin a frame again; nothing if it cannot be kept.
    pub(crate) fn fork(&self) -> Option<Box<dyn Sampler>> {
        self.sampler.fork()
    }

    /// Goes back to the beginning of a frame.
    pub(crate) fn restore(&mut self, begin: &dyn Sampler) {
        if let Some(begin) = begin.fork() {
            self.sampler = begin;
        }
    }

    /// What ends frames early.
    pub(crate) fn stop(&self) -> &Stop {
        &self.stop
    }
}

/// A frame whose tiles are all through, but which has not ended.
pub(crate) struct PassedFrame {
    frame: u32,
    canvas: Canvas,
    /// What the paths of all tiles ask for.
    pub paths: PathCounts,
}

impl PassedFrame {
    /// A frame on its canvas, and what the paths of its tiles ask for.
    pub(super) fn new(frame: u32, canvas: Canvas, paths: PathCounts) -> Self {
        Self { frame, canvas, paths }
    }
}

/// A band whose samples are all decided.
pub(super) struct Closed<'a> {
    pub sampler: &'a dyn Sampler,
    pub band: Band,
    pub stats: Vec<TileStats>,
    /// The next band, already open.
    pub below: Option<&'a Band>,
}

/// What comes after a row of tiles.
pub(super) enum Row {
    /// This row.
    Next(u32),
    /// The end of the frame.
    End,
}

/// Opens the bands of a frame top to bottom, closes each as soon as the one below it is open, and gives it to `give`. What a
/// band was like may change how the sampler treats those that are not open yet: the one after the next and on.
fn bands<S, R>(
    reader: &Reader<'_, S, R>,
    sampler: &mut dyn Sampler,
    mut give: impl FnMut(Closed<'_>) -> Result<()>,
) -> Result<()>
where
    S: TileSource + ?Sized,
    R: Fn(u32) -> rayreel_formats::Result<PackedTile> + Sync,
{
    sampler.begin_frame(reader.frame, reader.camera);
    let mut above: Option<Band> = None;
    let rows = (0..reader.source.meta().tile_grid().1).map(Row::Next);
    rows.chain([Row::End]).try_for_each(|row| next_row(reader, sampler, &mut above, row, &mut give))
}

/// One step of [`bands`]: opens the next row, if there is one, and closes the row above it.
pub(super) fn next_row<S, R>(
    reader: &Reader<'_, S, R>,
    sampler: &mut dyn Sampler,
    above: &mut Option<Band>,
    row: Row,
    give: &mut impl FnMut(Closed<'_>) -> Result<()>,
) -> Result<()>
where
    S: TileSource + ?Sized,
    R: Fn(u32) -> rayreel_formats::Result<PackedTile> + Sync,
{
    let open = match row {
        Row::Next(row) => Some(Band::open(reader, sampler, row)?),
        Row::End => None,
    };
    let closing = std::mem::replace(above, open);
    let Some(mut band) = closing else { return Ok(()) };
    let below = above.as_ref();
    let stats = band.close(sampler, reader.frame, below)?;
    sampler.end_row(&stats);
    sampler.keep(&band.tiles);
    give(Closed { sampler, band, stats, below })
}
