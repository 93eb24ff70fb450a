//! The banks and buses of a channel: which command is legal when. What to send is the controller's business.
//!
//! RD and WR here stand for a whole line: its bursts go out tCCD apart, and their slots on the command bus are taken at once.

use super::timing::{LONG_COMMAND, LONGER, SHORT_COMMAND, Timing};
use crate::time::{ClockCycle, DramCycle};

/// No row is open.
const CLOSED: u64 = u64::MAX;

/// A command. All but `PrechargeAll` and `Refresh` name a bank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Command {
    /// ACT: opens a row.
    Activate,
    /// RD: reads a line of the open row.
    Read,
    /// WR: writes a line of the open row.
    Write,
    /// PRE: closes the row.
    Precharge,
    /// PREab: closes the rows of all banks.
    PrechargeAll,
    /// REFab: refreshes all banks.
    Refresh,
}

/// A bank: its row, and the first cycle of each command that only the bank itself limits.
#[derive(Clone, Copy, Debug)]
struct Bank {
    row: u64,
    activate: DramCycle,
    column: DramCycle,
    precharge: DramCycle,
}

/// The state of a channel's device.
#[derive(Clone, Debug)]
pub struct Device {
    timing: Timing,
    banks: Vec<Bank>,
    /// Banks with an open row, bit by bit.
    open: u64,
    /// End of the last command on the command bus.
    bus_free: DramCycle,
    /// First slot of the last line's bursts, and how many there are.
    slots: DramCycle,
    slot_count: u64,
    activate: DramCycle,
    read: DramCycle,
    write: DramCycle,
    /// End of the tFAW windows that the last four ACTs opened, and the oldest of them.
    windows: [DramCycle; 4],
    oldest_window: usize,
}

impl Device {
    /// A device with all banks closed.
    pub fn new(timing: Timing, banks: u32) -> Self {
        let bank =
            Bank { row: CLOSED, activate: DramCycle::START, column: DramCycle::START, precharge: DramCycle::START };
        Self {
            timing,
            banks: vec![bank; banks as usize],
            open: 0,
            bus_free: DramCycle::START,
            slots: DramCycle::START,
            slot_count: 0,
            activate: DramCycle::START,
            read: DramCycle::START,
            write: DramCycle::START,
            windows: [DramCycle::START; 4],
            oldest_window: 0,
        }
    }

    /// The rules.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Number of banks.
    #[inline]
    pub fn banks(&self) -> usize {
        self.banks.len()
    }

    /// The open row of a bank.
    #[inline]
    pub fn row(&self, bank: usize) -> Option<u64> {
        let row = self.banks[bank].row;
        (row != CLOSED).then_some(row)
    }

    /// Banks with an open row, bit by bit.
    #[inline]
    pub fn open_banks(&self) -> u64 {
        self.open
    }

    /// The first cycle from `from` on at which `command` is legal if nothing else is sent before; the row's state is the caller's
    /// to check (ACT needs a closed bank, RD and WR the right row, REF all banks closed).
    #[inline]
    pub fn earliest(&self, from: DramCycle, command: Command, bank: usize) -> DramCycle {
        self.start(command, from.max(self.bank_ready(command, bank)))
    }

    /// The first cycle from `ready` on at which the rules of the whole channel allow `command`: buses, tRRD, tFAW, turnaround.
    #[inline(always)]
    pub fn start(&self, command: Command, ready: DramCycle) -> DramCycle {
        match command {
            Command::Activate => self.fit(ready.max(self.activate).max(self.windows[self.oldest_window]), LONG_COMMAND),
            // Slots of an earlier line are over before the next column command is legal.
            Command::Read => ready.max(self.read).max(self.bus_free),
            Command::Write => ready.max(self.write).max(self.bus_free),
            Command::Precharge | Command::PrechargeAll | Command::Refresh => self.fit(ready, SHORT_COMMAND),
        }
    }

    /// The first cycle at which the bank itself (for PREab and REF: all banks) allows `command`.
    #[inline(always)]
    pub fn bank_ready(&self, command: Command, bank: usize) -> DramCycle {
        match command {
            Command::Activate => self.banks[bank].activate,
            Command::Read | Command::Write => self.banks[bank].column,
            Command::Precharge => self.banks[bank].precharge,
            Command::PrechargeAll => {
                // Those that are closing by themselves have to be through with their data too.
                self.banks.iter().map(|bank| bank.precharge).max().unwrap_or(DramCycle::START)
            }
            Command::Refresh => {
                let last = self.banks.iter().map(|bank| bank.activate).max().unwrap_or(DramCycle::START);
                if last == DramCycle::START { last } else { last + LONGER }
            }
        }
    }

