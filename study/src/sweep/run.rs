//! Computing the points of a shard.
//!
//! Workers take points in the order of the plan and hand their rows to one writer, which puts what is finished into a segment
//! while they go on: no worker waits for a disk. A row is safe once its segment has its name, so a `kill -9` costs the points that
//! were being computed and those of the segment being written. A signal ends every simulation at its next tile and writes what is
//! finished.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayreel_formats::trace::Trace;

use crate::error::Result;
use crate::point::compute::{chain, compute};
use crate::point::decoded::Decoded;
use crate::point::row::{Column, Row};
use crate::sweep::folder::Folder;
use crate::sweep::known::Known;
use crate::sweep::plan::BUCKET;
use crate::sweep::segment::{self, Writer};
use crate::sweep::shard::Shard;
use rayreel_machine::probes::Watch;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::{PathSource, TileSource};

/// How often the writer looks for a signal.
const LOOK: Duration = Duration::from_millis(50);

/// How a shard is run.
pub struct Settings<'a> {
    /// Which points.
    pub shard: Shard,
    /// Points at a time.
    pub threads: usize,
    /// Bytes of decoded tiles that are kept.
    pub memory: usize,
    /// Least time between two segments: zero writes whatever is finished at once; on a shared file system seconds save files.
    pub flush: Duration,
    /// Who runs it.
    pub writer: Writer,
    /// Set to stop.
    pub stop: Arc<AtomicBool>,
    /// Opens a trace at the location of the plan.
    pub open: &'a (dyn Fn(&str) -> Result<Trace, String> + Sync),
    /// Rows of other sweeps: points that need not be computed.
    pub known: &'a Known,
}

/// What is told while a shard runs.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Told {
    /// Points whose rows were there before, at the beginning.
    pub skipped: usize,
    /// Points to do, at the beginning.
    pub todo: usize,
    /// Points done, with those being computed in part.
    pub done: f64,
    /// Points whose rows are on disk.
    pub saved: usize,
    /// Points whose rows say that they cannot be computed.
    pub failed: usize,
}

/// What came of a shard.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Outcome {
    /// Points of the shard.
    pub points: usize,
    /// Points whose rows were there before.
    pub skipped: usize,
    /// Rows taken from other sweeps.
    pub reused: usize,
    /// Points computed.
    pub computed: usize,
    /// Those of them that cannot be computed.
    pub failed: usize,
    /// Points that this attempt could not do and another may: what they are, and why.
    pub troubles: Vec<(String, String)>,
    /// Whether a signal ended it.
    pub interrupted: bool,
}

/// A point to compute: its number in the plan.
type Todo = usize;

/// What a worker reports.
enum Done {
    Row { point: usize, row: Box<Row>, columns: Vec<Column> },
    Trouble { point: usize, why: String },
}

/// Runs a shard. `tell` is told how far it is: once before anything is computed, then several times a second.
///
/// # Errors
/// A folder that cannot be read or written. What is wrong with a point is in its row, or in the outcome.
pub fn run(folder: &Folder, settings: &Settings<'_>, mut tell: impl FnMut(&Told)) -> Result<Outcome> {
    let plan = folder.plan();
    let range = settings.shard.points(plan.points.len());
    let mut outcome = Outcome { points: range.len(), ..Outcome::default() };
    let mut saver = Saver {
        folder,
        settings,
        pending: BTreeMap::new(),
        left: BTreeMap::new(),
        also: BTreeMap::new(),
        number: 0,
        kept: None,
    };
    let todo = missing(folder, range, &mut outcome, &mut saver)?;
    let queue = Queue::new(folder, settings, &todo);
    let (sender, receiver) = channel();
    let mut told = Told { skipped: outcome.skipped, todo: todo.len(), ..Told::default() };
    tell(&told);
    let ended = std::thread::scope(|scope| {
        for number in 0..settings.threads.min(todo.len()) {
            let (queue, sender) = (&queue, sender.clone());
            scope.spawn(move || queue.work(number, &sender));
        }
        drop(sender);
        let ended = collect(&receiver, &mut saver, &mut outcome, |saver, outcome| {
            told.saved = outcome.computed.saturating_sub(saver.waiting());
            told.failed = outcome.failed;
            told.done = outcome.computed as f64 + queue.part();
            tell(&told);
        });
        // After an error nobody waits for the workers' rows: they are to end too.
        queue.broken.store(ended.is_err(), Ordering::Relaxed);
        ended
    });
    ended?;
    outcome.interrupted = settings.stop.load(Ordering::Relaxed);
    Ok(outcome)
}

