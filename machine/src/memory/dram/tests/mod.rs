//! Tests of the DRAM: the device rule by rule, the controller by hand-worked sequences, both by an independent checker.

mod checker;
mod controller;
mod device;
mod policies;

use super::channel::Channel;
use super::device::Command;
use super::queue::Entry;
use crate::config;
use crate::time::DramCycle;

/// LPDDR4-3200 x16, with distances between the starts of commands that are easy to add: ACT-RD 29, PRE-ACT 29, PREab-ACT 34,
/// ACT-PRE 68, fifth ACT 64, RD-PRE 12, WR-PRE 51, WR-RD 38, REF-ACT 448.
pub fn lpddr4() -> config::Dram {
    config::Dram {
        clock_mhz: 1600,
        channels: 1,
        banks: 8,
        row_bytes: 2048,
        burst_bytes: 32,
        interleave_bytes: 64,
        hash: false,
        page_policy: config::PagePolicy::Open,
        page_timeout: 200,
        tccd: 8,
        trcd: 29,
        trp: 31,
        trp_all: 36,
        tras: 66,
        trrd: 16,
        tfaw: 67,
        rl: 32,
        wl: 14,
        trtp: 10,
        twr: 26,
        twtr: 15,
        twpre: 2,
        trfc: 450,
        age_cap: 4096,
        power_down_after: 1_000_000_000,
        txp: 12,
        trefi: 6246,
        read_queue_entries: 32,
        write_queue_entries: 32,
        write_high: 24,
        write_low: 8,
        controller_cycles: 48,
        sync_cycles: 2,
    }
}

/// A channel with lines of 64 B, and what came out of it.
struct Bench {
    channel: Channel,
    done: Vec<(u64, u32)>,
}

impl Bench {
    fn new(config: &config::Dram) -> Self {
        Self { channel: Channel::new(config, 64), done: Vec::new() }
    }

    fn push(&mut self, arrival: u64, bank: u8, row: u64, write: bool, token: u32) -> bool {
        let arrival = DramCycle(arrival);
        self.channel.push(Entry { arrival, row, bank, write, prepared: false, token, line: 0 })
    }

    fn read(&mut self, arrival: u64, bank: u8, row: u64) {
        let token = self.channel.taken() as u32;
        assert!(self.push(arrival, bank, row, false, token));
    }

    fn write(&mut self, arrival: u64, bank: u8, row: u64) {
        assert!(self.push(arrival, bank, row, true, 0));
    }

    fn run(&mut self, limit: u64) {
        let done = &mut self.done;
        self.channel.run(DramCycle(limit), |end, entry| done.push((end.0, entry.token)));
    }

    /// Commands so far, as `name bank @cycle`.
    fn commands(&self) -> Vec<String> {
        let name = |command| match command {
            Command::Activate => "ACT",
            Command::Read => "RD",
            Command::Write => "WR",
            Command::Precharge => "PRE",
            Command::PrechargeAll => "PREab",
            Command::Refresh => "REF",
        };
        self.channel.history.iter().map(|&(at, command, bank, _)| format!("{} {bank} @{at}", name(command))).collect()
    }
}

/// A small generator of test traffic.
pub struct Dice(pub u64);

impl Dice {
    /// 0..below.
    pub fn roll(&mut self, below: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % below
    }
}
