//! What happens while nobody asks: rows are closed without a command, and the channel powers down.

use super::super::queue::Queue;
use super::{Channel, ChannelCounters};
use crate::config::PagePolicy;
use crate::time::DramCycle;

impl Channel {
    /// Leaves power-down for what is to be done now.
    pub(super) fn wake_up(&mut self) {
        let Some(since) = self.idle_since.take() else { return };
        let down = since + self.power_down_after;
        if down < self.now {
            self.counters.powered_down += self.now - down;
            self.device.hold(self.now + self.device.timing().txp);
        }
    }

    /// Closes the row of a bank for which nobody has waited, if its timer has run out.
    pub(super) fn time_out(&mut self, bank: usize) {
        let end = self.used[bank] + self.page_timeout;
        if self.page_policy != PagePolicy::Timeout || end >= self.now || self.device.row(bank).is_none() {
            return;
        }
        let waits = |queue: &Queue| queue.waiting_banks() >> bank & 1 == 1;
        if !waits(&self.reads) && !waits(&self.writes) {
            self.close(end, bank);
        }
    }

    /// Closes the rows of all banks whose timers have run out: a refresh asks for all of them.
    pub(super) fn time_out_all(&mut self) {
        if self.page_policy == PagePolicy::Timeout {
            (0..self.device.banks()).for_each(|bank| self.time_out(bank));
        }
    }

    /// What happened before `end`, with the power-down at hand.
    pub fn counters_before(&self, end: DramCycle) -> ChannelCounters {
        // Its next refresh wakes it, if that is before `end`. So may a request on its way, a few cycles earlier: then a window counts some
        // cycles too many at its beginning or end. At the end of a frame none is on its way.
        let end = self.refresh_due.cycle().map_or(end, |due| end.min(due));
        let down = self.idle_since.map_or(0, |since| end.since(since + self.power_down_after));
        ChannelCounters { powered_down: self.counters.powered_down + down, ..self.counters }
    }

    /// Closes the row of a bank without a command.
    pub(super) fn close(&mut self, at: DramCycle, bank: usize) {
        self.device.close(at, bank);
        self.counters.closed += 1;
        self.row_changed(bank, None);
    }
}
