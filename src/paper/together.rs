//! Many replays of the same frames, in lockstep: each frame is read once, and in memory while all of them need it.

use std::sync::{Mutex, PoisonError};

use anyhow::{Result, anyhow};
use rayreel_machine::work::topology::Topology;
use rayreel_replay::PathSource;

use super::cache::Entry;
use super::jobs::{Stoppable, Task, pool};
use super::live::{Frame, Held};
use super::plan::Job;
use crate::progress;

/// What is done at a time while a frame is held.
enum Step<'a, S: PathSource> {
    /// The next frame is read.
    Read(u32, Mutex<Option<Frame>>),
    /// A job replays this one.
    Replay(Box<Mutex<Task<'a, Held<Stoppable<'a, S>>>>>),
}

impl<S: PathSource> Step<'_, S> {
    fn run(&self, held: &Held<Stoppable<'_, S>>, frame: u32, tree: Option<&Topology>) -> Result<()> {
        match self {
            Self::Read(next, read) => {
                *read.lock().unwrap_or_else(PoisonError::into_inner) = Some(held.read(*next)?);
                Ok(())
            }
            Self::Replay(task) => task.lock().unwrap_or_else(PoisonError::into_inner).frame(frame, tree, |_| {}),
        }
    }
}

/// Runs `jobs` on all frames of `source`. `tell` is told how many frames are done, and how many there are.
///
/// # Errors
/// The first error of a job; when interrupted.
pub fn run<S: PathSource>(jobs: &[&Job], source: &S, mut tell: impl FnMut(u64, u64)) -> Result<Vec<Entry>> {
    let held = Held::new(Stoppable(source));
    let frames = source.meta().frame_numbers();
    let tree = jobs.iter().any(|job| !job.simulated.is_empty()).then(|| source.topology());
    let mut steps = vec![Step::Read(frames.start, Mutex::new(None))];
    for &job in jobs {
        steps.push(Step::Replay(Box::new(Mutex::new(Task::new(job, &held)?))));
    }
    let threads = rayon::current_num_threads();
    pool(&steps[..1], threads, |step| step.run(&held, frames.start, None))?;
    for (done, frame) in (1..).zip(frames.clone()) {
        if let Step::Read(next, read) = &mut steps[0] {
            if let Some(read) = read.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
                held.hold(read);
            }
            *next = frame + 1;
        }
        // The next frame is read while this one is replayed: neither keeps all cores busy to its end.
        let work = if frame + 1 < frames.end { &steps[..] } else { &steps[1..] };
        pool(work, threads, |step| step.run(&held, frame, tree.as_ref()))?;
        if progress::stopped() {
            return Err(anyhow!("interrupted"));
        }
        tell(done, frames.len() as u64);
    }
    let entry = |step| match step {
        Step::Read(..) => None,
        Step::Replay(task) => Some(task.into_inner().unwrap_or_else(PoisonError::into_inner).finish()),
    };
    Ok(steps.into_iter().filter_map(entry).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rayreel_formats::Limits;
    use rayreel_formats::trace::Trace;
    use rayreel_machine::config::NamedMachine;
    use rayreel_tracer::accel;

    use super::*;
    use crate::common::{GridArgs, load_scene, meta};
    use crate::paper::live::Live;
    use crate::paper::plan::{Compared, Kind, Picture};
    use crate::paper::{policies, traces};

    /// One is traced where it is replayed, the other captured and read by each job for itself.
    #[test]
    fn together_is_as_one_after_the_other() {
        let scene = load_scene("teapot").unwrap();
        let built = accel::build(&scene).unwrap();
        let meta = meta(&scene, &GridArgs { size: (48, 32), samples: 1, depth: 4 }, 16, 3, 3);
        let machine = Arc::new(NamedMachine::load("sgrt-ti2", &[]).unwrap());
        let picture = Picture { frame: 4, kind: Kind::Result, shrink: 1, file: String::new() };
        let job = |(i, policy)| Job {
            shot: 0,
            policy,
            machine: Some(Arc::clone(&machine)),
            simulated: if i < 2 { vec![4] } else { Vec::new() },
            compared: [Compared::Valued, Compared::Seen, Compared::Not][i % 3],
            tiles: i % 2 == 1,
            pictures: vec![picture.clone(); i % 2],
        };
        let named = policies::load().unwrap().into_iter().map(|(_, policy)| policy);
        let jobs: Vec<Job> = named.enumerate().map(job).collect();

        let mut told = Vec::new();
        let live = Live::new(&scene, &built, &meta);
        let own: Vec<&Job> = jobs.iter().collect();
        let together = run(&own, &live, |done, of| told.push((done, of))).unwrap();
        assert_eq!(told, [(1, 3), (2, 3), (3, 3)]);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("teapot.rtrace");
        assert!(traces::make(&scene, &built, (&path, &meta), |_, _| {}).unwrap());
        let trace = Trace::open(&path, Limits::default()).unwrap();
        for (job, entry) in jobs.iter().zip(&together) {
            assert!(*entry == job.run(&trace, |_, _| {}).unwrap(), "{}", job.policy.name);
        }
        assert!(together[0].record.frames[1].machine.is_some() && together[5].record.frames[1].flicker.is_none());
    }
}
