//! A frame from what its windows measured.

use rayreel_machine::config::MachineConfig;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::functional::{Features, exact_counters};
use rayreel_machine::stats::Stats;

use super::blocks::Blocks;
use super::calibrate::{rates_used, weights};
use super::pass::Passed;
use super::window::Measured;
use crate::detail::{Detail, Estimate, Replicate};
use crate::simulate::MachineRun;

/// Parts that windows are left out in, one at a time.
const GROUPS: usize = 32;

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
    /// The first block, the last one and the heavy ones: they stand for themselves.
    certain: Sum,
    /// The windows between, and what they stand for.
    windows: Vec<Sum>,
    rest: Features,
    /// Rates that the weights depend on: none where every block is a window, for then only what crossed between them is
    /// missing, or there twice.
    rates: usize,
    is_exact: Stats,
}

/// The run of a frame of which the windows of `passed` were simulated.
pub fn extrapolate(config: &MachineConfig, blocks: &Blocks, passed: &Passed, detail: Detail) -> MachineRun {
    let frame = Frame::new(config, blocks, passed);
    let every = vec![true; frame.windows.len()];
    let estimated = frame.list(&every);
    let (stats, energy) = frame.run(&estimated);
    let groups = frame.windows.len().min(GROUPS);
    let free = blocks.middle().1 - passed.heavy.len();
    // What was simulated is not uncertain: where all is, nothing is.
    let unknown = (1.0 - frame.windows.len() as f64 / free.max(1) as f64).max(0.0).sqrt();
    let replicates = (0..groups).map(|group| {
        let kept: Vec<bool> = (0..frame.windows.len()).map(|window| window % groups != group).collect();
        let list: Vec<f64> =
            frame.list(&kept).iter().zip(&estimated).map(|(other, value)| value + unknown * (other - value)).collect();
        let (stats, energy) = frame.run(&list);
        Replicate { stats, energy }
    });
    let detailed: usize = passed.windows.keys().map(|&block| blocks.tiles(block).len()).sum();
    let estimate = Estimate {
        detail,
        tiles: passed.features.len() as u64,
        detailed_tiles: detailed as u64,
        windows: passed.windows.len() as u64,
        whole_frames: 0,
        // Size and rates were fitted to the windows.
        freedom: groups.saturating_sub(1 + frame.rates).max(1) as u32,
        replicates: replicates.collect(),
    };
    MachineRun { stats, energy, paths: Default::default(), estimate: Some(estimate) }
}

impl<'a> Frame<'a> {
    fn new(config: &'a MachineConfig, blocks: &Blocks, passed: &'a Passed) -> Self {
        let mut total = Features::default();
        passed.features.iter().for_each(|tile| total.add_part(tile, 1.0));
        let (mut windows, mut certain) = (Vec::new(), None::<Sum>);
        for (&block, measured) in &passed.windows {
            let sum = Sum::new(measured, &passed.features);
            if !blocks.is_edge(block) && !passed.heavy.contains(&block) {
                windows.push(sum);
            } else if let Some(certain) = &mut certain {
                certain.add(&sum, 1.0);
            } else {
                certain = Some(sum);
            }
        }
        let nothing = Sum { counters: vec![0.0; passed.counted.list().len()], features: Features::default() };
        let certain = certain.unwrap_or(nothing);
        let mut rest = total;
        rest.add_part(&certain.features, -1.0);
        let all = passed.windows.len() == blocks.len();
        let rates = if all { 0 } else { rates_used(windows.len()) };
        Self { config, passed, certain, windows, rest, rates, is_exact: exact_counters(config) }
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

    /// A run with these counters, with what is known exactly in their place.
    fn run(&self, list: &[f64]) -> (Stats, EnergyReport) {
        let mut stats = self.passed.counted.with_list(list);
        stats.make_exact(&self.passed.counted, &self.is_exact);
        stats.close_accounts(self.config);
        let energy = EnergyReport::new(self.config, &stats);
        (stats, energy)
    }
}

impl Sum {
    fn new(measured: &Measured, tiles: &[Features]) -> Self {
        let mut features = Features::default();
        measured.parts.iter().for_each(|&(tile, part)| features.add_part(&tiles[tile as usize], part));
        Self { counters: measured.counters.clone(), features }
    }

    fn add(&mut self, other: &Self, weight: f64) {
        self.counters.iter_mut().zip(&other.counters).for_each(|(sum, more)| *sum += weight * more);
        self.features.add_part(&other.features, weight);
    }
}
