//! A first-level cache: tags and miss status registers (MSHRs). It only reads, and it never blocks: a miss waits in its MSHR while
//! other accesses go on.

use std::num::NonZeroU32;

use crate::config;
use crate::counters::counters;
use crate::memory::interface::Memory;
use crate::memory::request::{Port, Request, Route};
use crate::memory::tags::Tags;
use crate::time::TiCycle;
use crate::work::layout::Region;

counters! {
    /// What a first-level cache did.
    pub struct CacheCounters {
        lookups: "events", "accesses that were looked up: hits, misses and merges";
        hits: "events", "lookups that found their line";
        misses: "events", "lookups that started a fetch";
        merges: "events", "lookups whose line was on its way already";
        full: "events", "attempts refused because no MSHR was free or the L2 took no request";
        fills: "events", "lines that arrived and were kept";
        dropped: "events", "lines that arrived but were not kept, for the L2 had evicted them in the meantime";
        evictions: "events", "lines that made room for another";
        invalidations: "events", "lines dropped because they left the L2";
    }
}

impl CacheCounters {
    /// Counts lookups of which the misses are counted already. All others hit: without time no line is on its way.
    pub(crate) fn looked_up(&mut self, lookups: u64) {
        self.lookups += lookups;
        self.hits = self.lookups - self.misses;
    }
}

/// What came of an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Access {
    /// The line is here: its data come `latency_cycles` later.
    Hit,
    /// The line was asked for.
    Miss,
    /// The line was on its way already.
    Merged,
    /// No MSHR is free, its row is full, or the L2 takes no request: nothing changed, ask again later.
    Rejected,
}

/// A line that is on its way.
#[derive(Clone, Copy, Debug)]
struct Mshr {
    waiters: u128,
    keep: bool,
}

/// A first-level cache.
#[derive(Clone, Debug)]
pub struct L1Cache {
    tags: Tags,
    /// The lines of the MSHRs, apart from the rest of them: they are searched.
    lines: Vec<u64>,
    mshrs: Vec<Mshr>,
    mshrs_max: usize,
    waiters_max: u32,
    port: Port,
    age: NonZeroU32,
    counters: CacheCounters,
}

impl L1Cache {
    /// Waiters that can be told apart.
    pub const WAITERS: u32 = u128::BITS;

    /// A cache that asks through `port`.
    pub fn new(config: &config::L1, line_bytes: u32, port: Port) -> Self {
        Self {
            tags: Tags::new(config.size.0, config.ways, line_bytes, config.replacement),
            lines: Vec::with_capacity(config.mshrs as usize),
            mshrs: Vec::with_capacity(config.mshrs as usize),
            mshrs_max: config.mshrs as usize,
            waiters_max: Self::WAITERS,
            port,
            age: NonZeroU32::MIN,
            counters: CacheCounters::default(),
        }
    }

    /// The same with a ray accumulation buffer: an MSHR is a row of it, of which there are `rows`, each for `waiters` rays.
    #[must_use]
    pub fn with_rows(self, rows: u32, waiters: u32) -> Self {
        Self { mshrs_max: self.mshrs_max.min(rows as usize), waiters_max: waiters, ..self }
    }

    /// Fills the empty cache.
    pub(crate) fn warm(&mut self, tags: &Tags) {
        self.tags.clone_from(tags);
    }

    /// The port through which it asks.
    pub fn port(&self) -> Port {
        self.port
    }

    /// What it holds.
    pub(crate) fn tags(&self) -> &Tags {
        &self.tags
    }

    /// Looks `line` up for `waiter` (0 to 127), who is told by [`L1Cache::fill`] when the line arrives.
    #[inline]
    pub fn access<M: Memory>(&mut self, now: TiCycle, line: u64, region: Region, waiter: u8, memory: &mut M) -> Access {
        self.look_up(now, line, region, 1 << waiter, memory)
    }

    /// As [`L1Cache::access`], but nobody waits: a miss starts the fetch, and whoever asked asks again.
    #[inline]
    pub fn fetch<M: Memory>(&mut self, now: TiCycle, line: u64, region: Region, memory: &mut M) -> Access {
        self.look_up(now, line, region, 0, memory)
    }

    #[inline]
    fn look_up<M: Memory>(&mut self, now: TiCycle, line: u64, region: Region, waiters: u128, memory: &mut M) -> Access {
        if self.hit(line) { Access::Hit } else { self.miss(now, line, region, waiters, memory) }
    }

