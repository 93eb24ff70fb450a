//! Frames of which not every cycle is simulated: a functional pass over all tiles, and windows that are simulated beside it.
//!
//! ```text
//! tiles of work -> functional machine (counts, warm caches) -> features of all tiles ---.
//!             `--> windows, side by side (cycles) -> counters, features of windows ----> weights -> counters of the frame
//! ```
//!
//! After SMARTS (Wunderlich et al., ISCA 2003): between the windows the machine's long-lived state, its caches, is kept warm by
//! a pass without cycles. `work_line` tells where the rays lie, `places` chooses the windows, `window` simulates one, `pass` takes the
//! tiles through, `calibrate` weighs windows and `extrapolate` makes the frame. Several machines share a pass.

mod calibrate;
mod extrapolate;
mod pass;
mod places;
mod window;
mod work_line;

use std::sync::Arc;

use rayreel_formats::scene::Meta;
use rayreel_machine::config::{MachineConfig, Pipeline, PrimaryVisibility};
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::system::Probe;
use rayreel_machine::work::check::PathCounts;
use rayreel_machine::work::topology::Topology;

use crate::detail::{Detail, Estimate, Replicate, WholeFrames, WhyWhole};
use crate::error::{ReplayError, Result};
use crate::frame::{FrameReplay, PassedFrame, Replayer};
use crate::policy::Sampler;
use crate::simulate::{MachineRun, check_kernels, frame_shape, only, pass_all};
use crate::source::PathSource;
use pass::{MachinePass, Passed, Shared, WindowSlots};
use places::{Places, Tiles, UnderWay};
use work_line::WorkLine;

/// A frame is uniform of which this part of the work lies in parts that are alike: those whose sizes differ by less than [`ALIKE`]. Of
/// twelve scenes under three policies the most uniform has 0.25, a triangle before half a sky 0.40 to 0.53, nothing but sky 0.92 and more.
const UNIFORM: f64 = 0.35;
/// See [`UNIFORM`].
const ALIKE: f64 = 0.05;

/// A machine with its name.
pub type Named<'a> = (&'a str, &'a MachineConfig);

/// Passes after which the precision asked for is given up for a whole simulation.
const PASSES: usize = 3;

/// Replays a frame and runs its rays through machines, as `detail` says, in one pass for all of them. `probe` is told once that the
/// frame begins, however often it is passed.
///
/// # Errors
/// As [`crate::simulate::simulate`].
pub fn simulate_estimated<S: PathSource + ?Sized, P: Probe>(
    replayer: &mut Replayer<'_, S>,
    frame: u32,
    tree: &Topology,
    machines: &[Named<'_>],
    detail: Detail,
    probe: &mut P,
) -> Result<(FrameReplay, Vec<MachineRun>)> {
    probe.begin(frame);
    let mut simulation = Simulation { replayer, frame, tree, detail, probe, rays: Vec::new() };
    let tiles = tiles(simulation.replayer.source().meta());
    let places =
        |config| Places::of(detail, tiles, under_way(config)).filter(|_| detail == Detail::All || is_sampled(config));
    let mut places: Vec<_> = machines.iter().map(|(_, config)| places(config)).collect();
    if detail != Detail::All && places.iter().any(Option::is_some) {
        simulation.rays = simulation.replayer.ray_counts(frame)?;
        places = places.into_iter().map(|places| places.map(|places| simulation.by_work(places))).collect();
    }
    // A policy that cannot begin a frame again can be counted: that takes one pass.
    let begin = simulation.replayer.fork();
    let sampled = begin.is_some() && places.iter().any(Option::is_some);
    if !sampled && detail != Detail::Counts {
        let why = |(_, config): &Named<'_>, places: &Option<Places>| match places {
            Some(_) => WhyWhole::Policy,
            None => no_places(detail, config),
        };
        let why: Vec<_> = machines.iter().zip(&places).map(|(machine, places)| why(machine, places)).collect();
        let (passed, runs) = simulation.whole(machines, &why)?;
        return Ok((simulation.replayer.finish(passed)?, runs));
    }
    let (passed_frame, mut passed) = simulation.pass(machines, &places)?;
    let left: Vec<_> = passed.iter_mut().map(|passed| passed.caches.take()).collect();
    let mut runs = Vec::new();
    for ((machine, places), passed) in machines.iter().zip(places).zip(passed) {
        let mut run = simulation.conclude(*machine, places, passed, begin.as_deref())?;
        run.paths = passed_frame.paths;
        runs.push(run);
    }
    // The next frame begins with what the functional pass left, however often this one was passed. What was simulated whole has left
    // its own caches.
    for (((_, config), left), run) in machines.iter().zip(left).zip(&runs) {
        let is_whole = run.estimate.as_ref().is_some_and(|estimate| estimate.whole_frames.total() > 0);
        left.into_iter().filter(|_| !is_whole).for_each(|left| simulation.replayer.caches.keep(config, frame, || left));
    }
    Ok((simulation.replayer.finish(passed_frame)?, runs))
}

