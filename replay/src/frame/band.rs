//! A row of tiles: the unit in which a frame passes through memory.
//!
//! A band is read, its R-samples traced and its X step made; then the band above can make its Y step, whose closing row is
//! now known, and leave. So two bands are held at a time, whatever the height of the frame.

use rayon::prelude::*;
use rayreel_formats::scene::Camera;

use super::counts::{Counts, RayCounts, TileStats};
use crate::error::Result;
use crate::policy::Apron;
use crate::policy::adaptive::Rules;
use crate::policy::view::{Point, SampleState, TileView};
use crate::source::TileSource;

/// The tiles of one row, left to right.
pub(super) struct Band {
    pub tiles: Vec<TileView>,
}

impl Band {
    /// Reads tile row `row` and decides all its samples on R-rows.
    pub fn open<S: TileSource + ?Sized>(
        source: &S,
        rules: &Rules,
        camera: &Camera,
        frame: u32,
        row: u32,
    ) -> Result<Self> {
        let columns = source.meta().tile_grid().0;
        let read = |index| -> Result<(TileView, Vec<Point>)> {
            let mut view = TileView::read(source, camera, frame, index)?;
            rules.trace_references(&mut view);
            let first = rules.first_column(&view);
            Ok((view, first))
        };
        // Collected one by one before errors are looked at, so that the first tile's error is reported on any machine.
        let results: Vec<_> = (row * columns..(row + 1) * columns).into_par_iter().map(read).collect();
        let (mut tiles, borders): (Vec<_>, Vec<_>) =
            results.into_iter().collect::<Result<Vec<_>>>()?.into_iter().unzip();
        tiles.par_iter_mut().enumerate().for_each(|(i, view)| {
            rules.step_x(view, borders.get(i + 1).map(Vec::as_slice));
        });
        Ok(Self { tiles })
    }

    /// Decides the other samples; `below` is the next band, already open.
    pub fn close(&mut self, rules: &Rules, below: Option<&Self>) -> Vec<TileStats> {
        self.tiles.par_iter_mut().enumerate().for_each(|(i, view)| {
            let closing = below.map(|band| first_row(&band.tiles[i]));
            rules.step_y(view, closing.as_deref());
        });
        (0..self.tiles.len()).into_par_iter().map(|i| self.stats(rules, below, i)).collect()
    }

    fn stats(&self, rules: &Rules, below: Option<&Self>, i: usize) -> TileStats {
        let view = &self.tiles[i];
        let rect = view.rect();
        let mut counts =
            Counts { samples_full: rect.len() as u64, rays_full: view.recorded_rays(), ..Counts::default() };
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                count(&mut counts, view, x, y);
            }
        }
        if rules.apron == Apron::Retrace {
            for rays in self.apron(rules, below, i) {
                counts.samples_apron += 1;
                counts.rays_apron += rays;
            }
        }
        TileStats { tile: view.index(), counts }
    }

    /// The rays of the samples outside tile `i` that its steps read as traced: on the closing column its R-rows, on the
    /// closing row the R-samples and what the X step traced there, and the corner of both.
    fn apron(&self, rules: &Rules, below: Option<&Self>, i: usize) -> Vec<RayCounts> {
        let rect = self.tiles[i].rect();
        let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
        let mut rays = Vec::new();
        if let Some(next) = self.tiles.get(i + 1) {
            rays.extend(rules.lattice.rows(rect.y, bottom).filter_map(|y| next.traced_rays(right, y)));
        }
        if let Some(band) = below {
            rays.extend((rect.x..right).filter_map(|x| band.tiles[i].traced_rays(x, bottom)));
            rays.extend(band.tiles.get(i + 1).and_then(|corner| corner.traced_rays(right, bottom)));
        }
        rays
    }
}

/// The first row of a tile: the closing row of the tile above.
fn first_row(view: &TileView) -> Vec<Point> {
    let rect = view.rect();
    (rect.x..rect.x + rect.width).map(|x| view.point(x, rect.y)).collect()
}

fn count(counts: &mut Counts, view: &TileView, x: u32, y: u32) {
    counts.rays_traced += view.traced_rays(x, y).unwrap_or_default();
    match view.state(x, y) {
        Some((SampleState::Reference, _)) => {
            counts.samples_reference += 1;
            counts.samples_traced += 1;
        }
        Some((SampleState::Traced, _)) => counts.samples_traced += 1,
        Some((SampleState::Interpolated, _)) => counts.samples_interpolated += 1,
        None => unreachable!("the steps of a policy decide every sample"),
    }
}
