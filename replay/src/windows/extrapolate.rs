//! A frame from what its windows measured.

use rayreel_machine::config::MachineConfig;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::functional::{Features, exact_counters};
use rayreel_machine::stats::Stats;

use super::calibrate::{rates_used, weights};
use super::pass::Passed;
use super::window::Measured;
use crate::detail::{Detail, Estimate, READS, Replicate, WholeFrames, weight_of_pair};
use crate::simulate::MachineRun;

/// Parts that windows are left out in, one at a time.
const GROUPS: usize = 32;

/// How far the bytes that a frame of [`READS_TILES`] reads from DRAM may be off, as a part of them, though windows and pass agree: windows
/// begin with what the L2 holds in the pass, and are over before they have filled it anew. The mean of thirty runs read 2 % too
/// much and five of them more than 4; a frame of 512 tiles 10 %, the others up to 8 (docs/accuracy.md).
const READS_OFF: f64 = 0.04;
const READS_TILES: f64 = 2048.0;

/// A window, or several that count for themselves.
#[derive(Clone)]
struct Sum {
    counters: Vec<f64>,
    features: Features,
}

/// The frame in the hands of the estimator.
struct Frame<'a> {
    config: &'a MachineConfig,
    passed: &'a Passed,
    /// The windows that stand for themselves.
    certain: Sum,
    /// The other windows, and what they stand for.
    windows: Vec<Sum>,
    rest: Features,
    /// Rates that the weights depend on.
    rates: usize,
    is_exact: Stats,
}

/// The run of a frame of which the windows of `passed` were simulated.
pub fn extrapolate(config: &MachineConfig, passed: &Passed, detail: Detail) -> MachineRun {
    let frame = Frame::new(config, passed);
    let every = vec![true; frame.windows.len()];
    let measured_list = frame.list(&every);
    let estimated = frame.settled(&measured_list);
    let (stats, energy) = frame.run(&estimated);
    let groups = frame.windows.len().min(GROUPS);
    // What was simulated is not uncertain: where all is, nothing is.
    let (measured, rest) = (frame.measured(), frame.rest.size());
    let unknown = (1.0 - measured / rest.max(1.0)).clamp(0.0, 1.0).sqrt();
    // What is read from DRAM is the pass's in each of them, as in the estimate: which windows are kept says nothing about it.
    let replicates = (0..groups).map(|group| {
        let kept: Vec<bool> = (0..frame.windows.len()).map(|window| window % groups != group).collect();
        frame.replicate(&estimated, unknown, (&frame.settled(&frame.list(&kept)), &estimated))
    });
    // Size and rates were fitted to the windows.
    let freedom = groups.saturating_sub(1 + frame.rates).max(1) as u32;
    // Windows and pass disagree about what is read from DRAM, and both may be wrong about it: two more replicates of each, which make an
    // interval as wide as that.
    let (reads_more, apart) = (frame.reading_more(&estimated), weight_of_pair(groups + READS, freedom));
    let pairs = [(&measured_list, apart), (&measured_list, -apart), (&reads_more, apart), (&reads_more, -apart)];
    let pairs = pairs.into_iter().filter(|_| groups > 0);
    let pairs = pairs.map(|(list, apart)| frame.replicate(&estimated, apart, (list, &estimated)));
    let replicates = replicates.chain(pairs).collect();
    let tiles = passed.sizes.len() as u64;
    let (all, certain) = (frame.rest.size() + frame.certain.features.size(), frame.certain.features.size());
    let part = if all > 0.0 { (measured + certain) / all } else { 1.0 };
    let estimate = Estimate {
        detail,
        tiles,
        detailed_tiles: (part * tiles as f64).round().min(tiles as f64) as u64,
        windows: passed.windows.len() as u64,
        frames: 1,
        whole_frames: WholeFrames::default(),
        freedom,
        replicates,
    };
    MachineRun { stats, energy, paths: Default::default(), estimate: Some(estimate) }
}

impl<'a> Frame<'a> {
    fn new(config: &'a MachineConfig, passed: &'a Passed) -> Self {
        let nothing = Sum { counters: vec![0.0; passed.counted.list().len()], features: Features::default() };
        let (mut windows, mut certain) = (Vec::new(), nothing);
        for Measured { counters, features, is_certain } in &passed.windows {
            let sum = Sum { counters: counters.clone(), features: *features };
            if *is_certain {
                certain.add(&sum, 1.0);
            } else {
                windows.push(sum);
            }
        }
        let mut rest = passed.features;
        rest.add_part(&certain.features, -1.0);
        let rates = rates_used(windows.len());
        Self { config, passed, certain, windows, rest, rates, is_exact: exact_counters(config) }
    }

    /// Work of the windows that stand for others.
    fn measured(&self) -> f64 {
        self.windows.iter().map(|window| window.features.size()).sum()
    }

    /// All counters, estimated from those windows that are kept.
    fn list(&self, kept: &[bool]) -> Vec<f64> {
        let windows: Vec<&Sum> =
            self.windows.iter().zip(kept).filter_map(|(window, kept)| kept.then_some(window)).collect();
        let features: Vec<Features> = windows.iter().map(|window| window.features).collect();
        let mut sum = self.certain.clone();
        let weights = weights(&features, &self.rest, self.rates);
        for (window, weight) in windows.iter().zip(weights) {
            sum.add(window, weight);
        }
        sum.counters
    }

    /// The same counters, but reading from DRAM what the functional pass did ([`Stats::read_as`]). Where all is simulated the
    /// windows know it.
    fn settled(&self, list: &[f64]) -> Vec<f64> {
        if self.windows.is_empty() {
            return list.to_vec();
        }
        let mut stats = self.passed.counted.with_list(list);
        stats.read_as(&self.passed.counted);
        stats.list()
    }

    /// The same counters, but reading from DRAM as much more as pass and windows may be wrong by together.
    fn reading_more(&self, list: &[f64]) -> Vec<f64> {
        let fewer = READS_TILES / self.passed.sizes.len().max(1) as f64;
        let mut stats = self.passed.counted.with_list(list);
        // The fourth root: of 512 tiles 5.7 %, of 288 tiles 6.5 %. Powers are not the same on all machines, square roots are.
        stats.read_times(1.0 + READS_OFF * fewer.sqrt().sqrt());
        stats.list()
    }

    /// The run that differs from `estimated` by a part of how `one` differs from `other`.
    fn replicate(&self, estimated: &[f64], part: f64, (one, other): (&[f64], &[f64])) -> Replicate {
        let apart = one.iter().zip(other).map(|(one, other)| part * (one - other));
        let list: Vec<f64> = estimated.iter().zip(apart).map(|(value, apart)| value + apart).collect();
        let (stats, energy) = self.run(&list);
        Replicate { stats, energy }
    }

    /// A run with these counters, with what is known exactly in their place.
    fn run(&self, list: &[f64]) -> (Stats, EnergyReport) {
        let mut stats = self.passed.counted.with_list(list);
        stats.follow_work(&self.passed.counted);
        stats.make_exact(&self.passed.counted, &self.is_exact);
        stats.close_dram(self.config.l2.line_bytes);
        stats.close_accounts(self.config);
        let energy = EnergyReport::new(self.config, &stats);
        (stats, energy)
    }
}

impl Sum {
    fn add(&mut self, other: &Self, weight: f64) {
        self.counters.iter_mut().zip(&other.counters).for_each(|(sum, more)| *sum += weight * more);
        self.features.add_part(&other.features, weight);
    }
}