/// Tiles that a machine works on at a time.
fn slots(config: &MachineConfig) -> usize {
    (config.gpu.cores * config.gpu.tiles_in_flight.clamp(1, 255)) as usize
}

/// Whether a sample can stand for a frame on this machine. Where rays are gathered, or traced by threads, or come out of a rasteriser, the
/// pass tells too little of how the time goes, and intervals missed more often than they state (docs/accuracy.md).
fn is_sampled(config: &MachineConfig) -> bool {
    let is_raster = config.gpu.primary_visibility == PrimaryVisibility::Raster;
    !is_raster && !matches!(config.ti.pipeline, Pipeline::Gathering | Pipeline::Software)
}

/// Why a frame has no places for windows on a machine.
fn no_places(detail: Detail, config: &MachineConfig) -> WhyWhole {
    if detail == Detail::All || is_sampled(config) { WhyWhole::FewTiles } else { WhyWhole::Machine }
}

/// What a machine has under way at a time, at most.
fn under_way(config: &MachineConfig) -> UnderWay {
    let ti = &config.ti;
    UnderWay { slots: slots(config), rays: config.gpu.cores * ti.trv * ti.rays_per_trv }
}

/// The tiles of a frame.
fn tiles(meta: &Meta) -> Tiles {
    Tiles { count: meta.tile_count() as usize, samples: meta.tile * meta.tile }
}

/// A frame under way.
struct Simulation<'r, 'a, S: ?Sized, P> {
    replayer: &'r mut Replayer<'a, S>,
    frame: u32,
    tree: &'r Topology,
    detail: Detail,
    probe: &'r mut P,
    /// Of each tile, where windows are a sample.
    rays: Vec<u64>,
}

