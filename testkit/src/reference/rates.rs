//! Blocks and factors of the frames of `multirate`, once more: written from POLICIES.md, from what the frames before were like.

use rayreel_formats::scene::Meta;
use rayreel_replay::FrameReplay;
use rayreel_replay::counts::TileStats;
use rayreel_replay::policy::Multirate;

/// A block and a factor on the colour limit for each tile.
type Tiles = Vec<(u32, f64)>;

/// The rates of a frame.
pub struct Plan {
    /// By tile.
    pub tiles: Tiles,
    /// Factor on the limits of correction.
    pub correct: f64,
}

/// The rates that frames in a row should have had. The camera never turns far enough for a cut.
pub fn plans(meta: &Meta, policy: &Multirate, frames: &[FrameReplay]) -> Vec<Plan> {
    let mut book =
        Book { policy, columns: meta.tile_grid().0 as usize, memory: None, history: Vec::new(), factor: 1.0 };
    frames.iter().map(|frame| book.frame(meta, frame)).collect()
}

struct Book<'a> {
    policy: &'a Multirate,
    columns: usize,
    /// What tiles are to have next; nothing before a first frame and after a cut.
    memory: Option<Vec<Memory>>,
    /// What each frame since the first one brought, the latest at the end.
    history: Vec<Brought>,
    factor: f64,
}

/// Of a frame: squared error at factor 1 and values of audits; samples traced and all.
struct Brought {
    unit: f64,
    values: f64,
    traced: f64,
    samples: f64,
}

#[derive(Clone)]
struct Memory {
    block: u32,
    ratio: Option<f64>,
    /// The last wishes, the latest at the end, all of them since the last change.
    wishes: Vec<i32>,
}

