//! Reads input after input of one target, in this process.

use std::collections::BTreeSet;
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::panic::{AssertUnwindSafe, catch_unwind, set_hook};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use crate::kept::Kept;
use crate::memory;
use crate::random::Random;
use crate::target::Target;

/// Exit code of a process in which an input took too long.
pub const TOO_LONG: i32 = 97;

/// What to do.
#[derive(Clone, Debug)]
pub struct Task {
    /// Where the choices begin.
    pub seed: u64,
    /// How long.
    pub time: Duration,
    /// How many inputs at most.
    pub executions: u64,
    /// Longest time of one input.
    pub limit: Duration,
    /// The file that always holds the input being read: its length in 8 bytes, then the input.
    pub current: Option<PathBuf>,
    /// Where inputs are put that fail.
    pub failures: PathBuf,
    /// The kept inputs of all targets, a folder each.
    pub corpus: PathBuf,
    /// Where to put new ones.
    pub keep: Option<PathBuf>,
}

/// What came of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Summary {
    /// Inputs that were read.
    pub executions: u64,
    /// Inputs that are kept.
    pub kept: usize,
    /// Different messages.
    pub messages: usize,
    /// Edges of the code that ran, and how many there are; 0 where nothing counts them.
    pub edges: (usize, usize),
    /// Longest time of an input, in milliseconds.
    pub slowest_ms: u64,
    /// Most memory that an input took, in bytes.
    pub peak: usize,
    /// What failed: the message, and the file.
    pub failures: Vec<String>,
}

/// What the last panic said.
static PANIC: Mutex<String> = Mutex::new(String::new());

/// When the input being read was begun, in milliseconds from the start of the run, plus 1; 0 between two.
static BEGUN: AtomicU64 = AtomicU64::new(0);

/// Reads one input. Gives what was said of it.
///
/// # Errors
/// What the panic said.
pub fn read(target: &Target, bytes: &[u8]) -> Result<String, String> {
    catch_unwind(AssertUnwindSafe(|| (target.read)(bytes)))
        .map_err(|_| PANIC.lock().unwrap_or_else(PoisonError::into_inner).clone())
}

/// Keeps what panics say instead of printing it.
pub fn listen_to_panics() {
    set_hook(Box::new(|panic| {
        let text = panic.to_string().split_whitespace().collect::<Vec<_>>().join(" ");
        *PANIC.lock().unwrap_or_else(PoisonError::into_inner) = text;
    }));
}

/// The first inputs of a target: those that it makes, and those that are kept.
pub fn seeds(target: &Target, corpus: &Path) -> Vec<Vec<u8>> {
    let mut seeds = (target.seeds)();
    let mut files: Vec<PathBuf> = fs::read_dir(corpus.join(target.name))
        .map(|entries| entries.filter_map(|entry| Some(entry.ok()?.path())).collect())
        .unwrap_or_default();
    files.sort();
    seeds.extend(files.into_iter().filter_map(|file| fs::read(file).ok()));
    seeds
}

/// Carries out a task; `tell` is called about once a second.
///
/// # Panics
/// When the file of the current input cannot be written.
pub fn run(target: &Target, task: &Task, mut tell: impl FnMut(&Summary)) -> Summary {
    listen_to_panics();
    let start = Instant::now();
    watch(start, task.limit);
    let current = task.current.as_ref().map(|path| File::create(path).expect("a file for the current input"));
    let seeds = seeds(target, &task.corpus);
    let (mut kept, mut random) = (Kept::new(seeds.clone()), Random(task.seed));
    let (mut summary, mut told) = (Summary::default(), Duration::ZERO);
    let mut known = BTreeSet::new();
    let mut first = seeds.into_iter();
    while start.elapsed() < task.time && summary.executions < task.executions {
        let bytes = first.next().unwrap_or_else(|| kept.next(target, &mut random));
        if let Some(file) = &current {
            let length = (bytes.len() as u64).to_le_bytes();
            file.write_all_at(&[&length[..], &bytes].concat(), 0).expect("the current input can be written");
        }
        kept.seen.clear();
        let (before, begun) = (memory::restart(), Instant::now());
        BEGUN.store(start.elapsed().as_millis() as u64 + 1, Relaxed);
        let said = read(target, &bytes);
        BEGUN.store(0, Relaxed);
        summary.executions += 1;
        summary.slowest_ms = summary.slowest_ms.max(begun.elapsed().as_millis() as u64);
        summary.peak = summary.peak.max(memory::peak().saturating_sub(before));
        match said {
            Ok(said) => kept.learn(&bytes, &said, &mut random),
            Err(why) if known.insert(why.clone()) && known.len() <= 20 => {
                let file = save(target, &task.failures, &bytes);
                summary.failures.push(format!("{}: {why} ({file})", target.name));
            }
            Err(_) => {}
        }
        if start.elapsed() - told > Duration::from_secs(1) {
            told = start.elapsed();
            fill(&mut summary, &kept);
            tell(&summary);
        }
    }
    fill(&mut summary, &kept);
    if let Some(folder) = &task.keep {
        kept.best(6, 1500).into_iter().for_each(|bytes| drop(save(target, &folder.join(target.name), bytes)));
    }
    summary
}

fn fill(summary: &mut Summary, kept: &Kept) {
    (summary.kept, summary.messages) = (kept.inputs.len(), kept.messages());
    summary.edges = (kept.seen.edges, kept.seen.counters());
}

/// Ends the process when an input takes too long. Its parent has the input.
fn watch(start: Instant, limit: Duration) {
    thread::spawn(move || {
        loop {
            thread::sleep(limit / 10);
            let begun = BEGUN.load(Relaxed);
            if begun > 0 && start.elapsed().as_millis() as u64 + 1 > begun + limit.as_millis() as u64 {
                std::process::exit(TOO_LONG);
            }
        }
    });
}

/// Puts an input into a folder under a name that follows from its bytes. Gives the name.
pub fn save(target: &Target, folder: &Path, bytes: &[u8]) -> String {
    let file = folder.join(format!("{}-{}", target.name, &blake3::hash(bytes).to_hex()[..12]));
    let written = fs::create_dir_all(folder).and_then(|()| fs::write(&file, bytes));
    match written {
        Ok(()) => file.display().to_string(),
        Err(error) => format!("cannot write {}: {error}", file.display()),
    }
}
