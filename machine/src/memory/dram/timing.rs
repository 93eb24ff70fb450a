//! The timing rules of a channel, as distances between commands.
//!
//! A command counts from the first cycle it is on the command bus: ACT, RD and WR are there for 4 tCK, PRE and REF for 2 (LPDDR4
//! sends them in two or four parts). Values and their sources stand in the preset.

use crate::config;
use crate::memory::Cycle;

/// Command bus time of ACT, RD and WR, tCK.
pub const LONG_COMMAND: Cycle = 4;
/// Command bus time of PRE and REF, tCK.
pub const SHORT_COMMAND: Cycle = 2;
/// Idle cycles of the data bus between read data and write data: one for the strobe's postamble, one for its preamble.
pub const READ_TO_WRITE_GAP: Cycle = 2;

/// Distances in tCK, and the size of a line.
#[derive(Clone, Copy, Debug)]
pub struct Timing {
    /// Bursts of a line; they follow each other tCCD apart.
    pub bursts: Cycle,
    /// Column command to column command of the same kind, and data time of a burst.
    pub tccd: Cycle,
    /// ACT to RD or WR of the bank.
    pub trcd: Cycle,
    /// PRE to ACT of the bank.
    pub trp: Cycle,
    /// PRE of all banks to ACT or REF.
    pub trp_all: Cycle,
    /// ACT to PRE of the bank.
    pub tras: Cycle,
    /// ACT to ACT of the bank: tRAS + tRP.
    pub trc: Cycle,
    /// ACT to ACT of another bank.
    pub trrd: Cycle,
    /// First to fifth ACT.
    pub tfaw: Cycle,
    /// RD to PRE of the bank.
    pub read_to_precharge: Cycle,
    /// WR to PRE of the bank: WL + burst + tWR.
    pub write_to_precharge: Cycle,
    /// RD to WR: RL + burst - WL + 2, so that the data bus is free and turns around.
    pub read_to_write: Cycle,
    /// WR to RD: WL + burst + tWTR.
    pub write_to_read: Cycle,
    /// RD to the end of its data: RL + burst.
    pub read_to_data: Cycle,
    /// REF to ACT or REF.
    pub trfc: Cycle,
    /// Distance of refreshes; 0 for none.
    pub trefi: Cycle,
}

impl Timing {
    /// The rules of `config`, with lines of `line_bytes`.
    pub fn new(config: &config::Dram, line_bytes: u32) -> Self {
        let [tccd, rl, wl] = [config.tccd, config.rl, config.wl].map(Cycle::from);
        Self {
            bursts: line_bytes.div_ceil(config.burst_bytes).max(1).into(),
            tccd,
            trcd: config.trcd.into(),
            trp: config.trp.into(),
            trp_all: config.trp_all.into(),
            tras: config.tras.into(),
            trc: Cycle::from(config.tras) + Cycle::from(config.trp),
            trrd: config.trrd.into(),
            tfaw: config.tfaw.into(),
            read_to_precharge: config.trtp.into(),
            write_to_precharge: wl + tccd + Cycle::from(config.twr),
            read_to_write: (rl + tccd + READ_TO_WRITE_GAP).saturating_sub(wl).max(tccd),
            write_to_read: wl + tccd + Cycle::from(config.twtr),
            read_to_data: rl + tccd,
            trfc: config.trfc.into(),
            trefi: config.trefi.into(),
        }
    }

    /// First to last column command of a line.
    pub fn last_burst(&self) -> Cycle {
        (self.bursts - 1) * self.tccd
    }
}
