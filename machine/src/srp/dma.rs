//! The DMA engine: blocks of lines to and from memory that only their tile waits for.
//!
//! Transfers run in the order in which they were asked for, one line a T&I cycle, at most [`READS`] reads outstanding. A write
//! is done when memory has accepted it, a read when its line has arrived. Partly covered lines count as whole lines. (Estimate.)

use std::collections::VecDeque;

use super::stats::DmaCounters;
use crate::memory::{Cycle, Memory, Port, Request, Route};
use crate::work::layout::{Lines, Region};

/// Reads outstanding of the DMA engine, and of each stream.
pub const READS: usize = 16;

#[derive(Clone, Copy, Debug)]
struct Transfer {
    slot: u8,
    region: Region,
    route: Route,
    line: u64,
    left: u64,
}

/// The DMA engine of a core.
#[derive(Clone, Debug)]
pub struct Dma {
    port: Port,
    line_bytes: u64,
    transfers: VecDeque<Transfer>,
    reads: Vec<(u64, u8)>,
    pending: Vec<u64>,
    moved_at: Option<Cycle>,
    refused: bool,
}

impl Dma {
    /// An engine for `slots` tile slots.
    pub fn new(port: Port, line_bytes: u64, slots: usize) -> Self {
        Self {
            port,
            line_bytes,
            transfers: VecDeque::new(),
            reads: Vec::with_capacity(READS),
            pending: vec![0; slots],
            moved_at: None,
            refused: false,
        }
    }

    /// Queues a transfer of slot `slot`.
    pub fn add(&mut self, slot: u8, region: Region, route: Route, lines: Lines) {
        let left = lines.last - lines.first + 1;
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

    /// Moves one line.
    pub fn tick<M: Memory>(&mut self, now: Cycle, memory: &mut M, counters: &mut DmaCounters) {
        self.refused = false;
        let Some(head) = self.transfers.front_mut() else { return };
        let read = head.route != Route::Write;
        if self.moved_at == Some(now) || (read && self.reads.len() >= READS) {
            return;
        }
        let request = Request { port: self.port, line: head.line, region: head.region, route: head.route };
        if !memory.request(now, request) {
            self.refused = true;
            return;
        }
        self.moved_at = Some(now);
        if read {
            self.reads.push((head.line, head.slot));
        } else {
            self.pending[head.slot as usize] -= 1;
        }
        *counter(counters, head.region, read) += self.line_bytes;
        head.line += 1;
        head.left -= 1;
        if head.left == 0 {
            self.transfers.pop_front();
        }
    }

    /// A line arrived.
    pub fn respond(&mut self, line: u64) {
        if let Some(place) = self.reads.iter().position(|(l, _)| *l == line) {
            let (_, slot) = self.reads.swap_remove(place);
            self.pending[slot as usize] -= 1;
        }
    }

    /// Whether memory refused the last request: it is tried again whenever memory has done something.
    pub fn refused(&self) -> bool {
        self.refused
    }

    /// When the engine can do something by itself.
    pub fn next_event(&self, now: Cycle) -> Option<Cycle> {
        let head = self.transfers.front()?;
        let waits = self.refused || (head.route != Route::Write && self.reads.len() >= READS);
        (!waits).then_some(now + 1)
    }
}

/// The counter of a region's traffic.
pub fn counter(counters: &mut DmaCounters, region: Region, read: bool) -> &mut u64 {
    match (region, read) {
        (Region::Framebuffer, _) => &mut counters.framebuffer_written,
        (Region::Border, false) => &mut counters.border_written,
        (Region::Border, true) => &mut counters.border_read,
        (Region::GBuffer, false) => &mut counters.gbuffer_written,
        (Region::GBuffer, true) => &mut counters.gbuffer_read,
        (Region::Ray, false) => &mut counters.ray_written,
        (Region::Ray, true) => &mut counters.ray_read,
        (_, false) => &mut counters.sample_written,
        (_, true) => &mut counters.sample_read,
    }
}
