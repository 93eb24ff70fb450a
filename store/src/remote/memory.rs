//! Blocks in memory: the last ones fetched, and those on their way.

use std::collections::VecDeque;
use std::ops::Range;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

/// Bytes kept; one block may be longer.
const MAX_BYTES: u64 = 64 << 20;

/// Bytes of the object from `start` on.
#[derive(Debug)]
pub(super) struct Block {
    pub(super) start: u64,
    pub(super) bytes: Vec<u8>,
}

impl Block {
    fn range(&self) -> Range<u64> {
        self.start..self.start + self.bytes.len() as u64
    }

    /// The part of `range` that it holds, from the start of `range` on.
    pub(super) fn part(&self, range: &Range<u64>) -> &[u8] {
        let at = |offset: u64| usize::try_from(offset.saturating_sub(self.start)).unwrap_or(usize::MAX);
        let end = at(range.end).min(self.bytes.len());
        self.bytes.get(at(range.start)..end).unwrap_or(&[])
    }
}

/// Whether all of `inner` lies in `outer`.
pub(super) fn contains(outer: &Range<u64>, inner: &Range<u64>) -> bool {
    outer.start <= inner.start && inner.end <= outer.end
}

/// Whether two ranges have a byte in common.
pub(super) fn overlaps(a: &Range<u64>, b: &Range<u64>) -> bool {
    a.start < b.end && b.start < a.end
}

#[derive(Debug, Default)]
struct State {
    /// Least recently used first.
    blocks: VecDeque<Arc<Block>>,
    /// Ranges that a thread is fetching.
    flying: Vec<Range<u64>>,
}

/// Blocks, shared by all threads that read.
#[derive(Debug, Default)]
pub(super) struct MemoryCache {
    state: Mutex<State>,
    landed: Condvar,
}

/// The answer to a thread that needs bytes.
pub(super) enum Lookup<'a> {
    /// The block that holds them.
    Held(Arc<Block>),
    /// Nobody has them or is fetching them: this thread must.
    ToFetch(Flight<'a>),
}

/// A range of bytes that one thread has to fetch. Others who need some of them wait until it is dropped.
pub(super) struct Flight<'a> {
    memory: &'a MemoryCache,
    pub(super) range: Range<u64>,
}

impl Drop for Flight<'_> {
    fn drop(&mut self) {
        let mut state = self.memory.lock();
        if let Some(at) = state.flying.iter().position(|range| *range == self.range) {
            state.flying.swap_remove(at);
        }
        self.memory.landed.notify_all();
    }
}

impl MemoryCache {
    fn lock(&self) -> MutexGuard<'_, State> {
        // Nothing under the lock leaves a state half changed.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// The block that holds `wanted`, waited for if it is on its way. If there is none, the caller has to fetch it, and
    /// what `extend` adds to it; `extend` can ask whether a range is here or on its way.
    pub(super) fn ask(
        &self,
        wanted: &Range<u64>,
        extend: impl Fn(&dyn Fn(&Range<u64>) -> bool) -> Range<u64>,
    ) -> Lookup<'_> {
        let mut state = self.lock();
        loop {
            if let Some(at) = state.blocks.iter().position(|block| contains(&block.range(), wanted))
                && let Some(block) = state.blocks.remove(at)
            {
                state.blocks.push_back(Arc::clone(&block));
                return Lookup::Held(block);
            }
            if !state.flying.iter().any(|range| contains(range, wanted)) {
                break;
            }
            state = self.landed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        let held = |range: &Range<u64>| {
            let mut here = state.blocks.iter().map(|block| block.range()).chain(state.flying.iter().cloned());
            here.any(|held| contains(&held, range))
        };
        let range = extend(&held);
        state.flying.push(range.clone());
        Lookup::ToFetch(Flight { memory: self, range })
    }

    /// Drops all blocks with some of these bytes.
    pub(super) fn forget(&self, range: &Range<u64>) {
        self.lock().blocks.retain(|block| !overlaps(&block.range(), range));
    }

    /// Takes in a block; drops old ones.
    pub(super) fn keep(&self, block: Block) -> Arc<Block> {
        let block = Arc::new(block);
        let mut state = self.lock();
        state.blocks.push_back(Arc::clone(&block));
        let mut total: u64 = state.blocks.iter().map(|block| block.bytes.len() as u64).sum();
        while total > MAX_BYTES
            && state.blocks.len() > 1
            && let Some(old) = state.blocks.pop_front()
        {
            total -= old.bytes.len() as u64;
        }
        block
    }
}
