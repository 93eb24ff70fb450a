//! The memory behind the L1s without cycles: what the L2 finds, and which rows of the DRAM are open.

use crate::config::MachineConfig;
use crate::memory::{AddressMap, CacheCounters, MemoryStats, Route, Tags};
use crate::work::layout::{Lines, Region};

/// No row is open.
const CLOSED: u64 = u64::MAX;

/// L2 counters and DRAM; the tags of the L2 stand in the warm state.
#[derive(Clone, Debug)]
pub(super) struct TagMemory {
    inclusive: bool,
    line_bytes: u64,
    bursts: u64,
    map: AddressMap,
    banks: usize,
    /// The open row of each bank, by channel.
    rows: Vec<u64>,
    evicted: Vec<u64>,
    lines: u64,
    stats: MemoryStats,
}

impl TagMemory {
    pub fn new(config: &MachineConfig) -> Self {
        let (dram, line_bytes) = (&config.dram, config.l2.line_bytes);
        let (channels, banks) = (dram.channels as usize, dram.banks as usize);
        Self {
            inclusive: config.l2.inclusive,
            line_bytes: line_bytes.into(),
            bursts: line_bytes.div_ceil(dram.burst_bytes).max(1).into(),
            map: AddressMap::new(dram, line_bytes),
            banks,
            rows: vec![CLOSED; channels * banks],
            evicted: Vec::new(),
            lines: 0,
            stats: MemoryStats { channels: vec![Default::default(); channels], ..MemoryStats::default() },
        }
    }

    /// Looks `line` up in an L1, and what misses there in the L2. Counts what misses: who looks up many lines counts these
    /// himself, for a counter of 64 bits that is written at every lookup costs more than the lookup.
    #[inline]
    pub fn look_up(
        &mut self,
        (l1, l2): (&mut Tags, &mut Tags),
        line: u64,
        region: Region,
        counted: &mut CacheCounters,
    ) {
        if !l1.touch(line) {
            self.fetch((l1, l2), line, region, counted);
        }
    }

    #[cold]
    fn fetch(&mut self, (l1, l2): (&mut Tags, &mut Tags), line: u64, region: Region, counted: &mut CacheCounters) {
        counted.misses += 1;
        counted.fills += 1;
        counted.evictions += u64::from(l1.insert(line).is_some());
        self.stats.l2.lookups += 1;
        if l2.touch(line) {
            self.stats.l2.hits += 1;
            return;
        }
        self.stats.l2.misses += 1;
        self.stats.l2.fills += 1;
        if let Some(evicted) = l2.insert(line) {
            self.stats.l2.evictions += 1;
            if self.inclusive {
                self.evicted.push(evicted);
            }
        }
        self.transfer(line, region, Route::Read);
    }

    /// Lines that go past the caches.
    pub fn transfer_all(&mut self, lines: Lines, region: Region, route: Route) {
        lines.each(|line| self.transfer(line, region, route));
    }

    fn transfer(&mut self, line: u64, region: Region, route: Route) {
        let at = self.map.address(line);
        let channel = &mut self.stats.channels[at.channel];
        let row = &mut self.rows[at.channel * self.banks + usize::from(at.bank)];
        if *row == at.row {
            channel.row_hits += 1;
        } else {
            let conflict = u64::from(*row != CLOSED);
            channel.activates += 1;
            channel.precharges += conflict;
            channel.row_conflicts += conflict;
            channel.row_closed += 1 - conflict;
            *row = at.row;
        }
        let traffic = &mut self.stats.traffic;
        if route == Route::Write {
            (channel.write_lines, channel.writes) = (channel.write_lines + 1, channel.writes + self.bursts);
            traffic.written[region as usize] += self.line_bytes;
        } else {
            (channel.read_lines, channel.reads) = (channel.read_lines + 1, channel.reads + self.bursts);
            traffic.read[region as usize] += self.line_bytes;
        }
        self.lines += 1;
    }

    /// Lines that are written and read again by someone else, one after the other: rows stay open.
    pub fn stream(&mut self, lines: u64, region: Region) {
        let channels = self.stats.channels.len() as u64;
        for (at, channel) in (0..).zip(&mut self.stats.channels) {
            let part = (lines + channels - 1 - at) / channels;
            channel.row_hits += 2 * part;
            (channel.write_lines, channel.writes) = (channel.write_lines + part, channel.writes + part * self.bursts);
            (channel.read_lines, channel.reads) = (channel.read_lines + part, channel.reads + part * self.bursts);
        }
        self.stats.traffic.written[region as usize] += lines * self.line_bytes;
        self.stats.traffic.read[region as usize] += lines * self.line_bytes;
        self.lines += 2 * lines;
    }

    /// Lines that went to and came from DRAM so far.
    pub fn lines(&self) -> u64 {
        self.lines
    }

    /// Lines that left an inclusive L2 since the last call.
    pub fn evicted(&mut self) -> impl Iterator<Item = u64> {
        self.evicted.drain(..)
    }

    pub fn stats(&self) -> MemoryStats {
        self.stats.clone()
    }
}
