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
use super::jobs::pool;
use super::plan::{Job, Plan};
use super::record::Record;
use super::traces;
use crate::common::{build, open};
use crate::progress::{self, Progress};

/// Work of capturing a sample, beside that of replaying it without a machine.
const CAPTURE: u64 = 4;

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
    let todo = run.missing()?;
    // What a run left that was killed between the last job of a trace and its removal.
    for (_, shot) in plan.shots.iter().enumerate().filter(|(i, shot)| !shot.keep && !todo.contains_key(i)) {
        let _ = std::fs::remove_file(&shot.path);
    }
    let total = todo.iter().map(|(shot, jobs)| run.capture_weight(*shot) + run.jobs_weight(jobs)).sum();
    run.meter = Mutex::new(Meter { bar: Progress::new("paper", total, quiet), done: 0, open: BTreeMap::new() });
    let mut batches: Vec<usize> = todo.keys().map(|shot| plan.shots[*shot].batch).collect();
    batches.sort_unstable();
    batches.dedup();
    for batch in batches {
        let own: BTreeMap<usize, Vec<usize>> =
            todo.iter().filter(|(shot, _)| plan.shots[**shot].batch == batch).map(|(s, j)| (*s, j.clone())).collect();
        if !run.batch(&own)? {
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
    fn missing(&self) -> Result<BTreeMap<usize, Vec<usize>>> {
        let mut todo: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
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

    fn capture_weight(&self, shot: usize) -> u64 {
        CAPTURE * self.plan.shots[shot].samples()
    }

    fn job_weight(&self, job: &Job) -> u64 {
        let shot = &self.plan.shots[job.shot];
        job.weight(shot.samples() / u64::from(shot.meta.frames), shot.meta.frames)
    }

    fn jobs_weight(&self, jobs: &[usize]) -> u64 {
        jobs.iter().map(|i| self.job_weight(&self.plan.jobs[*i])).sum()
    }

    /// Captures the shots and runs their jobs; false when interrupted.
    fn batch(&mut self, todo: &BTreeMap<usize, Vec<usize>>) -> Result<bool> {
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
        done?;
        for shot in todo.keys().map(|shot| &self.plan.shots[*shot]).filter(|shot| !shot.keep) {
            std::fs::remove_file(&shot.path).with_context(|| format!("cannot remove {}", shot.path.display()))?;
        }
        Ok(true)
    }

    /// The trace of a shot, from the cache or captured; nothing when interrupted.
    fn trace(&mut self, index: usize) -> Result<Option<Trace>> {
        let (shot, weight) = (&self.plan.shots[index], self.capture_weight(index));
        let (name, n) = (self.plan.scene_of(shot).to_owned(), shot.meta.samples);
        let close = |meter: &Mutex<Meter>| meter.lock().map(|mut m| m.close((false, index), weight)).is_ok();
        if let Some(trace) = traces::cached(&shot.path, &shot.meta) {
            close(&self.meter);
            return Ok(Some(trace));
        }
        let scene = &self.plan.stages[shot.scene].scene;
        if let Slot::Vacant(slot) = self.built.entry(shot.scene) {
            slot.insert(build(scene)?);
        }
        let whole = traces::make(scene, &self.built[&shot.scene], shot, |part, of| {
            if let Ok(mut meter) = self.meter.lock() {
                meter.tell((false, index), weight, (part, of), || format!("capture {name} {n}x{n}"));
            }
        })?;
        close(&self.meter);
        if !whole || progress::stopped() {
            return Ok(None);
        }
        Ok(Some(open(&shot.path)?))
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
