//! The traces of a run: opened by the first worker that needs one, closed behind the last.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use super::shape::Settings;
use crate::error::Result;
use crate::point::tile_cache::{MemoryBudget, TileCache};
use crate::sweep::folder::Folder;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::source::PathSource;
use rayreel_store::Location;

/// An open trace.
pub(super) struct OpenTrace {
    pub source: TileCache,
    pub tree: Topology,
}

/// A trace that workers share.
#[derive(Default)]
struct SharedTrace {
    opened: Mutex<Option<Result<Arc<OpenTrace>, String>>>,
    /// Points that still need it.
    left: AtomicUsize,
}

impl SharedTrace {
    fn close(&self) {
        *self.opened.lock().unwrap_or_else(PoisonError::into_inner) = None;
    }
}

/// All traces of a plan.
pub(super) struct SharedTraces<'a> {
    folder: &'a Folder,
    settings: &'a Settings<'a>,
    traces: Vec<SharedTrace>,
    budget: Arc<MemoryBudget>,
    /// How often each tile is read before it is dropped.
    readers: AtomicUsize,
}

impl<'a> SharedTraces<'a> {
    /// None is open yet; `todo` are the points that will need them.
    pub fn new(folder: &'a Folder, settings: &'a Settings<'a>, todo: impl Iterator<Item = usize>) -> Self {
        let traces: Vec<SharedTrace> = folder.plan().traces.iter().map(|_| SharedTrace::default()).collect();
        for point in todo {
            traces[folder.plan().points[point].trace].left.fetch_add(1, Ordering::Relaxed);
        }
        Self {
            folder,
            settings,
            traces,
            budget: MemoryBudget::new(settings.memory),
            readers: AtomicUsize::new(usize::MAX),
        }
    }

    /// Nobody reads any trace now, and from now on each tile is read so often.
    pub fn begin(&self, readers: usize) {
        self.readers.store(readers, Ordering::Relaxed);
        self.traces.iter().for_each(SharedTrace::close);
    }

    /// Trace number `trace` of the plan.
    pub fn open(&self, trace: usize) -> Result<Arc<OpenTrace>, String> {
        // A panic while it was held would have left it empty or filled, both of which are right.
        let mut slot = self.traces[trace].opened.lock().unwrap_or_else(PoisonError::into_inner);
        slot.get_or_insert_with(|| self.opened(trace)).clone()
    }

    fn opened(&self, trace: usize) -> Result<Arc<OpenTrace>, String> {
        let planned = &self.folder.plan().traces[trace];
        let unsigned = |why: String| {
            let how = "the plan keeps no user, password or query of its URL: set RAYREEL_TRACE_URLS to the whole URL";
            let given = std::env::var("RAYREEL_TRACE_URLS").unwrap_or_default();
            let is_given = given.split_whitespace().any(|url| Location::from(url).to_string() == planned.location);
            if planned.signed && !is_given { format!("{why}; {how}") } else { why }
        };
        let trace = (self.settings.open)(&planned.location).map_err(unsigned)?;
        let fingerprint = trace.fingerprint().map_err(|e| e.to_string())?.to_string();
        if fingerprint != planned.fingerprint {
            return Err(format!(
                "{} is not the trace that the plan was made for (fingerprint {fingerprint}, not {}); put that one there, or \
                 make a new plan",
                trace.path().display(),
                planned.fingerprint
            ));
        }
        let tree = trace.topology();
        let source = TileCache::new(trace, &self.budget).for_readers(self.readers.load(Ordering::Relaxed));
        Ok(Arc::new(OpenTrace { source, tree }))
    }

    /// A point of this trace is done; behind the last one it is closed.
    pub fn release(&self, trace: usize) {
        if self.traces[trace].left.fetch_sub(1, Ordering::Relaxed) == 1 {
            self.traces[trace].close();
        }
    }
}
