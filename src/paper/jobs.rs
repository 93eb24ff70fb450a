//! The simulations of the experiment, several at a time, their results in a fixed order.

use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Result, anyhow};
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::Trace;
use rayreel_replay::machine::config::NamedMachine;
use rayreel_replay::machine::probes::Watch;
use rayreel_replay::machine::simulate::simulate_each;
use rayreel_replay::machine::work::topology::Topology;
use rayreel_replay::report::{Origin, Report};
use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer, TileSource, replay_each};

use crate::progress::{self, Progress};
use crate::replay::write_pictures;

/// One simulation.
pub struct Job<'a> {
    /// Name in reports.
    pub name: &'a str,
    /// The trace.
    pub trace: &'a Trace,
    /// Size of its file: how long the simulation takes is roughly in proportion to it.
    pub bytes: u64,
    /// The policy.
    pub policy: &'a NamedPolicy,
    /// The machine, if there is one.
    pub machine: Option<&'a NamedMachine>,
    /// Where pictures go, if they are wanted.
    pub pictures: Option<PathBuf>,
}

impl Job<'_> {
    /// Expected work: adaptive traces roughly a third.
    fn weight(&self) -> u64 {
        if self.policy.name == "full" { 3 * self.bytes } else { self.bytes }.max(1)
    }

    fn run(&self, done: impl FnMut(u64)) -> Result<Report> {
        let (meta, source) = (self.trace.meta(), Stoppable(self.trace));
        let frames = meta.frame_numbers();
        let options = Options { reference: self.pictures.is_some() };
        let sink = |frame: rayreel_replay::FrameReplay| match &self.pictures {
            Some(folder) => write_pictures(&frame, meta.samples, folder, ""),
            None => Ok(()),
        };
        let origin = Origin { trace: self.name.into(), trace_digest: None };
        let Some(machine) = self.machine else {
            let stats = replay_each(&source, &self.policy.policy, frames, options, sink)?;
            return Ok(Report::new(&origin, self.policy, meta, &stats));
        };
        let mut replayer = Replayer::new(&source, &self.policy.policy, options)?;
        let named = (machine.name.as_str(), &machine.config);
        let (stats, runs) = simulate_each(&mut replayer, frames, named, &mut Watch::new(done), sink)?;
        Ok(Report::new(&origin, self.policy, meta, &stats).with_machine(machine, &runs))
    }
}

/// Runs all jobs, `threads` at a time; their reports in their order. Nothing when interrupted.
///
/// # Errors
/// The first error in the order of the jobs.
pub fn run_all(jobs: &[Job<'_>], threads: usize, quiet: bool) -> Result<Option<Vec<Report>>> {
    let total = jobs.iter().map(Job::weight).sum();
    let bar = Mutex::new((Progress::new("simulate", total, quiet), vec![0; jobs.len()]));
    let reports: Vec<_> = jobs.iter().map(|_| Mutex::new(None)).collect();
    // The longest first, so that none is left over at the end.
    let mut order: Vec<usize> = (0..jobs.len()).collect();
    order.sort_by_key(|&i| (std::cmp::Reverse(jobs[i].weight()), i));
    let next = AtomicUsize::new(0);
    let work = || {
        while let Some(&i) = order.get(next.fetch_add(1, Ordering::Relaxed)) {
            let job = &jobs[i];
            let tell = |part: u64, whole: u64| {
                let Ok(mut bar) = bar.lock() else { return };
                bar.1[i] = u128::from(job.weight()) * u128::from(part) / u128::from(whole.max(1));
                let done = bar.1.iter().sum::<u128>();
                bar.0.set(done as u64, || format!("{} under {}", job.name, job.policy.name));
            };
            let tiles = u64::from(job.trace.meta().tile_count());
            let report = job.run(|done| tell(done, tiles));
            tell(1, 1);
            let failed = report.is_err();
            if let Ok(mut slot) = reports[i].lock() {
                *slot = Some(report);
            }
            if failed {
                next.store(jobs.len(), Ordering::Relaxed);
            }
        }
    };
    std::thread::scope(|scope| {
        (1..threads.min(jobs.len())).for_each(|_| drop(scope.spawn(work)));
        work();
    });
    if let Ok((bar, _)) = bar.into_inner() {
        bar.finish();
    }
    if progress::stopped() {
        return Ok(None);
    }
    let found: Vec<_> = reports.into_iter().filter_map(|slot| slot.into_inner().ok().flatten()).collect();
    let reports: Vec<Report> = found.into_iter().collect::<Result<_>>()?;
    if reports.len() == jobs.len() { Ok(Some(reports)) } else { Err(anyhow!("a simulation gave no result")) }
}

/// A trace that cannot be read any more once a signal asked to stop, so that simulations end soon.
struct Stoppable<'a>(&'a Trace);

impl Stoppable<'_> {
    fn checked(&self) -> rayreel_formats::Result<()> {
        if progress::stopped() { Err(rayreel_formats::Error::usage("interrupted")) } else { Ok(()) }
    }
}

impl TileSource for Stoppable<'_> {
    fn meta(&self) -> &Meta {
        self.0.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.0.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        TileSource::camera(self.0, frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        self.checked()?;
        TileSource::tile(self.0, frame, index)
    }
}

impl PathSource for Stoppable<'_> {
    fn topology(&self) -> Topology {
        self.0.topology()
    }

    fn material_of(&self, triangle: u32) -> u32 {
        self.0.material_of(triangle)
    }

    fn tile_with_paths(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        self.checked()?;
        self.0.tile_with_paths(frame, index)
    }
}

/// Size of a file; 0 if it cannot be asked for.
pub fn file_bytes(path: &Path) -> u64 {
    std::fs::metadata(path).map_or(0, |meta| meta.len())
}
