//! Many points over the same frames, in lockstep: each frame is read once, and in memory while all of them need it.

use std::sync::{Mutex, PoisonError};

use rayreel_machine::probes::Watch;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::{PathSource, Stop};
use rayreel_study::StudyError;
use rayreel_study::point::key::Point;
use rayreel_study::point::task::{Computed, Missing, PointTask};
use rayreel_study::pool::Pool;

use crate::live::{FrameHolder, WholeFrame};

/// What is done at a time while a frame is held.
enum Step<'a, S: PathSource> {
    /// The next frame is read.
    Read(u32, Mutex<Option<WholeFrame>>),
    /// A point replays this one.
    Replay(Box<Mutex<PointTask<'a, FrameHolder<'a, S>>>>),
}

/// What all steps share.
struct Shared<'a, S> {
    holder: &'a FrameHolder<'a, S>,
    tree: Option<Topology>,
    stop: &'a Stop,
}

impl<S: PathSource> Step<'_, S> {
    fn run(&self, shared: &Shared<'_, S>, frame: u32) -> Result<(), StudyError> {
        match self {
            Self::Read(next, read) => {
                let whole = shared.holder.read(*next, shared.stop)?;
                *read.lock().unwrap_or_else(PoisonError::into_inner) = Some(whole);
                Ok(())
            }
            Self::Replay(task) => {
                let mut task = task.lock().unwrap_or_else(PoisonError::into_inner);
                task.frame(frame, shared.tree.as_ref(), &mut Watch::new(|_| {}))
            }
        }
    }
}

/// Computes what is missing of `points` on all frames of `source`. `tell` is told how many frames are done, and how many there
/// are.
///
/// # Errors
/// The first error of a point; an interruption.
pub fn run<S: PathSource>(
    points: &[(&Point, Missing)],
    source: &S,
    pool: &Pool,
    mut tell: impl FnMut(u64, u64),
) -> Result<Vec<Computed>, StudyError> {
    let holder = FrameHolder::new(source);
    let simulates = |(point, missing): &(&Point, Missing)| PointTask::<S>::simulates(point, *missing);
    let tree = points.iter().any(simulates).then(|| source.topology());
    let shared = Shared { holder: &holder, tree, stop: &pool.stop };
    let frames = source.meta().frame_numbers();
    let mut steps = vec![Step::Read(frames.start, Mutex::new(None))];
    for (point, missing) in points {
        let task = PointTask::new(&[(point, *missing)], &holder, &pool.stop)?;
        steps.push(Step::Replay(Box::new(Mutex::new(task))));
    }
    pool.each(&steps[..1], |step| step.run(&shared, frames.start))?;
    for (done, frame) in (1..).zip(frames.clone()) {
        if let Step::Read(next, read) = &mut steps[0] {
            if let Some(read) = read.get_mut().unwrap_or_else(PoisonError::into_inner).take() {
                holder.hold(read);
            }
            *next = frame + 1;
        }
        // The next frame is read while this one is replayed: neither keeps all cores busy to its end.
        let work = if frame + 1 < frames.end { &steps[..] } else { &steps[1..] };
        pool.each(work, |step| step.run(&shared, frame))?;
        pool.stop.check()?;
        tell(done, frames.len() as u64);
    }
    let computed = |step| match step {
        Step::Read(..) => Vec::new(),
        Step::Replay(task) => task.into_inner().unwrap_or_else(PoisonError::into_inner).finish(),
    };
    Ok(steps.into_iter().flat_map(computed).collect())
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use rayreel_machine::config::NamedMachine;
    use rayreel_replay::Detail;
    use rayreel_study::point::compute::compute;
    use rayreel_study::point::wanted::{Compared, Figures, Kind, PictureWanted, Views, Wanted};
    use rayreel_tracer::{SampleGrid, TraceSettings, accel};

    use super::*;
    use crate::live::LiveSource;
    use crate::{policies, traces};

    /// One is traced where it is replayed, the other captured and read by each point for itself.
    #[test]
    fn together_is_as_one_after_the_other() {
        let scene = rayreel_scenes::load("teapot").unwrap();
        let built = accel::build(&scene).unwrap();
        let grid = SampleGrid { width: 48, height: 32, samples: 1, tile: 16, first_frame: 3, frames: 3 };
        let meta = grid.meta(&scene, TraceSettings { max_depth: 4, ..TraceSettings::default() }, "test");
        let machine = Arc::new(NamedMachine::load("sgrt-ti2", &[]).unwrap());
        let picture = PictureWanted { frame: 4, kind: Kind::Result, shrink: 1 };
        let point = |(i, policy)| {
            let compared = [Compared::Valued, Compared::Seen, Compared::Not][i % 3];
            let figures = Figures::Frames { compared, simulated: if i < 2 { vec![4] } else { Vec::new() } };
            let views = Views { tiles: i % 2 == 1, pictures: vec![picture; i % 2] };
            let (machine, wanted) = (Some(Arc::clone(&machine)), Wanted { figures, views });
            Point { source: "test".into(), frames: (3, 3), machine, policy, detail: Detail::Full, wanted }
        };
        let named = policies::load().unwrap().into_iter().map(|(_, policy)| policy);
        let points: Vec<Point> = named.enumerate().map(point).collect();
        let wanted: Vec<_> = points.iter().map(|point| (point, Missing::all(point))).collect();

        let (stop, mut told) = (Stop::never(), Vec::new());
        let pool = Pool { threads: 2, stop: stop.clone() };
        let live = LiveSource::new(&scene, &built, &meta);
        let together = run(&wanted, &live, &pool, |done, of| told.push((done, of))).unwrap();
        assert_eq!(told, [(1, 3), (2, 3), (3, 3)]);

        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("teapot.rtrace");
        let trace = traces::make(&scene, &built, (&path, &meta), &|| false, |_, _| {}).unwrap();
        let tree = trace.topology();
        for ((point, missing), together) in wanted.iter().zip(&together) {
            let alone = compute(point, *missing, (&trace, Some(&tree)), &stop, |_, _| {}).unwrap();
            assert!(*together == alone, "{}", point.policy.name);
        }
        let frame = |i: usize| &together[i].details.as_ref().unwrap().frames[1];
        let figures = |i: usize| frame(i).figures.as_ref().unwrap();
        assert!(figures(0).row["cycles"].is_u64() && figures(2).row["cycles"].is_null());
        assert!(figures(5).flicker.is_none() && figures(0).flicker.is_some());
        assert!(!frame(1).tiles.is_empty());
    }

    #[test]
    fn a_request_to_stop_ends_it() {
        let scene = rayreel_scenes::load("cornell").unwrap();
        let built = accel::build(&scene).unwrap();
        let grid = SampleGrid { width: 16, height: 16, samples: 1, tile: 16, first_frame: 0, frames: 1 };
        let meta = grid.meta(&scene, TraceSettings::default(), "test");
        let stop = Stop::never();
        stop.request();
        let pool = Pool { threads: 1, stop };
        let ended = run(&[], &LiveSource::new(&scene, &built, &meta), &pool, |_, _| {});
        assert!(ended.unwrap_err().is_interruption());
    }
}