impl<S: PathSource + ?Sized, P: Probe> Simulation<'_, '_, S, P> {
    /// One pass over the tiles, for all machines.
    fn pass(&mut self, machines: &[Named<'_>], places: &[Option<Places>]) -> Result<(PassedFrame, Vec<Passed>)> {
        let (tree, stop) = (self.tree, self.replayer.stop().clone());
        // One for each thread: the pass brings the next while they run, and more would only take memory.
        let slots = WindowSlots::new(rayon::current_num_threads());
        let (meta, reads) = (self.replayer.source().meta(), self.replayer.reads());
        let mut passes: Vec<MachinePass<'_>> = machines
            .iter()
            .zip(places)
            .map(|((_, config), places)| {
                let caches = self.replayer.caches.of(config, self.frame);
                MachinePass::new((config, caches), tree, frame_shape(meta, config, reads), places.as_ref())
            })
            .collect();
        let shared = Shared { tree, stop: &stop, slots: &slots };
        let (frame, probe) = (self.frame, &mut *self.probe);
        let passed_frame = rayon::in_place_scope(|scope| {
            let mut tiles = 0;
            let passed_frame = self.replayer.pass(frame, tree, |work| {
                let work = Arc::new(work);
                for (machine, pass) in machines.iter().zip(&mut passes) {
                    check_kernels(*machine, &work)?;
                    pass.take(&work, shared, scope);
                }
                tiles += 1;
                probe.passed(tiles);
                Ok(())
            })?;
            passes.iter_mut().for_each(|pass| pass.close(shared, scope));
            Ok::<_, ReplayError>(passed_frame)
        })?;
        let passed: Result<Vec<_>> = passes.into_iter().map(MachinePass::finish).collect();
        Ok((passed_frame, passed?))
    }

    /// The run of a machine after a pass; more passes where one was not enough.
    fn conclude(
        &mut self,
        machine: Named<'_>,
        mut places: Option<Places>,
        mut passed: Passed,
        begin: Option<&dyn Sampler>,
    ) -> Result<MachineRun> {
        let config = machine.1;
        if self.detail == Detail::Counts {
            return Ok(counted(config, &passed));
        }
        let mut why = no_places(self.detail, config);
        for pass in 1..=PASSES {
            let Some(held) = places else { break };
            if let Some(no_parts) = self.without_typical_parts(&passed.sizes, slots(config)) {
                why = no_parts;
                break;
            }
            let run = extrapolate::extrapolate(config, &passed, self.detail);
            let Detail::Precision(wanted) = self.detail else { return Ok(run) };
            let width = widest(&run);
            if width <= wanted.fraction() {
                return Ok(run);
            }
            why = WhyWhole::Precision;
            if pass == PASSES {
                break;
            }
            // The width falls with the square root of the number of windows.
            let factor = (width / wanted.fraction()).powi(2) * 1.3;
            let more = held.more(tiles(self.replayer.source().meta()), factor.max(1.5));
            places = more.map(|places| self.by_work(places));
            if places.is_some() {
                begin.into_iter().for_each(|begin| self.replayer.restore(begin));
                let again = std::slice::from_ref(&places);
                let Some(next) = self.pass(&[machine], again)?.1.pop() else { break };
                passed = next;
            }
        }
        begin.into_iter().for_each(|begin| self.replayer.restore(begin));
        let (_, runs) = self.whole(&[machine], &[why])?;
        only(runs)
    }

    /// Windows at their places among the work of the frame.
    fn by_work(&self, places: Places) -> Places {
        let line = WorkLine::new(&self.rays, places.slots());
        places.by_work(&line)
    }

    /// Why windows cannot stand for a frame of these tiles; nothing if they can. Under `all` they stand for themselves, uniform or not.
    fn without_typical_parts(&self, tiles: &[f64], slots: usize) -> Option<WhyWhole> {
        if is_dominated(tiles, slots) {
            return Some(WhyWhole::OneTile);
        }
        (self.detail != Detail::All && is_uniform(tiles, slots)).then_some(WhyWhole::Uniform)
    }

    /// Every cycle of a frame that a sample cannot stand for, with the reason on each machine.
    fn whole(&mut self, machines: &[Named<'_>], why: &[WhyWhole]) -> Result<(PassedFrame, Vec<MachineRun>)> {
        let (passed, mut runs) = pass_all(self.replayer, self.frame, self.tree, machines, self.probe)?;
        let tiles = u64::from(self.replayer.source().meta().tile_count());
        for (run, why) in runs.iter_mut().zip(why) {
            run.estimate = Some(Estimate {
                detail: self.detail,
                tiles,
                detailed_tiles: tiles,
                windows: 0,
                frames: 1,
                whole_frames: WholeFrames::one(*why),
                freedom: 0,
                replicates: vec![Replicate { stats: run.stats.clone(), energy: run.energy.clone() }],
            });
        }
        Ok((passed, runs))
    }
}

/// What is known without cycles.
fn counted(config: &MachineConfig, passed: &Passed) -> MachineRun {
    let stats = passed.counted.clone();
    let energy = EnergyReport::new(config, &stats);
    let estimate = Estimate {
        detail: Detail::Counts,
        tiles: passed.sizes.len() as u64,
        detailed_tiles: 0,
        windows: 0,
        frames: 1,
        whole_frames: WholeFrames::default(),
        freedom: 0,
        replicates: Vec::new(),
    };
    MachineRun { stats, energy, paths: PathCounts::default(), estimate: Some(estimate) }
}

/// Whether one tile decides about the time of the frame: what all slots share between them takes no longer. Such a frame has no
/// typical parts.
fn is_dominated(tiles: &[f64], slots: usize) -> bool {
    let total: f64 = tiles.iter().sum();
    let largest = tiles.iter().copied().fold(0.0, f64::max);
    total <= 0.0 || largest * slots as f64 > total
}

/// Whether much of the frame's work lies in parts that take nearly the same, as sky and walls do. A part is as many tiles as the machine
/// works on at a time. There it does the same again and again, windows begin and end at the same point of that, and are all off in the same
/// way: cycles were up to 42 % off, where the windows' differences, which are all that intervals are made of, stated 4 %.
fn is_uniform(tiles: &[f64], slots: usize) -> bool {
    let parts: Vec<f64> = tiles.chunks_exact(slots).map(|part| part.iter().sum()).collect();
    let total: f64 = parts.iter().sum();
    let mut sorted = parts.clone();
    sorted.sort_by(f64::total_cmp);
    // The size of which half the work is smaller.
    let mut below = 0.0;
    let typical = sorted.into_iter().find(|size| {
        below += size;
        2.0 * below >= total
    });
    let Some(typical) = typical else { return false };
    let alike: f64 = parts.iter().filter(|size| (*size - typical).abs() <= ALIKE * typical).sum();
    total > 0.0 && alike >= UNIFORM * total
}

/// The wider of the intervals of cycles and energy, as a part of the value.
fn widest(run: &MachineRun) -> f64 {
    let Some(estimate) = &run.estimate else { return f64::INFINITY };
    let (cycles, energy) = (run.stats.cycles as f64, run.energy.gpu_fj() as f64);
    let floors = estimate.floors();
    let part = |value: f64, floor, of: fn(&Replicate) -> f64| estimate.half_width(value, floor, of) / value.max(1.0);
    part(cycles, floors.alone, |replicate| replicate.stats.cycles as f64).max(part(
        energy,
        floors.with_memory,
        |replicate| replicate.energy.gpu_fj() as f64,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_of_one_kind_of_tile_are_uniform() {
        assert!(is_uniform(&[7.0; 64], 8));
        assert!(!is_uniform(&[0.0; 64], 8) && !is_uniform(&[], 8));
        // Sizes that alternate make parts that do not.
        let alternating: Vec<f64> = (0..64).map(|i| if i % 2 == 0 { 5.0 } else { 9.0 }).collect();
        assert!(is_uniform(&alternating, 8) && !is_uniform(&(0..64).map(|i| f64::from(i + 1)).collect::<Vec<_>>(), 8));
        // Most tiles are cheap and alike, but not most of the work.
        let mut sky = vec![1.0; 448];
        sky.extend((0..64).map(|i| f64::from(100 + 10 * i)));
        assert!(!is_uniform(&sky, 8));
    }
}
