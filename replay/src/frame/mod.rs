//! The replay of frames: tiles in, picture and counts out.
//!
//! Tiles are read and decided in parallel, but everything is put together in tile order, and floats are never summed across
//! threads: the result is the same for any number of them.

mod band;
pub mod counts;
pub mod states;

use rayreel_formats::scene::Camera;
use rayreel_formats::tile::Tile;

use crate::error::{ReplayError, Result};
use crate::image::Image;
use crate::image::compare::Comparer;
use crate::image::flip::FlipMap;
use crate::image::resolve::Resolver;
use crate::policy::Policy;
use crate::policy::adaptive::Rules;
use crate::policy::rate::{Pacer, Rates};
use crate::source::{PathSource, TileSource};
use crate::stop::Stop;
use crate::work::build::{Builder, Built};
use crate::work::stream::{Output, ahead};
use band::{Band, How, Nearby, Reader};
use counts::{FrameStats, TileStats};
use rayreel_machine::work::TileWork;
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::topology::Topology;
use states::{Blocks, StateMap};

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
}

impl Default for Options {
    fn default() -> Self {
        Self { reference: true, perception: true }
    }
}

/// A replayed frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameReplay {
    /// Frame number.
    pub frame: u32,
    /// The policy's picture, linear RGB.
    pub image: Image,
    /// The picture of `full`, if it was asked for.
    pub reference: Option<Image>,
    /// Where a viewer sees that they differ, if they were compared so.
    pub flip: Option<FlipMap>,
    /// What became of each sample.
    pub states: StateMap,
    /// Block edge of each tile in samples; 1 for `full`.
    pub blocks: Blocks,
    /// Counts and quality.
    pub stats: FrameStats,
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

/// Replays one frame after the other. Frames are given to it in order: a policy may come to depend on the frame before.
pub struct Replayer<'a, S: ?Sized> {
    source: &'a S,
    rules: Rules,
    pacer: Pacer,
    options: Options,
    comparer: Comparer,
    stop: Stop,
}

impl<'a, S: TileSource + ?Sized> Replayer<'a, S> {
    /// Prepares `policy` for the frames of `source`.
    ///
    /// # Errors
    /// A value of the policy out of range, blocks that do not fit the tiles, a trace without samples.
    pub fn new(source: &'a S, policy: &Policy, options: Options) -> Result<Self> {
        let meta = source.meta();
        let (width, height) = meta.grid();
        if width == 0 || height == 0 || meta.tile == 0 {
            return Err(ReplayError::Nothing { what: "the sample grid of the trace is empty" });
        }
        let rules = Rules::new(policy, meta)?;
        check_tile(meta.tile, &Pacer::blocks(policy))?;
        let pacer = Pacer::new(policy, meta);
        Ok(Self {
            source,
            rules,
            pacer,
            options,
            comparer: Comparer::new(meta, options.perception),
            stop: Stop::never(),
        })
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
        let (source, rules, camera) = (self.source, &self.rules, self.camera(frame)?);
        let mut canvas = Canvas::new(source, self.options);
        let read = |index| source.tile(frame, index);
        let mut rates = self.pacer.rates(frame, &camera);
        let reader = Reader { source, camera: &camera, frame, read, keep: false, stop: &self.stop };
        bands(&reader, rules, &mut rates, |closed| {
            canvas.add(&closed.band, closed.stats);
            Ok(())
        })?;
        self.pacer.learn(frame, &camera, &rates, &canvas.tiles);
        canvas.finish(frame, Blocks::new(rates.blocks(), source.meta()), &mut self.comparer)
    }

    fn camera(&self, frame: u32) -> Result<Camera> {
        self.stop.check()?;
        let meta = self.source.meta();
        if !meta.frame_numbers().contains(&frame) {
            let (first, last) = (meta.first_frame, meta.first_frame + meta.frames.saturating_sub(1));
            return Err(ReplayError::NoSuchFrame { frame, first, last });
        }
        self.source.camera(frame).map_err(|e| ReplayError::Trace {
            what: "the camera".into(),
            frame,
            source: Box::new(e),
        })
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
        mut consume: impl FnMut(TileWork) -> Result<()>,
    ) -> Result<(FrameReplay, PathCounts)> {
        let (source, rules, camera) = (self.source, &self.rules, self.camera(frame)?);
        let mut canvas = Canvas::new(source, self.options);
        let read = |index| source.tile_with_paths(frame, index);
        let mut rates = self.pacer.rates(frame, &camera);
        let reader = Reader { source, camera: &camera, frame, read, keep: true, stop: &self.stop };
        let builder = Builder { source, tree };
        let produce = |output: &Output<'_, Built>| {
            let mut above = false;
            bands(&reader, rules, &mut rates, |Closed { how, band, stats, below }| {
                canvas.add(&band, stats);
                band.work(&builder, how, &Nearby { below, above }, |tile| output.put(tile))?;
                above = true;
                Ok(())
            })
        };
        let (stop, mut paths) = (&self.stop, PathCounts::default());
        ahead(BYTES_AHEAD, produce, |tile| {
            stop.check()?;
            paths += tile.paths;
            consume(tile.work)
        })?;
        self.pacer.learn(frame, &camera, &rates, &canvas.tiles);
        Ok((canvas.finish(frame, Blocks::new(rates.blocks(), source.meta()), &mut self.comparer)?, paths))
    }
}

/// A band whose samples are all decided.
struct Closed<'a> {
    how: How<'a>,
    band: Band,
    stats: Vec<TileStats>,
    /// The next band, already open.
    below: Option<&'a Band>,
}

