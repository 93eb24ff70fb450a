//! The timing rules of a channel, as distances between commands.
//!
//! A command is on the command bus for some cycles: ACT, RD and WR for 4 tCK, PRE and REF for 2 (LPDDR4 sends them in two or four
//! parts). JEDEC's times run from the last cycle of one command to the last of the next; the distances here are those of first
//! cycles, so between commands of different lengths they differ by 2 tCK. So they are those that DRAMSys' checker of LPDDR4 holds:
//! ACT-PRE tRAS + 2, PRE-ACT tRP - 2, RD-PRE tRTP + burst - 6, WR-PRE WL + burst + tWR + 3, WR-RD WL + burst + tWTR + 1, tFAW - 3,
//! REF-ACT tRFC - 2, RD-WR RL + tDQSCK + burst - WL + tWPRE. Values and their sources stand in the preset.

use crate::config;

/// Command bus time of ACT, RD and WR, tCK.
pub const LONG_COMMAND: u64 = 4;
/// Command bus time of PRE and REF, tCK.
pub const SHORT_COMMAND: u64 = 2;
/// What an ACT, RD or WR takes longer on the bus than a PRE or REF.
pub const LONGER: u64 = LONG_COMMAND - SHORT_COMMAND;
/// From the first cycle of the first ACT of a window to the first of the fifth tFAW is shorter by so much: it ends with the last.
const WINDOW_OVERLAP: u64 = LONG_COMMAND - 1;

/// Distances in tCK, and the size of a line.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Bursts of a line; they follow each other tCCD apart.
    pub bursts: u64,
    /// Column command to column command of the same kind, and data time of a burst.
    pub tccd: u64,
    /// ACT to RD or WR of the bank.
    pub trcd: u64,
    /// PRE to ACT of the bank.
    pub trp: u64,
    /// PRE of all banks to ACT; REF may come [`LONGER`] later.
    pub trp_all: u64,
    /// ACT to PRE of the bank.
    pub tras: u64,
    /// ACT to ACT of the bank: tRAS + tRP.
    pub trc: u64,
    /// ACT to ACT of another bank.
    pub trrd: u64,
    /// First to fifth ACT.
    pub tfaw: u64,
    /// RD to PRE of the bank.
    pub read_to_precharge: u64,
    /// WR to PRE of the bank.
    pub write_to_precharge: u64,
    /// RD to WR: RL + burst - WL + tWPRE, so that the data bus is free and turns around.
    pub read_to_write: u64,
    /// WR to RD: WL + 1 + burst + tWTR.
    pub write_to_read: u64,
    /// RD to the end of its data: RL + burst.
    pub read_to_data: u64,
    /// REF to ACT; REF may come [`LONGER`] later.
    pub trfc: u64,
    /// Power-down to any command.
    pub txp: u64,
    /// Distance of refreshes; 0 for none.
    pub trefi: u64,
}

impl Timing {
    /// The rules of `config`, with lines of `line_bytes`.
    pub fn new(config: &config::Dram, line_bytes: u32) -> Self {
        let [tccd, rl, wl] = [config.tccd, config.rl, config.wl].map(u64::from);
        Self {
            bursts: line_bytes.div_ceil(config.burst_bytes).max(1).into(),
            tccd,
            trcd: config.trcd.into(),
            trp: u64::from(config.trp).saturating_sub(LONGER),
            trp_all: u64::from(config.trp_all).saturating_sub(LONGER),
            tras: u64::from(config.tras) + LONGER,
            trc: u64::from(config.tras) + u64::from(config.trp),
            trrd: config.trrd.into(),
            tfaw: u64::from(config.tfaw).saturating_sub(WINDOW_OVERLAP),
            // A burst of BL16 lasts 8 tCK, and JEDEC counts tRTP from 8 tCK before its end.
            read_to_precharge: u64::from(config.trtp) + LONGER,
            write_to_precharge: wl + 1 + tccd + u64::from(config.twr) + LONGER,
            read_to_write: (rl + tccd + u64::from(config.twpre)).saturating_sub(wl).max(tccd),
            write_to_read: wl + 1 + tccd + u64::from(config.twtr),
            read_to_data: rl + tccd,
            trfc: u64::from(config.trfc).saturating_sub(LONGER),
            txp: config.txp.into(),
            trefi: config.trefi.into(),
        }
    }

    /// First to last column command of a line.
    pub fn last_burst(&self) -> u64 {
        (self.bursts - 1) * self.tccd
    }
}
