//! What happens while nobody asks: rows are closed without a command, and the channel powers down.

use super::super::queue::Queue;
use super::Channel;
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

    /// Closes the row of a bank without a command.
    pub(super) fn close(&mut self, at: DramCycle, bank: usize) {
        self.device.close(at, bank);
        self.counters.closed += 1;
        self.row_changed(bank, None);
    }
}
