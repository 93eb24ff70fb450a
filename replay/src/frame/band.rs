//! A row of tiles: the unit in which a frame passes through memory.
//!
//! A band is read, its R-samples traced and its X step made; then the band above can make its Y step, whose closing row is
//! now known, and leave. So two bands are held at a time, whatever the height of the frame.

use rayon::prelude::*;
use rayreel_formats::scene::Camera;
use rayreel_formats::tile::Tile;

use super::counts::{Counts, RayCounts, TileStats};
use crate::error::{ReplayError, Result};
use crate::image::psnr::SquaredError;
use crate::policy::Apron;
use crate::policy::adaptive::{Rules, TileRules};
use crate::policy::rate::Rates;
use crate::policy::tree::Forest;
use crate::policy::view::{SampleState, TileView};
use crate::source::{PathSource, TileSource};
use crate::stop::Stop;
use crate::work::build::{Builder, Built, Part};

/// The tiles of one row, left to right.
pub(super) struct Band {
    pub tiles: Vec<TileView>,
    /// What was recorded of each tile, if a machine wants its paths; else empty.
    recorded: Vec<Tile>,
}

/// How the tiles of a frame are sampled.
#[derive(Clone, Copy)]
pub(super) struct How<'a> {
    pub rules: &'a Rules,
    pub rates: &'a Rates,
}

impl<'a> How<'a> {
    /// The rules for a tile.
    pub fn tile(&self, view: &TileView) -> TileRules<'a> {
        self.rules.tile(self.rates.tile(view.index()))
    }
}

/// A source of tiles, with or without paths.
pub(super) struct Reader<'a, S: ?Sized, R> {
    pub source: &'a S,
    pub camera: &'a Camera,
    pub frame: u32,
    /// Reads a tile of the frame.
    pub read: R,
    /// The tiles are kept for a machine.
    pub keep: bool,
    /// Looked at before each tile.
    pub stop: &'a Stop,
}

/// The other bands that a band needs to become work.
pub(super) struct Nearby<'a> {
    pub below: Option<&'a Band>,
    /// There is a band above.
    pub above: bool,
}

impl Band {
    /// Reads tile row `row` and decides all its samples on R-rows.
    pub fn open<S, R>(reader: &Reader<'_, S, R>, how: How<'_>, row: u32) -> Result<Self>
    where
        S: TileSource + ?Sized,
        R: Fn(u32) -> rayreel_formats::Result<Tile> + Sync,
    {
        let &Reader { source, camera, frame, keep, stop, .. } = reader;
        let columns = source.meta().tile_grid().0;
        let read = |index| -> Result<(TileView, Forest, Option<Tile>)> {
            stop.check()?;
            let tile = (reader.read)(index).map_err(|e| ReplayError::Trace {
                what: format!("tile {index}"),
                frame,
                source: Box::new(e),
            })?;
            let mut view = TileView::new(source, camera, (frame, index), &tile, how.rules.deep())?;
            let rules = how.tile(&view);
            rules.trace_references(&mut view);
            let first = rules.first_column(&view);
            Ok((view, first, keep.then_some(tile)))
        };
        // Collected one by one before errors are looked at, so that the first tile's error is reported on any machine.
        let results: Vec<_> = (row * columns..(row + 1) * columns).into_par_iter().map(read).collect();
        let (mut tiles, mut borders, mut recorded) = (Vec::new(), Vec::new(), Vec::new());
        for (view, first, tile) in results.into_iter().collect::<Result<Vec<_>>>()? {
            tiles.push(view);
            borders.push(first);
            recorded.extend(tile);
        }
        tiles.par_iter_mut().enumerate().for_each(|(i, view)| {
            how.tile(view).step_x(view, borders.get(i + 1));
        });
        Ok(Self { tiles, recorded })
    }

    /// Decides the other samples; `below` is the next band, already open.
    pub fn close(&mut self, how: How<'_>, frame: u32, below: Option<&Self>) -> Vec<TileStats> {
        let decided = self.tiles.par_iter_mut().enumerate().map(|(i, view)| {
            let closing = below.map(|band| TileRules::first_row(&band.tiles[i]));
            how.tile(view).step_y(view, closing.as_ref());
            how.rules.audit.map(|audit| audit.run(view, frame)).unwrap_or_default()
        });
        let audits: Vec<_> = decided.collect();
        audits.into_par_iter().enumerate().map(|(i, audited)| self.stats(how, below, i, audited)).collect()
    }

