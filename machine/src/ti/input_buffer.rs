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
use std::num::NonZeroU32;

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

/// An operation. Its lines are bits by place: at most 256 bytes in lines of at least 16 are [`LINES_MAX`].
#[derive(Clone, Copy, Debug)]
struct Op {
    first: u64,
    arrived: TiCycle,
    /// Lines that are kept for it (`retry`).
    kept: u32,
    /// Lines that it was the first to ask for, or joined: with `retry` ever, otherwise those that are still to come.
    asked: u32,
    /// The age of the L1 at which its one line was refused.
    refused_at: Option<NonZeroU32>,
    region: Region,
    /// Lines, and how many of them were looked up.
    lines: u8,
    done: u8,
    /// [`MISSED`], [`REFUSED`] and [`OTHERS_WAIT`].
    state: u8,
}

/// Most lines of an operation.
const LINES_MAX: usize = 17;

/// A lookup did not find its line.
const MISSED: u8 = 1;
/// A lookup was refused, and is tried again.
const REFUSED: u8 = 2;
/// Other operations waited for lines when it arrived.
const OTHERS_WAIT: u8 = 4;

/// The input buffer of a pipeline, with its L1.
#[derive(Debug)]
pub struct InputBuffer {
    mode: MissHandling,
    latency_cycles: u64,
    l1: L1Cache,
    /// Whether an operation that has read its lines never reads them again.
    once: bool,
    /// Whether an MSHR takes more waiters than there are slots, so that it never turns one away.
    roomy: bool,
    /// Whether operations never stay here: `retry`, and MSHRs are roomy.
    passes: bool,
    /// Cycles of the data port by number of lines.
    reads: [u64; LINES_MAX + 1],
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
    /// A buffer with miss handling `mode`, of `entries` slots in front of an L1 that reads so many lines a cycle.
    pub fn new(
        (ti, mode): (&config::Ti, MissHandling),
        (l1, lines_per_cycle): (&config::L1, u32),
        line_bytes: u32,
        port: Port,
        entries: u32,
    ) -> Self {
        let none = Op {
            first: 0,
            arrived: TiCycle::default(),
            kept: 0,
            asked: 0,
            refused_at: None,
            region: Region::Node,
            lines: 0,
            done: 0,
            state: 0,
        };
        let mut cache = L1Cache::new(l1, line_bytes, port);
        if mode == MissHandling::Accumulate {
            cache = cache.with_rows(ti.accumulate_rows, ti.accumulate_rays_per_row);
        }
        let roomy = entries < L1Cache::WAITERS && mode != MissHandling::Accumulate;
        Self {
            mode,
            latency_cycles: l1.latency_cycles.into(),
            l1: cache,
            once: true,
            roomy,
            passes: roomy && mode == MissHandling::Retry,
            reads: std::array::from_fn(|lines| (lines as u64).div_ceil(lines_per_cycle.into())),
            ops: vec![none; entries as usize],
            held_up: VecDeque::with_capacity(entries as usize),
            port_free: TiCycle::default(),
            waiting: 0,
            counters: InputBufferCounters::default(),
        }
    }

