//! The input buffer of a pipeline that reads memory: operations wait here for their lines, under one of three rules of miss
//! handling.
//!
//! - `reorder` (Reorder Buffer, HPG 2015): each operation looks its lines up once, in order of arrival; one that misses stays in
//!   its slot; the oldest operation whose lines are all here issues.
//! - `retry` (looping for the next chance): operations look up in order and enter the pipeline in order, whatever the outcome;
//!   one that missed passes it as a bypass and comes back to the end of the queue. A line that arrived for it is kept until it
//!   comes round: otherwise operations whose lines share a set could evict each other's for ever.
//! - `accumulate` (ray accumulation buffer, US 9,342,919): operations look up in order; one that misses is parked in the row of
//!   its line; when the line arrives, the row issues, before anything else. No free row, or a full one, holds up the queue.
//!
//! All three: one operation looks up a cycle, as many of its lines as the L1 has banks for (`trv_lines_per_cycle`, `ist_lines_per_cycle`); one operation
//! issues a cycle; a hit has its data the L1's latency later. An
//! operation whose line arrived keeps it, even if the cache evicts the line before it issues.

use std::collections::VecDeque;

use crate::machine::config::{self, MissHandling};
use crate::machine::counters::counters;
use crate::machine::memory::l1::{Access, L1Cache};
use crate::machine::memory::{Cycle, Memory, Port};
use crate::machine::work::layout::{Lines, Region};

counters! {
    /// What an input buffer did.
    pub struct FrontCounters {
        record_writes: "events", "records written into the input buffer";
        record_reads: "events", "records read from it, on issue";
        late_reads: "events", "lines read by operations that had missed";
        parked: "events", "operations parked in an accumulation row";
        slot_updates: "events", "state changes of reorder-buffer slots";
    }
}

/// An operation that leaves the buffer for the pipeline.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Issue {
    /// Slot of the operation.
    pub op: u8,
    /// It missed and passes without work.
    pub bypass: bool,
}

/// Why nothing issued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Waiting {
    /// The buffer is empty.
    Nothing,
    /// A lookup or the hit latency is under way.
    Fetch,
    /// Every operation waits for a line.
    Memory,
    /// The oldest lookup is refused: no MSHR, no row, no queue entry.
    Refused,
}

#[derive(Clone, Copy, Debug)]
struct Op {
    next: u64,
    lines: Lines,
    /// Lines that are kept for it, by place (`retry`).
    kept: u8,
    region: Region,
    /// Lines that missed and are still to come.
    outstanding: u8,
    /// A line of this operation missed.
    missed: bool,
    seq: u64,
}

/// See the module.
#[derive(Debug)]
pub struct Front {
    mode: MissHandling,
    latency: Cycle,
    lines_per_cycle: u32,
    l1: L1Cache,
    ops: Vec<Op>,
    /// Operations whose lookups are not done.
    queue: VecDeque<u8>,
    /// Operations whose last lookup is done, with the cycle at which its data are here.
    fetched: VecDeque<(Cycle, u8)>,
    /// Operations that had missed and have all lines; `reorder`: oldest first, `accumulate`: in order of arrival of the line.
    ready: VecDeque<u8>,
    /// Operations that wait for a line.
    waiting: u32,
    refused: bool,
    seq: u64,
    /// What it did.
    pub counters: FrontCounters,
}

impl Front {
    /// A buffer of `entries` slots in front of an L1 that reads so many lines a cycle.
    pub fn new(
        ti: &config::Ti,
        (l1, lines_per_cycle): (&config::L1, u32),
        line_bytes: u32,
        port: Port,
        entries: u32,
    ) -> Self {
        let none = Op {
            next: 0,
            kept: 0,
            lines: Lines { first: 0, last: 0 },
            region: Region::Node,
            outstanding: 0,
            missed: false,
            seq: 0,
        };
        let mut cache = L1Cache::new(l1, line_bytes, port);
        if ti.miss_handling == MissHandling::Accumulate {
            cache = cache.with_rows(ti.accumulate_rows, ti.accumulate_rays_per_row);
        }
        Self {
            mode: ti.miss_handling,
            latency: l1.latency_cycles.into(),
            lines_per_cycle,
            l1: cache,
            ops: vec![none; entries as usize],
            queue: VecDeque::with_capacity(entries as usize),
            fetched: VecDeque::with_capacity(entries as usize),
            ready: VecDeque::with_capacity(entries as usize),
            waiting: 0,
            refused: false,
            seq: 0,
            counters: FrontCounters::default(),
        }
    }

    /// The cache.
    pub fn l1(&self) -> &L1Cache {
        &self.l1
    }

    /// The cache, to drop lines from.
    pub fn l1_mut(&mut self) -> &mut L1Cache {
        &mut self.l1
    }

    /// An operation arrives; it can look up in this very cycle.
    #[inline]
    pub fn push(&mut self, op: u8, lines: Lines, region: Region) {
        self.seq += 1;
        self.ops[op as usize] =
            Op { next: lines.first, lines, kept: 0, region, outstanding: 0, missed: false, seq: self.seq };
        self.queue.push_back(op);
        self.counters.record_writes += 1;
    }

