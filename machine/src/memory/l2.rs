//! The shared second-level cache, in the clock of the T&I unit.
//!
//! A request accepted at cycle `t` waits in the queue of its bank (line number modulo banks). From `t + 1` on, each bank looks up
//! the head of its queue, one a cycle. A hit is answered `latency_cycles` after the lookup. A miss takes an MSHR and leaves for
//! memory `latency_cycles` after the lookup; a miss of a line that is on its way joins its MSHR. With no MSHR or no entry in the
//! memory's queue the head waits, and its bank with it. A line that arrives is filled, and everyone who waited is answered, in
//! the same cycle, before the lookups of that cycle. The bank that looks first moves on each cycle, so that none is favoured.

use std::collections::VecDeque;

use super::dram::{Dram, LineRead};
use super::request::{Port, Response};
use super::tags::Tags;
use super::traffic::Traffic;
use crate::component::{Component, Tick};
use crate::config;
use crate::counters::counters;
use crate::time::{TiCycle, When};
use crate::work::layout::Region;

counters! {
    /// What the second-level cache did.
    pub struct L2Counters {
        lookups: "events", "requests that were looked up: hits, misses and merges";
        hits: "events", "lookups that found their line";
        misses: "events", "lookups that fetched a line from memory";
        merges: "events", "lookups whose line was on its way already";
        full: "events", "attempts refused because the queue of the bank was full";
        blocked: "bank cycles", "the head of a bank's queue waited for an MSHR or a place in the memory's queue";
        fills: "events", "lines that arrived from memory";
        evictions: "events", "lines that made room for another";
    }
}

/// No line, no waiter.
const NONE: u64 = u64::MAX;
const END: u32 = u32::MAX;

#[derive(Clone, Copy, Debug)]
struct Queued {
    port: Port,
    region: Region,
    line: u64,
}

#[derive(Clone, Debug)]
struct Bank {
    queue: VecDeque<Queued>,
    /// Cycle since which the head waits.
    blocked: Option<TiCycle>,
}

/// Buckets of lines that are on their way.
const BUCKETS: usize = 256;

fn bucket(line: u64) -> usize {
    (line ^ line >> 8) as usize % BUCKETS
}

/// Ports waiting for a line: a list in a pool, in order of request.
#[derive(Clone, Copy, Debug)]
struct Waiter {
    port: Port,
    next: u32,
}

/// The waiters of an MSHR, as places in the pool; `END` if there are none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct WaiterList {
    first: u32,
    last: u32,
}

const NOBODY: WaiterList = WaiterList { first: END, last: END };

/// What the cache works with: the memory behind it, and those who asked.
#[derive(Debug)]
pub struct L2Context<'a> {
    /// Where it fetches lines.
    pub dram: &'a mut Dram,
    /// Bytes at the DRAM; what it fetches is added.
    pub traffic: &'a mut Traffic,
    /// Answers are appended here.
    pub arrived: &'a mut Vec<Response>,
}

/// The second-level cache.
#[derive(Clone, Debug)]
pub struct L2Cache {
    tags: Tags,
    banks: Vec<Bank>,
    bank_mask: u64,
    queue_max: usize,
    latency_cycles: u64,
    /// Lines of the MSHRs, or `NONE`.
    mshr_lines: Vec<u64>,
    /// Who waits for each MSHR.
    mshr_waiters: Vec<WaiterList>,
    /// MSHRs without a line.
    mshrs_free: Vec<u32>,
    /// Lines of MSHRs by bucket: most that are not on their way are known by it, without a search.
    on_their_way: [u16; BUCKETS],
    waiters: Vec<Waiter>,
    waiters_free: u32,
    hits: VecDeque<(TiCycle, Response)>,
    /// Banks with a head that is not blocked.
    ready_banks: usize,
    evicted: Vec<u64>,
    inclusive: bool,
    line_bytes: u64,
    counters: L2Counters,
}

