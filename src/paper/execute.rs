//! Doing what the plan asks for and the cache does not hold.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry as Slot;
use std::path::Path;
use std::sync::{Arc, Mutex};

use anyhow::{Context, Result, anyhow};
use rayreel_formats::trace::Trace;
use rayreel_replay::image::files::write_atomically;
use rayreel_tracer::accel::Built;

use super::cache::{Cache, Entry};
use super::jobs::{self, pool};
use super::live::Live;
use super::plan::{Job, Plan};
use super::record::Record;
use super::{together, traces};
use crate::common::{build, open};
use crate::progress::{self, Progress};

/// Jobs by shot.
type Todo = BTreeMap<usize, Vec<usize>>;

/// An open trace, and how many jobs still need it.
type OpenTrace = Mutex<(usize, Option<Arc<Trace>>)>;

/// The experiment under way.
pub struct Run<'a> {
    plan: &'a Plan<'a>,
    cache: &'a Cache,
    out: &'a Path,
    records: Vec<Mutex<Option<Record>>>,
    meter: Mutex<Meter>,
    built: BTreeMap<usize, Built>,
}

/// How far it is, over everything that is to be done.
struct Meter {
    bar: Progress,
    done: u64,
    /// Part of the jobs and captures that are being worked at.
    open: BTreeMap<(bool, usize), u64>,
}

impl Meter {
    /// Item `id` of weight `weight` is done to `part` of `whole`.
    fn tell(&mut self, id: (bool, usize), weight: u64, (part, whole): (u64, u64), what: impl FnOnce() -> String) {
        let own = u128::from(weight) * u128::from(part.min(whole)) / u128::from(whole.max(1));
        self.open.insert(id, own as u64);
        let now = self.done + self.open.values().sum::<u64>();
        self.bar.set(now, what);
    }

    fn close(&mut self, id: (bool, usize), weight: u64) {
        self.open.remove(&id);
        self.done += weight;
    }
}

/// Does all that is missing, and puts the pictures into `out`. The records, one a job; nothing when interrupted.
///
/// # Errors
/// The first thing that fails.
pub fn execute(plan: &Plan<'_>, cache: &Cache, out: &Path, quiet: bool) -> Result<Option<Vec<Record>>> {
    let mut run = Run {
        plan,
        cache,
        out,
        records: plan.jobs.iter().map(|_| Mutex::new(None)).collect(),
        meter: Mutex::new(Meter { bar: Progress::Quiet, done: 0, open: BTreeMap::new() }),
        built: BTreeMap::new(),
    };
    let (live, recorded): (Todo, Todo) = run.missing()?.into_iter().partition(|(i, _)| plan.shots[*i].path.is_none());
    let total = live.iter().chain(&recorded).map(|(shot, jobs)| run.shot_weight(*shot) + run.jobs_weight(jobs)).sum();
    run.meter = Mutex::new(Meter { bar: Progress::new("paper", total, quiet), done: 0, open: BTreeMap::new() });
    if !run.recorded(&recorded)? {
        return Ok(None);
    }
    for (shot, jobs) in &live {
        if !run.live(*shot, jobs)? {
            return Ok(None);
        }
    }
    if let Ok(meter) = run.meter.into_inner() {
        meter.bar.finish();
    }
    let records: Option<Vec<Record>> =
        run.records.into_iter().map(|record| record.into_inner().ok().flatten()).collect();
    records.map(Some).ok_or_else(|| anyhow!("a replay gave no result"))
}

