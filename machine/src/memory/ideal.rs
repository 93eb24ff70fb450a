//! A memory without limits: every read is answered after a fixed time. For bounds and closed forms.

use std::collections::VecDeque;

use super::interface::Memory;
use super::request::{Request, Response, Route};
use super::stats::MemoryStats;
use crate::component::{Component, Tick};
use crate::time::{TiCycle, When};

/// Answers every request a fixed number of cycles later, at any rate.
#[derive(Clone, Debug)]
pub struct IdealMemory {
    latency_cycles: u64,
    /// Responses with the cycle at which they arrive, in order.
    waiting: VecDeque<(TiCycle, Response)>,
    reads: u64,
    writes: u64,
}

impl IdealMemory {
    /// A memory of that latency, T&I cycles.
    ///
    /// # Panics
    /// When the latency is 0: a response comes at a later cycle than its request.
    pub fn new(latency_cycles: u64) -> Self {
        assert!(latency_cycles > 0, "a response takes at least a cycle");
        Self { latency_cycles, waiting: VecDeque::new(), reads: 0, writes: 0 }
    }

    /// Lines read so far.
    pub fn reads(&self) -> u64 {
        self.reads
    }

    /// Lines written so far.
    pub fn writes(&self) -> u64 {
        self.writes
    }
}

impl Memory for IdealMemory {
    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        if request.route == Route::Write {
            self.writes += 1;
        } else {
            self.reads += 1;
            let response = Response { port: request.port, line: request.line };
            self.waiting.push_back((now + self.latency_cycles, response));
        }
        true
    }
}

impl Component for IdealMemory {
    /// Nothing: it has neither an L2 nor DRAM.
    type Report = MemoryStats;

    fn next_event(&self, now: TiCycle) -> When {
        When::from(self.waiting.front().map(|&(ready, _)| ready)).after(now)
    }

    fn finish(&mut self, _: TiCycle) -> MemoryStats {
        MemoryStats::default()
    }
}

impl Tick<&mut Vec<Response>> for IdealMemory {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        while let Some(&(ready, response)) = self.waiting.front()
            && ready <= now
        {
            self.waiting.pop_front();
            arrived.push(response);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Port;
    use super::*;
    use crate::work::layout::Region;

    #[test]
    fn a_read_takes_exactly_its_latency() {
        let mut memory = IdealMemory::new(7);
        let request = Request { port: Port(3), line: 11, region: Region::Node, route: Route::Cached };
        assert!(memory.request(TiCycle(5), request));
        assert!(memory.request(TiCycle(5), Request { route: Route::Write, ..request }));
        let mut arrived = Vec::new();
        assert_eq!(memory.next_event(TiCycle(5)), When::at(TiCycle(12)));
        memory.tick(TiCycle(11), &mut arrived);
        assert!(arrived.is_empty());
        memory.tick(TiCycle(12), &mut arrived);
        assert_eq!(arrived, [Response { port: Port(3), line: 11 }]);
        assert_eq!((memory.is_idle(TiCycle(12)), memory.reads(), memory.writes()), (true, 1, 1));
    }
}
