//! Messages through memory: written by one side, read by the other, out in order.
//!
//! Used for rays and hits of `interface = "memory"` and for the G-buffer of a rasteriser. As many messages as fit share a line
//! and none straddles two unless it is larger than a line. A line is written when it is full, or `gpu.stream_flush_cycles` after its
//! first message, so that few rays are not held back. One line a cycle is written and one read, at most `gpu.stream_reads` reads
//! outstanding, and a line is read at the earliest one cycle after memory accepted its write. (Estimate.) Lines lie in a ring: one is
//! not written before the one that had its place has been read.

use std::collections::VecDeque;

use super::stats::DmaCounters;
use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::link::RayRef;
use crate::memory::{Memory, Port, Request, Route};
use crate::time::{TiCycle, When};
use crate::work::layout::Region;

/// Lines that belong together: one line of several messages, or the lines of one large message.
#[derive(Clone, Copy, Debug)]
struct Packet {
    messages: u32,
    line: u64,
    arrived: u64,
}

/// A stream of messages.
#[derive(Clone, Debug)]
pub struct Stream {
    port: Port,
    region: Region,
    first_line: u64,
    next_line: u64,
    line_bytes: u64,
    per_packet: u32,
    packet_lines: u64,
    /// Lines of the ring buffer that it runs through.
    ring_lines: u64,
    flush_cycles: u64,
    reads_max: usize,
    messages: VecDeque<RayRef>,
    open: u32,
    open_since: TiCycle,
    packets: VecDeque<Packet>,
    /// Lines of `packets` written and asked for, counted from the front packet.
    written: u64,
    asked: u64,
    outstanding: usize,
    ready: u32,
    wrote_at: Option<TiCycle>,
    read_at: Option<TiCycle>,
    write_refused: bool,
    read_refused: bool,
    counters: DmaCounters,
}

impl Stream {
    /// A stream of messages of `message_bytes`, from an address of a region on.
    pub fn new(config: &MachineConfig, port: Port, (region, address): (Region, u64), message_bytes: u64) -> Self {
        let (line_bytes, bytes) = (u64::from(config.l2.line_bytes), message_bytes.max(1));
        let packet_lines = bytes.div_ceil(line_bytes);
        Self {
            port,
            region,
            first_line: address / line_bytes,
            next_line: 0,
            line_bytes,
            per_packet: (line_bytes / bytes).max(1) as u32,
            packet_lines,
            ring_lines: u64::from(config.layout.ring_lines) * packet_lines,
            flush_cycles: config.gpu.stream_flush_cycles.into(),
            reads_max: config.gpu.stream_reads.max(1) as usize,
            messages: VecDeque::new(),
            open: 0,
            open_since: TiCycle::default(),
            packets: VecDeque::new(),
            written: 0,
            asked: 0,
            outstanding: 0,
            ready: 0,
            wrote_at: None,
            read_at: None,
            write_refused: false,
            read_refused: false,
            counters: DmaCounters::default(),
        }
    }

    /// Adds a message.
    pub fn push(&mut self, now: TiCycle, message: RayRef) {
        if self.open == 0 {
            self.open_since = now;
        }
        self.open += 1;
        self.messages.push_back(message);
        if self.open == self.per_packet {
            self.close();
        }
    }

    /// Lines that wait to be written.
    pub fn unwritten_lines(&self) -> u64 {
        self.packets.len() as u64 * self.packet_lines - self.written
    }

    /// Ends the line that is being filled.
    pub fn close(&mut self) {
        if self.open > 0 {
            self.packets.push_back(Packet { messages: self.open, line: self.first_line + self.next_line, arrived: 0 });
            self.next_line = (self.next_line + self.packet_lines) % self.ring_lines;
            self.open = 0;
        }
    }

    /// Whether the stream uses this line.
    pub fn owns(&self, line: u64) -> bool {
        (self.first_line..self.first_line + self.ring_lines).contains(&line)
    }

    /// Whether a line waits to be written whose place in the ring is free.
    fn can_write(&self) -> bool {
        self.unwritten_lines() > 0 && self.written < self.ring_lines
    }

    fn read_line<M: Memory>(&mut self, now: TiCycle, memory: &mut M) {
        self.read_refused = !memory.request(now, self.request(self.asked, Route::Read));
        if !self.read_refused {
            *self.counters.of(self.region, true) += self.line_bytes;
            (self.asked, self.outstanding, self.read_at) = (self.asked + 1, self.outstanding + 1, Some(now));
        }
    }

