//! How many rays were traced for each sample of a frame.

use rayreel_formats::scene::Meta;

use crate::policy::view::TileView;

/// Rays that a policy traced for a sample.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TracedRays {
    /// All of them.
    pub all: u32,
    /// Those to lights.
    pub shadow: u32,
}

/// The rays that a policy traced for every sample of a frame, row by row. Samples that tiles trace again for their apron are not in it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TracedMap {
    width: u32,
    rays: Vec<TracedRays>,
}

impl TracedMap {
    /// A map for the frames of a trace, in which nothing is traced yet.
    pub(super) fn new(meta: &Meta) -> Self {
        let (width, height) = meta.grid();
        Self { width, rays: vec![TracedRays::default(); width as usize * height as usize] }
    }

    /// Takes over a decided tile.
    pub(super) fn add(&mut self, view: &TileView) {
        for (x, y) in view.samples() {
            let rays = view.traced_rays(x, y).unwrap_or_default();
            let offset = y as usize * self.width as usize + x as usize;
            self.rays[offset] = TracedRays { all: rays.total() as u32, shadow: rays.shadow as u32 };
        }
    }

    /// The rays of sample (`x`, `y`).
    ///
    /// # Panics
    /// When the sample is outside the frame.
    pub fn at(&self, x: u32, y: u32) -> TracedRays {
        assert!(x < self.width, "sample ({x}, {y}) is outside the frame");
        self.rays[y as usize * self.width as usize + x as usize]
    }
}
