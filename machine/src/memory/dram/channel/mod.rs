//! The controller of a channel: FR-FCFS over an open-page device, one command at a time.
//!
//! At any cycle it sends, of the commands that are legal then, the column command (RD, WR) of the oldest request whose row is
//! open; without one, the ACT or PRE of the oldest request that needs it. A row is closed only when no request of the active
//! queue hits it. The active queue is that of the reads, unless writes reached `write_high` (until they are down to
//! `write_low`) or no read waits. A refresh is never postponed: from its due cycle on nothing but PREab and REF is sent.
//!
//! Rows may also be closed without a command. With `page_policy = "closed"` a column command for whose row no other request waits
//! closes it (auto-precharge). With `"timeout"` a timer of the bank closes it after `page_timeout` cycles without a column command;
//! its PRE takes no slot of the command bus. A channel without requests powers down after `power_down_after` cycles, but for
//! refreshes; its next command comes tXP after what wakes it.
//!
//! Starvation: once the oldest request of the active queue is `age_cap` cycles old, younger requests to other rows of its bank
//! are passed over, so its row is opened next there; its column command then wins by age.
//!
//! The controller never counts through idle cycles: it computes the first cycle at which a command is legal and jumps there.

mod idle;

use std::collections::VecDeque;

use super::device::{Command, Device};
use super::queue::{Entry, Queue};
use super::timing::Timing;
use crate::config::{self, PagePolicy};
use crate::counters::counters;
use crate::time::{ClockCycle, DramCycle, When};

counters! {
    /// What a channel did.
    pub struct ChannelCounters {
        activates: "events", "rows opened (ACT)";
        precharges: "events", "rows closed by a request (PRE)";
        closed: "events", "rows closed without a command: with their last column command, or by a timer";
        powered_down: "dram cycles", "in power-down";
        precharges_all: "events", "PRE of all banks, before a refresh";
        refreshes: "events", "refreshes of all banks (REF)";
        reads: "bursts", "bursts read";
        writes: "bursts", "bursts written";
        row_hits: "lines", "requests whose row was open when it was their turn";
        row_closed: "lines", "requests that opened a row in a closed bank";
        row_conflicts: "lines", "requests that had to close another row first";
        bus_busy: "dram cycles", "data on the data bus";
        read_lines: "lines", "lines read";
        write_lines: "lines", "lines written";
        read_latency: "dram cycles", "from entry into the channel's queue to the last data of each read line, summed; controller and clock crossings not included";
        refused_reads: "events", "read requests refused because the queue was full";
        refused_writes: "events", "write requests refused because the queue was full";
    }
}

/// What is sent next.
#[derive(Clone, Copy, Debug)]
struct Decision {
    at: DramCycle,
    command: Command,
    bank: usize,
    row: u64,
    /// Position of the request in the active queue; nothing for a refresh.
    index: usize,
}

/// A channel with its queues.
#[derive(Clone, Debug)]
pub struct Channel {
    device: Device,
    reads: Queue,
    writes: Queue,
    /// Accepted requests on their way to the queue, by arrival.
    transit: VecDeque<Entry>,
    reads_taken: usize,
    writes_taken: usize,
    reads_max: usize,
    writes_max: usize,
    write_high: usize,
    write_low: usize,
    drain: bool,
    refresh_due: When<DramCycle>,
    page_policy: PagePolicy,
    page_timeout: u64,
    age_cap: u64,
    power_down_after: u64,
    /// Per bank the last column command.
    used: Vec<DramCycle>,
    /// Since when it has had nothing to do; nothing while it has.
    idle_since: Option<DramCycle>,
    /// Everything before this cycle is decided.
    now: DramCycle,
    decision: Option<Decision>,
    wake: When<DramCycle>,
    counters: ChannelCounters,
    #[cfg(test)]
    pub(super) history: Vec<(DramCycle, Command, usize, u64)>,
}

impl Channel {
    /// An idle channel.
    pub fn new(config: &config::Dram, line_bytes: u32) -> Self {
        let timing = Timing::new(config, line_bytes);
        let refresh_due = When::only_if(timing.trefi > 0, DramCycle(timing.trefi));
        Self {
            device: Device::new(timing, config.banks),
            reads: Queue::new(config.banks),
            writes: Queue::new(config.banks),
            transit: VecDeque::new(),
            reads_taken: 0,
            writes_taken: 0,
            reads_max: config.read_queue_entries as usize,
            writes_max: config.write_queue_entries as usize,
            write_high: config.write_high as usize,
            write_low: config.write_low as usize,
            drain: false,
            refresh_due,
            page_policy: config.page_policy,
            page_timeout: config.page_timeout.into(),
            age_cap: config.age_cap.into(),
            power_down_after: config.power_down_after.into(),
            used: vec![DramCycle::START; config.banks as usize],
            idle_since: Some(DramCycle::START),
            now: DramCycle::START,
            decision: None,
            wake: refresh_due,
            counters: ChannelCounters::default(),
            #[cfg(test)]
            history: Vec::new(),
        }
    }

