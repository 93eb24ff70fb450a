//! The input buffer of a pipeline that reads memory: operations look their lines up here, under one of three rules of miss
//! handling.
//!
//! - `reorder` (Reorder Buffer, HPG 2015): each operation looks its lines up once; one that misses stays in its slot until they
//!   are here, while others pass it.
//! - `retry` (looping for the next chance): operations enter the pipeline in order, whatever the outcome; one that missed passes
//!   it as a bypass and comes back to the end of the queue. A line that arrived for it is kept until it comes round: otherwise
//!   operations whose lines share a set could evict each other's for ever.
//! - `accumulate` (ray accumulation buffer, US 9,342,919): one that misses is parked in the row of its line until the line
//!   arrives. No free row, or a full one, holds up the queue.
//!
//! All three: tags are looked up when the operation arrives (as US 2016/0027204 has it: the outcome is noted in the slot). Data
//! are read in order of arrival, one operation a cycle, as many of its lines as the L1 has banks for (`trv_lines_per_cycle`,
//! `ist_lines_per_cycle`), and are there the L1's latency after the last read began. An operation whose line arrived keeps it,
//! even if the cache evicts the line before it issues.

use std::collections::VecDeque;

use super::stage::{Candidate, Wait};
use crate::config::{self, MissHandling};
use crate::counters::counters;
use crate::memory::{Access, L1Cache, Memory, Port};
use crate::time::TiCycle;
use crate::work::layout::{Lines, Region};

counters! {
    /// What an input buffer did.
    pub struct InputBufferCounters {
        record_writes: "events", "records written into the input buffer";
        record_reads: "events", "records read from it, on issue";
        late_reads: "events", "lines read by operations that had missed";
        parked: "events", "operations parked in an accumulation row";
        slot_updates: "events", "state changes of reorder-buffer slots";
    }
}

/// What came of an arrival or a lookup.
#[derive(Clone, Copy, Debug)]
pub enum Outcome {
    /// It has its data in sight and can issue.
    Ready(Candidate),
    /// It is the first whose lookups are held up: [`InputBuffer::retry_lookup`] in the next cycle.
    HeldUp,
    /// It waits for lines, or behind one that is held up.
    Waits,
}

#[derive(Clone, Copy, Debug)]
struct Op {
    first: u64,
    arrived: TiCycle,
    region: Region,
    /// Lines, and how many of them were looked up.
    lines: u8,
    done: u8,
    /// Lines that are kept for it, by place (`retry`). At most 256 bytes in lines of at least 16 are 17 lines.
    kept: u64,
    /// Lines that missed and are still to come.
    outstanding: u8,
    missed: bool,
    refused: bool,
    others_wait: bool,
}

/// The input buffer of a pipeline, with its L1.
#[derive(Debug)]
pub struct InputBuffer {
    mode: MissHandling,
    latency_cycles: u64,
    lines_per_cycle: u64,
    l1: L1Cache,
    ops: Vec<Op>,
    /// Operations whose lookups are held up, the one that holds them up first.
    held_up: VecDeque<u8>,
    /// First cycle in which the data port is free.
    port_free: TiCycle,
    /// Operations that wait for a line.
    waiting: u32,
    /// What it did.
    pub counters: InputBufferCounters,
}

