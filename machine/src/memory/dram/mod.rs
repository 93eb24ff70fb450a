//! The memory behind the L2: LPDDR4 channels with their controllers, in their own clock.
//!
//! Consecutive `interleave_bytes` lie in a channel, the next in the next channel. Within the channel they are dealt row : bank :
//! column, column lowest: a row's worth in a bank, the next row's worth in the next bank. With `hash`, higher bits of the address
//! are folded into channel and bank by exclusive or, so that strides of powers of two do not meet in one of them.
//!
//! A request leaves the T&I clock, passes the synchroniser of the DRAM clock and half of the controller, and enters its
//! channel's queue. Read data pass the other half of the controller and the synchroniser of the T&I clock. Queue entries are
//! credits held on the T&I side: one is taken when the request is accepted, and it comes back without delay.

mod address;
mod channel;
mod device;
mod queue;
mod timing;

#[cfg(test)]
pub(super) mod tests;

use std::collections::VecDeque;

pub use address::{AddressMap, DramAddress};
pub use channel::ChannelCounters;

use channel::Channel;
use queue::Entry;

use crate::component::{Component, Tick};
use crate::config;
use crate::time::{ClockCycle, Crossing, DramCycle, TiCycle, When};

/// Most banks of a channel that the model takes; LPDDR4 has 8.
const BANKS_MAX: u32 = 64;

/// A line that is read, on its way there and back.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LineRead {
    /// Line number.
    pub line: u64,
    /// Name by which the requester knows it.
    pub token: u32,
}

/// A channel as the T&I clock sees it.
#[derive(Clone, Debug)]
struct Lane {
    channel: Channel,
    /// Lines on their way back, with the T&I cycle at which they are there. In order.
    arriving: VecDeque<(TiCycle, LineRead)>,
    /// Someone waits for a queue entry of this channel.
    watched: bool,
}

/// When something happens in a lane.
#[derive(Clone, Copy, Debug)]
struct Ahead {
    /// The next event that concerns the requesters.
    next: When,
    /// When the channel has something to do.
    due: When,
}

/// All channels.
#[derive(Clone, Debug)]
pub struct Dram {
    lanes: Vec<Lane>,
    /// The same of each lane, together: they are looked at all the time.
    ahead: Vec<Ahead>,
    map: AddressMap,
    up: Crossing<TiCycle, DramCycle>,
    down: Crossing<DramCycle, TiCycle>,
    /// Controller cycles before the queue, and after the data.
    before_cycles: u64,
    after_cycles: u64,
    /// Read command to data at the synchroniser.
    read_cycles: u64,
    /// The first of the lanes' `next` and of their `due`.
    next: When,
    due: When,
}

impl Dram {
    /// The memory of `config`, seen from a clock of `clock_mhz`.
    ///
    /// # Panics
    /// When there is no channel or bank, or a row holds no line: the configuration was not checked.
    pub fn new(config: &config::Dram, clock_mhz: u32, line_bytes: u32) -> Self {
        assert!(config.channels > 0 && (1..=BANKS_MAX).contains(&config.banks) && config.row_bytes >= line_bytes);
        let channel = Channel::new(config, line_bytes);
        let lane = Lane { channel, arriving: VecDeque::new(), watched: false };
        let ahead = Ahead { next: When::NEVER, due: When::at(TiCycle::START) };
        let timing = timing::Timing::new(config, line_bytes);
        let before_cycles = u64::from(config.controller_cycles / 2);
        let after_cycles = u64::from(config.controller_cycles) - before_cycles;
        Self {
            lanes: vec![lane; config.channels as usize],
            ahead: vec![ahead; config.channels as usize],
            map: AddressMap::new(config, line_bytes),
            up: Crossing::new(clock_mhz, config.clock_mhz, config.sync_cycles),
            down: Crossing::new(config.clock_mhz, clock_mhz, config.sync_cycles),
            before_cycles,
            after_cycles,
            read_cycles: timing.last_burst() + timing.read_to_data + after_cycles,
            next: When::NEVER,
            due: When::at(TiCycle::START),
        }
    }

    /// Where a line lies.
    #[inline]
    pub fn address(&self, line: u64) -> DramAddress {
        self.map.address(line)
    }

