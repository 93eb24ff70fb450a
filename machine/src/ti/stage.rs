//! An issue stage: one operation a cycle, first ready, first issued; and the account of what it did in every cycle.
//!
//! An operation takes the first cycle behind all that are booked in which it is ready, so its issue is known as soon as it is
//! certain to be ready, and the cycles since the issue before can be accounted at once. (One that is ready before a booked
//! operation waits behind it: MODEL.md says what that costs.) A cycle without an issue is charged to
//! what the next operation waited for:
//! - from its arrival on, to what it waited for itself: a lookup or the hit latency, a line, a refused lookup, or a full stage behind;
//! - before that, to `idle` as far as no ray was in the unit; the rest to `memory` if at its arrival other operations of the
//!   stage waited for lines, otherwise to `starved`.

use crate::counters::Activity;
use crate::time::TiCycle;

/// What an operation waited for between arrival and issue. The numbers are places in an account.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wait {
    /// A lookup or the hit latency.
    Fetch = 2,
    /// A line.
    Memory = 3,
    /// A lookup that was refused.
    Refused = 4,
    /// The stage behind was full.
    Blocked = 5,
}

/// Places in an account, in the order of [`Activity`]; those of [`Wait`] lie between.
const BUSY: usize = 0;
const STARVED: usize = 6;
const IDLE: usize = 7;

/// An operation that is to issue.
#[derive(Clone, Copy, Debug)]
pub struct Candidate {
    /// When it came to the stage.
    pub arrived: TiCycle,
    /// When it can issue.
    pub ready: TiCycle,
    /// What it waited for in between.
    pub wait: Wait,
    /// It passes without work.
    pub bypass: bool,
    /// Other operations of the stage waited for lines when it arrived.
    pub others_wait: bool,
}

/// Cycles in which a unit holds no ray.
#[derive(Clone, Copy, Debug, Default)]
pub struct Idle {
    /// Finished spells.
    total: u64,
    /// Start of the spell at hand.
    since: Option<TiCycle>,
}

impl Idle {
    /// A unit that is idle from cycle 0 on.
    pub fn new() -> Self {
        Self { total: 0, since: Some(TiCycle(0)) }
    }

    /// A ray enters at cycle `now`.
    #[inline]
    pub fn end(&mut self, now: TiCycle) {
        if let Some(since) = self.since.take() {
            self.total += now - since;
        }
    }

    /// The last ray leaves at cycle `now`.
    #[inline]
    pub fn begin(&mut self, now: TiCycle) {
        self.since = Some(now);
    }

    /// Idle cycles before `now`.
    #[inline]
    pub fn before(&self, now: TiCycle) -> u64 {
        self.total + self.since.map_or(0, |since| now - since)
    }
}

/// An issue stage with its account.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stage {
    /// First cycle that is not accounted: the one after the last issue.
    free: TiCycle,
    /// Idle cycles of the unit that are accounted or lie before `free`.
    idle_seen: u64,
    /// Cycles by class.
    account: [u64; 8],
}

impl Stage {
    /// Issues an operation; returns the cycle. `idle` is that of the unit, which holds the operation's ray.
    ///
    /// No branch: whether there is a gap, and why, is as good as random.
    #[inline]
    pub fn issue(&mut self, op: Candidate, idle: &Idle) -> TiCycle {
        let at = op.ready.max(self.free);
        let arrived = op.arrived.clamp(self.free, at);
        let before = arrived - self.free;
        self.account[op.wait as usize] += at - arrived;
        let spell = (idle.total - self.idle_seen).min(before);
        let others = if op.others_wait { before - spell } else { 0 };
        self.account[Wait::Memory as usize] += others;
        self.account[IDLE] += spell;
        self.account[STARVED] += before - spell - others;
        self.account[BUSY + usize::from(op.bypass)] += 1;
        self.idle_seen = idle.total;
        self.free = at + 1;
        at
    }

    /// Cycles in which an operation issued or will issue, bypasses not.
    #[inline]
    pub fn busy(&self) -> u64 {
        self.account[BUSY]
    }

    /// The account of the cycles before `end`: nothing more issues before it. An operation that issues later is in it already.
    pub fn report(&self, end: TiCycle, idle: &Idle) -> Activity {
        let rest = end.since(self.free);
        let unused = (idle.before(end) - self.idle_seen).min(rest);
        let mut account = self.account;
        account[IDLE] += unused;
        account[STARVED] += rest - unused;
        let [busy, bypass, fetch, memory, mshr, blocked, starved, idle] = account;
        Activity { busy, bypass, fetch, memory, mshr, blocked, starved, idle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const OP: Candidate =
        Candidate { arrived: TiCycle(10), ready: TiCycle(12), wait: Wait::Fetch, bypass: false, others_wait: false };

    #[test]
    fn one_a_cycle_and_not_before_it_is_ready() {
        let (mut stage, idle) = (Stage::default(), Idle::default());
        assert_eq!(stage.issue(OP, &idle), 12);
        assert_eq!(stage.issue(OP, &idle), 13);
        assert_eq!(stage.issue(Candidate { ready: TiCycle(20), ..OP }, &idle), 20);
    }

    #[test]
    fn every_cycle_is_charged_once() {
        let (mut stage, mut idle) = (Stage::default(), Idle::new());
        idle.end(TiCycle(4));
        stage.issue(OP, &idle);
        let late = Candidate { ready: TiCycle(30), arrived: TiCycle(20), wait: Wait::Memory, others_wait: true, ..OP };
        stage.issue(late, &idle);
        stage.issue(Candidate { ready: TiCycle(31), arrived: TiCycle(31), bypass: true, ..OP }, &idle);
        idle.begin(TiCycle(40));
        let activity = stage.report(TiCycle(50), &idle);
        let Activity { busy, bypass, fetch, memory, idle, starved, .. } = activity;
        // 4 idle and 6 starved before the first; 7 of others and 10 for which the second waited itself; 8 starved, 10 idle at the end.
        assert_eq!((busy, bypass, fetch, memory, idle, starved), (2, 1, 2, 17, 14, 14));
        assert_eq!(activity.total(), 50);
    }

    #[test]
    fn a_unit_without_rays_waits_for_no_line() {
        let (mut stage, mut idle) = (Stage::default(), Idle::new());
        idle.end(TiCycle(4));
        stage.issue(Candidate { others_wait: true, ..OP }, &idle);
        let Activity { busy, fetch, memory, idle, starved, .. } = stage.report(TiCycle(13), &idle);
        // 4 idle; 6 in which others waited for lines; 2 for which it waited itself.
        assert_eq!((busy, fetch, memory, idle, starved), (1, 2, 6, 4, 0));
    }
}
