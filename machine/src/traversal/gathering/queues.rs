//! Rays that need the same node or triangle, queue by queue: which queue can issue, and when.

use std::cmp::Reverse;
use std::collections::VecDeque;

use crate::config::MachineConfig;
use crate::memory::{Access, L1Cache, Memory};
use crate::time::{TiCycle, When};
use crate::work::layout::{Lines, Region};

/// Testers: of boxes, and of triangles.
pub const TESTERS: usize = 2;

/// The testers of a region.
pub fn testers(region: Region) -> usize {
    usize::from(region == Region::Triangle)
}

/// What a queue is for: region and number of node or triangle, as one number that is fast to look for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key(u64);

impl Key {
    /// A queue that is free.
    const FREE: Self = Self(u64::MAX);

    /// Of a node or triangle.
    pub fn new(region: Region, index: u32) -> Self {
        Self((region as u64) << 32 | u64::from(index))
    }
}

/// Rays that need the same.
#[derive(Clone, Debug)]
struct Queue {
    region: Region,
    lines: Lines,
    /// In the order in which queues were opened.
    number: u64,
    /// Places of its rays, each with the cycle in which it came.
    rays: VecDeque<(u16, TiCycle)>,
    /// Lines that were looked up, and that have not come.
    looked_up: u64,
    missing: u32,
    /// Lines that its first issue reads after they have come; those that were there were read when they were looked up.
    missed: u64,
    /// When its data can be read; known once all lines are here.
    ready: TiCycle,
    /// It has issued before.
    again: bool,
}

/// Rays of a queue that are tested in a cycle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Taken {
    /// Their places in the unit.
    pub places: Vec<u16>,
    /// Lines that are read for them now: those that had missed, and all where the queue has issued before.
    pub late_reads: u64,
}

/// Which of two queues is taken: the fuller, of equals the one that was opened first.
type Rank = (usize, Reverse<u64>);

/// The queues of a unit.
#[derive(Debug)]
pub struct Queues {
    /// Rays of a queue that testers take a cycle.
    width: [usize; TESTERS],
    wait_cycles: u64,
    latency_cycles: u64,
    queues: Vec<Option<Queue>>,
    /// Of each queue what it is for, and when it can issue: searched and compared in every cycle.
    keys: Vec<Key>,
    issues_at: Vec<When>,
    /// Queues whose lines are to be looked up, those that were opened first at first.
    to_look_up: VecDeque<u8>,
    /// Queues that are open, and those of them that have all lines, by tester.
    open: [usize; TESTERS],
    filled: [usize; TESTERS],
    opened: u64,
}

impl Queue {
    fn is_looked_up(&self) -> bool {
        self.looked_up > self.lines.last - self.lines.first
    }

    fn has_lines(&self) -> bool {
        self.is_looked_up() && self.missing == 0
    }
}

impl Queues {
    /// No queue is open.
    pub fn new(config: &MachineConfig) -> Self {
        let ti = &config.ti;
        let count = ti.gather_queues as usize;
        Self {
            width: [ti.gather_boxes as usize, ti.gather_triangles as usize],
            wait_cycles: ti.gather_wait_cycles.into(),
            latency_cycles: ti.trv_l1.latency_cycles.into(),
            queues: vec![None; count],
            keys: vec![Key::FREE; count],
            issues_at: vec![When::NEVER; count],
            to_look_up: VecDeque::new(),
            open: [0; TESTERS],
            filled: [0; TESTERS],
            opened: 0,
        }
    }

    /// The ray at `place` joins the queue of what it needs, or opens it; false where none is free.
    pub fn join(&mut self, now: TiCycle, place: u16, (region, index): (Region, u32), lines: Lines) -> bool {
        let key = Key::new(region, index);
        if let Some(id) = self.keys.iter().position(|other| *other == key) {
            if let Some(queue) = &mut self.queues[id] {
                queue.rays.push_back((place, now));
            }
            self.plan(id);
            return true;
        }
        let Some(id) = self.keys.iter().position(|other| *other == Key::FREE) else { return false };
        let (rays, number) = (VecDeque::from([(place, now)]), self.opened);
        self.queues[id] =
            Some(Queue { region, lines, number, rays, looked_up: 0, missing: 0, missed: 0, ready: now, again: false });
        self.keys[id] = key;
        self.to_look_up.push_back(id as u8);
        self.open[testers(region)] += 1;
        self.opened += 1;
        true
    }