    /// Whether the channel of `line` takes a read. If not, its next event tells when it may.
    pub fn has_read_room(&mut self, line: u64) -> bool {
        let lane = self.map.channel(line);
        let room = self.lanes[lane].channel.has_read_room();
        if !room && !self.lanes[lane].watched {
            self.watch(lane);
        }
        room
    }

    /// Takes a read that leaves at T&I cycle `sent`, not before `now`, or refuses it because the channel's queue is full.
    /// Everything up to `now` must have been run.
    #[inline]
    pub fn read(&mut self, now: TiCycle, sent: TiCycle, read: LineRead) -> bool {
        self.request(now, sent, read, false)
    }

    /// Takes a write that leaves at T&I cycle `now`, or refuses it because the channel's queue is full. Everything up to `now`
    /// must have been run.
    #[inline]
    pub fn write(&mut self, now: TiCycle, line: u64) -> bool {
        self.request(now, now, LineRead { line, token: 0 }, true)
    }

    fn request(&mut self, now: TiCycle, sent: TiCycle, LineRead { line, token }: LineRead, write: bool) -> bool {
        let DramAddress { channel, bank, row } = self.address(line);
        // The cycle of `now` has been run: without synchroniser and controller the request is seen one DRAM cycle later.
        let arrival = (self.up.arrive(sent) + self.before_cycles).max(self.up.floor(now) + 1);
        let taken = self.lanes[channel].channel.push(Entry { arrival, row, bank, write, prepared: false, token, line });
        if taken {
            self.look_ahead(channel);
        } else {
            self.watch(channel);
        }
        taken
    }

    fn run_lanes(&mut self, now: TiCycle) {
        let limit = self.up.floor(now);
        for index in 0..self.lanes.len() {
            if !self.ahead[index].due.is_due(now) {
                continue;
            }
            let Lane { channel, arriving, watched } = &mut self.lanes[index];
            let taken = channel.taken();
            channel.run(limit, |end, entry| {
                let ready = self.down.arrive(end + self.after_cycles);
                arriving.push_back((ready, LineRead { line: entry.line, token: entry.token }));
            });
            *watched &= channel.taken() == taken;
            self.look_ahead(index);
        }
    }

    /// The next line that has arrived by T&I cycle `now`, channel by channel.
    pub fn take(&mut self, now: TiCycle) -> Option<LineRead> {
        for index in 0..self.lanes.len() {
            if !self.ahead[index].next.is_due(now) {
                continue;
            }
            let lane = &mut self.lanes[index];
            if let Some(&(ready, read)) = lane.arriving.front()
                && ready <= now
            {
                lane.arriving.pop_front();
                self.look_ahead(index);
                return Some(read);
            }
        }
        None
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
        let data = match lane.arriving.front() {
            Some(&(ready, _)) => When::at(ready),
            None => When::from(step.cycle().map(|step| self.down.arrive(step + self.read_cycles))),
        };
        let due = self.down.ceil_when(lane.channel.wake());
        let next = if lane.watched && !step.is_never() { data.min(due) } else { data };
        self.ahead[index] = Ahead { next, due };
        (self.next, self.due) = (When::NEVER, When::NEVER);
        for lane in &self.ahead {
            self.next = self.next.min(lane.next);
            self.due = self.due.min(lane.due);
        }
    }

    /// What each channel did.
    pub fn counters(&self) -> impl Iterator<Item = &ChannelCounters> {
        self.lanes.iter().map(|lane| lane.channel.counters())
    }

    /// What each channel did before T&I cycle `end`, with the power-down at hand.
    pub fn counters_before(&self, end: TiCycle) -> Vec<ChannelCounters> {
        let end = self.up.floor(end);
        self.lanes.iter().map(|lane| lane.channel.counters_before(end)).collect()
    }
}

impl Component for Dram {
    /// What each channel did.
    type Report = Vec<ChannelCounters>;

    /// The first cycle at which a line can arrive, or a queue that someone waits for can have a free entry.
    #[inline]
    fn next_event(&self, _: TiCycle) -> When {
        self.next
    }

    fn finish(&mut self, end: TiCycle) -> Vec<ChannelCounters> {
        self.counters_before(end)
    }
}

impl Tick<()> for Dram {
    #[inline]
    fn tick(&mut self, now: TiCycle, (): ()) {
        if self.due.is_due(now) {
            self.run_lanes(now);
        }
    }
}
