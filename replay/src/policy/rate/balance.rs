//! When a tile's block is too small or too large.
//!
//! **The balance.** A tile traces its R-samples in any case, and of the others those that its tests ask for. Where these are fewer
//! than the R-samples, most of what it traces is the grid: a block twice as large has a quarter of it. Where they are many times
//! as many, the tile is full of detail. A finer grid costs little there, since most of its samples are traced anyway, and finds
//! what slips between R-samples. So a tile asks for a larger block when it traces few I-samples for each R-sample, and for a
//! smaller one when it traces many.
//!
//! The larger the block, the fewer it must be: tests of a wider gap find less, and the picture pays. Half as many at each step is an
//! estimate of ours, by trying all blocks on each tile of flights through three built-in scenes.
//!
//! **The weight.** Both thresholds are multiplied by the factor on the colour limit that comes next and by the root of the tile's
//! rays a sample over three, as the colour limit is: what a finer grid finds is worth less where it costs more rays, and where the
//! target is not so strict.

use crate::counts::TileStats;
use crate::policy::Multirate;

/// What changes the block of a tile.
#[derive(Clone, Copy, Debug)]
pub struct Balance {
    raise: f64,
    lower: f64,
    finest: u32,
    coarsest: u32,
}

impl Balance {
    /// The thresholds of a policy, `apart` times further apart than it says on either side.
    pub fn new(multirate: &Multirate, apart: f64) -> Self {
        let Multirate { raise, lower, finest, coarsest, .. } = *multirate;
        Self { raise: raise / apart, lower: lower * apart, finest, coarsest }
    }

    /// 1 if a tile of block `block` asks for twice that, -1 if for half, else 0. `factor` is what its colour limit is to be
    /// multiplied by.
    pub fn asks(&self, block: u32, factor: f64, stats: &TileStats) -> i32 {
        let counts = &stats.counts;
        if counts.samples_intermediate() == 0 {
            return 0;
        }
        let rays = counts.rays_traced.total() as f64 / counts.samples_traced as f64;
        let weight = factor * (rays / 3.0).sqrt();
        let traced = (counts.samples_intermediate() - counts.samples_interpolated) as f64;
        let balance = traced / counts.samples_reference as f64;
        match block {
            _ if balance * f64::from(block) * 0.5 <= self.raise * weight && block < self.coarsest => 1,
            _ if balance >= self.lower * weight && block > self.finest => -1,
            _ => 0,
        }
    }
}
