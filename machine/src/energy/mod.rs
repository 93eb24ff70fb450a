//! Energy: counters times energy per event, and leakage times time, by component.
//!
//! Rules:
//! - dynamic energy is a sum of counter x femtojoules, in integers. Traversal units, intersection units and SRPs pay for their
//!   clock and pipeline registers in each cycle in which they have work, whether an operation issues or not. On-chip components
//!   that are gated access by access (memories, buffers, wires) add `energy.clock_tree_percent` instead; DRAM and PHY do not,
//!   for their figures hold it. The sum is rounded to a femtojoule once per component;
//! - leakage is microwatts x time, time being cycles of the T&I clock over its megahertz, rounded once per component. Memories
//!   leak by size. The background power of the DRAM counts as its leakage;
//! - a lookup that hits, and a late read of a line that had missed, pay the read of a line; a lookup that misses or merges pays
//!   the tags. Attempts that a full cache refuses are free: the request is held, not looked up again;
//! - a ray passes the ray buffer once (a write and a read), a leaf task the crossbar twice (there and back);
//! - a bypass pays for each stage of the pipeline that it passes;
//! - what an L1 asks the L2 for travels there (a request of `l2.request_bytes`) and back (a line);
//! - a channel in power-down has a lower background power;
//! - the direct interface is paid per byte; through memory, the traffic is paid at the DRAM instead;
//! - a processor pays for an instruction once a warp, for operands and operations in each lane at work, and for its data word by
//!   word instead of line by line; it stands with the SRP, for it does the work of both;
//! - a unified pipeline tests triangles in the traversal unit, and their energy stands there.

mod by_size;
mod cache_prices;
mod others;
mod ram_prices;
mod rounding;
mod trv_prices;

use by_size::in_proportion;
use cache_prices::CachePrices;
use ram_prices::RamPrices;
use rounding::nearest;
use trv_prices::TrvPrices;

use crate::config::{Interface, L1, MachineConfig, Picojoules, Pipeline, PrimaryVisibility};
use crate::memory::{CacheCounters, ChannelCounters};
use crate::srp::SrpStats;
use crate::stats::Stats;
use crate::ti::{InputBufferCounters, IstStats, TiStats, TrvStats};
use crate::work::layout::Region;

/// The component of a rasteriser, which only a machine that has one reports.
pub const RASTERISER: &str = "rasteriser";

/// What a component belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Group {
    /// The T&I units: what the paper's Figure 7 measures.
    Ti,
    /// The SRPs and the interface to the T&I units.
    Srp,
    /// What the cores share: L2 and DRAM.
    Memory,
}

impl Group {
    /// The name, as reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Ti => "ti",
            Self::Srp => "srp",
            Self::Memory => "memory",
        }
    }
}

/// Energy of one component, all cores together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Component {
    /// Name in reports.
    pub name: &'static str,
    /// What it belongs to.
    pub group: Group,
    /// Dynamic energy, clock tree included, femtojoules.
    pub dynamic_fj: u128,
    /// Leakage, or background of the DRAM, femtojoules.
    pub leakage_fj: u128,
}

impl Component {
    /// All its energy, femtojoules.
    pub fn total_fj(&self) -> u128 {
        self.dynamic_fj + self.leakage_fj
    }
}

/// Energy of a run. The total is the sum of the components, to the femtojoule.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct EnergyReport {
    /// The components, in order of the report.
    pub components: Vec<Component>,
    /// Dynamic energy of L2, its wires, DRAM and PHY that nodes and triangles caused: of L2 and wires by lookups, of DRAM and PHY by bytes,
    /// each rounded down. It is part of the components of the memory and is not added to them.
    pub ti_memory_fj: u128,
}

impl EnergyReport {
    /// Energy of a run on a machine.
    pub fn new(config: &MachineConfig, stats: &Stats) -> Self {
        let sums = Sums::new(config, stats);
        let traversal = match config.ti.pipeline {
            Pipeline::Software => sums.processors().to_vec(),
            _ => sums.ti().to_vec(),
        };
        let raster = match config.gpu.primary_visibility {
            PrimaryVisibility::Raster => vec![sums.raster()],
            PrimaryVisibility::Traced => Vec::new(),
        };
        let components = [traversal, sums.srp().to_vec(), raster, sums.memory().to_vec()].concat();
        let mut report = Self { components, ti_memory_fj: 0 };
        report.ti_memory_fj = sums.ti_share(&report);
        report
    }

    /// Energy of a group, femtojoules.
    pub fn group_fj(&self, group: Group) -> u128 {
        self.components.iter().filter(|c| c.group == group).map(Component::total_fj).sum()
    }