    /// Looks up what queues need, until a lookup is refused.
    pub fn look_up<M: Memory>(&mut self, now: TiCycle, l1: &mut L1Cache, memory: &mut M) {
        while let Some(&id) = self.to_look_up.front() {
            let Some(queue) = &mut self.queues[usize::from(id)] else { return };
            let line = queue.lines.first + queue.looked_up;
            match l1.access(now, line, queue.region, id, memory) {
                Access::Hit => queue.ready = queue.ready.max(now + self.latency_cycles),
                Access::Miss | Access::Merged => {
                    queue.missing += 1;
                    queue.missed += 1;
                }
                Access::Rejected => return,
            }
            queue.looked_up += 1;
            if queue.is_looked_up() {
                self.to_look_up.pop_front();
                self.note_lines(id.into());
            }
        }
    }

    /// A line arrived that queue `id` waits for.
    pub fn fill(&mut self, now: TiCycle, id: usize) {
        if let Some(queue) = &mut self.queues[id] {
            queue.missing -= 1;
            queue.ready = queue.ready.max(now);
            self.note_lines(id);
        }
    }

    /// A queue may have all its lines.
    fn note_lines(&mut self, id: usize) {
        if let Some(queue) = self.queues[id].as_ref().filter(|queue| queue.has_lines()) {
            self.filled[testers(queue.region)] += 1;
            self.plan(id);
        }
    }

    /// Notes when a queue can issue: its rays or its lines have changed.
    fn plan(&mut self, id: usize) {
        self.issues_at[id] = self.queues[id].as_ref().map_or(When::NEVER, |queue| self.issue_of(queue));
    }

    /// When a queue can issue; never before its lines are here.
    fn issue_of(&self, queue: &Queue) -> When {
        if !queue.has_lines() {
            return When::NEVER;
        }
        let company = match queue.rays.front() {
            Some(_) if queue.rays.len() >= self.width[testers(queue.region)] => TiCycle(0),
            Some((_, came)) => *came + self.wait_cycles,
            None => return When::NEVER,
        };
        When::at(queue.ready.max(company))
    }

    /// For each kind of testers the queue that they take in cycle `now`: the fullest, of equals the first.
    pub fn best(&self, now: TiCycle) -> [Option<usize>; TESTERS] {
        let mut best: [Option<(usize, Rank)>; TESTERS] = [None; TESTERS];
        let due = self.issues_at.iter().enumerate().filter(|(_, at)| at.is_due(now));
        for (id, queue) in due.filter_map(|(id, _)| Some((id, self.queues[id].as_ref()?))) {
            let (best, rank) = (&mut best[testers(queue.region)], (queue.rays.len(), Reverse(queue.number)));
            if best.is_none_or(|(_, other)| rank > other) {
                *best = Some((id, rank));
            }
        }
        best.map(|best| best.map(|(id, _)| id))
    }

    /// Takes rays of queue `id`, as many as its testers test in a cycle.
    pub fn take(&mut self, id: usize) -> Option<Taken> {
        let queue = self.queues[id].as_mut()?;
        let late_reads = if queue.again { queue.lines.count() } else { queue.missed };
        queue.again = true;
        let tester = testers(queue.region);
        let take = queue.rays.len().min(self.width[tester]);
        let places = queue.rays.drain(..take).map(|(place, _)| place).collect();
        if queue.rays.is_empty() {
            (self.queues[id], self.keys[id]) = (None, Key::FREE);
            self.open[tester] -= 1;
            self.filled[tester] -= 1;
        }
        self.plan(id);
        Some(Taken { places, late_reads })
    }

    /// Whether a queue of these testers is open, and whether one of them has its lines.
    pub fn state(&self, tester: usize) -> (bool, bool) {
        (self.open[tester] > 0, self.filled[tester] > 0)
    }

    /// Whether a queue is free.
    pub fn has_free(&self) -> bool {
        self.keys.contains(&Key::FREE)
    }

    /// When something happens next by itself: a refused lookup is tried again in the next cycle.
    pub fn next_event(&self, now: TiCycle) -> When {
        let soonest = When::at(now + 1);
        // Mostly a queue can issue in the next cycle, and then it does not matter which.
        if !self.to_look_up.is_empty() || self.issues_at.iter().any(|at| *at <= soonest) {
            return soonest;
        }
        self.issues_at.iter().copied().fold(When::NEVER, When::min)
    }
}
