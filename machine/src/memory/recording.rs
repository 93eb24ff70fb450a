//! A memory that writes down what it is asked, and by whom, in the order of issue. It changes nothing: a machine in front of it does
//! what it does in front of the memory behind.

use super::interface::Memory;
use super::request::{Lookup, Request, Response};
use crate::component::{Component, Tick};
use crate::time::{TiCycle, When};

/// Something that was issued.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Issued<T> {
    /// When.
    pub at: TiCycle,
    /// What.
    pub what: T,
}

/// A memory with a record of what was issued to it.
#[derive(Clone, Debug)]
pub struct Recording<M> {
    behind: M,
    /// What units looked for in their L1s.
    lookups: Option<Vec<Issued<Lookup>>>,
    /// Requests that it took: what L1s missed, and what engines read and wrote.
    requests: Option<Vec<Issued<Request>>>,
}

impl<M> Recording<M> {
    /// Writes down what units look for, before any cache.
    pub fn of_lookups(behind: M) -> Self {
        Self { behind, lookups: Some(Vec::new()), requests: None }
    }

    /// Writes down requests for lines, behind the L1s.
    pub fn of_requests(behind: M) -> Self {
        Self { behind, lookups: None, requests: Some(Vec::new()) }
    }

    /// What units looked for since the last call, in order.
    pub fn take_lookups(&mut self) -> Vec<Issued<Lookup>> {
        self.lookups.as_mut().map(std::mem::take).unwrap_or_default()
    }

    /// The requests taken since the last call, in order.
    pub fn take_requests(&mut self) -> Vec<Issued<Request>> {
        self.requests.as_mut().map(std::mem::take).unwrap_or_default()
    }
}

impl<M: Memory> Memory for Recording<M> {
    const LISTENS: bool = true;

    fn wants_lookups(&self) -> bool {
        self.lookups.is_some()
    }

    fn looked_for(&mut self, now: TiCycle, lookup: Lookup) {
        if let Some(lookups) = &mut self.lookups {
            lookups.push(Issued { at: now, what: lookup });
        }
    }

    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        let taken = self.behind.request(now, request);
        if let (true, Some(requests)) = (taken, &mut self.requests) {
            requests.push(Issued { at: now, what: request });
        }
        taken
    }

    fn is_idle(&self, now: TiCycle) -> bool {
        self.behind.is_idle(now)
    }

    fn bytes_moved(&self) -> u64 {
        self.behind.bytes_moved()
    }

    fn take_evicted(&mut self) -> Vec<u64> {
        self.behind.take_evicted()
    }
}

impl<M: Memory> Component for Recording<M> {
    type Report = M::Report;

    fn next_event(&self, now: TiCycle) -> When {
        self.behind.next_event(now)
    }

    fn finish(&mut self, end: TiCycle) -> Self::Report {
        self.behind.finish(end)
    }
}

impl<M: Memory> Tick<&mut Vec<Response>> for Recording<M> {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.behind.tick(now, arrived);
    }
}
