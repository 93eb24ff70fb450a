//! One replay, and many of them at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use anyhow::Result;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::Trace;
use rayreel_machine::probes::Watch;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::image::{Srgb8, errors, files, srgb};
use rayreel_replay::maps;
use rayreel_replay::simulate::{MachineFrame, MachineRun, simulate};
use rayreel_replay::{FrameReplay, Options, PathSource, Replayer, TileSource};

use super::cache::Entry;
use super::plan::{Compared, Job, Kind, Picture as Wanted};
use super::record::{Frame, Record};
use crate::progress;

/// Measured work on a sample at the paper's size, in tenths of a microsecond of a core: to capture it,
pub const CAPTURE: u64 = 35;
/// to trace it without coding it,
pub const TRACE: u64 = 10;
/// to decode it,
const DECODE: u64 = 12;
/// to replay it under a policy,
const REPLAY: u64 = 4;
/// to simulate all its rays.
const MACHINE: u64 = 380;

impl Job {
    /// Expected work on `samples` samples a frame: a replay that need not decode is much faster, and an adaptive policy traces
    /// less than a third.
    pub fn weight(&self, samples: u64, frames: u32, live: bool) -> u64 {
        let machine = if self.policy.policy.kind() == "full" { MACHINE } else { MACHINE * 3 / 10 };
        let replay = if live { REPLAY } else { DECODE + REPLAY };
        samples * (replay * u64::from(frames) + machine * self.simulated.len() as u64)
    }

    /// Replays all frames of the trace. `tell` is told how much is done, and how much there is.
    ///
    /// # Errors
    /// A policy that does not fit the trace or the machine; a trace that cannot be read.
    pub fn run(&self, trace: &Trace, mut tell: impl FnMut(u64, u64)) -> Result<Entry> {
        let (meta, source) = (trace.meta(), Stoppable(trace));
        let tree = (!self.simulated.is_empty()).then(|| source.topology());
        let mut task = Task::new(self, &source)?;
        let tiles = u64::from(meta.tile_count());
        for (i, frame) in (0..).zip(meta.frame_numbers()) {
            task.frame(frame, tree.as_ref(), |own| tell(i * tiles + own, u64::from(meta.frames) * tiles))?;
        }
        Ok(task.finish())
    }
}

/// A job under way.
pub struct Task<'a, S> {
    job: &'a Job,
    replayer: Replayer<'a, S>,
    entry: Entry,
}

impl<'a, S: PathSource> Task<'a, S> {
    /// Begins a job.
    ///
    /// # Errors
    /// A policy that does not fit the source.
    pub fn new(job: &'a Job, source: &'a S) -> Result<Self> {
        let options = Options { reference: job.compared != Compared::Not, perception: job.compared == Compared::Seen };
        Ok(Self {
            job,
            replayer: Replayer::new(source, &job.policy.policy, options)?,
            entry: Entry { record: Record { frames: Vec::new() }, pictures: vec![Vec::new(); job.pictures.len()] },
        })
    }

    /// Replays the next frame; `tree` is the source's topology, if anything is simulated. `tell` is told how many tiles are
    /// done.
    ///
    /// # Errors
    /// A policy that does not fit the machine; a source that cannot be read.
    pub fn frame(&mut self, frame: u32, tree: Option<&Topology>, mut tell: impl FnMut(u64)) -> Result<()> {
        let (job, meta) = (self.job, self.replayer.source().meta());
        let machine = job.machine.as_ref().filter(|_| job.simulated.contains(&frame));
        let (replay, run) = match (machine, tree) {
            (Some(machine), Some(tree)) => {
                let mut watch = Watch::new(&mut tell);
                let named = (machine.name.as_str(), &machine.config);
                let MachineFrame { replay, stats, energy, paths } =
                    simulate(&mut self.replayer, frame, tree, named, &mut watch)?;
                (replay, Some((&**machine, MachineRun { stats, energy, paths })))
            }
            _ => (self.replayer.frame(frame)?, None),
        };
        let run = run.as_ref().map(|(machine, run)| (*machine, run));
        self.entry.record.frames.push(Frame::new(&job.policy, meta, &replay.stats, run, job.tiles));
        for (picture, bytes) in job.pictures.iter().zip(&mut self.entry.pictures) {
            if picture.frame == frame {
                *bytes = png(&replay, picture, meta)?;
            }
        }
        tell(u64::from(meta.tile_count()));
        Ok(())
    }

