//! The block of each tile: fixed, by distance from the gaze, or by what the frame before found.
//!
//! **Feedback** (paper, section 3: "the per-tile similarity ratio can be referenced from the previous frame, and this value is
//! compared with the predefined thresholds"). What is compared is not the share of I-samples that are interpolated, which means
//! another thing at each block, but the [`balance`] between what a tile must trace and what it finds. A change is made when `hold`
//! frames in a row asked for it. In odd frames both thresholds lie further out by the share `alternate`: so a tile whose balance
//! sits on one does not follow it in every frame, and neighbours that are alike change in different frames.
//!
//! **First frame and cuts.** Without a frame before, all tiles have the block `start`, but for those that [`FirstFrame`] makes
//! finer. (Tried: the block that the tile two rows above asks for, whether the target is missed or not. Raising cost up to 3 dB,
//! lowering up to 40 % more rays: a tile is not what lies above it.) The same holds after a cut: a frame whose number does not
//! follow the last one's, a camera that turned by more than `cut_deg`, or (seen one frame late) similarity ratios, interpolated
//! per I-sample, that changed by more than `cut_change` in the mean.

mod balance;

use balance::Balance;
use rayreel_formats::math::Vec3;
use rayreel_formats::scene::{Camera, Meta};

use crate::counts::TileStats;
use crate::policy::similarity::within_angle;
use crate::policy::target::{FirstFrame, LimitController};
use crate::policy::{Adaptive, Foveated, Jin2009, Mitchell1987, Multirate, Policy, Temporal, Whitted1980};

/// What a tile is sampled with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TileRate {
    /// Block edge, samples.
    pub block: u32,
    /// Block edge of the tile to the left; its own for the first of a row.
    pub left: u32,
    /// Factor on the colour limit.
    pub relax: f64,
    /// Factor on the limits of correction.
    pub correct: f64,
}

/// The rates of a frame's tiles, in tile order.
#[derive(Clone, Debug, Default)]
pub struct Rates {
    columns: u32,
    /// Per tile block edge and factor on the colour limit.
    tiles: Vec<(u32, f64)>,
    /// In a first frame, or after a cut: what its rows learn from those above.
    first: Option<FirstFrame>,
    /// The smallest block that these may make.
    finest: u32,
}

impl Rates {
    /// The rate of tile `tile`.
    pub fn tile(&self, tile: u32) -> TileRate {
        let (block, relax) = self.tiles[tile as usize];
        let left = if tile.is_multiple_of(self.columns) { block } else { self.tiles[tile as usize - 1].0 };
        TileRate { block, left, relax, correct: self.first.as_ref().map_or(1.0, FirstFrame::correct) }
    }

    /// Nothing is known of the frame before, or it does not count.
    pub fn is_first(&self) -> bool {
        self.first.is_some()
    }

    /// Takes note of the next row of tiles that is finished, top to bottom. In a first frame it moves the colour limit and the blocks of
    /// the row after the next: the next one is at work already.
    pub fn finished(&mut self, row: &[TileStats]) {
        let (Some(first), Some(tile)) = (&mut self.first, row.first()) else { return };
        let factor = first.row(row);
        let below = (tile.tile + 2 * self.columns) as usize;
        if below >= self.tiles.len() {
            return;
        }
        for ((block, relax), above) in self.tiles[below..].iter_mut().zip(row) {
            *relax = factor;
            if *block > self.finest && first.is_detailed(above, factor) {
                *block /= 2;
            }
        }
    }

    /// The blocks, tile by tile.
    #[cfg(test)]
    pub fn blocks(&self) -> Vec<u32> {
        self.tiles.iter().map(|t| t.0).collect()
    }
}

/// Chooses the rates of one frame after the other.
#[derive(Clone, Debug)]
pub struct RateController {
    columns: u32,
    rows: u32,
    tile: u32,
    grid: (u32, u32),
    policy: Policy,
    history: Option<History>,
    target: Option<LimitController>,
}

/// What the last frame left.
#[derive(Clone, Debug)]
struct History {
    frame: u32,
    forward: Vec3,
    tiles: Vec<TileHistory>,
    /// The ratios changed so much that they say nothing about the next frame.
    cut: bool,
}

/// What is remembered of a tile.
#[derive(Clone, Copy, Debug)]
struct TileHistory {
    block: u32,
    ratio: Option<f64>,
    /// Frames in a row that asked for a larger (positive) or smaller (negative) block.
    asked: i32,
}

impl RateController {
    /// Prepares `policy` for the tiles of a trace.
    pub fn new(policy: &Policy, meta: &Meta) -> Self {
        let (columns, rows) = meta.tile_grid();
        let target = policy.multirate().map(|multirate| LimitController::new(&multirate.target));
        Self { columns, rows, tile: meta.tile, grid: meta.grid(), policy: policy.clone(), history: None, target }
    }

