//! The crossbar by which leaf operations reach the intersection units: reserved entries, and tasks on their way.
//!
//! A traversal unit reserves an entry of an intersection unit before it issues a leaf operation, so a task that arrives always
//! has a place. Leaf operations without an entry wait in one queue for all traversal units; an entry that becomes free goes to
//! the first of them in the cycle after. A unit accepts one task a cycle.

use std::collections::VecDeque;

use super::wheel::{Event, EventKind, Wheel};
use crate::config::MachineConfig;
use crate::time::TiCycle;

/// A ray in a leaf: triangles to test one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LeafTask {
    /// Traversal unit.
    pub trv: u8,
    /// The ray's slot there.
    pub slot: u8,
    /// First triangle.
    pub triangle: u32,
    /// Number of triangles to test.
    pub tests: u8,
}

/// A leaf operation that needs an entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafRequest {
    /// Traversal unit.
    pub trv: u8,
    /// The ray's slot there.
    pub slot: u8,
    /// When the operation came to the leaf stage.
    pub arrived: TiCycle,
}

/// A leaf operation that has its entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeafGrant {
    /// The operation.
    pub request: LeafRequest,
    /// Intersection unit of the entry.
    pub ist: u8,
}

/// The crossbar of a core.
#[derive(Debug)]
pub struct LeafCrossbar {
    latency_cycles: u64,
    /// Free entries of each unit.
    free: Vec<u32>,
    /// Tasks on their way, and first cycle in which each unit can accept one.
    inbox: Vec<VecDeque<LeafTask>>,
    accepts: Vec<TiCycle>,
    /// Leaf operations without an entry.
    waiting: VecDeque<LeafRequest>,
}

impl LeafCrossbar {
    /// The crossbar of a core.
    pub fn new(config: &MachineConfig) -> Self {
        let ist = config.ti.ist as usize;
        Self {
            latency_cycles: config.ti.crossbar_cycles.into(),
            free: vec![config.ti.ist_entries; ist],
            inbox: vec![VecDeque::with_capacity(config.ti.ist_entries as usize); ist],
            accepts: vec![TiCycle::default(); ist],
            waiting: VecDeque::new(),
        }
    }

    /// An entry for a leaf operation. Without one it waits, and [`LeafCrossbar::grant`] gives it out later.
    #[inline]
    pub fn reserve_or_wait(&mut self, request: LeafRequest) -> Option<LeafGrant> {
        let ist = if self.waiting.is_empty() { self.reserve() } else { None };
        if ist.is_none() {
            self.waiting.push_back(request);
        }
        ist.map(|ist| LeafGrant { request, ist })
    }

    /// The operation that waits longest with its entry, if there is one.
    #[inline]
    pub fn grant(&mut self) -> Option<LeafGrant> {
        let &request = self.waiting.front()?;
        let ist = self.reserve()?;
        self.waiting.pop_front();
        Some(LeafGrant { request, ist })
    }

    /// Reserves an entry of the unit that has most of them free, the first of equals.
    #[inline]
    fn reserve(&mut self) -> Option<u8> {
        let mut best = 0;
        for ist in 1..self.free.len() {
            if self.free[ist] > self.free[best] {
                best = ist;
            }
        }
        let free = self.free.get_mut(best).filter(|free| **free > 0)?;
        *free -= 1;
        Some(best as u8)
    }

    /// Gives an entry back.
    #[inline]
    pub fn release(&mut self, ist: u8) {
        self.free[ist as usize] += 1;
    }

    /// Sends a task to a reserved entry.
    #[inline]
    pub fn send(&mut self, now: TiCycle, ist: u8, task: LeafTask, wheel: &mut Wheel) {
        let accepts = &mut self.accepts[ist as usize];
        let at = (now + self.latency_cycles).max(*accepts);
        *accepts = at + 1;
        self.inbox[ist as usize].push_back(task);
        wheel.push(at, Event::new(EventKind::Task, ist, 0));
    }

    /// The task that an intersection unit accepts.
    #[inline]
    pub fn accept(&mut self, ist: u8) -> Option<LeafTask> {
        self.inbox[ist as usize].pop_front()
    }
}
