//! The DMA engine: blocks of lines to and from memory that only their tile waits for.
//!
//! Transfers run in the order in which they were asked for, one line a T&I cycle, at most `srp.dma_reads` reads outstanding. A write
//! is done when memory has accepted it, a read when its line has arrived. Partly covered lines count as whole lines. (Estimate.)

use std::collections::VecDeque;

use super::stats::DmaCounters;
use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::memory::{Memory, Port, Request, Route};
use crate::time::{TiCycle, When};
use crate::work::layout::{Lines, Region};

#[derive(Clone, Copy, Debug)]
struct Transfer {
    slot: u8,
    region: Region,
    route: Route,
    line: u64,
    left: u64,
}

#[derive(Clone, Copy, Debug)]
struct OutstandingRead {
    slot: u8,
    line: u64,
}

/// The DMA engine of a core.
#[derive(Clone, Debug)]
pub struct Dma {
    port: Port,
    line_bytes: u64,
    transfers: VecDeque<Transfer>,
    reads: Vec<OutstandingRead>,
    reads_max: usize,
    /// Per slot the lines that are not done.
    pending: Vec<u64>,
    moved_at: Option<TiCycle>,
    refused: bool,
    counters: DmaCounters,
}

impl Dma {
    /// The engine of a core of a machine, at `port`, for `slots` tile slots.
    pub fn new(config: &MachineConfig, port: Port, slots: usize) -> Self {
        let reads_max = config.srp.dma_reads.max(1) as usize;
        Self {
            port,
            line_bytes: config.l2.line_bytes.into(),
            transfers: VecDeque::new(),
            reads: Vec::with_capacity(reads_max),
            reads_max,
            pending: vec![0; slots],
            moved_at: None,
            refused: false,
            counters: DmaCounters::default(),
        }
    }

    /// Queues a transfer of slot `slot`.
    pub fn add(&mut self, slot: u8, region: Region, route: Route, lines: Lines) {
        let left = lines.count();
        self.transfers.push_back(Transfer { slot, region, route, line: lines.first, left });
        self.pending[slot as usize] += left;
    }

    /// Lines of a slot that are not done.
    #[inline]
    pub fn pending(&self, slot: u8) -> u64 {
        self.pending[slot as usize]
    }

    /// Whether nothing is under way.
    pub fn is_idle(&self) -> bool {
        self.transfers.is_empty() && self.reads.is_empty()
    }

    /// A line arrived.
    pub fn respond(&mut self, line: u64) {
        if let Some(read) = self.reads.iter().position(|read| read.line == line) {
            let slot = self.reads.swap_remove(read).slot;
            self.pending[slot as usize] -= 1;
        }
    }

    /// Whether memory refused the last request: it is tried again whenever memory has done something.
    pub fn refused(&self) -> bool {
        self.refused
    }

    /// What it moved so far.
    pub fn counters(&self) -> &DmaCounters {
        &self.counters
    }
}

impl Component for Dma {
    type Report = DmaCounters;

    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        let Some(head) = self.transfers.front() else { return When::NEVER };
        let waits = self.refused || (head.route != Route::Write && self.reads.len() >= self.reads_max);
        When::only_if(!waits, now + 1)
    }

    fn finish(&mut self, _: TiCycle) -> DmaCounters {
        self.counters
    }
}

impl<M: Memory> Tick<&mut M> for Dma {
    /// Moves one line.
    #[inline]
    fn tick(&mut self, now: TiCycle, memory: &mut M) {
        self.refused = false;
        let Some(head) = self.transfers.front_mut() else { return };
        let read = head.route != Route::Write;
        if self.moved_at == Some(now) || (read && self.reads.len() >= self.reads_max) {
            return;
        }
        let request = Request { port: self.port, line: head.line, region: head.region, route: head.route };
        if !memory.request(now, request) {
            self.refused = true;
            return;
        }
        self.moved_at = Some(now);
        if read {
            self.reads.push(OutstandingRead { slot: head.slot, line: head.line });
        } else {
            self.pending[head.slot as usize] -= 1;
        }
        *self.counters.of(head.region, read) += self.line_bytes;
        head.line += 1;
        head.left -= 1;
        if head.left == 0 {
            self.transfers.pop_front();
        }
    }
}
