//! The memory behind the L2: LPDDR4 channels with their controllers, in their own clock.
//!
//! Line `n` lies in channel `n mod channels`. Within the channel the lines are dealt row : bank : column, column lowest: a row's
//! worth of consecutive lines in a bank, the next row's worth in the next bank.
//!
//! A request leaves the T&I clock, passes the synchroniser of the DRAM clock and half of the controller, and enters its
//! channel's queue. Read data pass the other half of the controller and the synchroniser of the T&I clock. Queue entries are
//! credits held on the T&I side: one is taken when the request is accepted, and it comes back without delay.

pub mod channel;
pub mod device;
pub mod queue;
pub mod timing;

#[cfg(test)]
pub(super) mod tests;

use std::collections::VecDeque;

pub use channel::{Channel, ChannelCounters};

use super::Cycle;
use super::crossing::Crossing;
use crate::config;
use queue::Entry;

/// Most banks of a channel that the model takes; LPDDR4 has 8.
pub const BANKS_MAX: u32 = 64;

/// Where a line lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Place {
    /// Channel.
    pub channel: usize,
    /// Bank of the channel.
    pub bank: u8,
    /// Row of the bank.
    pub row: u64,
}

/// A read line on its way back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Arrival {
    /// Name that the requester gave.
    pub token: u32,
    /// Line number.
    pub line: u64,
}

/// A channel as the T&I clock sees it.
#[derive(Clone, Debug)]
struct Lane {
    channel: Channel,
    /// Lines on their way back, with the T&I cycle at which they are there. In order.
    arriving: VecDeque<(Cycle, Arrival)>,
    /// Someone waits for a queue entry of this channel.
    watched: bool,
    /// T&I cycle of the next event that concerns the requesters.
    next: Cycle,
    /// T&I cycle at which the channel has something to do.
    due: Cycle,
}

/// All channels.
#[derive(Clone, Debug)]
pub struct Dram {
    lanes: Vec<Lane>,
    banks: u64,
    row_lines: u64,
    up: Crossing,
    down: Crossing,
    before: Cycle,
    after: Cycle,
    /// Read command to data at the synchroniser.
    read_cycles: Cycle,
    /// The first of the lanes' `next` and of their `due`.
    next: Cycle,
    due: Cycle,
}

impl Dram {
    /// The memory of `config`, seen from a clock of `clock_mhz`.
    ///
    /// # Panics
    /// When there is no channel or bank, or a row holds no line: the configuration was not checked.
    pub fn new(config: &config::Dram, clock_mhz: u32, line_bytes: u32) -> Self {
        assert!(config.channels > 0 && (1..=BANKS_MAX).contains(&config.banks) && config.row_bytes >= line_bytes);
        let channel = Channel::new(config, line_bytes);
        let lane = Lane { channel, arriving: VecDeque::new(), watched: false, next: Cycle::MAX, due: 0 };
        let timing = timing::Timing::new(config, line_bytes);
        let before = Cycle::from(config.controller_cycles / 2);
        let after = Cycle::from(config.controller_cycles) - before;
        Self {
            lanes: vec![lane; config.channels as usize],
            banks: config.banks.into(),
            row_lines: (config.row_bytes / line_bytes).into(),
            up: Crossing::new(clock_mhz, config.clock_mhz, config.sync_cycles),
            down: Crossing::new(config.clock_mhz, clock_mhz, config.sync_cycles),
            before,
            after,
            read_cycles: timing.last_burst() + timing.read_to_data + after,
            next: Cycle::MAX,
            due: 0,
        }
    }

    /// Where a line lies.
    #[inline]
    pub fn place(&self, line: u64) -> Place {
        let channels = self.lanes.len() as u64;
        let (channel, row_number) = ((line % channels) as usize, line / channels / self.row_lines);
        Place { channel, bank: (row_number % self.banks) as u8, row: row_number / self.banks }
    }

    /// Whether the channel of `line` takes a read. If not, [`Dram::next_event`] tells when it may.
    pub fn has_read_room(&mut self, line: u64) -> bool {
        let lane = (line % self.lanes.len() as u64) as usize;
        let room = self.lanes[lane].channel.has_read_room();
        if !room && !self.lanes[lane].watched {
            self.watch(lane);
        }
        room
    }

    /// Takes a request that leaves at T&I cycle `sent`, not before `now`, or refuses it because the channel's queue is full.
    /// Everything up to `now` must have been run.
    pub fn request(&mut self, now: Cycle, sent: Cycle, line: u64, write: bool, token: u32) -> bool {
        let Place { channel, bank, row } = self.place(line);
        // The cycle of `now` has been run: without synchroniser and controller the request is seen one DRAM cycle later.
        let arrival = (self.up.arrive(sent) + self.before).max(self.up.floor(now) + 1);
        let taken = self.lanes[channel].channel.push(Entry { arrival, row, bank, write, prepared: false, token, line });
        if taken {
            self.look_ahead(channel);
        } else {
            self.watch(channel);
        }
        taken
    }

    /// Runs up to and including T&I cycle `now`.
    #[inline]
    pub fn run(&mut self, now: Cycle) {
        if now >= self.due {
            self.run_lanes(now);
        }
    }

    fn run_lanes(&mut self, now: Cycle) {
        let limit = self.up.floor(now);
        for index in 0..self.lanes.len() {
            let Lane { channel, arriving, watched, due, .. } = &mut self.lanes[index];
            if now < *due {
                continue;
            }
            let taken = channel.taken();
            channel.run(limit, |end, entry| {
                let ready = self.down.arrive(end + self.after);
                arriving.push_back((ready, Arrival { token: entry.token, line: entry.line }));
            });
            *watched &= channel.taken() == taken;
            self.look_ahead(index);
        }
    }

    /// The next line that has arrived by T&I cycle `now`, channel by channel.
    pub fn take(&mut self, now: Cycle) -> Option<Arrival> {
        for index in 0..self.lanes.len() {
            let lane = &mut self.lanes[index];
            if let Some(&(ready, arrival)) = lane.arriving.front()
                && ready <= now
            {
                lane.arriving.pop_front();
                self.look_ahead(index);
                return Some(arrival);
            }
        }
        None
    }

    /// The first T&I cycle at which a line can arrive, or a queue that someone waits for can have a free entry.
    #[inline]
    pub fn next_event(&self) -> Option<Cycle> {
        (self.next < Cycle::MAX).then_some(self.next)
    }

    fn watch(&mut self, index: usize) {
        self.lanes[index].watched = true;
        self.look_ahead(index);
    }

    /// Computes the lane's next events. Data of a command that is not sent yet cannot come before the channel's next step and the
    /// read latency; that bound may be early, never late.
    fn look_ahead(&mut self, index: usize) {
        let lane = &mut self.lanes[index];
        let step = lane.channel.next_event();
        let data = match (lane.arriving.front(), step) {
            (Some(&(ready, _)), _) => ready,
            (None, Some(step)) => self.down.arrive(step + self.read_cycles),
            (None, None) => Cycle::MAX,
        };
        lane.due = self.down.ceil(lane.channel.wake());
        lane.next = if lane.watched && step.is_some() { data.min(lane.due) } else { data };
        (self.next, self.due) = (Cycle::MAX, Cycle::MAX);
        for lane in &self.lanes {
            self.next = self.next.min(lane.next);
            self.due = self.due.min(lane.due);
        }
    }

    /// What each channel did.
    pub fn counters(&self) -> impl Iterator<Item = &ChannelCounters> {
        self.lanes.iter().map(|lane| lane.channel.counters())
    }
}
