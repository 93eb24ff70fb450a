//! A memory without limits: every read is answered after a fixed time. For bounds and closed forms.

use std::collections::VecDeque;

use super::{Cycle, Memory, Request, Response, Route};

/// Answers every request exactly `latency` cycles later, at any rate.
#[derive(Clone, Debug)]
pub struct IdealMemory {
    latency: Cycle,
    waiting: VecDeque<(Cycle, Response)>,
    reads: u64,
    writes: u64,
}

impl IdealMemory {
    /// A memory of that latency, T&I cycles.
    ///
    /// # Panics
    /// When the latency is 0: a response comes at a later cycle than its request.
    pub fn new(latency: Cycle) -> Self {
        assert!(latency > 0, "a response takes at least a cycle");
        Self { latency, waiting: VecDeque::new(), reads: 0, writes: 0 }
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
    fn request(&mut self, now: Cycle, request: Request) -> bool {
        if request.route == Route::Write {
            self.writes += 1;
        } else {
            self.reads += 1;
            self.waiting.push_back((now + self.latency, Response { port: request.port, line: request.line }));
        }
        true
    }

    fn tick(&mut self, now: Cycle, arrived: &mut Vec<Response>) {
        while let Some(&(ready, response)) = self.waiting.front()
            && ready <= now
        {
            self.waiting.pop_front();
            arrived.push(response);
        }
    }

    fn next_event(&self) -> Option<Cycle> {
        self.waiting.front().map(|&(ready, _)| ready)
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
        assert!(memory.request(5, request));
        assert!(memory.request(5, Request { route: Route::Write, ..request }));
        let mut arrived = Vec::new();
        assert_eq!(memory.next_event(), Some(12));
        memory.tick(11, &mut arrived);
        assert!(arrived.is_empty());
        memory.tick(12, &mut arrived);
        assert_eq!(arrived, [Response { port: Port(3), line: 11 }]);
        assert_eq!((memory.next_event(), memory.reads(), memory.writes()), (None, 1, 1));
    }
}