impl Run<'_> {
    /// Takes what the cache holds; the jobs that it does not, by shot.
    fn missing(&self) -> Result<Todo> {
        let mut todo = Todo::new();
        for (i, job) in self.plan.jobs.iter().enumerate() {
            match self.cache.load(&self.plan.keys[i], job.pictures.len()) {
                Some(entry) => self.take(i, entry)?,
                None => todo.entry(job.shot).or_default().push(i),
            }
        }
        Ok(todo)
    }

    /// Keeps the record of job `i` and writes its pictures.
    fn take(&self, i: usize, entry: Entry) -> Result<()> {
        for (picture, bytes) in self.plan.jobs[i].pictures.iter().zip(&entry.pictures) {
            let path = self.out.join(&picture.file);
            if bytes.is_empty() || std::fs::read(&path).is_ok_and(|old| old == *bytes) {
                continue;
            }
            if let Some(folder) = path.parent() {
                std::fs::create_dir_all(folder)
                    .with_context(|| format!("cannot create folder {}", folder.display()))?;
            }
            write_atomically(&path, bytes)?;
        }
        if let Ok(mut record) = self.records[i].lock() {
            *record = Some(entry.record);
        }
        Ok(())
    }

    /// Of capturing, or of tracing what is not captured.
    fn shot_weight(&self, shot: usize) -> u64 {
        let shot = &self.plan.shots[shot];
        shot.samples() * if shot.path.is_some() { jobs::CAPTURE } else { jobs::TRACE }
    }

    fn job_weight(&self, job: &Job) -> u64 {
        let shot = &self.plan.shots[job.shot];
        job.weight(shot.samples() / u64::from(shot.meta.frames), shot.meta.frames, shot.path.is_none())
    }

    fn jobs_weight(&self, jobs: &[usize]) -> u64 {
        jobs.iter().map(|i| self.job_weight(&self.plan.jobs[*i])).sum()
    }

    /// Captures the shots and runs their jobs; false when interrupted.
    fn recorded(&mut self, todo: &Todo) -> Result<bool> {
        let mut traces = BTreeMap::new();
        for (&shot, jobs) in todo {
            let Some(trace) = self.trace(shot)? else { return Ok(false) };
            traces.insert(shot, Mutex::new((jobs.len(), Some(Arc::new(trace)))));
        }
        let mut jobs: Vec<usize> = todo.values().flatten().copied().collect();
        // The longest first, so that none is left over at the end.
        jobs.sort_by_key(|&i| (std::cmp::Reverse(self.job_weight(&self.plan.jobs[i])), i));
        let done = pool(&jobs, rayon::current_num_threads(), |&i| self.job(i, &traces));
        if progress::stopped() {
            return Ok(false);
        }
        done.map(|()| true)
    }

    /// Traces the frames of a shot and runs its jobs on them; false when interrupted.
    fn live(&mut self, index: usize, jobs: &[usize]) -> Result<bool> {
        let shot = &self.plan.shots[index];
        self.build(shot.scene)?;
        let source = Live::new(&self.plan.stages[shot.scene].scene, &self.built[&shot.scene], &shot.meta);
        let (weight, name) = (self.shot_weight(index) + self.jobs_weight(jobs), self.plan.scene_of(shot));
        let own: Vec<&Job> = jobs.iter().map(|i| &self.plan.jobs[*i]).collect();
        let entries = together::run(&own, &source, |part, of| {
            if let Ok(mut meter) = self.meter.lock() {
                let frame = u64::from(shot.meta.first_frame) + part;
                meter.tell((false, index), weight, (part, of), || format!("{name}, frame {frame}"));
            }
        });
        if progress::stopped() {
            return Ok(false);
        }
        for (&i, entry) in jobs.iter().zip(&entries?) {
            self.take(i, self.cache.store(&self.plan.keys[i], entry)?)?;
        }
        if let Ok(mut meter) = self.meter.lock() {
            meter.close((false, index), weight);
        }
        Ok(true)
    }

    /// Builds the BVH of a scene, once.
    fn build(&mut self, scene: usize) -> Result<()> {
        if let Slot::Vacant(slot) = self.built.entry(scene) {
            slot.insert(build(&self.plan.stages[scene].scene)?);
        }
        Ok(())
    }

    /// The trace of a shot, from the cache or captured; nothing when interrupted.
    fn trace(&mut self, index: usize) -> Result<Option<Trace>> {
        let (shot, weight) = (&self.plan.shots[index], self.shot_weight(index));
        let path = shot.path.as_deref().context("a live shot has no file")?;
        let (name, n) = (self.plan.scene_of(shot).to_owned(), shot.meta.samples);
        let close = |meter: &Mutex<Meter>| meter.lock().map(|mut m| m.close((false, index), weight)).is_ok();
        if let Some(trace) = traces::cached(path, &shot.meta) {
            close(&self.meter);
            return Ok(Some(trace));
        }
        let scene = &self.plan.stages[shot.scene].scene;
        self.build(shot.scene)?;
        let whole = traces::make(scene, &self.built[&shot.scene], (path, &shot.meta), |part, of| {
            if let Ok(mut meter) = self.meter.lock() {
                meter.tell((false, index), weight, (part, of), || format!("capture {name} {n}x{n}"));
            }
        })?;
        close(&self.meter);
        if !whole || progress::stopped() {
            return Ok(None);
        }
        Ok(Some(open(path)?))
    }

    /// Runs a job and keeps its result. The trace is closed behind its last job.
    fn job(&self, i: usize, traces: &BTreeMap<usize, OpenTrace>) -> Result<()> {
        let job = &self.plan.jobs[i];
        let slot = traces.get(&job.shot).context("a job without its trace")?;
        let trace = slot.lock().ok().and_then(|slot| slot.1.clone()).context("a trace was closed too early")?;
        let (weight, name) = (self.job_weight(job), self.plan.scene_of(&self.plan.shots[job.shot]));
        let entry = job.run(&trace, |part, whole| {
            if let Ok(mut meter) = self.meter.lock() {
                meter.tell((true, i), weight, (part, whole), || format!("{name} under {}", job.policy.name));
            }
        })?;
        drop(trace);
        if let Ok(mut slot) = slot.lock() {
            slot.0 -= 1;
            if slot.0 == 0 {
                slot.1 = None;
            }
        }
        self.take(i, self.cache.store(&self.plan.keys[i], &entry)?)?;
        if let Ok(mut meter) = self.meter.lock() {
            meter.close((true, i), weight);
        }
        Ok(())
    }
}