    /// The same for operations that come back after they read their lines.
    pub fn with_second_reads(self) -> Self {
        Self { once: false, ..self }
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
    #[inline(always)]
    pub fn push<M: Memory>(&mut self, now: TiCycle, slot: u8, lines: Lines, region: Region, memory: &mut M) -> Outcome {
        // Most operations are done here, and nothing is written down of them.
        if self.once && lines.first == lines.last && self.held_up.is_empty() && self.l1.hit(lines.first) {
            return Outcome::Ready(self.read_one(now));
        }
        self.push_slowly(now, slot, lines, region, memory)
    }

    #[inline(never)]
    fn push_slowly<M: Memory>(
        &mut self,
        now: TiCycle,
        slot: u8,
        lines: Lines,
        region: Region,
        memory: &mut M,
    ) -> Outcome {
        let state = self.others_wait();
        self.ops[slot as usize] = Op {
            first: lines.first,
            arrived: now,
            kept: 0,
            asked: 0,
            refused_at: None,
            region,
            lines: (lines.last - lines.first) as u8 + 1,
            done: 0,
            state,
        };
        if self.passes { Outcome::Ready(self.pass(now, slot, memory)) } else { self.arrive(now, slot, memory) }
    }

    /// An operation comes back after a bypass, or for its second box.
    #[inline]
    pub fn push_again<M: Memory>(&mut self, now: TiCycle, slot: u8, memory: &mut M) -> Outcome {
        if self.passes {
            return Outcome::Ready(self.pass(now, slot, memory));
        }
        let state = self.others_wait();
        let op = &mut self.ops[slot as usize];
        (op.arrived, op.done, op.state) = (now, 0, state);
        self.arrive(now, slot, memory)
    }

    /// An operation passes the buffer, whatever its lookups find.
    #[inline]
    fn pass<M: Memory>(&mut self, now: TiCycle, slot: u8, memory: &mut M) -> Candidate {
        let op = &mut self.ops[slot as usize];
        let mut bypass = false;
        if op.lines == 1 && op.asked > op.kept {
            // Most that come back wait for their one line still.
            self.l1.ask_again();
            bypass = true;
        } else {
            for place in 0..op.lines {
                let bit = 1 << place;
                if op.kept & bit != 0 {
                    self.counters.late_reads += 1;
                    continue;
                }
                let access = if op.asked & bit != 0 {
                    self.l1.ask_again()
                } else if op.refused_at == Some(self.l1.age()) {
                    self.l1.ask_unchanged(now, op.first, op.region, slot, memory)
                } else {
                    self.l1.access(now, op.first + u64::from(place), op.region, slot, memory)
                };
                match access {
                    Access::Hit => continue,
                    Access::Miss | Access::Merged => op.asked |= bit,
                    Access::Rejected => op.refused_at = if op.lines == 1 { Some(self.l1.age()) } else { None },
                }
                bypass = true;
            }
        }
        self.counters.record_writes += 1;
        self.counters.record_reads += 1;
        let reads = self.reads[op.lines as usize];
        let begin = self.port_free.max(now);
        self.port_free = begin + reads;
        let ready = begin + (reads - 1) + self.latency_cycles;
        Candidate { arrived: now, ready, wait: Wait::Fetch, bypass, others_wait: false }
    }

    /// An operation passes the buffer whose one line is here.
    #[inline(always)]
    fn read_one(&mut self, now: TiCycle) -> Candidate {
        self.counters.record_writes += 1;
        self.counters.record_reads += 1;
        let begin = self.port_free.max(now);
        self.port_free = begin + 1;
        let (ready, others_wait) = (begin + self.latency_cycles, self.waiting > 0);
        Candidate { arrived: now, ready, wait: Wait::Fetch, bypass: false, others_wait }
    }

    #[inline]
    fn others_wait(&self) -> u8 {
        if self.waiting > 0 { OTHERS_WAIT } else { 0 }
    }

    #[inline(never)]
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
        let bit = 1 << (line - op.first);
        if self.mode == MissHandling::Retry {
            op.kept |= bit;
            return None;
        }
        op.asked &= !bit;
        self.counters.late_reads += 1;
        if op.asked != 0 || op.done < op.lines {
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
        let retry = self.mode == MissHandling::Retry;
        while op.done < op.lines {
            let bit = 1 << op.done;
            if op.kept & bit != 0 {
                self.counters.late_reads += 1;
                op.done += 1;
                continue;
            }
            let access = if op.asked & bit != 0 && self.roomy {
                // It was not told of the line: nothing has changed.
                self.l1.ask_again()
            } else if op.refused_at == Some(self.l1.age()) {
                self.l1.ask_unchanged(now, op.first, op.region, slot, memory)
            } else {
                self.l1.access(now, op.first + u64::from(op.done), op.region, slot, memory)
            };
            match access {
                Access::Hit => {}
                Access::Rejected => {
                    op.refused_at = if op.lines == 1 && self.roomy { Some(self.l1.age()) } else { None };
                    if !retry {
                        op.state |= REFUSED;
                        return false;
                    }
                    op.state |= MISSED;
                }
                Access::Miss | Access::Merged => {
                    op.state |= MISSED;
                    op.asked |= bit;
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
        if !retry && op.asked != 0 {
            self.waiting += 1;
            return Outcome::Waits;
        }
        self.counters.record_reads += 1;
        let begin = self.port_free.max(now);
        let reads = self.reads[op.lines as usize];
        self.port_free = begin + reads;
        let missed = op.state & MISSED != 0;
        let wait = match (op.state & REFUSED != 0, missed && !retry) {
            (true, _) => Wait::Refused,
            (false, true) => Wait::Memory,
            (false, false) => Wait::Fetch,
        };
        Outcome::Ready(candidate(&op, begin + (reads - 1) + self.latency_cycles, wait, retry && missed))
    }
}

fn candidate(op: &Op, ready: TiCycle, wait: Wait, bypass: bool) -> Candidate {
    Candidate { arrived: op.arrived, ready, wait, bypass, others_wait: op.state & OTHERS_WAIT != 0 }
}