impl Book<'_> {
    fn frame(&mut self, meta: &Meta, frame: &FrameReplay) -> Plan {
        let tiles = &frame.stats.tiles;
        let plan: Tiles = match &self.memory {
            Some(memory) => memory.iter().map(|tile| (tile.block, self.factor)).collect(),
            None => self.first(meta, tiles),
        };
        let is_first = self.memory.is_none();
        let fresh = plan.iter().map(|tile| Memory { block: tile.0, ratio: None, wishes: Vec::new() });
        let mut memory = self.memory.take().unwrap_or_else(|| fresh.collect());
        self.learn(tiles, is_first);
        let mut changes = Vec::new();
        for (tile, stats) in memory.iter_mut().zip(tiles) {
            let (between, counts) = (stats.counts.samples_full - stats.counts.samples_reference, &stats.counts);
            let ratio = (between > 0).then(|| counts.samples_interpolated as f64 / between as f64);
            changes.extend(tile.ratio.zip(ratio).map(|(old, new)| (new - old).abs()));
            tile.ratio = ratio;
            let apart = if frame.frame % 2 == 1 { 1.0 + self.policy.alternate } else { 1.0 };
            tile.wishes.push(self.wish(tile.block, stats, apart));
            let last = *tile.wishes.last().unwrap();
            let in_a_row = tile.wishes.iter().rev().take_while(|&&wish| wish == last).count();
            if last != 0 && in_a_row >= self.policy.hold as usize {
                tile.block = if last > 0 { tile.block * 2 } else { tile.block / 2 };
                tile.wishes.clear();
            }
        }
        let change = changes.iter().sum::<f64>() / changes.len() as f64;
        self.memory = (changes.is_empty() || change <= self.policy.cut_change).then_some(memory);
        let is_stricter = is_first && self.policy.target.psnr_db.value().is_some();
        Plan { tiles: plan, correct: if is_stricter { self.policy.target.first_correct } else { 1.0 } }
    }

    /// 1 for twice the block, -1 for half.
    fn wish(&self, block: u32, stats: &TileStats, apart: f64) -> i32 {
        let (counts, policy) = (&stats.counts, self.policy);
        let between = counts.samples_full - counts.samples_reference;
        if between == 0 {
            return 0;
        }
        let rays = counts.rays_traced.total() as f64 / counts.samples_traced as f64;
        let weight = self.factor * (rays / 3.0).sqrt();
        let balance = (between - counts.samples_interpolated) as f64 / counts.samples_reference as f64;
        if block < policy.coarsest && balance * f64::from(block) / 2.0 <= policy.raise / apart * weight {
            1
        } else if block > policy.finest && balance >= policy.lower * apart * weight {
            -1
        } else {
            0
        }
    }

    /// A first frame, row by row.
    fn first(&self, meta: &Meta, tiles: &[TileStats]) -> Tiles {
        let (width, height) = meta.grid();
        let total = f64::from(width) * f64::from(height);
        let mut plan = vec![(self.policy.start, 1.0); tiles.len()];
        let Some(aim) = self.aim() else { return plan };
        for (tile, rate) in plan.iter_mut().enumerate().skip(2 * self.columns) {
            let above = tile - 2 * self.columns;
            let done = &tiles[..(above / self.columns + 1) * self.columns];
            let (found, _, values) = sums(done);
            let found = (found + 192.0 * aim) / (values + 192.0);
            // Each row a power of `decay`, the last one 1.
            let (mut unit, mut values) = (192.0 * aim, 192.0);
            for (age, row) in done.rchunks(self.columns).enumerate() {
                let (_, row_unit, row_values) = sums(row);
                unit += libm::pow(self.policy.target.decay, age as f64) * row_unit;
                values += libm::pow(self.policy.target.decay, age as f64) * row_values;
            }
            let unit = unit / values;
            let share = done.iter().map(|tile| tile.counts.samples_full).sum::<u64>() as f64 / total;
            let rest = (aim - share * found) / (1.0 - share);
            let factor = libm::pow(rest.max(aim / 4.0) / unit, 1.0 / 0.7).min(1.0);
            rate.1 = self.within(factor, traced(done) / samples(done));
            // Below a tile full of detail the block is halved, should the target be missed.
            let (counts, target) = (&tiles[above].counts, &self.policy.target);
            let between = counts.samples_full - counts.samples_reference;
            let share = (between - counts.samples_interpolated) as f64 / between as f64;
            if rate.1 < 1.0 && share >= target.first_detail {
                rate.0 = (rate.0 / 2).max(self.policy.finest);
            }
        }
        plan
    }

    fn learn(&mut self, tiles: &[TileStats], is_first: bool) {
        let Some(aim) = self.aim() else { return };
        let (_, mut unit, values) = sums(tiles);
        // What a first frame's stricter corrections spared it, the next one will have.
        if is_first {
            let target = &self.policy.target;
            unit *= libm::pow(target.first_correct.max(0.01), -target.first_growth);
        }
        if is_first {
            self.history.clear();
        }
        self.history.push(Brought { unit, values, traced: traced(tiles), samples: samples(tiles) });
        let decay = self.policy.target.decay;
        let ages = self.history.iter().rev().enumerate();
        let sum = |of: fn(&Brought) -> f64| -> f64 {
            ages.clone().map(|(age, frame)| libm::pow(decay, age as f64) * of(frame)).sum()
        };
        let unit = (sum(|frame| frame.unit) + 192.0 * aim) / (sum(|frame| frame.values) + 192.0);
        let traced = sum(|frame| frame.traced) / sum(|frame| frame.samples);
        self.factor = self.within(libm::pow(aim / unit, 1.0 / 0.7), traced);
    }

    fn aim(&self) -> Option<f64> {
        self.policy.target.psnr_db.value().map(|db| 65025.0 * libm::pow(10.0, -db / 10.0))
    }

    fn within(&self, factor: f64, traced: f64) -> f64 {
        let target = &self.policy.target;
        let w =
            if target.share > 0.0 { ((target.share - traced) / (0.25 * target.share)).clamp(0.0, 1.0) } else { 0.0 };
        factor.min(target.loosest.max(1.0)).max((1.0 + (target.strictest - 1.0) * w).max(0.01))
    }
}

fn traced(tiles: &[TileStats]) -> f64 {
    tiles.iter().map(|tile| tile.counts.samples_traced).sum::<u64>() as f64
}

fn samples(tiles: &[TileStats]) -> f64 {
    tiles.iter().map(|tile| tile.counts.samples_full).sum::<u64>() as f64
}

/// Squared error found, the same at factor 1, and the number of values.
fn sums(tiles: &[TileStats]) -> (f64, f64, f64) {
    let values = tiles.iter().map(|tile| tile.audited.values).sum::<u64>() as f64;
    let found = tiles.iter().map(|tile| tile.audited.sum).sum::<u64>() as f64;
    (found, tiles.iter().map(|tile| tile.audited.sum as f64 / libm::pow(tile.factor, 0.7)).sum(), values)
}