    /// Energy of the T&I units alone, as in the paper's Figure 7, femtojoules.
    pub fn ti_fj(&self) -> u128 {
        self.group_fj(Group::Ti)
    }

    /// Energy of the T&I units and what their nodes and triangles cost at L2 and DRAM, femtojoules.
    pub fn ti_with_memory_fj(&self) -> u128 {
        self.ti_fj() + self.ti_memory_fj
    }

    /// Energy of the whole GPU with its memory, femtojoules.
    pub fn gpu_fj(&self) -> u128 {
        self.components.iter().map(Component::total_fj).sum()
    }

    /// A component by name.
    pub fn component(&self, name: &str) -> Option<&Component> {
        self.components.iter().find(|c| c.name == name)
    }

    /// Components of a machine whose dynamic energy nobody knows where no cycle was simulated: what instructions cost, which are
    /// not counted then. A total that contains them is not known either.
    pub fn timed_components(config: &MachineConfig) -> &'static [&'static str] {
        match config.ti.pipeline {
            Pipeline::Software => &["processors", "data_l1", "code_l1"],
            _ => &[],
        }
    }

    /// Adds the energy of another run of the same machine.
    pub fn add(&mut self, other: &Self) {
        if self.components.is_empty() {
            self.clone_from(other);
            return;
        }
        for (component, more) in self.components.iter_mut().zip(&other.components) {
            component.dynamic_fj += more.dynamic_fj;
            component.leakage_fj += more.leakage_fj;
        }
        self.ti_memory_fj += other.ti_memory_fj;
    }
}

/// Mean power of `fj` femtojoules in `cycles` of a clock of `mhz`, watts; 0 for no time.
pub fn watts(fj: u128, cycles: u64, mhz: u32) -> f64 {
    if cycles == 0 { 0.0 } else { fj as f64 * f64::from(mhz) / cycles as f64 * 1e-9 }
}

/// Counters added over cores and units.
struct Sums<'a> {
    config: &'a MachineConfig,
    stats: &'a Stats,
    cores: u64,
    dram: ChannelCounters,
    trv_l1: CacheCounters,
    ist_l1: CacheCounters,
    trv_buffer: InputBufferCounters,
    ist_buffer: InputBufferCounters,
}

impl<'a> Sums<'a> {
    fn new(config: &'a MachineConfig, stats: &'a Stats) -> Self {
        let mut sums = Self {
            config,
            stats,
            cores: config.gpu.cores.into(),
            dram: stats.memory.dram(),
            trv_l1: CacheCounters::default(),
            ist_l1: CacheCounters::default(),
            trv_buffer: InputBufferCounters::default(),
            ist_buffer: InputBufferCounters::default(),
        };
        for trv in stats.trv() {
            sums.trv_l1 += trv.l1;
            sums.trv_buffer += trv.buffer;
        }
        for ist in stats.ist() {
            sums.ist_l1 += ist.l1;
            sums.ist_buffer += ist.buffer;
        }
        sums
    }

