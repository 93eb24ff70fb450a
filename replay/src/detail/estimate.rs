//! What is known of figures that were estimated: how far they may be off.
//!
//! An estimate comes with replicates: the same estimate made again without a part of the windows, each time another (the
//! delete-a-group jackknife; Kott 2001). Whatever figure is made of counters and joules, how much it differs between replicates
//! tells how much it would differ between samples. So every figure, and every ratio of figures of two runs that have the same
//! windows, gets an interval by computing it for each replicate.

use rayreel_machine::energy::EnergyReport;
use rayreel_machine::stats::Stats;

use super::mode::Detail;

/// Half width of an interval, at least, as a part of the value: what windows do not tell of, such as the seams between
/// them, has been below this (see the bench `detail`).
pub const FLOOR: f64 = 0.005;

/// A run of which not every cycle was simulated.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Estimate {
    /// What was asked for.
    pub detail: Detail,
    /// Tiles of the frames.
    pub tiles: u64,
    /// Tiles that windows measured, or that belong to frames that were simulated whole.
    pub detailed_tiles: u64,
    /// Windows that were simulated.
    pub windows: u64,
    /// Frames that were simulated whole, for they have too few tiles, or tiles too alike or too different.
    pub whole_frames: u64,
    /// Degrees of freedom of the intervals; 0 where all frames were simulated whole.
    pub freedom: u32,
    /// The run, estimated again without a part of the windows each.
    pub replicates: Vec<Replicate>,
}

/// A run as it was estimated from a part of the windows.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Replicate {
    /// What the machine counted.
    pub stats: Stats,
    /// What it cost.
    pub energy: EnergyReport,
}

impl Estimate {
    /// The share of the tiles that was simulated in detail.
    pub fn fraction(&self) -> f64 {
        if self.tiles == 0 { 1.0 } else { self.detailed_tiles as f64 / self.tiles as f64 }
    }

    /// Adds another frame of the same machine.
    pub fn add(&mut self, other: &Self) {
        self.tiles += other.tiles;
        self.detailed_tiles += other.detailed_tiles;
        self.windows += other.windows;
        self.whole_frames += other.whole_frames;
        // The frame with the fewest windows is the one that knows least.
        self.freedom = match (self.freedom, other.freedom) {
            (0, freedom) | (freedom, 0) => freedom,
            (a, b) => a.min(b),
        };
        // A frame that was simulated whole has one replicate, which is itself.
        let count = self.replicates.len().max(other.replicates.len());
        if other.replicates.is_empty() || self.replicates.is_empty() {
            return;
        }
        let given = self.replicates.len();
        self.replicates = (0..count).map(|i| self.replicates[i % given].clone()).collect();
        for (i, sum) in self.replicates.iter_mut().enumerate() {
            let more = &other.replicates[i % other.replicates.len()];
            sum.stats.add(&more.stats);
            sum.energy.add(&more.energy);
        }
    }

    /// Half the width of the 95 % interval of a figure that is `value`, and `of` each replicate; never less than [`FLOOR`].
    pub fn half_width(&self, value: f64, of: impl FnMut(&Replicate) -> f64) -> f64 {
        let values: Vec<f64> = self.replicates.iter().map(of).collect();
        half_width(value, &values, self.freedom)
    }
}

/// Half the width of the 95 % interval of a figure that is `value` and had these values in the replicates.
pub fn half_width(value: f64, replicates: &[f64], freedom: u32) -> f64 {
    let floor = FLOOR * value.abs();
    if replicates.len() < 2 || freedom == 0 {
        return floor;
    }
    let count = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / count;
    let squares: f64 = replicates.iter().map(|r| (r - mean) * (r - mean)).sum();
    (student(freedom) * (squares * (count - 1.0) / count).sqrt()).hypot(floor)
}

/// How far from the estimate two replicates among `count` have to lie, one on each side, to add this once to the half width.
pub(crate) fn weight_of_pair(count: usize, freedom: u32) -> f64 {
    let count = count as f64;
    1.0 / (student(freedom) * (2.0 * (count - 1.0) / count).sqrt())
}

/// The 97.5 % point of Student's t with so many degrees of freedom.
fn student(freedom: u32) -> f64 {
    const FIRST: [f64; 30] = [
        12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
        2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056, 2.052, 2.048, 2.045, 2.042,
    ];
    match freedom {
        0 => FIRST[0],
        1..=30 => FIRST[freedom as usize - 1],
        31..=60 => 2.021,
        _ => 1.980,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replicates_of_a_mean_give_the_interval_of_a_mean() {
        // Means without one of five values each: the jackknife is the textbook's standard error of the mean.
        let values = [2.0, 4.0, 4.0, 5.0, 10.0];
        let mean = values.iter().sum::<f64>() / 5.0;
        let without: Vec<f64> = values.iter().map(|v| (mean * 5.0 - v) / 4.0).collect();
        let variance = values.iter().map(|v| (v - mean) * (v - mean)).sum::<f64>() / 4.0;
        let expected = (2.776 * (variance / 5.0).sqrt()).hypot(FLOOR * mean);
        assert!((half_width(mean, &without, 4) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_pair_adds_its_distance() {
        let (value, apart) = (100.0, 7.0);
        let pair = weight_of_pair(10, 5) * apart;
        let replicates = [[value; 8].as_slice(), &[value - pair, value + pair]].concat();
        assert!((half_width(value, &replicates, 5) - apart.hypot(FLOOR * value)).abs() < 1e-9);
    }

    #[test]
    fn without_windows_there_is_the_floor() {
        assert_eq!(half_width(10.0, &[], 0), FLOOR * 10.0);
        assert_eq!(half_width(-10.0, &[-10.0, -10.0], 1), FLOOR * 10.0);
    }

    #[test]
    fn fewer_windows_make_wider_intervals() {
        assert!((1..200).all(|f| student(f) >= student(f + 1)));
    }
}