    /// The rates of `frame`.
    pub fn rates(&self, frame: u32, camera: &Camera) -> Rates {
        let count = (self.columns * self.rows) as usize;
        let mut first = None;
        let tiles = match &self.policy {
            Policy::Full => vec![(1, 1.0); count],
            Policy::Adaptive(Adaptive { block, .. })
            | Policy::Whitted1980(Whitted1980 { block, .. })
            | Policy::Mitchell1987(Mitchell1987 { block, .. })
            | Policy::Jin2009(Jin2009 { block, .. }) => vec![(*block, 1.0); count],
            Policy::Foveated(rings) => (0..self.columns * self.rows).map(|tile| self.foveated(rings, tile)).collect(),
            Policy::Multirate(multirate) | Policy::Temporal(Temporal { multirate, .. }) => {
                match (&self.history, &self.target) {
                    (Some(history), target) if !self.is_cut(multirate, history, frame, camera) => {
                        let factor = target.as_ref().map_or(1.0, LimitController::factor);
                        history.tiles.iter().map(|memory| (memory.block, factor)).collect()
                    }
                    (_, target) => {
                        let total = u64::from(self.grid.0) * u64::from(self.grid.1);
                        first = target.as_ref().map(|target| target.first(total));
                        vec![(multirate.start, 1.0); count]
                    }
                }
            }
        };
        Rates {
            columns: self.columns,
            tiles,
            first,
            finest: self.policy.multirate().map_or(1, |multirate| multirate.finest),
        }
    }

    /// Takes note of what the tiles of `frame` were like under `rates`.
    pub fn learn(&mut self, frame: u32, camera: &Camera, rates: &Rates, stats: &[TileStats]) {
        let Some(multirate) = self.policy.multirate() else { return };
        let fresh = rates.tiles.iter().map(|&(block, _)| TileHistory { block, ratio: None, asked: 0 }).collect();
        let known = self.history.take().filter(|history| !self.is_cut(multirate, history, frame, camera));
        let factor = self.target.as_mut().map_or(1.0, |target| {
            target.learn(stats, known.is_none());
            target.factor()
        });
        let mut tiles: Vec<TileHistory> = known.map_or(fresh, |history| history.tiles);
        let (mut change, mut compared) = (0.0, 0u32);
        let balance = Balance::new(multirate, if frame % 2 == 1 { 1.0 + multirate.alternate } else { 1.0 });
        for (memory, stats) in tiles.iter_mut().zip(stats) {
            let ratio = stats.counts.similarity_ratio();
            if let (Some(old), Some(new)) = (memory.ratio, ratio) {
                change += (new - old).abs();
                compared += 1;
            }
            memory.ratio = ratio;
            memory.follow(balance.asks(memory.block, factor, stats), multirate.hold);
        }
        let cut = compared > 0 && change / f64::from(compared) > multirate.cut_change;
        self.history = Some(History { frame, forward: self.forward(camera), tiles, cut });
    }

    fn is_cut(&self, multirate: &Multirate, history: &History, frame: u32, camera: &Camera) -> bool {
        let (a, b) = (history.forward, self.forward(camera));
        let cosine = libm::cos(multirate.cut_deg.to_radians());
        history.cut || history.frame.checked_add(1) != Some(frame) || !within_angle(a, b, cosine)
    }

    /// The direction of the middle of the picture.
    fn forward(&self, camera: &Camera) -> Vec3 {
        let (w, h) = self.grid;
        ((camera.corner + camera.right * (w as f32 * 0.5)) + camera.down * (h as f32 * 0.5)).normalized()
    }

    /// Block and relaxation of a tile by the distance of its middle from the gaze point.
    fn foveated(&self, rings: &Foveated, tile: u32) -> (u32, f64) {
        let (w, h) = (f64::from(self.grid.0), f64::from(self.grid.1));
        let middle = |index: u32, size: f64| {
            let start = f64::from(index * self.tile);
            (start + (start + f64::from(self.tile)).min(size)) * 0.5
        };
        let x = (middle(tile % self.columns, w) - rings.gaze_x * w) / h;
        let y = (middle(tile / self.columns, h) - rings.gaze_y * h) / h;
        let distance = (x * x + y * y).sqrt();
        // 0 up to the inner radius, 1 from the outer one on.
        let way = if rings.outer > rings.inner { (distance - rings.inner) / (rings.outer - rings.inner) } else { 1.0 };
        let way = if distance <= rings.inner { 0.0 } else { way.clamp(0.0, 1.0) };
        let steps = (rings.coarsest / rings.finest).trailing_zeros();
        // The largest block from the outer radius on, the others in rings of equal width inside.
        let ring = ((way * f64::from(steps)).floor() as u32).min(steps);
        (rings.finest << ring, 1.0 + (rings.relax - 1.0) * way)
    }
}

impl TileHistory {
    /// Lets the tile, which asks for a larger block (1), a smaller one (-1) or none, change it if enough frames asked so.
    fn follow(&mut self, asks: i32, hold: u32) {
        self.asked = if asks == 0 || self.asked.signum() == -asks { asks } else { self.asked + asks };
        if self.asked.unsigned_abs() >= hold {
            self.block = if asks > 0 { self.block * 2 } else { self.block / 2 };
            self.asked = 0;
        }
    }
}

#[cfg(test)]
mod tests;