    fn ti(&self) -> [Component; 7] {
        let (energy, ti) = (&self.config.energy, &self.config.ti);
        let sum = |of: &dyn Fn(&TiStats) -> u64| self.stats.cores.iter().map(|core| of(&core.ti)).sum::<u64>();
        let trv = |of: fn(&TrvStats) -> u64| sum(&|ti| ti.trv.iter().map(of).sum());
        let ist = |of: fn(&IstStats) -> u64| sum(&|ti| ti.ist.iter().map(of).sum());
        let (trvs, ists) = (self.cores * u64::from(ti.trv), self.cores * u64::from(ti.ist));
        let rays = sum(&|ti| ti.dispatch.rays);
        let (tasks, stacks) = (ist(|u| u.events.tasks), RamPrices::of_stacks(self.config));
        let trv_prices = TrvPrices::of(self.config);
        let buffers = [&self.trv_buffer, &self.ist_buffer];
        let buffer = |of: fn(&InputBufferCounters) -> u64| buffers.into_iter().map(of).sum::<u64>();
        let of = |name, events: &[(u64, Picojoules)], uw, bytes| self.component(name, Group::Ti, events, uw, bytes);
        let clocked = |name, events: &[(u64, Picojoules)], uw| self.clocked(name, Group::Ti, events, uw);
        [
            clocked(
                "trv",
                &[
                    (trv(|u| u.events.box_tests), energy.box_test_pj),
                    (trv(|u| u.events.triangle_tests), energy.triangle_test_pj),
                    (trv(|u| u.events.bypasses) * self.bypassed_stages(), energy.bypass_stage_pj),
                    (rays, energy.ray_setup_pj),
                    (
                        trv(|u| u.stages.first().map_or(0, |(_, account)| account.total() - account.idle)),
                        trv_prices.clock,
                    ),
                ],
                trvs * trv_prices.leakage_uw,
            ),
            of(
                "stacks",
                &[(trv(|u| u.events.pushes), stacks.write), (trv(|u| u.events.stack_operations), stacks.read)],
                0,
                trvs * self.config.stack_bytes(),
            ),
            clocked(
                "ist",
                &[
                    (ist(|u| u.events.triangle_tests), energy.triangle_test_pj),
                    (ist(|u| u.events.bypasses) * u64::from(ti.ist_cycles), energy.bypass_stage_pj),
                    (ist(|u| u.activity.total() - u.activity.idle), energy.ist_clock_pj),
                ],
                ists * energy.ist_leakage_uw,
            ),
            of(
                "trv_l1",
                &self.l1(&ti.trv_l1, energy.trv_l1_read_pj, &self.trv_l1, self.trv_buffer.late_reads),
                0,
                trvs * l1_bytes(&ti.trv_l1),
            ),
            of(
                "ist_l1",
                &self.l1(&ti.ist_l1, energy.ist_l1_read_pj, &self.ist_l1, self.ist_buffer.late_reads),
                0,
                ists * l1_bytes(&ti.ist_l1),
            ),
            of(
                "ray_buffers",
                &[
                    (rays + buffer(|b| b.record_writes), energy.ray_buffer_write_pj),
                    (rays + buffer(|b| b.record_reads), energy.ray_buffer_read_pj),
                    (buffer(|b| b.parked), energy.accumulate_pj),
                    (buffer(|b| b.slot_updates), energy.reorder_pj),
                ],
                0,
                self.config.ray_buffer_bytes(),
            ),
            of("crossbar", &[(2 * tasks, energy.crossbar_pj)], 0, 0),
        ]
    }

    fn srp(&self) -> [Component; 4] {
        let energy = &self.config.energy;
        let sum = |of: &dyn Fn(&SrpStats) -> u64| self.stats.cores.iter().map(|core| of(&core.srp)).sum::<u64>();
        let mut l1 = CacheCounters::default();
        self.stats.cores.iter().for_each(|core| l1 += core.srp_l1);
        let bytes = match self.config.gpu.interface {
            Interface::Direct => sum(&|s| s.interface.ray_bytes + s.interface.hit_bytes),
            Interface::Memory => 0,
        };
        let prices = RamPrices::of_local(self.config);
        let local = [(sum(&|s| s.local.reads), prices.read), (sum(&|s| s.local.writes), prices.write)];
        let ops = sum(&|s| s.kernels.iter().map(|k| k.ops).sum());
        let clock = sum(&|s| s.activity.total() - s.activity.idle);
        let srp = [(ops, energy.srp_op_pj), (clock, energy.srp_clock_pj)];
        let of = |name, events: &[(u64, Picojoules)], uw, bytes| self.component(name, Group::Srp, events, uw, bytes);
        let (l1_size, local_size) = (l1_bytes(&self.config.srp.l1), self.config.srp.local_memory.0);
        [
            self.clocked("srp", Group::Srp, &srp, self.cores * energy.srp_leakage_uw),
            of("srp_l1", &self.l1(&self.config.srp.l1, energy.srp_l1_read_pj, &l1, 0), 0, self.cores * l1_size),
            of("local_memory", &local, 0, self.cores * local_size),
            of("interface", &[(bytes, energy.interface_pj_per_byte)], 0, 0),
        ]
    }

    /// Events of first-level caches; a later read of a line that had missed is a read.
    fn l1(&self, of: &L1, read: Picojoules, counted: &CacheCounters, late_reads: u64) -> [(u64, Picojoules); 3] {
        let CacheCounters { hits, misses, merges, fills, .. } = counted;
        CachePrices::of_l1(self.config, of, read).of(hits + late_reads, misses + merges, *fills)
    }

    /// Stages that a bypass passes in a traversal unit.
    fn bypassed_stages(&self) -> u64 {
        let ti = &self.config.ti;
        let stages = match ti.pipeline {
            Pipeline::Parallel => ti.inner_cycles,
            Pipeline::Single => ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles,
            Pipeline::Unified => ti.inner_cycles + ti.leaf_cycles + ti.stack_cycles + ti.ist_cycles,
            Pipeline::Software | Pipeline::Gathering => 0,
        };
        stages.into()
    }