/// Opens the bands of a frame top to bottom, closes each as soon as the one below it is open, and gives it to `give`. What a
/// band was like may change the rates of those that are not open yet: of the one after the next.
fn bands<S, R>(
    reader: &Reader<'_, S, R>,
    rules: &Rules,
    rates: &mut Rates,
    mut give: impl FnMut(Closed<'_>) -> Result<()>,
) -> Result<()>
where
    S: TileSource + ?Sized,
    R: Fn(u32) -> rayreel_formats::Result<Tile> + Sync,
{
    let mut close = |rates: &mut Rates, mut band: Band, below: Option<&Band>| {
        let stats = band.close(How { rules, rates }, reader.frame, below);
        rates.finished(&stats);
        give(Closed { how: How { rules, rates }, band, stats, below })
    };
    let mut above: Option<Band> = None;
    for row in 0..reader.source.meta().tile_grid().1 {
        let band = Band::open(reader, How { rules, rates }, row)?;
        if let Some(above) = above.take() {
            close(rates, above, Some(&band))?;
        }
        above = Some(band);
    }
    above.map_or(Ok(()), |last| close(rates, last, None))
}

/// Replays `frames` and keeps them all.
///
/// # Errors
/// As [`Replayer::new`] and [`Replayer::frame`].
pub fn replay<S: TileSource + ?Sized>(
    source: &S,
    policy: &Policy,
    frames: impl IntoIterator<Item = u32>,
    options: Options,
) -> Result<Replay> {
    let mut kept = Vec::new();
    replay_each(source, policy, frames, options, |frame| {
        kept.push(frame);
        Ok(())
    })?;
    Ok(Replay { frames: kept })
}

/// Replays `frames` one by one, gives each to `sink` and keeps only its statistics.
///
/// # Errors
/// As [`Replayer::new`] and [`Replayer::frame`], and what `sink` returns.
pub fn replay_each<S: TileSource + ?Sized>(
    source: &S,
    policy: &Policy,
    frames: impl IntoIterator<Item = u32>,
    options: Options,
    mut sink: impl FnMut(FrameReplay) -> Result<()>,
) -> Result<Vec<FrameStats>> {
    let mut replayer = Replayer::new(source, policy, options)?;
    let mut stats = Vec::new();
    for number in frames {
        let frame = replayer.frame(number)?;
        stats.push(frame.stats.clone());
        sink(frame)?;
    }
    if stats.is_empty() {
        return Err(ReplayError::Nothing { what: "no frame was chosen" });
    }
    Ok(stats)
}

/// Tiles must begin at R-samples of every block that they may have.
fn check_tile(tile: u32, blocks: &[u32]) -> Result<()> {
    let Some(&block) = blocks.iter().find(|b| !tile.is_multiple_of(**b)) else { return Ok(()) };
    let fit = |b: &u32| tile.is_multiple_of(*b);
    let blocks: Vec<_> = [2, 3, 4, 8, 16].into_iter().filter(fit).map(|b| b.to_string()).collect();
    let below = tile / block * block;
    let tiles: Vec<_> = [below, below + block].into_iter().filter(|&t| t > 0).map(|t| t.to_string()).collect();
    let blocks = if blocks.is_empty() { "none does".into() } else { blocks.join(", ") };
    Err(ReplayError::TileSize { tile, block, blocks, tiles: tiles.join(" or ") })
}

/// A frame that is being put together.
struct Canvas {
    image: Resolver,
    reference: Option<Resolver>,
    states: StateMap,
    tiles: Vec<TileStats>,
}

impl Canvas {
    fn new<S: TileSource + ?Sized>(source: &S, options: Options) -> Self {
        let meta = source.meta();
        let resolver = || Resolver::new(meta.width, meta.height, meta.samples);
        Self {
            image: resolver(),
            reference: options.reference.then(resolver),
            states: StateMap::new(meta.grid()),
            tiles: Vec::new(),
        }
    }

    /// Takes over a decided band; bands come top to bottom.
    fn add(&mut self, band: &Band, stats: Vec<TileStats>) {
        let rows = band.tiles.first().map_or(0..0, |t| t.rect().y..t.rect().y + t.rect().height);
        for y in rows {
            for view in &band.tiles {
                let rect = view.rect();
                for x in rect.x..rect.x + rect.width {
                    self.image.add(x, y, view.tree(x, y)[0].colour);
                    if let Some(state) = view.state(x, y) {
                        self.states.set(x, y, state);
                    }
                }
                if let Some(reference) = &mut self.reference {
                    (rect.x..).zip(view.recorded_row(y)).for_each(|(x, colour)| reference.add(x, y, colour));
                }
            }
        }
        self.tiles.extend(stats);
    }

    fn finish(self, frame: u32, blocks: Blocks, comparer: &mut Comparer) -> Result<FrameReplay> {
        let image = self.image.finish();
        let reference = self.reference.map(Resolver::finish);
        let compared = reference.as_ref().map(|full| comparer.compare(frame, &image, full)).transpose()?;
        let counts = self.tiles.iter().map(|t| t.counts).sum();
        let (quality, tile_errors, flip) = match compared {
            Some(found) => (Some(found.quality), found.tiles, found.flip),
            None => (None, Vec::new(), None),
        };
        let stats = FrameStats { frame, counts, tiles: self.tiles, quality, tile_errors };
        Ok(FrameReplay { frame, image, reference, flip, states: self.states, blocks, stats })
    }
}
