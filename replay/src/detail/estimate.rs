//! What is known of figures that were estimated: how far they may be off.
//!
//! An estimate comes with replicates: the same estimate made again without a part of the windows, each time another (the
//! delete-a-group jackknife; Kott 2001). Whatever figure is made of counters and joules, how much it differs between replicates
//! tells how much it would differ between samples. So every figure, and every ratio of figures of two runs that have the same
//! windows, gets an interval by computing it for each replicate.

use rayreel_machine::energy::EnergyReport;
use rayreel_machine::stats::Stats;

use super::mode::Detail;
use super::whole::WholeFrames;

/// Half width of an interval, at least, as a part of the value, of a frame of 2048 tiles or more: what windows do not tell
/// of, such as the seams between them, has been below this (see the bench `detail`).
pub const FLOOR: f64 = 0.005;

/// In frames of fewer tiles the machine itself is known less well: another refresh interval of the DRAM, which means nothing, moved a
/// frame of 288 tiles by 0.7 % of its cycles, and by 2.0 % of the energy with the memory (root mean squares, every cycle simulated).
const FLOOR_TILES: f64 = 2048.0;

/// The last replicates of a frame, in pairs: how far what is read from DRAM may be off otherwise than windows say.
pub(crate) const READS: usize = 4;

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
    /// Frames.
    pub frames: u64,
    /// Frames that were simulated whole.
    pub whole_frames: WholeFrames,
    /// Degrees of freedom of the intervals; 0 where all frames were simulated whole.
    pub freedom: u32,
    /// The run, estimated again without a part of the windows each.
    pub replicates: Vec<Replicate>,
}

/// Why frames are simulated whole though a sample was asked for, where nobody knows which reason it was.
pub const WHY_WHOLE: &str = "too few tiles or too small ones, tiles too alike or too different, a precision that no sample reaches, or a machine that gathers \
                             rays, traces them by threads or has a rasteriser";

/// The least half widths of intervals, as parts of the value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Floors {
    /// Of time, and of what needs no L2 and DRAM.
    pub alone: f64,
    /// Of energies with these, and of what they count.
    pub with_memory: f64,
}

impl Default for Floors {
    fn default() -> Self {
        Self { alone: FLOOR, with_memory: FLOOR }
    }
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
        self.frames += other.frames;
        self.whole_frames.add(&other.whole_frames);
        // The frame with the fewest windows is the one that knows least.
        self.freedom = match (self.freedom, other.freedom) {
            (0, freedom) | (freedom, 0) => freedom,
            (a, b) => a.min(b),
        };
        if other.replicates.is_empty() || self.replicates.is_empty() {
            // Those of some of the frames say nothing of all.
            self.replicates.clear();
            return;
        }
        let (ours, theirs) = (self.replicates.len(), other.replicates.len());
        let count = ours.max(theirs);
        let sum = |i: usize| {
            let mut sum = self.replicates[place(i, count, ours)].clone();
            let more = &other.replicates[place(i, count, theirs)];
            sum.stats.add(&more.stats);
            sum.energy.add(&more.energy);
            sum
        };
        self.replicates = (0..count).map(sum).collect();
    }

    /// How well figures can be known at best. What frames are off by otherwise than windows say is off this way and that, and
    /// less in a sum of several.
    pub fn floors(&self) -> Floors {
        let frames = self.frames.max(1) as f64;
        let fewer = FLOOR_TILES * frames / self.tiles.max(1) as f64;
        let of_sum = |of_frame: f64| FLOOR * (of_frame / frames.sqrt()).max(1.0);
        Floors { alone: of_sum(fewer.sqrt()), with_memory: of_sum(fewer) }
    }

    /// Half the width of the 95 % interval of a figure that is `value`, and `of` each replicate; never less than the part `floor` of it.
    pub fn half_width(&self, value: f64, floor: f64, of: impl FnMut(&Replicate) -> f64) -> f64 {
        let values: Vec<f64> = self.replicates.iter().map(of).collect();
        half_width(value, &values, self.freedom, floor)
    }
}