    /// Takes a request that enters the queue at its `arrival`, or refuses it. An entry of the queue is taken at once, and it is
    /// free again when the column command is sent.
    pub fn push(&mut self, entry: Entry) -> bool {
        let (taken, most) = match entry.write {
            true => (&mut self.writes_taken, self.writes_max),
            false => (&mut self.reads_taken, self.reads_max),
        };
        if *taken >= most {
            match entry.write {
                true => self.counters.refused_writes += 1,
                false => self.counters.refused_reads += 1,
            }
            return false;
        }
        *taken += 1;
        let behind = self.transit.iter().rev().take_while(|other| other.arrival > entry.arrival).count();
        self.transit.insert(self.transit.len() - behind, entry);
        self.wake = self.wake.min(When::at(entry.arrival));
        true
    }

    /// Whether a read finds an entry of the queue free.
    #[inline]
    pub fn has_read_room(&self) -> bool {
        self.reads_taken < self.reads_max
    }

    /// Entries taken, of both queues.
    #[inline]
    pub fn taken(&self) -> usize {
        self.reads_taken + self.writes_taken
    }

    /// The next cycle at which [`Channel::run`] does anything, refreshes included.
    #[inline]
    pub fn wake(&self) -> When<DramCycle> {
        self.wake
    }

    /// The next cycle at which the channel does anything for a request; nothing before it can free an entry or read data.
    #[inline]
    pub fn next_event(&self) -> When<DramCycle> {
        if self.taken() > 0 { self.wake } else { When::NEVER }
    }

    /// Runs up to and including cycle `limit`; `done` gets each read request and the end of its data.
    #[inline]
    pub fn run(&mut self, limit: DramCycle, done: impl FnMut(DramCycle, Entry)) {
        if self.wake.is_due(limit) {
            self.run_busy(limit, done);
        }
    }

    fn run_busy(&mut self, limit: DramCycle, mut done: impl FnMut(DramCycle, Entry)) {
        loop {
            let stop = self.next_stop();
            let command = When::from(self.decision.map(|d| d.at));
            self.wake = stop.min(command);
            let Some(wake) = self.wake.due(limit) else { return };
            match self.decision {
                Some(decision) if command < stop => self.issue(decision, &mut done),
                _ => self.now = wake,
            }
            if self.refresh_due.is_due(self.now) {
                self.wake_up();
                self.time_out_all();
            }
            self.admit();
            self.decision = self.decide();
        }
    }

    /// The next cycle at which something other than a command changes what is to be sent: a request enters, a refresh is due,
    /// the oldest request comes of age.
    fn next_stop(&self) -> When<DramCycle> {
        let coming = |event: When<DramCycle>| if event.is_due(self.now) { When::NEVER } else { event };
        let arrival = When::from(self.transit.front().map(|entry| entry.arrival.max(self.now)));
        let age = self.active().entries().first().map(|oldest| oldest.arrival + self.age_cap);
        arrival.min(coming(self.refresh_due)).min(coming(When::from(age)))
    }

    fn admit(&mut self) {
        while let Some(&entry) = self.transit.front()
            && entry.arrival <= self.now
        {
            self.transit.pop_front();
            self.wake_up();
            self.time_out(entry.bank.into());
            let open = self.device.row(entry.bank.into());
            if entry.write { &mut self.writes } else { &mut self.reads }.push(entry, open);
        }
        if self.writes.len() >= self.write_high {
            self.drain = true;
        }
        if self.writes.len() <= self.write_low {
            self.drain = false;
        }
    }

    #[inline]
    fn serves_writes(&self) -> bool {
        self.drain || self.reads.is_empty()
    }

    #[inline]
    fn active(&self) -> &Queue {
        if self.serves_writes() { &self.writes } else { &self.reads }
    }

    fn decide(&self) -> Option<Decision> {
        if self.refresh_due.is_due(self.now) {
            let command = if self.device.open_banks() != 0 { Command::PrechargeAll } else { Command::Refresh };
            let at = self.device.earliest(self.now, command, 0);
            return Some(Decision { at, command, bank: 0, row: 0, index: 0 });
        }
        let queue = self.active();
        let oldest = queue.entries().first()?;
        let (waiting, open) = (queue.waiting_banks(), self.device.open_banks());
        let mut hits = queue.hit_banks();
        if oldest.arrival + self.age_cap <= self.now && self.device.row(oldest.bank.into()) != Some(oldest.row) {
            hits &= !(1 << oldest.bank);
        }
        let column = if self.serves_writes() { Command::Write } else { Command::Read };
        let (closed, conflicts) = (waiting & !open, waiting & open & !hits);
        let start = self.class_start(column, hits);
        let activate = self.class_start(Command::Activate, closed);
        let precharge = self.class_start(Command::Precharge, conflicts);
        let first = start.min(activate).min(precharge);
        let at = first.cycle().expect("a request that waits needs a command");
        if start == first {
            let banks = self.legal_banks(column, hits, at);
            let hit = |e: &Entry| banks >> e.bank & 1 == 1 && self.device.row(e.bank.into()) == Some(e.row);
            return Some(self.oldest(queue, column, at, hit));
        }
        let closed = if activate == first { self.legal_banks(Command::Activate, closed, at) } else { 0 };
        let conflicts = if precharge == first { self.legal_banks(Command::Precharge, conflicts, at) } else { 0 };
        let mut decision = self.oldest(queue, Command::Activate, at, |e| (closed | conflicts) >> e.bank & 1 == 1);
        if conflicts >> decision.bank & 1 == 1 {
            decision.command = Command::Precharge;
        }
        Some(decision)
    }