    fn memory(&self) -> [Component; 4] {
        let (energy, l2, dram) = (&self.config.energy, &self.stats.memory.l2, &self.dram);
        let network = l2.lookups * u64::from(self.config.l2.request_bytes + self.config.l2.line_bytes);
        let l2 = CachePrices::of_l2(self.config).of(l2.hits, l2.misses + l2.merges, l2.fills);
        // A row is so many cells and sense amplifiers, a burst so many bits through the array and over the wires.
        let device = &self.config.dram;
        let row = |price| in_proportion(price, device.row_bytes.into(), energy.dram_priced_row_bytes.into());
        let burst = |price| in_proportion(price, device.burst_bytes.into(), energy.dram_priced_burst_bytes.into());
        let rows = [
            (dram.activates, row(energy.dram_row_pj)),
            (dram.reads, burst(energy.dram_read_pj)),
            (dram.writes, burst(energy.dram_write_pj)),
            (dram.refreshes, energy.dram_refresh_pj),
        ];
        let bytes = (dram.reads + dram.writes) * u64::from(self.config.dram.burst_bytes);
        let background = u64::from(self.config.dram.channels) * energy.dram_background_uw;
        let saved = energy.dram_background_uw.saturating_sub(energy.dram_power_down_uw);
        let saved_fj =
            nearest(u128::from(saved) * u128::from(dram.powered_down) * 1000, self.config.dram.clock_mhz.max(1).into());
        let off_chip = |name, events: &[_], uw| Component {
            name,
            group: Group::Memory,
            dynamic_fj: dynamic(events),
            leakage_fj: self.leakage(uw, 0),
        };
        let mut device = off_chip("dram", &rows, background);
        device.leakage_fj = device.leakage_fj.saturating_sub(saved_fj);
        [
            self.component("l2", Group::Memory, &l2, 0, self.config.l2.size.0),
            self.component("network", Group::Memory, &[(network, energy.network_pj_per_byte)], 0, 0),
            device,
            off_chip("dram_phy", &[(bytes, energy.dram_phy_pj_per_byte)], 0),
        ]
    }

    /// Logic whose clock is among its events.
    fn clocked(&self, name: &'static str, group: Group, events: &[(u64, Picojoules)], uw: u64) -> Component {
        Component { name, group, dynamic_fj: dynamic(events), leakage_fj: self.leakage(uw, 0) }
    }

    /// An on-chip component: events with their energies, logic leakage in microwatts, bytes of SRAM.
    fn component(
        &self,
        name: &'static str,
        group: Group,
        events: &[(u64, Picojoules)],
        uw: u64,
        bytes: u64,
    ) -> Component {
        let percent = 100 + u128::from(self.config.energy.clock_tree_percent);
        let dynamic_fj = nearest(dynamic(events) * percent, 100);
        Component { name, group, dynamic_fj, leakage_fj: self.leakage(uw, bytes) }
    }

    /// A microwatt is 1000 fJ a microsecond.
    fn leakage(&self, uw: u64, bytes: u64) -> u128 {
        let uw_1024 =
            u128::from(uw) * 1024 + u128::from(self.config.energy.sram_leakage_uw_per_kib) * u128::from(bytes);
        nearest(uw_1024 * u128::from(self.stats.cycles) * 1000, 1024 * u128::from(self.config.ti.clock_mhz))
    }

    /// The value of [`EnergyReport::ti_memory_fj`]. What an L1 of the T&I units misses, it asks the L2 for.
    fn ti_share(&self, report: &EnergyReport) -> u128 {
        if self.config.ti.pipeline == Pipeline::Software {
            return 0;
        }
        let dynamic = |name: &str| report.component(name).map_or(0, |c| c.dynamic_fj);
        let share = |fj: u128, part: u64, all: u64| fj * u128::from(part.min(all)) / u128::from(all.max(1));
        let traffic = &self.stats.memory.traffic;
        let of_ti = |bytes: &[u64]| bytes[Region::Node as usize] + bytes[Region::Triangle as usize];
        let bytes = of_ti(&traffic.read) + of_ti(&traffic.written);
        share(dynamic("l2") + dynamic("network"), self.trv_l1.misses + self.ist_l1.misses, self.stats.memory.l2.lookups)
            + share(dynamic("dram") + dynamic("dram_phy"), bytes, traffic.total())
    }
}

fn l1_bytes(l1: &L1) -> u64 {
    l1.size.0
}

fn dynamic(events: &[(u64, Picojoules)]) -> u128 {
    events.iter().map(|(count, energy)| u128::from(*count) * u128::from(energy.femtojoules)).sum()
}

#[cfg(test)]
mod tests;