/// The points that have no row yet, each key once; takes rows of other sweeps.
fn missing<'a>(
    folder: &'a Folder,
    range: std::ops::Range<usize>,
    outcome: &mut Outcome,
    saver: &mut Saver<'a>,
) -> Result<Vec<Todo>> {
    let (mut todo, mut seen) = (Vec::new(), BTreeMap::new());
    if range.is_empty() {
        return Ok(todo);
    }
    for bucket in range.start / BUCKET..=(range.end - 1) / BUCKET {
        let held = segment::read(folder, bucket)?;
        let own = folder.bucket(bucket);
        let mut left = 0;
        for point in own.start.max(range.start)..own.end.min(range.end) {
            let key = &folder.plan().points[point].key;
            if held.rows.contains_key(key) {
                outcome.skipped += 1;
            } else if let Some(row) = saver.settings.known.rows.get(key) {
                saver.pending.entry(bucket).or_default().push(row.clone());
                outcome.reused += 1;
            } else if let Some(first) = seen.get(key) {
                // Computed once, and put into every bucket that has a point of this key.
                left += usize::from(*first != bucket && saver.also.entry(key).or_default().insert(bucket));
            } else {
                seen.insert(key, bucket);
                todo.push(point);
                left += 1;
            }
        }
        if outcome.reused > 0 {
            segment::write_columns(folder, &saver.settings.known.columns, &saver.settings.writer)?;
        }
        saver.left.insert(bucket, left);
        saver.flush(bucket)?;
    }
    Ok(todo)
}