    /// The first cycle at which `command` is legal for one of `banks`.
    #[inline]
    fn class_start(&self, command: Command, banks: u64) -> When<DramCycle> {
        if banks == 0 {
            return When::NEVER;
        }
        let (mut ready, mut rest) = (DramCycle::END, banks);
        while rest != 0 {
            ready = ready.min(self.device.bank_ready(command, rest.trailing_zeros() as usize));
            rest &= rest - 1;
        }
        When::at(self.device.start(command, ready.max(self.now)))
    }

    /// Those of `banks` for which `command` is legal at `at`, when it is legal for one.
    #[inline]
    fn legal_banks(&self, command: Command, banks: u64, at: DramCycle) -> u64 {
        let (mut legal, mut rest) = (0, banks);
        while rest != 0 {
            let bank = rest.trailing_zeros() as usize;
            legal |= u64::from(self.device.bank_ready(command, bank) <= at) << bank;
            rest &= rest - 1;
        }
        legal
    }

    /// The oldest request that is `wanted`; there must be one.
    #[inline]
    fn oldest(&self, queue: &Queue, command: Command, at: DramCycle, wanted: impl Fn(&Entry) -> bool) -> Decision {
        let index = queue.entries().iter().position(wanted).expect("a bank with a legal command has a request");
        let entry = &queue.entries()[index];
        Decision { at, command, bank: entry.bank.into(), row: entry.row, index }
    }

    fn issue(&mut self, decision: Decision, done: &mut impl FnMut(DramCycle, Entry)) {
        let Decision { at, command, bank, row, index } = decision;
        #[cfg(test)]
        self.history.push((at, command, bank, row));
        self.now = at;
        self.device.issue(at, command, bank, row);
        match command {
            Command::Read | Command::Write => self.column_sent(at, command, index, done),
            Command::Activate => {
                self.counters.activates += 1;
                self.prepare(index, |counters| &mut counters.row_closed);
                self.row_changed(bank, Some(row));
            }
            Command::Precharge => {
                self.counters.precharges += 1;
                self.prepare(index, |counters| &mut counters.row_conflicts);
                self.row_changed(bank, None);
            }
            Command::PrechargeAll => {
                self.counters.precharges_all += 1;
                (0..self.device.banks()).for_each(|bank| self.row_changed(bank, None));
            }
            Command::Refresh => {
                self.counters.refreshes += 1;
                if self.taken() == 0 {
                    self.idle_since = Some(at + self.device.timing().trfc);
                }
                let due = self.refresh_due.cycle();
                self.refresh_due = When::from(due.map(|due| due + self.device.timing().trefi));
            }
        }
    }

    fn column_sent(&mut self, at: DramCycle, command: Command, index: usize, done: &mut impl FnMut(DramCycle, Entry)) {
        let timing = *self.device.timing();
        self.counters.bus_busy += timing.bursts * timing.tccd;
        let entry = if command == Command::Read {
            let entry = self.reads.remove(index);
            let end = at + timing.last_burst() + timing.read_to_data;
            self.reads_taken -= 1;
            self.counters.reads += timing.bursts;
            self.counters.read_lines += 1;
            self.counters.read_latency += end - entry.arrival;
            done(end, entry);
            entry
        } else {
            self.writes_taken -= 1;
            self.counters.writes += timing.bursts;
            self.counters.write_lines += 1;
            self.writes.remove(index)
        };
        self.counters.row_hits += u64::from(!entry.prepared);
        let bank = usize::from(entry.bank);
        self.used[bank] = at + timing.last_burst();
        let hits = |queue: &Queue| queue.hit_banks() >> bank & 1 == 1;
        if self.page_policy == PagePolicy::Closed && !hits(&self.reads) && !hits(&self.writes) {
            self.close(at, bank);
        }
        if self.taken() == 0 {
            self.idle_since = Some(at + timing.last_burst());
        }
    }

    /// Counts what the request found when its first command was chosen.
    fn prepare(&mut self, index: usize, counter: impl Fn(&mut ChannelCounters) -> &mut u64) {
        let queue = if self.serves_writes() { &mut self.writes } else { &mut self.reads };
        let entry = queue.entry_mut(index);
        if !entry.prepared {
            entry.prepared = true;
            *counter(&mut self.counters) += 1;
        }
    }

    fn row_changed(&mut self, bank: usize, row: Option<u64>) {
        self.reads.row_changed(bank, row);
        self.writes.row_changed(bank, row);
    }

    /// What happened so far.
    pub fn counters(&self) -> &ChannelCounters {
        &self.counters
    }
}