    /// Earliest start at or after `from` of a command of `length` that leaves the slots of the last line's bursts free.
    #[inline]
    fn fit(&self, from: DramCycle, length: u64) -> DramCycle {
        let mut start = from.max(self.bus_free);
        for burst in 1..self.slot_count {
            let slot = self.slots + burst * self.timing.tccd;
            if start < slot + LONG_COMMAND && start + length > slot {
                start = slot + LONG_COMMAND;
            }
        }
        start
    }

    /// Sends `command` at `now`, when it is legal.
    pub fn issue(&mut self, now: DramCycle, command: Command, bank: usize, row: u64) {
        debug_assert!(self.earliest(now, command, bank) == now, "{command:?} to bank {bank} at {now} is too early");
        match command {
            Command::Activate => self.activated(now, bank, row),
            Command::Read => self.read(now, bank),
            Command::Write => self.written(now, bank),
            Command::Precharge => self.precharged(now, bank),
            Command::PrechargeAll => self.precharged_all(now),
            Command::Refresh => self.refreshed(now),
        }
    }

    fn activated(&mut self, now: DramCycle, bank: usize, row: u64) {
        let t = &self.timing;
        self.open |= 1 << bank;
        let bank = &mut self.banks[bank];
        debug_assert!(bank.row == CLOSED, "ACT of an open bank");
        bank.row = row;
        bank.column = now + t.trcd;
        bank.precharge = now + t.tras;
        bank.activate = now + t.trc;
        self.activate = now + t.trrd;
        self.windows[self.oldest_window] = now + t.tfaw;
        self.oldest_window = (self.oldest_window + 1) % self.windows.len();
        self.bus_free = now + LONG_COMMAND;
    }

    fn read(&mut self, now: DramCycle, bank: usize) {
        let t = &self.timing;
        let last = now + t.last_burst();
        let bank = &mut self.banks[bank];
        bank.precharge = bank.precharge.max(last + t.read_to_precharge);
        self.read = last + t.tccd;
        self.write = last + t.read_to_write;
        self.slots = now;
        self.slot_count = t.bursts;
        self.bus_free = now + LONG_COMMAND;
    }

    fn written(&mut self, now: DramCycle, bank: usize) {
        let t = &self.timing;
        let last = now + t.last_burst();
        let bank = &mut self.banks[bank];
        bank.precharge = bank.precharge.max(last + t.write_to_precharge);
        self.write = last + t.tccd;
        self.read = last + t.write_to_read;
        self.slots = now;
        self.slot_count = t.bursts;
        self.bus_free = now + LONG_COMMAND;
    }

    fn precharged(&mut self, now: DramCycle, bank: usize) {
        self.open &= !(1 << bank);
        let bank = &mut self.banks[bank];
        bank.row = CLOSED;
        bank.activate = bank.activate.max(now + self.timing.trp);
        self.bus_free = now + SHORT_COMMAND;
    }

    /// Closes the row of a bank without a command, at `at` or as soon as it may be: with its last column command, or by a timer.
    pub fn close(&mut self, at: DramCycle, bank: usize) {
        self.open &= !(1 << bank);
        let trp = self.timing.trp;
        let bank = &mut self.banks[bank];
        bank.row = CLOSED;
        bank.activate = bank.activate.max(bank.precharge.max(at) + trp);
    }

    /// Nothing is sent before `at`: the device wakes.
    pub fn hold(&mut self, at: DramCycle) {
        self.bus_free = self.bus_free.max(at);
    }

    fn precharged_all(&mut self, now: DramCycle) {
        self.open = 0;
        for bank in &mut self.banks {
            bank.row = CLOSED;
            bank.activate = bank.activate.max(now + self.timing.trp_all);
        }
        self.bus_free = now + SHORT_COMMAND;
    }

    fn refreshed(&mut self, now: DramCycle) {
        for bank in &mut self.banks {
            debug_assert!(bank.row == CLOSED, "REF with an open bank");
            bank.activate = now + self.timing.trfc;
        }
        self.bus_free = now + SHORT_COMMAND;
    }
}