    fn write_line<M: Memory>(&mut self, now: TiCycle, memory: &mut M) {
        self.write_refused = !memory.request(now, self.request(self.written, Route::Write));
        if !self.write_refused {
            *self.counters.of(self.region, false) += self.line_bytes;
            (self.written, self.wrote_at) = (self.written + 1, Some(now));
        }
    }

    fn request(&self, line: u64, route: Route) -> Request {
        let packet = &self.packets[(line / self.packet_lines) as usize];
        Request { port: self.port, line: packet.line + line % self.packet_lines, region: self.region, route }
    }

    /// A line arrived.
    pub fn respond(&mut self, line: u64) {
        let of = |p: &Packet| p.line <= line && line < p.line + self.packet_lines;
        if let Some(packet) = self.packets.iter().position(of) {
            self.packets[packet].arrived += 1;
            self.outstanding -= 1;
        }
        while self.packets.front().is_some_and(|p| p.arrived == self.packet_lines) {
            self.ready += self.packets.pop_front().map_or(0, |p| p.messages);
            self.written -= self.packet_lines;
            self.asked -= self.packet_lines;
        }
    }

    /// Whether a message can be taken.
    pub fn has_ready(&self) -> bool {
        self.ready > 0
    }

    /// Takes the next message that has arrived.
    pub fn pop(&mut self) -> Option<RayRef> {
        if self.ready == 0 {
            return None;
        }
        self.ready -= 1;
        self.messages.pop_front()
    }

    /// What it moved so far.
    pub fn counters(&self) -> &DmaCounters {
        &self.counters
    }

    /// Whether memory refused a request of the last tick.
    pub fn refused(&self) -> bool {
        self.read_refused || self.write_refused
    }
}

impl Component for Stream {
    type Report = DmaCounters;

    /// Messages that can be taken are the taker's event.
    fn next_event(&self, now: TiCycle) -> When {
        let reads = self.asked < self.written && self.outstanding < self.reads_max && !self.read_refused;
        let writes = self.can_write() && !self.write_refused;
        if reads || writes {
            return When::at(now + 1);
        }
        When::only_if(self.open > 0, self.open_since + self.flush_cycles).after(now)
    }

    fn finish(&mut self, _: TiCycle) -> DmaCounters {
        self.counters
    }
}

impl<M: Memory> Tick<&mut M> for Stream {
    /// Moves a line each way. Reads come before writes: a line is read a cycle after it was written.
    fn tick(&mut self, now: TiCycle, memory: &mut M) {
        if self.open > 0 && now >= self.open_since + self.flush_cycles {
            self.close();
        }
        (self.read_refused, self.write_refused) = (false, false);
        if self.asked < self.written && self.outstanding < self.reads_max && self.read_at != Some(now) {
            self.read_line(now, memory);
        }
        if self.can_write() && self.wrote_at != Some(now) {
            self.write_line(now, memory);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::srp::tests::mocks::Mem;
    use crate::test_config::machine;

    /// A ring of four lines, of which the first comes last: nothing takes its place before that.
    #[test]
    fn a_line_that_is_not_read_is_not_written_over() {
        let mut config = machine();
        (config.layout.ring_lines, config.gpu.stream_reads) = (4, 16);
        let line_bytes = config.l2.line_bytes.into();
        let mut stream = Stream::new(&config, Port(0), (Region::Ray, 0), line_bytes);
        let (mut memory, mut now) = (Mem::new(1000, 0), 0);
        let mut tick = |stream: &mut Stream| {
            (0..20).for_each(|_| {
                stream.tick(TiCycle(now), &mut memory);
                now += 1;
            });
            std::mem::take(&mut memory.log)
        };
        let lines = |log: &[(u64, Request)], route| -> Vec<u64> {
            log.iter().filter(|(_, request)| request.route == route).map(|(_, request)| request.line).collect()
        };
        (0..12).for_each(|ray| stream.push(TiCycle(0), RayRef { slot: 0, ray }));
        let log = tick(&mut stream);
        assert_eq!((lines(&log, Route::Write), lines(&log, Route::Read)), (vec![0, 1, 2, 3], vec![0, 1, 2, 3]));
        (1..4).for_each(|line| stream.respond(line));
        assert!(tick(&mut stream).is_empty() && !stream.has_ready() && stream.next_event(TiCycle(40)).is_never());
        stream.respond(0);
        let mut taken = Vec::new();
        for _ in 0..3 {
            let log = tick(&mut stream);
            lines(&log, Route::Read).into_iter().for_each(|line| stream.respond(line));
            taken.extend(std::iter::from_fn(|| stream.pop()).map(|ray| ray.ray));
        }
        assert_eq!(taken, (0..12).collect::<Vec<_>>());
    }
}