impl L2Cache {
    /// An empty cache.
    ///
    /// # Panics
    /// When banks are not a power of two or the latency is 0: the configuration was not checked.
    pub fn new(config: &config::L2) -> Self {
        assert!(config.banks.is_power_of_two(), "the number of L2 banks must be a power of two, not {}", config.banks);
        assert!(config.latency_cycles > 0, "an L2 answers at a later cycle");
        Self {
            tags: Tags::new(config.size.0, config.ways, config.line_bytes, config.replacement),
            banks: vec![Bank { queue: VecDeque::new(), blocked: None }; config.banks as usize],
            bank_mask: u64::from(config.banks) - 1,
            queue_max: config.queue_entries as usize,
            latency_cycles: config.latency_cycles.into(),
            mshr_lines: vec![NONE; config.mshrs as usize],
            mshr_waiters: vec![NOBODY; config.mshrs as usize],
            mshrs_free: (0..config.mshrs).collect(),
            on_their_way: [0; BUCKETS],
            waiters: Vec::new(),
            waiters_free: END,
            hits: VecDeque::new(),
            ready_banks: 0,
            evicted: Vec::new(),
            inclusive: config.inclusive,
            line_bytes: config.line_bytes.into(),
            counters: L2Counters::default(),
        }
    }

    /// Fills the empty cache.
    pub(crate) fn warm(&mut self, tags: &Tags) {
        self.tags.clone_from(tags);
    }

    /// What it holds.
    pub(crate) fn tags(&self) -> &Tags {
        &self.tags
    }

    /// Queues a request, or refuses it because its bank's queue is full.
    #[inline]
    pub fn request(&mut self, port: Port, line: u64, region: Region) -> bool {
        let bank = &mut self.banks[(line & self.bank_mask) as usize];
        if bank.queue.len() >= self.queue_max {
            self.counters.full += 1;
            return false;
        }
        self.ready_banks += usize::from(bank.queue.is_empty());
        bank.queue.push_back(Queued { port, region, line });
        true
    }

    /// The line of an MSHR arrived.
    pub fn fill(&mut self, mshr: u32, arrived: &mut Vec<Response>) {
        let mshr = mshr as usize;
        let line = std::mem::replace(&mut self.mshr_lines[mshr], NONE);
        self.mshrs_free.push(mshr as u32);
        self.on_their_way[bucket(line)] -= 1;
        self.counters.fills += 1;
        if let Some(evicted) = self.tags.insert(line) {
            self.counters.evictions += 1;
            if self.inclusive {
                self.evicted.push(evicted);
            }
        }
        let WaiterList { first, last } = self.mshr_waiters[mshr];
        let mut at = first;
        while at != END {
            let waiter = &mut self.waiters[at as usize];
            arrived.push(Response { port: waiter.port, line });
            at = if at == last { END } else { waiter.next };
        }
        self.waiters[last as usize].next = self.waiters_free;
        self.waiters_free = first;
    }

    /// Looks up the head of a bank's queue.
    #[inline]
    fn serve(&mut self, now: TiCycle, bank: usize, context: &mut L2Context<'_>) {
        let Some(&head) = self.banks[bank].queue.front() else { return };
        // A blocked head has missed, and only its bank could have its line fetched: it is a miss still.
        let blocked = self.banks[bank].blocked.is_some();
        let done = if blocked { self.miss(now, head, context) } else { self.look_up(now, head, context) };
        if done {
            self.advance(now, bank);
        } else if !blocked {
            self.banks[bank].blocked = Some(now);
            self.ready_banks -= 1;
        }
    }

    /// The head of a bank's queue is done.
    fn advance(&mut self, now: TiCycle, bank: usize) {
        let bank = &mut self.banks[bank];
        bank.queue.pop_front();
        let was_ready = match bank.blocked.take() {
            Some(since) => {
                self.counters.blocked += now - since;
                0
            }
            None => 1,
        };
        self.ready_banks = self.ready_banks - was_ready + usize::from(!bank.queue.is_empty());
    }