impl InputBuffer {
    /// A buffer of `entries` slots in front of an L1 that reads so many lines a cycle.
    pub fn new(
        ti: &config::Ti,
        (l1, lines_per_cycle): (&config::L1, u32),
        line_bytes: u32,
        port: Port,
        entries: u32,
    ) -> Self {
        let none = Op {
            first: 0,
            arrived: TiCycle::default(),
            region: Region::Node,
            lines: 0,
            done: 0,
            kept: 0,
            outstanding: 0,
            missed: false,
            refused: false,
            others_wait: false,
        };
        let mut cache = L1Cache::new(l1, line_bytes, port);
        if ti.miss_handling == MissHandling::Accumulate {
            cache = cache.with_rows(ti.accumulate_rows, ti.accumulate_rays_per_row);
        }
        Self {
            mode: ti.miss_handling,
            latency_cycles: l1.latency_cycles.into(),
            lines_per_cycle: lines_per_cycle.into(),
            l1: cache,
            ops: vec![none; entries as usize],
            held_up: VecDeque::with_capacity(entries as usize),
            port_free: TiCycle::default(),
            waiting: 0,
            counters: InputBufferCounters::default(),
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

    /// An operation arrives.
    #[inline]
    pub fn push<M: Memory>(&mut self, now: TiCycle, slot: u8, lines: Lines, region: Region, memory: &mut M) -> Outcome {
        self.ops[slot as usize] = Op {
            first: lines.first,
            arrived: now,
            region,
            lines: (lines.last - lines.first) as u8 + 1,
            done: 0,
            kept: 0,
            outstanding: 0,
            missed: false,
            refused: false,
            others_wait: self.waiting > 0,
        };
        self.arrive(now, slot, memory)
    }

    /// An operation comes back after a bypass, or for its second box.
    #[inline]
    pub fn push_again<M: Memory>(&mut self, now: TiCycle, slot: u8, memory: &mut M) -> Outcome {
        let others_wait = self.waiting > 0;
        let op = &mut self.ops[slot as usize];
        (op.arrived, op.done, op.missed, op.refused, op.others_wait) = (now, 0, false, false, others_wait);
        self.arrive(now, slot, memory)
    }

    #[inline]
    fn arrive<M: Memory>(&mut self, now: TiCycle, slot: u8, memory: &mut M) -> Outcome {
        self.counters.record_writes += 1;
        if self.held_up.is_empty() && self.look_up(now, slot, memory) {
            return self.looked_up(now, slot);
        }
        self.held_up.push_back(slot);
        if self.held_up.len() == 1 { Outcome::HeldUp } else { Outcome::Waits }
    }

    /// The lookup of the first operation that is held up goes on, at cycle `now`. Gives the operation with its outcome, once it
    /// is complete.
    pub fn retry_lookup<M: Memory>(&mut self, now: TiCycle, memory: &mut M) -> Option<(u8, Outcome)> {
        let &slot = self.held_up.front()?;
        if !self.look_up(now, slot, memory) {
            return None;
        }
        self.held_up.pop_front();
        Some((slot, self.looked_up(now, slot)))
    }

    /// Whether an operation is held up, so that [`InputBuffer::retry_lookup`] is to be called in the next cycle: a queue of the memory
    /// may have room by then.
    #[inline]
    pub fn is_held_up(&self) -> bool {
        !self.held_up.is_empty()
    }

    /// A line arrived: who waits for it, bit by bit. [`InputBuffer::filled`] is to be called for each.
    #[inline]
    pub fn fill(&mut self, line: u64) -> u128 {
        self.l1.fill(line)
    }

    /// A line that an operation waited for is here at cycle `now`; gives the operation, if it has all its lines.
    #[inline]
    pub fn filled(&mut self, now: TiCycle, slot: u8, line: u64) -> Option<Candidate> {
        let op = &mut self.ops[slot as usize];
        if self.mode == MissHandling::Retry {
            op.kept |= 1 << (line - op.first);
            return None;
        }
        op.outstanding -= 1;
        self.counters.late_reads += 1;
        if op.outstanding > 0 || op.done < op.lines {
            return None;
        }
        self.waiting -= 1;
        self.counters.slot_updates += u64::from(self.mode == MissHandling::Reorder);
        self.counters.record_reads += 1;
        Some(candidate(op, now, Wait::Memory, false))
    }

    /// Looks up the lines of an operation that are not looked up yet; false if one is refused.
    #[inline]
    fn look_up<M: Memory>(&mut self, now: TiCycle, slot: u8, memory: &mut M) -> bool {
        let op = &mut self.ops[slot as usize];
        while op.done < op.lines {
            if op.kept >> op.done & 1 == 1 {
                self.counters.late_reads += 1;
                op.done += 1;
                continue;
            }
            match self.l1.access(now, op.first + u64::from(op.done), op.region, slot, memory) {
                Access::Hit => {}
                Access::Rejected if self.mode != MissHandling::Retry => {
                    op.refused = true;
                    return false;
                }
                Access::Rejected => op.missed = true,
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
            op.done += 1;
        }
        true
    }

    /// All lines are looked up: the operation has its data in sight, or waits for lines.
    #[inline]
    fn looked_up(&mut self, now: TiCycle, slot: u8) -> Outcome {
        let op = self.ops[slot as usize];
        let retry = self.mode == MissHandling::Retry;
        if !retry && op.outstanding > 0 {
            self.waiting += 1;
            return Outcome::Waits;
        }
        self.counters.record_reads += 1;
        let begin = self.port_free.max(now);
        let reads = if op.lines == 1 { 1 } else { u64::from(op.lines).div_ceil(self.lines_per_cycle) };
        self.port_free = begin + reads;
        let wait = match (op.refused, op.missed && !retry) {
            (true, _) => Wait::Refused,
            (false, true) => Wait::Memory,
            (false, false) => Wait::Fetch,
        };
        Outcome::Ready(candidate(&op, begin + (reads - 1) + self.latency_cycles, wait, retry && op.missed))
    }
}

fn candidate(op: &Op, ready: TiCycle, wait: Wait, bypass: bool) -> Candidate {
    Candidate { arrived: op.arrived, ready, wait, bypass, others_wait: op.others_wait }
}
