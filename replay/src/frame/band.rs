//! A row of tiles: the unit in which a frame passes through memory.
//!
//! A band is read, its R-samples traced and its X step made; then the band above can make its Y step, whose closing row is
//! now known, and leave. So two bands are held at a time, whatever the height of the frame.

use rayon::prelude::*;
use rayreel_formats::scene::Camera;

use crate::counts::{Counts, RayCounts, TileStats};
use crate::error::{ReplayError, Result};
use crate::policy::tree::Forest;
use crate::policy::view::{Closer, SampleState, TileView};
use crate::policy::{Apron, Sampler};
use crate::source::{PackedTile, PathSource, TileSource};
use crate::stop::Stop;
use crate::work::build::Builder;
use crate::work::part::{Borders, Built, Closes, Part, Parts};
use crate::work::recorded::RecordedTile;

/// The tiles of one row, left to right.
pub(super) struct Band {
    pub tiles: Vec<TileView>,
    /// What was recorded of each tile, if a machine wants its paths; else empty.
    recorded: Vec<RecordedTile>,
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
pub(super) struct AdjacentBands<'a> {
    pub below: Option<&'a Band>,
    /// What is left to do of the band above, if there is one.
    pub above: Option<LeftOver>,
}

/// What is left to do of a band whose tiles became work.
pub(super) struct LeftOver(Vec<LastRows>);

/// What is left to do of a tile.
#[derive(Default)]
struct LastRows {
    /// What the tile below does.
    straight: Part,
    /// What the tile to the right of that does.
    across: Part,
    /// Rounds of its X step.
    x_rounds: u32,
}

/// A tile that has begun: its view, what it shares with the tile to its left, and what was recorded of it if that is kept.
type Begun = (TileView, Option<Forest>, Option<RecordedTile>);

impl<S, R> Reader<'_, S, R>
where
    S: TileSource + ?Sized,
    R: Fn(u32) -> rayreel_formats::Result<PackedTile> + Sync,
{
    /// Reads tile `index` and lets the sampler begin it.
    fn begin(&self, sampler: &dyn Sampler, index: u32) -> Result<Begun> {
        self.stop.check()?;
        let read = (self.read)(index).map_err(|e| ReplayError::tile((self.frame, index), e))?;
        let mut view = TileView::new(self.source, self.camera, (self.frame, index), &read.tile, sampler.deep())?;
        self.divide(sampler, &mut view);
        sampler.begin_tile(&mut view);
        let (rows, x) = (sampler.shared_rows(&view), view.rect().x);
        let shared = (!rows.is_empty()).then(|| forest(&view, rows.into_iter().map(|y| (x, y))));
        Ok((view, shared, self.keep.then(|| RecordedTile::new(read))))
    }

    /// Tells the view which of its columns and rows wait for neighbours: none where there is no neighbour, or where the tile
    /// traces for itself what it needs of them.
    fn divide(&self, sampler: &dyn Sampler, view: &mut TileView) {
        if sampler.apron() == Apron::Share {
            let (columns, rows) = self.source.meta().tile_grid();
            let (column, row) = sampler.waiting_from(view);
            let has_right = view.index() % columns + 1 < columns;
            let has_below = view.index() / columns + 1 < rows;
            let from = (if has_right { column } else { u32::MAX }, if has_below { row } else { u32::MAX });
            view.wait_from(from, sampler.shares_corner());
        }
    }
}