    fn stats(&self, how: How<'_>, below: Option<&Self>, i: usize, audited: SquaredError) -> TileStats {
        let view = &self.tiles[i];
        let rect = view.rect();
        let mut counts =
            Counts { samples_full: rect.len() as u64, rays_full: view.recorded_rays(), ..Counts::default() };
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                count(&mut counts, view, x, y);
            }
        }
        if how.rules.apron == Apron::Retrace {
            for rays in self.apron(how, below, i) {
                counts.samples_apron += 1;
                counts.rays_apron += rays;
            }
        }
        TileStats { tile: view.index(), counts, audited, factor: how.rates.tile(view.index()).relax }
    }

    /// The rays of the samples outside tile `i` that its steps read as traced.
    fn apron(&self, how: How<'_>, below: Option<&Self>, i: usize) -> Vec<RayCounts> {
        let outside = self.outside(how, below, i);
        let rays = |(band, j, samples): (&Self, usize, Vec<(u32, u32)>)| -> Vec<RayCounts> {
            samples.into_iter().filter_map(|(x, y)| band.tiles[j].traced_rays(x, y)).collect()
        };
        outside.into_iter().flat_map(rays).collect()
    }

    /// The samples outside tile `i` that its steps read, with the band and tile that they are in: the R-rows of the closing
    /// column, the closing row, and the corner of both.
    fn outside<'a>(&'a self, how: How<'_>, below: Option<&'a Self>, i: usize) -> Vec<Outside<'a>> {
        let rect = self.tiles[i].rect();
        let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
        let mut list = Vec::new();
        if i + 1 < self.tiles.len() {
            list.push((
                self,
                i + 1,
                how.tile(&self.tiles[i]).lattice.rows(rect.y, bottom).map(|y| (right, y)).collect(),
            ));
        }
        if let Some(band) = below {
            list.push((band, i, (rect.x..right).map(|x| (x, bottom)).collect()));
            if i + 1 < band.tiles.len() {
                list.push((band, i + 1, vec![(right, bottom)]));
            }
        }
        list
    }

    /// Gives the tiles to `put` as work for a machine, left to right. The band must be closed. Few are in memory at a time: the
    /// operations of a tile are many times what was recorded of it.
    ///
    /// # Errors
    /// A path that does not lead through the tree; what `put` returns. The tiles before have been given then.
    pub fn work<S>(
        &self,
        builder: &Builder<'_, S>,
        how: How<'_>,
        nearby: &Nearby<'_>,
        mut put: impl FnMut(Built) -> Result<()>,
    ) -> Result<()>
    where
        S: PathSource + ?Sized,
    {
        let build = |i: usize| {
            let (view, tile) = (&self.tiles[i], &self.recorded[i]);
            let border = border_samples(how, view, (i > 0, nearby.above));
            builder.own(view, tile)?.join(self.apron_part(builder, how, nearby.below, i)?, tile, border)
        };
        let (count, group) = (self.recorded.len(), rayon::current_num_threads());
        for first in (0..count).step_by(group) {
            let built: Vec<_> = (first..count.min(first + group)).into_par_iter().map(build).collect();
            built.into_iter().try_for_each(|tile| put(tile?))?;
        }
        Ok(())
    }

    /// What tile `i` does for its apron: nothing if that is shared. The closing row repeats its X step.
    fn apron_part<S>(&self, builder: &Builder<'_, S>, how: How<'_>, below: Option<&Self>, i: usize) -> Result<Part>
    where
        S: PathSource + ?Sized,
    {
        let mut part = Part::default();
        if how.rules.apron == Apron::Retrace {
            for (band, j, samples) in self.outside(how, below, i) {
                builder.apron(&mut part, &band.tiles[j], &band.recorded[j], &samples)?;
            }
            if let Some(band) = below {
                part.count(band.tiles[i].first_row_waves());
            }
        }
        Ok(part)
    }
}

/// Samples of one tile: its band, its place in that, and the samples.
type Outside<'a> = (&'a Band, usize, Vec<(u32, u32)>);

/// How many samples of a tile are read by the tiles to its `left` and `above`: in its first column those on its neighbour's
/// R-rows, and its whole first row. None if each tile traces them again, or if blocks of one sample leave nothing to test.
fn border_samples(how: How<'_>, view: &TileView, (left, above): (bool, bool)) -> u32 {
    let rules = how.tile(view);
    if how.rules.apron == Apron::Retrace || rules.lattice.block == 1 {
        return 0;
    }
    let rect = view.rect();
    let column = if left { rules.left.rows(rect.y, rect.y + rect.height).count() as u32 } else { 0 };
    let row = if above { rect.width } else { 0 };
    // The corner is in both.
    column + row - u32::from(left && above)
}

fn count(counts: &mut Counts, view: &TileView, x: u32, y: u32) {
    counts.rays_traced += view.traced_rays(x, y).unwrap_or_default();
    match view.state(x, y) {
        Some((SampleState::Reference, _)) => {
            counts.samples_reference += 1;
            counts.samples_traced += 1;
        }
        Some((SampleState::Traced, _)) => counts.samples_traced += 1,
        Some((SampleState::Partial, _)) => {
            counts.samples_partial += 1;
            counts.samples_traced += 1;
        }
        Some((SampleState::Interpolated, _)) => counts.samples_interpolated += 1,
        None => unreachable!("the steps of a policy decide every sample"),
    }
}