/// Which of `given` replicates of a frame goes with number `i` of `count` of a sum. The last [`READS`] stand for what all frames are off by
/// alike, so they meet; those without a group of windows begin again where a frame has fewer. A frame that was simulated whole has
/// one replicate, which is itself.
fn place(i: usize, count: usize, given: usize) -> usize {
    match given.checked_sub(READS) {
        None | Some(0) => i % given,
        Some(groups) if i < count - READS => i % groups,
        Some(_) => i + given - count,
    }
}

/// Half the width of the 95 % interval of a figure that is `value` and had these values in the replicates; at least the part `floor` of it.
pub fn half_width(value: f64, replicates: &[f64], freedom: u32, floor: f64) -> f64 {
    let floor = floor * value.abs();
    if replicates.len() < 2 || freedom == 0 {
        return floor;
    }
    let count = replicates.len() as f64;
    let mean = replicates.iter().sum::<f64>() / count;
    let squares: f64 = replicates.iter().map(|r| (r - mean) * (r - mean)).sum();
    (student(freedom) * (squares * (count - 1.0) / count).sqrt()).hypot(floor)
}

/// The replicates of the ratio of `a` to `b`, each a value with its replicates. Replicates at equal places leave out equal windows, so what
/// these share cancels, unless the one has more than the other. What is read from DRAM is off by as much only where both runs do the
/// same work (`alike`): of two policies the one may read 5 % too much and the other nothing (docs/accuracy.md), so there both count.
pub fn replicates_of_ratio((a, of_a): (f64, &[f64]), (b, of_b): (f64, &[f64]), alike: bool) -> Vec<f64> {
    let together = match of_a.len() {
        count if count != of_b.len() => 0,
        count if alike || count <= READS => count,
        count => count - READS,
    };
    let ((of_a, only_a), (of_b, only_b)) = (of_a.split_at(together), of_b.split_at(together));
    let ratios = of_a.iter().zip(of_b).map(|(a, b)| a / b);
    ratios.chain(only_a.iter().map(|a| a / b)).chain(only_b.iter().map(|b| a / b)).collect()
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
        // That of the least of them: wider rather than narrower.
        31..=39 => 2.040,
        40..=59 => 2.021,
        60..=119 => 2.000,
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
        assert!((half_width(mean, &without, 4, FLOOR) - expected).abs() < 1e-12);
    }

    #[test]
    fn a_pair_adds_its_distance() {
        let (value, apart) = (100.0, 7.0);
        let pair = weight_of_pair(10, 5) * apart;
        let replicates = [[value; 8].as_slice(), &[value - pair, value + pair]].concat();
        assert!((half_width(value, &replicates, 5, FLOOR) - apart.hypot(FLOOR * value)).abs() < 1e-9);
    }

    #[test]
    fn replicates_meet_their_like() {
        let with = |count, given| -> Vec<usize> { (0..count).map(|i| place(i, count, given)).collect() };
        assert_eq!(with(10, 10), (0..10).collect::<Vec<_>>());
        // Three groups beside six; what frames are off by alike stands last in both.
        assert_eq!(with(10, 7), [0, 1, 2, 0, 1, 2, 3, 4, 5, 6]);
        assert_eq!(with(7, 1), [0; 7]);
    }

    /// What two frames are off by alike adds up in their sum, however many windows each has.
    #[test]
    fn frames_that_are_off_alike_are_off_together() {
        let frame = |groups: usize, apart: f64| {
            let cycles = |cycles: f64| Replicate {
                stats: Stats {
                    cycles: (1e6 + cycles).round() as u64,
                    cores: vec![Default::default()],
                    ..Stats::default()
                },
                energy: EnergyReport::default(),
            };
            let pair = weight_of_pair(groups + READS, 20) * apart;
            let pairs = [pair, -pair, 0.0, 0.0].map(cycles);
            Estimate {
                detail: Detail::Full,
                tiles: 2048,
                detailed_tiles: 100,
                windows: groups as u64,
                frames: 1,
                whole_frames: WholeFrames::default(),
                freedom: 20,
                replicates: std::iter::repeat_with(|| cycles(0.0)).take(groups).chain(pairs).collect(),
            }
        };
        let off = |a: Estimate, b: Estimate| {
            let mut sum = a;
            sum.add(&b);
            sum.half_width(2e6, 0.0, |replicate| replicate.stats.cycles as f64)
        };
        for (a, b) in [(24, 24), (24, 32), (32, 24)] {
            let off = off(frame(a, 30_000.0), frame(b, 40_000.0));
            assert!((off - 70_000.0).abs() < 700.0, "{a} and {b} groups: {off}");
        }
    }

    /// A sum had the replicates of its first frame alone, if one of the others had none.
    #[test]
    fn a_sum_is_known_as_well_whatever_comes_first() {
        let frame = |replicates: usize| Estimate {
            detail: Detail::All,
            tiles: 288,
            detailed_tiles: 288,
            windows: 2,
            frames: 1,
            whole_frames: WholeFrames::default(),
            freedom: 0,
            replicates: vec![Replicate::default(); replicates],
        };
        for (first, second) in [(0, 1), (1, 0), (0, 0)] {
            let mut sum = frame(first);
            sum.add(&frame(second));
            assert_eq!((sum.replicates.len(), sum.frames), (0, 2), "{first} and {second}");
        }
    }

    #[test]
    fn what_is_read_from_dram_cancels_between_runs_of_the_same_work_alone() {
        let (count, a, b) = (24 + READS, 300.0, 100.0);
        // Both leave out windows alike, and both may read 2 and 3 % too much or too little.
        let replicates = |value: f64, reads: f64| -> Vec<f64> {
            let windows = (0..24).map(|i| value * (1.0 + 0.01 * f64::from(i % 3 - 1)));
            let pair = weight_of_pair(count, 20) * reads;
            windows.chain([pair, -pair, 0.0, 0.0].map(|apart| value * (1.0 + apart))).collect()
        };
        let (of_a, of_b) = (replicates(a, 0.02), replicates(b, 0.03));
        let width = |alike| half_width(3.0, &replicates_of_ratio((a, &of_a), (b, &of_b), alike), 20, 0.0) / 3.0;
        assert!((width(true) - 0.01).abs() < 2e-4, "{}", width(true));
        assert!((width(false) - 0.02f64.hypot(0.03)).abs() < 1e-3, "{}", width(false));
        let short = replicates_of_ratio((a, &of_a[..2]), (b, &of_b[..2]), false);
        assert_eq!(short, [3.0, 3.0], "no replicates for what is read");
        // The other run was simulated whole: it has one replicate, which is itself.
        let whole = half_width(3.0, &replicates_of_ratio((a, &of_a), (b, &[b]), false), 20, 0.0) / 3.0;
        let alone = half_width(a, &of_a, 20, 0.0) / a;
        assert!(alone > 0.02 && (whole - alone).abs() < 1e-3, "{whole} and {alone}");
    }

    #[test]
    fn without_windows_there_is_the_floor() {
        assert_eq!(half_width(10.0, &[], 0, FLOOR), FLOOR * 10.0);
        assert_eq!(half_width(-10.0, &[-10.0, -10.0], 1, FLOOR), FLOOR * 10.0);
    }

    #[test]
    fn small_frames_are_known_less_well_and_flights_of_them_better() {
        let of = |frames: u64, tiles: u64| {
            let detail = Detail::All;
            let (detailed_tiles, windows, whole_frames, freedom) = (0, 0, WholeFrames::default(), 0);
            let replicates = Vec::new();
            Estimate {
                detail,
                tiles: frames * tiles,
                detailed_tiles,
                windows,
                frames,
                whole_frames,
                freedom,
                replicates,
            }
            .floors()
        };
        assert_eq!([of(1, 2048), of(1, 100_000), of(60, 2048)], [Floors::default(); 3]);
        assert_eq!(of(1, 512), Floors { alone: 2.0 * FLOOR, with_memory: 4.0 * FLOOR });
        assert_eq!(of(4, 512), Floors { alone: FLOOR, with_memory: 2.0 * FLOOR });
        assert_eq!(of(60, 512), Floors::default());
    }

    #[test]
    fn fewer_windows_make_wider_intervals() {
        assert!((1..200).all(|f| student(f) >= student(f + 1)));
    }
}