impl Band {
    /// Reads tile row `row` and lets the sampler take its first two looks at the tiles.
    pub fn open<S, R>(reader: &Reader<'_, S, R>, sampler: &dyn Sampler, row: u32) -> Result<Self>
    where
        S: TileSource + ?Sized,
        R: Fn(u32) -> rayreel_formats::Result<PackedTile> + Sync,
    {
        let columns = reader.source.meta().tile_grid().0;
        // Collected one by one before errors are looked at, so that the first tile's error is reported on any machine.
        let begun: Vec<_> =
            (row * columns..(row + 1) * columns).into_par_iter().map(|index| reader.begin(sampler, index)).collect();
        let (mut tiles, mut borders, mut recorded) = (Vec::new(), Vec::new(), Vec::new());
        for (view, shared, tile) in begun.into_iter().collect::<Result<Vec<_>>>()? {
            tiles.push(view);
            borders.push(shared);
            recorded.extend(tile);
        }
        tiles.par_iter_mut().enumerate().for_each(|(i, view)| {
            sampler.step_x(view, borders.get(i + 1).and_then(Option::as_ref));
            // Of cells only R-samples are read, so nobody waits for the end of this step.
            if !sampler.shares_corner() {
                view.end_step_x();
            }
        });
        Ok(Self { tiles, recorded })
    }

    /// Lets the sampler decide the other samples; `below` is the next band, already open.
    ///
    /// # Errors
    /// When it left a sample undecided.
    pub fn close(&mut self, sampler: &dyn Sampler, frame: u32, below: Option<&Self>) -> Result<Vec<TileStats>> {
        let corners: Vec<_> = (0..self.tiles.len()).map(|i| self.corners(sampler, below, i)).collect();
        self.tiles.par_iter_mut().zip(corners).enumerate().for_each(|(i, (view, corners))| {
            let closing = below.and_then(|band| closing_row(sampler, &band.tiles[i], corners));
            sampler.step_y(view, closing.as_ref());
        });
        let stats: Vec<_> =
            (0..self.tiles.len()).into_par_iter().map(|i| self.stats(sampler, frame, below, i)).collect();
        stats.into_iter().collect()
    }

    /// The last sample that the tile to the right of tile `i` shares and the first of the tile below that, for a sampler that
    /// reads them.
    fn corners(&self, sampler: &dyn Sampler, below: Option<&Self>, i: usize) -> Forest {
        let mut corners = Forest::default();
        let both = below.and_then(|band| band.tiles.get(i + 1)).zip(self.tiles.get(i + 1));
        if let Some((across, right)) = both.filter(|_| sampler.shares_corner()) {
            let (at, first) = (right.rect(), across.rect());
            let last = sampler.shared_rows(right).last().copied();
            last.into_iter().for_each(|y| corners.push(right.tree(at.x, y)));
            corners.push(across.tree(first.x, first.y));
        }
        corners
    }

    fn stats(&self, sampler: &dyn Sampler, frame: u32, below: Option<&Self>, i: usize) -> Result<TileStats> {
        let view = &self.tiles[i];
        let (tile, samples_full) = (view.index(), view.rect().len() as u64);
        let mut counts = Counts { samples_full, rays_full: view.recorded_rays(), ..Counts::default() };
        for (x, y) in view.samples() {
            count(&mut counts, view, (x, y)).ok_or_else(|| ReplayError::Usage {
                detail: format!("the policy left sample ({x}, {y}) of tile {tile} of frame {frame} undecided"),
            })?;
        }
        if sampler.apron() == Apron::Retrace {
            for rays in self.apron(sampler, below, i) {
                counts.samples_apron += 1;
                counts.rays_apron += rays;
            }
        }
        Ok(TileStats { tile, counts, audited: view.audits(), factor: sampler.factor(tile) })
    }

    /// The rays of the samples outside tile `i` that its steps read as traced.
    fn apron(&self, sampler: &dyn Sampler, below: Option<&Self>, i: usize) -> Vec<RayCounts> {
        let rays = |OutsideSamples { band, tile, samples }: OutsideSamples<'_>| -> Vec<RayCounts> {
            samples.into_iter().filter_map(|(x, y)| band.tiles[tile].traced_rays(x, y)).collect()
        };
        self.outside(sampler, below, i).into_iter().flat_map(rays).collect()
    }

