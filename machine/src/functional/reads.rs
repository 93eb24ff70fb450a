//! How much a frame reads from DRAM, where windows and the functional pass disagree.
//!
//! Windows are few, and what tiles read differs more than what they work: scaled by windows reads are not too many and not too few in
//! the mean, but further off than those of the functional pass, which passes all tiles and mostly reads somewhat more than a simulation
//! (`docs/accuracy.md`, reads from DRAM). So estimates read as much as the pass did, and how windows differ from it says how far both may be off.

use crate::memory::{ChannelCounters, L2Counters};
use crate::stats::Stats;
use crate::work::layout::Region;

/// What is read through the L2.
const CACHED: [Region; 4] = [Region::Node, Region::Triangle, Region::Attribute, Region::Texture];

impl Stats {
    /// Lets the run read through its L2 what `counted` says, region by region. [`Stats::close_dram`] lets its channels follow.
    pub fn read_as(&mut self, counted: &Self) {
        let bytes = |stats: &Self| CACHED.iter().map(|region| stats.memory.traffic.read[*region as usize]).sum::<u64>();
        let (read, wanted) = (bytes(self), bytes(counted));
        if read == 0 || wanted == 0 {
            return;
        }
        for region in CACHED {
            self.memory.traffic.read[region as usize] = counted.memory.traffic.read[region as usize];
        }
        scale_misses(&mut self.memory.l2, wanted as f64 / read as f64);
    }

    /// Lets the run read so many times as much through its L2.
    pub fn read_times(&mut self, factor: f64) {
        for region in CACHED {
            scale([&mut self.memory.traffic.read[region as usize]], factor);
        }
        scale_misses(&mut self.memory.l2, factor);
    }

    /// Lets the channels of the DRAM move the lines that the traffic is made of, as in every run of all cycles; commands and
    /// rows keep their share of a line.
    pub fn close_dram(&mut self, line_bytes: u32) {
        let lines = |bytes: &[u64]| bytes.iter().sum::<u64>() as f64 / f64::from(line_bytes.max(1));
        let (read, written) = (lines(&self.memory.traffic.read), lines(&self.memory.traffic.written));
        let channels = &mut self.memory.channels;
        let part = |wanted: f64, moved: u64| if moved > 0 { wanted / moved as f64 } else { 1.0 };
        let reads = part(read, channels.iter().map(|channel| channel.read_lines).sum());
        let writes = part(written, channels.iter().map(|channel| channel.write_lines).sum());
        channels.iter_mut().for_each(|channel| scale_channel(channel, reads, writes));
    }
}

fn scale<const N: usize>(counters: [&mut u64; N], factor: f64) {
    counters.into_iter().for_each(|counter| *counter = (*counter as f64 * factor).round() as u64);
}

/// A channel with so many times the reads and writes. Rows are opened as often a line as before.
fn scale_channel(channel: &mut ChannelCounters, reads: f64, writes: f64) {
    let before = channel.read_lines + channel.write_lines;
    scale([&mut channel.reads, &mut channel.read_lines, &mut channel.read_latency], reads);
    scale([&mut channel.writes, &mut channel.write_lines], writes);
    if before > 0 {
        let lines = (channel.read_lines + channel.write_lines) as f64 / before as f64;
        let ChannelCounters { activates, precharges, closed, row_hits, row_closed, row_conflicts, bus_busy, .. } =
            channel;
        scale([activates, precharges, closed, row_hits, row_closed, row_conflicts, bus_busy], lines);
    }
}

/// An L2 with so many times the misses among the same lookups.
fn scale_misses(l2: &mut L2Counters, factor: f64) {
    let found = l2.hits + l2.misses;
    scale([&mut l2.misses, &mut l2.fills, &mut l2.evictions], factor);
    l2.hits = found.saturating_sub(l2.misses);
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stats(node: u64, sample: u64, lines: u64) -> Stats {
        let mut stats = Stats::default();
        stats.memory.traffic.read[Region::Node as usize] = node;
        stats.memory.traffic.read[Region::Sample as usize] = sample;
        stats.memory.l2 =
            L2Counters { lookups: 1000, hits: 700, misses: 300, fills: 300, evictions: 280, ..L2Counters::default() };
        stats.memory.channels = vec![ChannelCounters {
            reads: 2 * lines,
            read_lines: lines,
            write_lines: 100,
            writes: 200,
            row_hits: lines,
            row_conflicts: 100,
            activates: 100,
            ..ChannelCounters::default()
        }];
        stats
    }

    #[test]
    fn misses_follow_and_lookups_stay() {
        let (mut run, counted) = (stats(60_000, 40_000, 900), stats(30_000, 1, 1));
        run.read_as(&counted);
        let (traffic, l2) = (run.memory.traffic, run.memory.l2);
        assert_eq!((traffic.read[Region::Node as usize], traffic.read[Region::Sample as usize]), (30_000, 40_000));
        assert_eq!((l2.lookups, l2.hits, l2.misses, l2.fills, l2.evictions), (1000, 850, 150, 150, 140));
    }

    #[test]
    fn a_run_that_reads_more_misses_more() {
        let mut run = stats(60_000, 40_000, 900);
        run.read_times(1.1);
        let (traffic, l2) = (run.memory.traffic, run.memory.l2);
        assert_eq!((traffic.read[Region::Node as usize], traffic.read[Region::Sample as usize]), (66_000, 40_000));
        assert_eq!((l2.lookups, l2.hits, l2.misses), (1000, 670, 330));
    }

    #[test]
    fn channels_move_what_the_traffic_is_made_of() {
        let mut run = stats(30_000, 33_000, 900);
        run.memory.traffic.written[Region::Framebuffer as usize] = 10_000;
        run.close_dram(100);
        let channel = run.memory.channels[0];
        // 70 % of the reads; 730 of 1000 lines.
        assert_eq!((channel.reads, channel.read_lines, channel.writes, channel.write_lines), (1260, 630, 200, 100));
        assert_eq!((channel.row_hits, channel.row_conflicts, channel.activates), (657, 73, 73));
        run.memory.traffic.written[Region::Framebuffer as usize] = 5_000;
        run.close_dram(100);
        assert_eq!((run.memory.channels[0].read_lines, run.memory.channels[0].write_lines), (630, 50));
        let closed = run.clone();
        run.close_dram(100);
        assert_eq!(run, closed, "closed it stays");
    }

    #[test]
    fn where_nothing_is_read_nothing_changes() {
        let (mut run, nothing) = (stats(60_000, 40_000, 900), stats(0, 0, 0));
        run.read_as(&nothing);
        assert_eq!(run, stats(60_000, 40_000, 900));
    }
}
