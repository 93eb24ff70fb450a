//! One replay, and many of them at a time.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use anyhow::Result;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_formats::trace::Trace;
use rayreel_replay::image::{Srgb8, errors, files, map, srgb};
use rayreel_replay::machine::probes::Watch;
use rayreel_replay::machine::simulate::{MachineFrame, MachineRun, simulate};
use rayreel_replay::machine::work::topology::Topology;
use rayreel_replay::{FrameReplay, Options, PathSource, Replayer, TileSource};

use super::cache::Entry;
use super::plan::{Job, Kind, Picture as Wanted};
use super::record::{Frame, Record};
use crate::progress;

impl Job {
    /// Expected work on `samples` samples a frame: measured, a machine takes some twenty times as long as a replay without one,
    /// and an adaptive policy traces less than half.
    pub fn weight(&self, samples: u64, frames: u32) -> u64 {
        let machine = if self.policy.policy.kind() == "full" { 24 } else { 10 };
        samples * (u64::from(frames) + machine * self.simulated.len() as u64)
    }

    /// Replays all frames of the trace. `tell` is told how much is done, and how much there is.
    ///
    /// # Errors
    /// A policy that does not fit the trace or the machine; a trace that cannot be read.
    pub fn run(&self, trace: &Trace, mut tell: impl FnMut(u64, u64)) -> Result<Entry> {
        let (meta, source) = (trace.meta(), Stoppable(trace));
        let mut replayer = Replayer::new(&source, &self.policy.policy, Options { reference: self.compared })?;
        let tree = (!self.simulated.is_empty()).then(|| source.topology());
        let mut entry =
            Entry { record: Record { frames: Vec::new() }, pictures: vec![Vec::new(); self.pictures.len()] };
        let tiles = u64::from(meta.tile_count());
        for (i, frame) in (0..).zip(meta.frame_numbers()) {
            let machine = self.machine.as_ref().filter(|_| self.simulated.contains(&frame));
            let (replay, run) = match (machine, &tree) {
                (Some(machine), Some(tree)) => {
                    let mut watch = Watch::new(|own| tell(i * tiles + own, u64::from(meta.frames) * tiles));
                    let named = (machine.name.as_str(), &machine.config);
                    let MachineFrame { replay, stats, energy, paths } =
                        simulate(&mut replayer, frame, tree, named, &mut watch)?;
                    (replay, Some((&**machine, MachineRun { stats, energy, paths })))
                }
                _ => (replayer.frame(frame)?, None),
            };
            let run = run.as_ref().map(|(machine, run)| (*machine, run));
            entry.record.frames.push(Frame::new(&self.policy, meta, &replay.stats, run, self.tiles));
            for (picture, bytes) in self.pictures.iter().zip(&mut entry.pictures) {
                if picture.frame == frame {
                    *bytes = png(&replay, picture, meta)?;
                }
            }
            tell((i + 1) * tiles, u64::from(meta.frames) * tiles);
        }
        Ok(entry)
    }
}

/// A picture of a frame as a PNG file; empty if the replay has none of the kind.
fn png(frame: &FrameReplay, wanted: &Wanted, meta: &Meta) -> rayreel_replay::Result<Vec<u8>> {
    let reference = || frame.reference.as_ref().map(srgb::encode);
    let picture = match wanted.kind {
        Kind::Result => Some(srgb::encode(&frame.image)),
        Kind::Reference => reference(),
        Kind::Error => reference().map(|full| errors::amplified(&srgb::encode(&frame.image), &full)).transpose()?,
        Kind::Similarity => Some(map::similarity_map_pixels(&frame.states, &frame.blocks, meta.samples)),
        Kind::Rate => Some(map::rate_map_pixels(&frame.states, &frame.blocks, meta.samples)),
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