    /// Looks `line` up if it is here; otherwise nothing has happened.
    #[inline]
    pub fn hit(&mut self, line: u64) -> bool {
        let hit = self.tags.touch(line);
        self.counters.lookups += u64::from(hit);
        self.counters.hits += u64::from(hit);
        hit
    }

    fn miss<M: Memory>(&mut self, now: TiCycle, line: u64, region: Region, waiters: u128, memory: &mut M) -> Access {
        if let Some(at) = self.mshr(line) {
            let mshr = &mut self.mshrs[at];
            if mshr.waiters.count_ones() >= self.waiters_max {
                self.counters.full += 1;
                return Access::Rejected;
            }
            mshr.waiters |= waiters;
            self.count_merge();
            return Access::Merged;
        }
        self.ask(now, line, region, waiters, memory)
    }

    /// Asks for a line that is neither here nor on its way.
    #[inline]
    fn ask<M: Memory>(&mut self, now: TiCycle, line: u64, region: Region, waiters: u128, memory: &mut M) -> Access {
        let request = Request { port: self.port, line, region, route: Route::Cached };
        if self.mshrs.len() == self.mshrs_max || !memory.request(now, request) {
            self.counters.full += 1;
            return Access::Rejected;
        }
        self.lines.push(line);
        self.mshrs.push(Mshr { waiters, keep: true });
        self.change();
        self.counters.lookups += 1;
        self.counters.misses += 1;
        Access::Miss
    }

    #[inline]
    fn change(&mut self) {
        self.age = self.age.checked_add(1).unwrap_or(NonZeroU32::MIN);
    }

    /// The MSHR of `line`.
    #[inline]
    fn mshr(&self, line: u64) -> Option<usize> {
        self.lines.iter().position(|&other| other == line)
    }

    #[inline]
    fn count_merge(&mut self) {
        self.counters.lookups += 1;
        self.counters.merges += 1;
    }

    /// As [`L1Cache::access`] by someone who asked for the line before and has not been told of it: it is on its way still. There
    /// must be fewer than [`L1Cache::WAITERS`] of them, or they may all wait for it, and then it takes no more.
    #[inline]
    pub fn ask_again(&mut self) -> Access {
        self.count_merge();
        Access::Merged
    }

    /// As [`L1Cache::access`] of a line that was refused when the [`L1Cache::age`] was the same, and not because its MSHR was full:
    /// it is neither here nor on its way.
    #[inline]
    pub fn ask_unchanged<M: Memory>(
        &mut self,
        now: TiCycle,
        line: u64,
        region: Region,
        waiter: u8,
        memory: &mut M,
    ) -> Access {
        self.ask(now, line, region, 1 << waiter, memory)
    }

    /// A number that is another one after a line came, went or was asked for.
    #[inline]
    pub fn age(&self) -> NonZeroU32 {
        self.age
    }

    /// Takes `line` in, frees its MSHR and returns who waited for it, bit `w` for waiter `w`.
    ///
    /// # Panics
    /// When nobody asked for the line.
    pub fn fill(&mut self, line: u64) -> u128 {
        let at = self.mshr(line).expect("a line arrives only when it was asked for");
        self.lines.swap_remove(at);
        let mshr = self.mshrs.swap_remove(at);
        self.change();
        if mshr.keep {
            self.counters.fills += 1;
            self.counters.evictions += u64::from(self.tags.insert(line).is_some());
        } else {
            self.counters.dropped += 1;
        }
        mshr.waiters
    }

    /// Drops `line`, which left an inclusive L2. If it is still on its way here, it will be handed to its waiters, but not kept.
    pub fn invalidate(&mut self, line: u64) {
        self.counters.invalidations += u64::from(self.tags.invalidate(line));
        self.change();
        if let Some(at) = self.mshr(line) {
            self.mshrs[at].keep = false;
        }
    }

    /// Whether `line` is here. Changes nothing.
    #[inline]
    pub fn contains(&self, line: u64) -> bool {
        self.tags.contains(line)
    }

    /// Lines on their way.
    #[inline]
    pub fn outstanding(&self) -> usize {
        self.mshrs.len()
    }

    /// Whether an MSHR is free.
    #[inline]
    pub fn has_free_mshr(&self) -> bool {
        self.mshrs.len() < self.mshrs_max
    }

    /// What happened so far.
    pub fn counters(&self) -> &CacheCounters {
        &self.counters
    }
}

#[cfg(test)]
mod tests;