    /// What came of it.
    pub fn finish(self) -> Entry {
        self.entry
    }
}

/// A picture of a frame as a PNG file; empty if the replay has none of the kind.
fn png(frame: &FrameReplay, wanted: &Wanted, meta: &Meta) -> rayreel_replay::Result<Vec<u8>> {
    let reference = || frame.reference.as_ref().map(srgb::encode);
    let picture = match wanted.kind {
        Kind::Result => Some(srgb::encode(&frame.image)),
        Kind::Reference => reference(),
        Kind::Error => reference().map(|full| errors::amplified(&srgb::encode(&frame.image), &full)).transpose()?,
        Kind::Similarity => Some(maps::similarity_map_pixels(&frame.states, &frame.blocks, meta.samples)),
        Kind::Rate => Some(maps::rate_map_pixels(&frame.states, &frame.blocks, meta.samples)),
    };
    picture.map_or(Ok(Vec::new()), |picture| files::png(&shrunk(picture, wanted.shrink)))
}

/// The mean of each `by` x `by` pixels; columns and rows that do not fill one are cut off.
fn shrunk(picture: Srgb8, by: u32) -> Srgb8 {
    let (width, height) = (picture.width / by, picture.height / by);
    if by == 1 || width == 0 || height == 0 {
        return picture;
    }
    let mean = |i: u32| {
        let (left, top) = (i % width * by, i / width * by);
        let mut sums = [0u32; 3];
        for (x, y) in (top..top + by).flat_map(|y| (left..left + by).map(move |x| (x, y))) {
            let pixel = picture.pixels[y as usize * picture.width as usize + x as usize];
            sums.iter_mut().zip(pixel).for_each(|(sum, v)| *sum += u32::from(v));
        }
        sums.map(|sum| (sum / (by * by)) as u8)
    };
    Srgb8 { width, height, pixels: (0..width * height).map(mean).collect() }
}

/// Runs `work` on each of `items`, `threads` at a time, in their order. After an error, or when interrupted, no other is begun.
///
/// # Errors
/// The first error in the order of the items.
pub fn pool<T: Sync>(items: &[T], threads: usize, work: impl Fn(&T) -> Result<()> + Sync) -> Result<()> {
    let (next, failed) = (AtomicUsize::new(0), AtomicBool::new(false));
    let results: Vec<Mutex<Result<()>>> = items.iter().map(|_| Mutex::new(Ok(()))).collect();
    let run = || {
        while !failed.load(Ordering::Relaxed) && !progress::stopped() {
            let i = next.fetch_add(1, Ordering::Relaxed);
            let (Some(item), Some(result)) = (items.get(i), results.get(i)) else { return };
            let own = work(item);
            failed.fetch_or(own.is_err(), Ordering::Relaxed);
            if let Ok(mut result) = result.lock() {
                *result = own;
            }
        }
    };
    std::thread::scope(|scope| {
        (1..threads.min(items.len())).for_each(|_| drop(scope.spawn(run)));
        run();
    });
    results.into_iter().try_for_each(|result| result.into_inner().unwrap_or(Ok(())))
}

/// A source that cannot be read any more once a signal asked to stop, so that simulations end soon.
pub struct Stoppable<'a, S>(pub &'a S);

impl<S> Stoppable<'_, S> {
    fn checked(&self) -> rayreel_formats::Result<()> {
        if progress::stopped() { Err(rayreel_formats::Error::usage("interrupted")) } else { Ok(()) }
    }
}

impl<S: TileSource> TileSource for Stoppable<'_, S> {
    fn meta(&self) -> &Meta {
        self.0.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.0.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.0.camera(frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        self.checked()?;
        self.0.tile(frame, index)
    }
}

impl<S: PathSource> PathSource for Stoppable<'_, S> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shrinking_takes_means() {
        let pixels = vec![[0; 3], [4, 8, 12], [9; 3], [4, 0, 4], [8, 8, 8], [9; 3]];
        let small = shrunk(Srgb8 { width: 3, height: 2, pixels }, 2);
        assert_eq!(small, Srgb8 { width: 1, height: 1, pixels: vec![[4, 4, 6]] });
    }
}
