//! The timing rules of a channel, as distances between commands.
//!
//! A command counts from the first cycle it is on the command bus: ACT, RD and WR are there for 4 tCK, PRE and REF for 2 (LPDDR4
//! sends them in two or four parts). Values and their sources stand in the preset.

use crate::config;

/// Command bus time of ACT, RD and WR, tCK.
pub const LONG_COMMAND: u64 = 4;
/// Command bus time of PRE and REF, tCK.
pub const SHORT_COMMAND: u64 = 2;
/// Idle cycles of the data bus between read data and write data: one for the strobe's postamble, one for its preamble.
pub const READ_TO_WRITE_GAP: u64 = 2;

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
    /// PRE of all banks to ACT or REF.
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
    /// WR to PRE of the bank: WL + burst + tWR.
    pub write_to_precharge: u64,
    /// RD to WR: RL + burst - WL + 2, so that the data bus is free and turns around.
    pub read_to_write: u64,
    /// WR to RD: WL + burst + tWTR.
    pub write_to_read: u64,
    /// RD to the end of its data: RL + burst.
    pub read_to_data: u64,
    /// REF to ACT or REF.
    pub trfc: u64,
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
            trp: config.trp.into(),
            trp_all: config.trp_all.into(),
            tras: config.tras.into(),
            trc: u64::from(config.tras) + u64::from(config.trp),
            trrd: config.trrd.into(),
            tfaw: config.tfaw.into(),
            read_to_precharge: config.trtp.into(),
            write_to_precharge: wl + tccd + u64::from(config.twr),
            read_to_write: (rl + tccd + READ_TO_WRITE_GAP).saturating_sub(wl).max(tccd),
            write_to_read: wl + tccd + u64::from(config.twtr),
            read_to_data: rl + tccd,
            trfc: config.trfc.into(),
            trefi: config.trefi.into(),
        }
    }

    /// First to last column command of a line.
    pub fn last_burst(&self) -> u64 {
        (self.bursts - 1) * self.tccd
    }
}
