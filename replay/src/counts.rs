//! What is counted: integers only; ratios are made in the report.

use std::iter::Sum;
use std::ops::{Add, AddAssign};

use rayreel_formats::tile::{RayKind, RayNode};
use serde::Serialize;

use crate::image::compare::Quality;
use crate::image::psnr::SquaredError;

/// Rays by kind.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub struct RayCounts {
    /// From the eye.
    pub primary: u64,
    /// Mirrored.
    pub reflection: u64,
    /// Bent.
    pub refraction: u64,
    /// To the lights.
    pub shadow: u64,
}

impl RayCounts {
    /// The rays of some nodes of a ray tree: one for each node and one for each shadow ray cast.
    pub fn of(nodes: &[RayNode]) -> Self {
        let mut counts = Self::default();
        for node in nodes {
            match node.class.kind() {
                RayKind::Primary => counts.primary += 1,
                RayKind::Reflection => counts.reflection += 1,
                _ => counts.refraction += 1,
            }
            counts.shadow += u64::from(node.shadows.count());
        }
        counts
    }

    /// Rays of all kinds.
    pub fn total(&self) -> u64 {
        self.primary + self.reflection + self.refraction + self.shadow
    }
}

impl Add for RayCounts {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            primary: self.primary + o.primary,
            reflection: self.reflection + o.reflection,
            refraction: self.refraction + o.refraction,
            shadow: self.shadow + o.shadow,
        }
    }
}

impl AddAssign for RayCounts {
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl Sum for RayCounts {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

/// Samples and rays of a tile, a frame, or several.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Samples of the grid.
    pub samples_full: u64,
    /// R-samples.
    pub samples_reference: u64,
    /// Samples of which rays were traced, R-samples included, apron samples not.
    pub samples_traced: u64,
    /// The traced samples of which some hits were interpolated.
    pub samples_partial: u64,
    /// Samples that were interpolated.
    pub samples_interpolated: u64,
    /// Samples of other tiles that were traced again.
    pub samples_apron: u64,
    /// Rays of all samples of the grid.
    pub rays_full: RayCounts,
    /// Rays of the traced samples.
    pub rays_traced: RayCounts,
    /// Rays of the apron samples.
    pub rays_apron: RayCounts,
}

impl Counts {
    /// I-samples: those that could have been interpolated.
    pub fn samples_intermediate(&self) -> u64 {
        self.samples_full - self.samples_reference
    }

    /// Interpolated per I-sample; `None` if there are no I-samples.
    pub fn similarity_ratio(&self) -> Option<f64> {
        let all = self.samples_intermediate();
        (all > 0).then(|| self.samples_interpolated as f64 / all as f64)
    }

    /// Rays that need not be traced, apron rays deducted; negative if the apron costs more than is saved.
    pub fn rays_saved(&self) -> i64 {
        self.rays_full.total() as i64 - self.rays_traced.total() as i64 - self.rays_apron.total() as i64
    }
}

impl Add for Counts {
    type Output = Self;
    fn add(self, o: Self) -> Self {
        Self {
            samples_full: self.samples_full + o.samples_full,
            samples_reference: self.samples_reference + o.samples_reference,
            samples_traced: self.samples_traced + o.samples_traced,
            samples_partial: self.samples_partial + o.samples_partial,
            samples_interpolated: self.samples_interpolated + o.samples_interpolated,
            samples_apron: self.samples_apron + o.samples_apron,
            rays_full: self.rays_full + o.rays_full,
            rays_traced: self.rays_traced + o.rays_traced,
            rays_apron: self.rays_apron + o.rays_apron,
        }
    }
}

impl Sum for Counts {
    fn sum<I: Iterator<Item = Self>>(iter: I) -> Self {
        iter.fold(Self::default(), Add::add)
    }
}

/// What a tile cost.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileStats {
    /// Tile number in the frame.
    pub tile: u32,
    /// Its counts.
    pub counts: Counts,
    /// What its audits found; no values without audits.
    pub audited: SquaredError,
    /// Factor on the colour limit.
    pub factor: f64,
}

/// What a frame cost, and how good it is.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameStats {
    /// Frame number.
    pub frame: u32,
    /// Sums over the tiles.
    pub counts: Counts,
    /// The tiles, in order.
    pub tiles: Vec<TileStats>,
    /// The comparison with `full`, if it was asked for.
    pub quality: Option<Quality>,
    /// Squared error of each tile, in order; empty without a comparison.
    pub tile_errors: Vec<SquaredError>,
}