    /// An operation comes back after a bypass.
    #[inline]
    pub fn push_again(&mut self, op: u8) {
        let Op { lines, region, kept, .. } = self.ops[op as usize];
        self.push(op, lines, region);
        self.ops[op as usize].kept = kept;
    }

    /// A line arrived.
    pub fn fill(&mut self, line: u64) {
        let mut waiters = self.l1.fill(line);
        while waiters != 0 {
            let slot = waiters.trailing_zeros() as u8;
            waiters &= waiters - 1;
            let op = &mut self.ops[slot as usize];
            if self.mode == MissHandling::Retry {
                op.kept |= 1 << (line - op.lines.first);
                continue;
            }
            op.outstanding -= 1;
            self.counters.late_reads += 1;
            if op.outstanding == 0 && op.next > op.lines.last {
                self.waiting -= 1;
                self.make_ready(slot);
            }
        }
    }

    /// The lookups of the operation whose turn it is, as far as the memory takes its misses.
    #[inline]
    pub fn look_up<M: Memory>(&mut self, now: Cycle, memory: &mut M) {
        self.refused = false;
        let Some(&slot) = self.queue.front() else { return };
        for _ in 0..self.lines_per_cycle {
            if !self.look_up_line(now, slot, memory) {
                return;
            }
            let op = &self.ops[slot as usize];
            if op.next > op.lines.last {
                self.queue.pop_front();
                if self.mode == MissHandling::Retry || op.outstanding == 0 {
                    self.fetched.push_back((now + self.latency, slot));
                } else {
                    self.waiting += 1;
                }
                return;
            }
        }
    }

    /// Looks up the next line of an operation; false if that was refused.
    #[inline]
    fn look_up_line<M: Memory>(&mut self, now: Cycle, slot: u8, memory: &mut M) -> bool {
        let op = &mut self.ops[slot as usize];
        if op.kept >> (op.next - op.lines.first) & 1 == 1 {
            self.counters.late_reads += 1;
            op.next += 1;
            return true;
        }
        match self.l1.access(now, op.next, op.region, slot, memory) {
            Access::Hit => {}
            Access::Full if self.mode != MissHandling::Retry => {
                self.refused = true;
                return false;
            }
            Access::Full => op.missed = true,
            Access::Miss | Access::Merged => {
                op.missed = true;
                op.outstanding += 1;
                match self.mode {
                    MissHandling::Retry => {}
                    MissHandling::Accumulate => self.counters.parked += 1,
                    MissHandling::Reorder => self.counters.slot_updates += 1,
                }
            }
        }
        op.next += 1;
        true
    }

    /// The operation that issues in this cycle.
    #[inline]
    pub fn issue(&mut self, now: Cycle) -> Option<Issue> {
        let op = match self.mode {
            MissHandling::Reorder => self.oldest(now),
            MissHandling::Accumulate => self.ready.pop_front().or_else(|| self.take_fetched(now)),
            MissHandling::Retry => self.take_fetched(now),
        }?;
        self.counters.record_reads += 1;
        let bypass = self.mode == MissHandling::Retry && self.ops[op as usize].missed;
        Some(Issue { op, bypass })
    }

    /// Why nothing issues, judged after this cycle's lookup.
    #[inline]
    pub fn waiting(&self) -> Waiting {
        if !self.fetched.is_empty() || !self.ready.is_empty() {
            Waiting::Fetch
        } else if self.refused {
            Waiting::Refused
        } else if !self.queue.is_empty() {
            Waiting::Fetch
        } else if self.waiting > 0 {
            Waiting::Memory
        } else {
            Waiting::Nothing
        }
    }

    /// The next cycle at which something can happen here, judged at the end of cycle `now`. A refused lookup is tried in
    /// every cycle, since a queue of the memory may have room by then.
    #[inline]
    pub fn next_event(&self, now: Cycle) -> Option<Cycle> {
        if !self.queue.is_empty() || !self.ready.is_empty() {
            return Some(now + 1);
        }
        self.fetched.front().map(|f| f.0.max(now + 1))
    }

    /// True when no operation is here.
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty() && self.fetched.is_empty() && self.ready.is_empty() && self.waiting == 0
    }

    /// The oldest operation with all lines. Fetched ones are in order of age among themselves, and so are ready ones.
    #[inline]
    fn oldest(&mut self, now: Cycle) -> Option<u8> {
        let Some(&late) = self.ready.front() else { return self.take_fetched(now) };
        let fetched = self.fetched.front().filter(|f| f.0 <= now);
        match fetched {
            Some(&(_, slot)) if self.ops[slot as usize].seq < self.ops[late as usize].seq => self.take_fetched(now),
            _ => self.ready.pop_front(),
        }
    }

    fn take_fetched(&mut self, now: Cycle) -> Option<u8> {
        if self.fetched.front()?.0 > now {
            return None;
        }
        self.fetched.pop_front().map(|f| f.1)
    }

    fn make_ready(&mut self, slot: u8) {
        if self.mode != MissHandling::Reorder {
            self.ready.push_back(slot);
            return;
        }
        self.counters.slot_updates += 1;
        let seq = self.ops[slot as usize].seq;
        // Nearly always the youngest: most operations hit and become ready in order of arrival.
        let at = self.ready.iter().rposition(|&o| self.ops[o as usize].seq < seq).map_or(0, |i| i + 1);
        self.ready.insert(at, slot);
    }
}