    /// The samples outside tile `i` that its steps read: the shared rows of the closing column, the closing row, and the
    /// corner of both.
    fn outside<'a>(&'a self, sampler: &dyn Sampler, below: Option<&'a Self>, i: usize) -> Vec<OutsideSamples<'a>> {
        let rect = self.tiles[i].rect();
        let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
        let mut list = Vec::new();
        if let Some(next) = self.tiles.get(i + 1) {
            let samples = sampler.shared_rows(next).into_iter().map(|y| (right, y)).collect();
            list.push(OutsideSamples { band: self, tile: i + 1, samples });
        }
        if let Some(band) = below.filter(|_| sampler.shares_first_row()) {
            let row = sampler.shared_columns(&band.tiles[i]).into_iter().map(|x| (x, bottom)).collect();
            list.push(OutsideSamples { band, tile: i, samples: row });
            if i + 1 < band.tiles.len() {
                list.push(OutsideSamples { band, tile: i + 1, samples: vec![(right, bottom)] });
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
        sampler: &dyn Sampler,
        AdjacentBands { below, above }: AdjacentBands<'_>,
        mut put: impl FnMut(Built) -> Result<()>,
    ) -> Result<LeftOver>
    where
        S: PathSource + ?Sized,
    {
        let build = |i: usize| -> Result<(Parts, Part)> {
            let (view, recorded) = (&self.tiles[i], &self.recorded[i]);
            let keep = sampler.apron() == Apron::Retrace;
            let parts = recorded.with_paths(builder.source, keep, |paths| builder.tile(view, &recorded.tile, paths))?;
            Ok((parts, self.apron_part(builder, sampler, below, i)?))
        };
        let is_first = above.is_none();
        let mut above = above.map_or_else(Vec::new, |LeftOver(parts)| parts);
        let (mut left, mut beside, mut left_over) = (Part::default(), LastRows::default(), Vec::new());
        let (count, group) = (self.recorded.len(), rayon::current_num_threads());
        for first in (0..count).step_by(group) {
            let built: Vec<_> = (first..count.min(first + group)).into_par_iter().map(build).collect();
            for (i, parts) in (first..).zip(built) {
                let (mut parts, apron) = parts?;
                let mut rows = above.get_mut(i).map(std::mem::take).unwrap_or_default();
                let above_rounds = rows.x_rounds.max(beside.x_rounds);
                let above = [std::mem::take(&mut rows.straight), std::mem::take(&mut beside.across)];
                beside = rows;
                let right = parts.take(Closer::Right);
                let closes = Closes { left: std::mem::replace(&mut left, right), above, above_rounds };
                let borders = self.borders(sampler, i, (is_first, below.is_none()));
                left_over.push(last_rows(&mut parts, &self.tiles[i], below.map(|band| &band.tiles[i])));
                let history = |places: &[u32]| sampler.history(&self.tiles[i], places);
                put(parts.take(Closer::Itself).join(closes, apron, &self.recorded[i].tile, (borders, history))?)?;
            }
        }
        Ok(LeftOver(left_over))
    }

    /// What tile `i` exchanges with its neighbours: nothing if each tile traces again what it reads. The band may be the first
    /// of the frame, or the last.
    fn borders(&self, sampler: &dyn Sampler, i: usize, (is_first, is_last): (bool, bool)) -> Borders {
        let columns = self.tiles.len() as u32;
        if sampler.apron() == Apron::Retrace {
            return Borders { read: 0, kept: 0, columns };
        }
        let column = |tile: &TileView| sampler.shared_rows(tile).len() as u32;
        // Tiles above one another share the same columns.
        let row = sampler.shared_columns(&self.tiles[i]).len() as u32;
        let has_right = i + 1 < self.tiles.len();
        let corner = |is_there: bool| u32::from(is_there && sampler.shares_corner());
        let read = if i > 0 { column(&self.tiles[i]) } else { 0 } + if is_first { 0 } else { row };
        let kept = self.tiles.get(i + 1).map_or(0, column) + if is_last { 0 } else { row };
        let (read, kept) = (read + corner(i > 0 && !is_first), kept + corner(has_right && !is_last));
        Borders { read, kept, columns }
    }

    /// What tile `i` does for its apron: nothing if that is shared. The closing row repeats its X step.
    fn apron_part<S>(
        &self,
        builder: &Builder<'_, S>,
        sampler: &dyn Sampler,
        below: Option<&Self>,
        i: usize,
    ) -> Result<Part>
    where
        S: PathSource + ?Sized,
    {
        let mut part = Part::default();
        if sampler.apron() == Apron::Retrace {
            for OutsideSamples { band, tile, samples } in self.outside(sampler, below, i) {
                let (view, recorded) = (&band.tiles[tile], &band.recorded[tile]);
                // It is one of the tiles that several others read, and is work itself.
                recorded.with_paths(builder.source, true, |paths| {
                    builder.apron(&mut part, view, &recorded.tile, paths, &samples)
                })?;
            }
            if let Some(band) = below.filter(|_| sampler.shares_first_row()) {
                part.count(band.tiles[i].first_row_rounds());
            }
        }
        Ok(part)
    }
}

/// Samples of one tile that another one reads.
struct OutsideSamples<'a> {
    band: &'a Band,
    /// Which tile of the band.
    tile: usize,
    /// Column and row in the frame's grid.
    samples: Vec<(u32, u32)>,
}

/// The samples that tile `view` shares with the one above it, followed by its `corners`; nothing if it shares none.
fn closing_row(sampler: &dyn Sampler, view: &TileView, corners: Forest) -> Option<Forest> {
    let y = view.rect().y;
    let columns = sampler.shared_columns(view);
    let mut row = (!columns.is_empty()).then(|| forest(view, columns.into_iter().map(|x| (x, y))))?;
    (0..corners.samples()).for_each(|i| row.push(corners.tree(i)));
    Some(row)
}

/// The trees of some samples of a tile.
fn forest(view: &TileView, samples: impl Iterator<Item = (u32, u32)>) -> Forest {
    let mut forest = Forest::default();
    for (x, y) in samples {
        forest.push(view.tree(x, y));
        forest.last_is_interpolated(matches!(view.state(x, y), Some((SampleState::Interpolated, _))));
    }
    forest
}

/// What others do of tile `view`. They begin after the X step of the tile `below`, which brings the row that they test against.
fn last_rows(parts: &mut Parts, view: &TileView, below: Option<&TileView>) -> LastRows {
    let mut take = |closer| {
        let mut part = parts.take(closer);
        if let Some(below) = below {
            part.begin_after(below.last_x_round());
        }
        part
    };
    let (straight, across) = (take(Closer::Below), take(Closer::Corner));
    LastRows { straight, across, x_rounds: u32::from(view.last_x_round()) + 1 }
}

/// Adds a sample; nothing if it is not decided.
fn count(counts: &mut Counts, view: &TileView, (x, y): (u32, u32)) -> Option<()> {
    let (state, _) = view.state(x, y)?;
    counts.rays_traced += view.traced_rays(x, y).unwrap_or_default();
    match state {
        SampleState::Interpolated => counts.samples_interpolated += 1,
        SampleState::Traced => counts.samples_traced += 1,
        SampleState::Reference => {
            counts.samples_reference += 1;
            counts.samples_traced += 1;
        }
        SampleState::Partial => {
            counts.samples_partial += 1;
            counts.samples_traced += 1;
        }
    }
    Some(())
}