/// Takes rows as they come and saves them.
fn collect(
    receiver: &Receiver<Done>,
    saver: &mut Saver<'_>,
    outcome: &mut Outcome,
    mut tell: impl FnMut(&Saver<'_>, &Outcome),
) -> Result<()> {
    let mut last = Instant::now();
    loop {
        match receiver.recv_timeout(LOOK) {
            Ok(done) => {
                let mut next = Some(done);
                // Whatever else is finished goes into the same segment.
                while let Some(done) = next {
                    saver.take(done, outcome)?;
                    next = receiver.try_recv().ok();
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if last.elapsed() >= saver.settings.flush {
            saver.flush_all()?;
            last = Instant::now();
        }
        tell(saver, outcome);
    }
    saver.flush_all()?;
    tell(saver, outcome);
    Ok(())
}

/// Puts rows into segments, and seals buckets.
struct Saver<'a> {
    folder: &'a Folder,
    settings: &'a Settings<'a>,
    /// Rows that are not on disk yet, by bucket.
    pending: BTreeMap<usize, Vec<Row>>,
    /// Points of each bucket that this shard still has to do.
    left: BTreeMap<usize, usize>,
    /// Other buckets with points of a key that is computed for one of them.
    also: BTreeMap<&'a str, BTreeSet<usize>>,
    /// Segments written.
    number: u64,
    /// The columns that were written last: most rows have the same.
    kept: Option<Vec<Column>>,
}

impl Saver<'_> {
    fn waiting(&self) -> usize {
        self.pending.values().map(Vec::len).sum()
    }

    fn take(&mut self, done: Done, outcome: &mut Outcome) -> Result<()> {
        match done {
            Done::Trouble { point, why } => outcome.troubles.push((self.folder.plan().describe(point), why)),
            Done::Row { point, row, columns } => {
                if row.error.is_none() && self.kept.as_ref() != Some(&columns) {
                    // Before the rows: a row whose columns nobody can explain must not be on disk.
                    segment::write_columns(self.folder, &columns, &self.settings.writer)?;
                    self.kept = Some(columns);
                }
                outcome.computed += 1;
                outcome.failed += usize::from(row.error.is_some());
                let others = self.also.remove(row.key.as_str()).unwrap_or_default();
                for bucket in others.into_iter().chain([point / BUCKET]) {
                    self.pending.entry(bucket).or_default().push((*row).clone());
                    self.left.entry(bucket).and_modify(|left| *left = left.saturating_sub(1));
                }
            }
        }
        Ok(())
    }

    fn flush_all(&mut self) -> Result<()> {
        let buckets: Vec<usize> = self.pending.keys().copied().collect();
        buckets.into_iter().try_for_each(|bucket| self.flush(bucket))
    }

    /// Writes the rows of a bucket; seals it when this shard has done its part. Another shard may have done the rest.
    fn flush(&mut self, bucket: usize) -> Result<()> {
        if let Some(rows) = self.pending.remove(&bucket).filter(|rows| !rows.is_empty()) {
            segment::write(self.folder, bucket, self.number, &rows, &self.settings.writer)?;
            self.number += 1;
        }
        if self.left.get(&bucket) == Some(&0) {
            segment::seal(self.folder, bucket, &self.settings.writer)?;
            self.left.remove(&bucket);
        }
        Ok(())
    }
}

/// A trace that workers share.
#[derive(Default)]
struct Shared {
    /// Opened by the first that needs it, closed by the last.
    trace: Mutex<Option<Result<Arc<Opened>, String>>>,
    /// Points that still need it.
    left: AtomicUsize,
}

/// An open trace.
struct Opened {
    source: Decoded,
    tree: Topology,
}

/// The points to do, and what the workers share.
struct Queue<'a> {
    folder: &'a Folder,
    settings: &'a Settings<'a>,
    todo: &'a [Todo],
    next: AtomicUsize,
    broken: AtomicBool,
    traces: Vec<Shared>,
    /// How much of its point each worker has done, in millionths.
    parts: Vec<AtomicUsize>,
}

impl<'a> Queue<'a> {
    fn new(folder: &'a Folder, settings: &'a Settings<'a>, todo: &'a [Todo]) -> Self {
        let traces: Vec<Shared> = folder.plan().traces.iter().map(|_| Shared::default()).collect();
        for point in todo {
            traces[folder.plan().points[*point].trace].left.fetch_add(1, Ordering::Relaxed);
        }
        let parts = (0..settings.threads).map(|_| AtomicUsize::new(0)).collect();
        Self { folder, settings, todo, next: AtomicUsize::new(0), broken: AtomicBool::new(false), traces, parts }
    }

    /// Points being computed, in parts.
    fn part(&self) -> f64 {
        self.parts.iter().map(|part| part.load(Ordering::Relaxed) as f64 * 1e-6).sum()
    }

    fn ended(&self) -> bool {
        self.settings.stop.load(Ordering::Relaxed) || self.broken.load(Ordering::Relaxed)
    }

    /// Worker `number` takes points until there are none.
    fn work(&self, number: usize, sender: &Sender<Done>) {
        while !self.ended() {
            let Some(&point) = self.todo.get(self.next.fetch_add(1, Ordering::Relaxed)) else { return };
            let done = match self.one(point, &self.parts[number]) {
                Ok((row, columns)) => Done::Row { point, row: Box::new(row), columns },
                Err(_) if self.ended() => return,
                Err(why) => Done::Trouble { point, why },
            };
            self.parts[number].store(0, Ordering::Relaxed);
            self.release(self.folder.plan().points[point].trace);
            if sender.send(done).is_err() {
                return;
            }
        }
    }

    fn one(&self, point: usize, part: &AtomicUsize) -> Result<(Row, Vec<Column>), String> {
        let own = &self.folder.plan().points[point];
        let resolved = self.folder.plan().resolve(own).map_err(|e| e.to_string())?;
        let opened = self.open(own.trace)?;
        let tiles = u64::from(opened.source.meta().tile_count());
        let whole = (tiles * u64::from(own.frames.1)).max(1);
        let (mut before, mut last) = (0, 0);
        let mut watch = Watch::new(|now| {
            // Tiles are counted anew in each frame.
            before += if now < last { tiles } else { 0 };
            last = now;
            part.store(((before + now).min(whole) * 1_000_000 / whole) as usize, Ordering::Relaxed);
        });
        compute(&resolved, &own.key, &opened.source, &opened.tree, &mut watch).map_err(|e| chain(&e))
    }

    fn open(&self, trace: usize) -> Result<Arc<Opened>, String> {
        // A panic while it was held would have left it empty or filled, both of which are right.
        let mut slot = self.traces[trace].trace.lock().unwrap_or_else(PoisonError::into_inner);
        slot.get_or_insert_with(|| self.opened(trace)).clone()
    }

    fn opened(&self, trace: usize) -> Result<Arc<Opened>, String> {
        let own = &self.folder.plan().traces[trace];
        let opened = (self.settings.open)(&own.location)?;
        let fingerprint = opened.fingerprint().map_err(|e| e.to_string())?.to_string();
        if fingerprint != own.fingerprint {
            let location = &own.location;
            return Err(format!(
                "{location} is not the trace that the plan was made for (fingerprint {fingerprint}, not {}); put that one there, or \
                 make a new plan",
                own.fingerprint
            ));
        }
        let (trace, stop) = (Arc::new(opened), Arc::clone(&self.settings.stop));
        let tree = trace.topology();
        Ok(Arc::new(Opened { source: Decoded::new(trace, self.settings.memory, stop), tree }))
    }

    /// A point of this trace is done; behind the last one it is closed.
    fn release(&self, trace: usize) {
        if self.traces[trace].left.fetch_sub(1, Ordering::Relaxed) == 1 {
            *self.traces[trace].trace.lock().unwrap_or_else(PoisonError::into_inner) = None;
        }
    }
}
