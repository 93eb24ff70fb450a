//! The memory.

use rayreel_settings::Rule::{Flag, Integer};
use rayreel_settings::{Rule, settings, words};

use super::rules::CLOCK;

/// Timings, tCK.
const TIMING: Rule = Integer(1, 1024);

words! {
    /// When a row is closed.
    pub enum PagePolicy {
        /// When another row of its bank is needed, or before a refresh.
        Open = "open",
        /// With the last column command for which a request waits (auto-precharge).
        Closed = "closed",
        /// As `Open`, and after `page_timeout` without a column command.
        Timeout = "timeout",
    }
}

settings! {
    /// LPDDR4: timings in cycles of its clock (tCK), between the last cycles of commands as JEDEC counts them.
    #[serde(deny_unknown_fields)]
    pub struct Dram {
        clock_mhz: u32 = CLOCK, "clock: half the data rate", "MHz";
        channels: u32 = Integer(1, 16), "channels of 16 bits";
        interleave_bytes: u32 = Integer(16, 65_536), "consecutive bytes of a channel, before the next channel's", "bytes";
        hash: bool = Flag, "bits of the row are folded into channel and bank, so that powers of two spread over them";
        page_policy: PagePolicy = PagePolicy::RULE, "when rows are closed";
        page_timeout: u32 = Integer(1, 1_000_000), "idle time after which a row is closed (timeout)", "tCK";
        banks: u32 = Integer(1, 64), "banks per channel";
        row_bytes: u32 = Integer(256, 65_536), "row (page) of a bank", "bytes";
        burst_bytes: u32 = Integer(8, 256), "bytes per burst: BL16 on 16 bits", "bytes";
        tccd: u32 = TIMING, "data bus time of a burst, and least distance of column commands (tCCD)", "tCK";
        trcd: u32 = TIMING, "activate to column command", "tCK";
        trp: u32 = TIMING, "precharge of a bank", "tCK";
        trp_all: u32 = TIMING, "precharge of all banks, before a refresh", "tCK";
        tras: u32 = TIMING, "activate to precharge", "tCK";
        trrd: u32 = TIMING, "activate to activate, other bank", "tCK";
        tfaw: u32 = TIMING, "window of four activates", "tCK";
        rl: u32 = TIMING, "read command to first data, tDQSCK included", "tCK";
        wl: u32 = TIMING, "write command to first data", "tCK";
        trtp: u32 = TIMING, "read to precharge", "tCK";
        twr: u32 = TIMING, "end of write data to precharge", "tCK";
        twtr: u32 = TIMING, "end of write data to read command", "tCK";
        twpre: u32 = Integer(0, 64), "data bus left idle from read data to write data (tWPRE + tRPST)", "tCK";
        trfc: u32 = Integer(1, 10_000), "all-bank refresh", "tCK";
        trefi: u32 = Integer(100, 1_000_000), "mean distance of refreshes", "tCK";
        read_queue_entries: u32 = Integer(1, 256), "entries of the read queue of a channel", "lines";
        write_queue_entries: u32 = Integer(1, 256), "entries of the write queue of a channel", "lines";
        write_high: u32 = Integer(1, 256), "writes waiting at which writes go first";
        write_low: u32 = Integer(0, 255), "writes waiting at which reads go first again";
        controller_cycles: u32 = Integer(0, 1024),
            "controller and network, request to command queue and data to requester together", "tCK";
        age_cap: u32 = Integer(1, 1_000_000), "age at which the oldest request closes its bank to younger row hits", "tCK";
        power_down_after: u32 = Integer(1, 1_000_000_000), "time without a request after which a channel powers down", "tCK";
        txp: u32 = Integer(0, 1024), "power-down to next command", "tCK";
        sync_cycles: u32 = Integer(0, 16),
            "synchroniser at each clock-domain crossing", "cycles of the receiving clock";
    }
}