    /// Looks a request up; `false` if it has to wait, then nothing changed.
    fn look_up(&mut self, now: TiCycle, head: Queued, context: &mut L2Context<'_>) -> bool {
        let Queued { port, line, .. } = head;
        if self.tags.touch(line) {
            self.hits.push_back((now + self.latency_cycles, Response { port, line }));
            self.counters.hits += 1;
        } else if let Some(mshr) = self.mshr(line) {
            self.wait(mshr, port);
            self.counters.merges += 1;
        } else {
            return self.miss(now, head, context);
        }
        self.counters.lookups += 1;
        true
    }

    /// The MSHR of `line`.
    #[inline]
    fn mshr(&self, line: u64) -> Option<usize> {
        if self.on_their_way[bucket(line)] == 0 {
            return None;
        }
        self.mshr_lines.iter().position(|&other| other == line)
    }

    /// Fetches a line; `false` if there is no MSHR or the memory's queue is full.
    fn miss(&mut self, now: TiCycle, head: Queued, context: &mut L2Context<'_>) -> bool {
        let Queued { port, region, line } = head;
        let Some(&free) = self.mshrs_free.last() else { return false };
        if !context.dram.has_read_room(line) {
            return false;
        }
        let (mshr, read) = (free as usize, LineRead { line, token: free });
        let taken = context.dram.read(now, now + self.latency_cycles, read);
        debug_assert!(taken, "the memory had room");
        self.mshrs_free.pop();
        self.on_their_way[bucket(line)] += 1;
        self.mshr_lines[mshr] = line;
        self.mshr_waiters[mshr] = NOBODY;
        self.wait(mshr, port);
        self.counters.lookups += 1;
        self.counters.misses += 1;
        context.traffic.read[region as usize] += self.line_bytes;
        true
    }

    /// Adds `port` to those who wait for the line of `mshr`.
    fn wait(&mut self, mshr: usize, port: Port) {
        let waiter = Waiter { port, next: END };
        let at = self.waiters_free;
        let at = if at == END {
            self.waiters.push(waiter);
            (self.waiters.len() - 1) as u32
        } else {
            self.waiters_free = self.waiters[at as usize].next;
            self.waiters[at as usize] = waiter;
            at
        };
        let list = &mut self.mshr_waiters[mshr];
        if *list == NOBODY {
            *list = WaiterList { first: at, last: at };
        } else {
            self.waiters[list.last as usize].next = at;
            list.last = at;
        }
    }

    /// Whether `line` is here. Changes nothing.
    pub fn contains(&self, line: u64) -> bool {
        self.tags.contains(line)
    }

    /// Lines that left since the last call (inclusive only).
    pub fn take_evicted(&mut self) -> Vec<u64> {
        std::mem::take(&mut self.evicted)
    }

    /// What happened so far.
    pub fn counters(&self) -> &L2Counters {
        &self.counters
    }
}

impl Component for L2Cache {
    type Report = L2Counters;

    /// A hit to answer, or a head to look up. Blocked heads wait for the memory's events.
    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        if self.ready_banks > 0 {
            return When::at(now + 1);
        }
        When::from(self.hits.front().map(|&(ready, _)| ready))
    }

    fn finish(&mut self, _: TiCycle) -> L2Counters {
        self.counters
    }
}

impl Tick<L2Context<'_>> for L2Cache {
    /// Answers hits that are due, then each bank looks up its head.
    fn tick(&mut self, now: TiCycle, mut context: L2Context<'_>) {
        while let Some(&(ready, response)) = self.hits.front()
            && ready <= now
        {
            self.hits.pop_front();
            context.arrived.push(response);
        }
        if self.ready_banks == 0 && self.mshrs_free.is_empty() {
            return;
        }
        let banks = self.banks.len();
        for turn in 0..banks {
            self.serve(now, (now.0 as usize).wrapping_add(turn) & (banks - 1), &mut context);
        }
    }
}
