//! Each timing rule of the device: not legal at t - 1, legal at t.

use super::super::device::{Command, Device};
use super::super::timing::Timing;
use super::lpddr4;
use crate::config;
use crate::time::DramCycle;
use Command::{Activate, Precharge, PrechargeAll, Read, Refresh, Write};

struct Probe(Device);

impl Probe {
    fn new(config: &config::Dram, line_bytes: u32) -> Self {
        Self(Device::new(Timing::new(config, line_bytes), config.banks))
    }

    fn earliest(&self, from: u64, command: Command, bank: usize) -> u64 {
        self.0.earliest(DramCycle(from), command, bank).0
    }

    #[track_caller]
    fn assert_earliest(&self, command: Command, bank: usize, clk: u64) {
        assert_ne!(self.earliest(clk - 1, command, bank), clk - 1, "{command:?} is legal at {}", clk - 1);
        assert_eq!(self.earliest(clk, command, bank), clk, "{command:?}");
    }

    #[track_caller]
    fn issue(&mut self, at: u64, command: Command, bank: usize) {
        assert_eq!(self.earliest(at, command, bank), at, "{command:?} at {at}");
        self.0.issue(DramCycle(at), command, bank, 7);
    }
}

fn probe() -> Probe {
    Probe::new(&lpddr4(), 32)
}

#[test]
fn after_an_activate() {
    let mut p = probe();
    p.issue(100, Activate, 0);
    p.assert_earliest(Read, 0, 129);
    p.assert_earliest(Write, 0, 129);
    p.assert_earliest(Precharge, 0, 168);
    p.assert_earliest(Activate, 1, 116);
    p.issue(168, Precharge, 0);
    p.assert_earliest(Activate, 0, 197);
}

#[test]
fn precharge_to_activate_when_the_row_was_open_long() {
    let mut p = probe();
    p.issue(100, Activate, 0);
    p.issue(500, Precharge, 0);
    p.assert_earliest(Activate, 0, 529);
    p.assert_earliest(Refresh, 0, 531);
}

#[test]
fn four_activates_in_a_window() {
    let mut p = Probe::new(&config::Dram { trrd: 8, ..lpddr4() }, 32);
    for (bank, at) in [100, 120, 130, 140].into_iter().enumerate() {
        p.issue(at, Activate, bank);
    }
    p.assert_earliest(Activate, 4, 164);
    p.issue(164, Activate, 4);
    p.assert_earliest(Activate, 5, 184);
}

#[test]
fn after_a_read() {
    let mut p = probe();
    p.issue(100, Activate, 0);
    p.issue(120, Activate, 1);
    p.issue(200, Read, 0);
    p.assert_earliest(Read, 0, 208);
    p.assert_earliest(Read, 1, 208);
    // RL 32 + burst 8 + 2 - WL 14.
    p.assert_earliest(Write, 1, 228);
    p.assert_earliest(Precharge, 0, 212);
}

#[test]
fn after_a_write() {
    let mut p = probe();
    p.issue(100, Activate, 0);
    p.issue(120, Activate, 1);
    p.issue(200, Write, 0);
    p.assert_earliest(Write, 1, 208);
    // WL 14 + burst 8 + tWTR 16, any bank.
    p.assert_earliest(Read, 1, 238);
    // WL 14 + burst 8 + tWR 29.
    p.assert_earliest(Precharge, 0, 251);
}

#[test]
fn a_line_of_two_bursts_counts_from_its_last() {
    let mut p = Probe::new(&lpddr4(), 64);
    p.issue(100, Activate, 0);
    p.issue(200, Read, 0);
    p.assert_earliest(Read, 0, 216);
    p.assert_earliest(Write, 0, 236);
    p.assert_earliest(Precharge, 0, 220);
    p.issue(300, Write, 0);
    p.assert_earliest(Write, 0, 316);
    p.assert_earliest(Read, 0, 346);
    p.assert_earliest(Precharge, 0, 359);
}

#[test]
fn refresh_needs_all_banks_closed_and_keeps_them_so() {
    let mut p = probe();
    p.issue(100, Activate, 0);
    p.issue(116, Activate, 1);
    p.assert_earliest(PrechargeAll, 0, 184);
    p.issue(184, PrechargeAll, 0);
    // A REF is shorter than an ACT, so its last cycle comes later after its first.
    p.assert_earliest(Refresh, 0, 220);
    p.issue(220, Refresh, 0);
    p.assert_earliest(Activate, 3, 668);
    p.assert_earliest(Refresh, 0, 670);
}

#[test]
fn the_command_bus_carries_one_command_at_a_time() {
    let mut p = Probe::new(&config::Dram { trrd: 1, ..lpddr4() }, 64);
    p.issue(100, Activate, 0);
    p.assert_earliest(Activate, 1, 104);
    p.issue(104, Activate, 1);
    p.issue(108, Activate, 2);
    p.issue(300, Read, 0);
    p.assert_earliest(Precharge, 1, 304);
    p.issue(304, Precharge, 1);
    p.assert_earliest(Precharge, 2, 306);
    // 308 to 311 carry the line's second burst; ACT needs 4 cycles and finds them after it only.
    p.assert_earliest(Activate, 3, 312);
    p.issue(306, Precharge, 2);
    p.assert_earliest(PrechargeAll, 0, 320);
}

#[test]
fn an_activate_fits_between_two_bursts_exactly() {
    let mut p = Probe::new(&lpddr4(), 64);
    p.issue(100, Activate, 0);
    p.issue(300, Read, 0);
    p.assert_earliest(Activate, 1, 304);
    assert_eq!(p.earliest(305, Activate, 1), 312);
}
