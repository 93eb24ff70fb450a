//! Area of a machine by component: a pure function of its configuration.
//!
//! Rules:
//! - logic is units times the area of a unit. A traversal unit has its control and a box test for each box a cycle; where one
//!   pipeline also intersects, a triangle test too;
//! - a memory is its bits times the area of a cell, over the share of it that is cells, rounded once per component. A cache has the
//!   tags of its lines too. Ray buffers and stacks have cells with two ports;
//! - components are those of the energy. No source gives an area of crossbar, wires to the L2, ray setup, direct interface,
//!   DRAM controller and PHY: they are left out, and totals are too small by them.

use crate::config::{L1, MachineConfig, Pipeline, PrimaryVisibility};
use crate::energy::Group;

/// Area of one component, all cores together.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ComponentArea {
    /// Name in reports: that of the component of the energy.
    pub name: &'static str,
    /// What it belongs to.
    pub group: Group,
    /// Square micrometres.
    pub um2: u64,
}

/// Area of a machine. The total is the sum of the components.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct AreaReport {
    /// The components, in the order of those of the energy.
    pub components: Vec<ComponentArea>,
}

impl AreaReport {
    /// Area of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let MachineConfig { gpu, ti, l2, srp, area, .. } = config;
        let cores = u64::from(gpu.cores);
        let (trvs, ists) = (cores * u64::from(ti.trv), cores * u64::from(ti.ist));
        let line = u64::from(l2.line_bytes);
        let cache = |count: u64, bytes: u64| {
            let bits = bytes * 8 + bytes.div_ceil(line) * area.tag_bits;
            memory(count * bits, area.sram_bit_nm2, area.array_percent)
        };
        let l1 = |count: u64, l1: &L1| cache(count, l1.size.0);
        let buffer = |bytes: u64| memory(bytes * 8, area.buffer_bit_nm2, area.array_percent);
        let local = memory(cores * srp.local_memory.0 * 8, area.sram_bit_nm2, area.array_percent);
        let of = |group, name, um2| ComponentArea { name, group, um2 };
        let processors = vec![
            of(Group::Srp, "processors", trvs * area.processor_um2),
            of(Group::Srp, "data_l1", l1(trvs, &ti.trv_l1)),
            of(Group::Srp, "code_l1", l1(trvs, &config.processor.code_l1)),
            of(Group::Srp, "stacks", buffer(trvs * config.stack_bytes())),
            of(Group::Srp, "ray_buffers", buffer(config.ray_buffer_bytes())),
        ];
        let units = vec![
            of(Group::Ti, "trv", trvs * config.trv_um2(config.trv_width())),
            of(Group::Ti, "stacks", buffer(trvs * config.stack_bytes())),
            of(Group::Ti, "ist", ists * area.triangle_um2),
            of(Group::Ti, "trv_l1", l1(trvs, &ti.trv_l1)),
            of(Group::Ti, "ist_l1", l1(ists, &ti.ist_l1)),
            of(Group::Ti, "ray_buffers", buffer(config.ray_buffer_bytes())),
        ];
        let rasterisers = match gpu.primary_visibility {
            PrimaryVisibility::Raster => vec![of(Group::Srp, "rasteriser", cores * area.raster_um2)],
            PrimaryVisibility::Traced => Vec::new(),
        };
        let shared = vec![
            of(Group::Srp, "srp", cores * area.srp_um2),
            of(Group::Srp, "srp_l1", l1(cores, &srp.l1)),
            of(Group::Srp, "local_memory", local),
        ];
        let memory = vec![of(Group::Memory, "l2", cache(1, l2.size.0))];
        let traversal = if ti.pipeline == Pipeline::Software { processors } else { units };
        Self { components: [traversal, shared, rasterisers, memory].concat() }
    }

    /// The T&I units, mm2.
    pub fn ti_mm2(&self) -> f64 {
        mm2(self.components.iter().filter(|c| c.group == Group::Ti).map(|c| c.um2).sum())
    }

    /// The whole GPU without its memory, mm2.
    pub fn gpu_mm2(&self) -> f64 {
        mm2(self.components.iter().map(|c| c.um2).sum())
    }
}

impl ComponentArea {
    /// Square millimetres.
    pub fn mm2(&self) -> f64 {
        mm2(self.um2)
    }
}

fn mm2(um2: u64) -> f64 {
    um2 as f64 / 1e6
}

/// Area of a memory, rounded to the nearest square micrometre.
fn memory(bits: u64, bit_nm2: u64, array_percent: u64) -> u64 {
    let (nm2, by) = (u128::from(bits) * u128::from(bit_nm2) * 100, u128::from(array_percent) * 1_000_000);
    u64::try_from((nm2 + by / 2) / by).unwrap_or(u64::MAX)
}

#[cfg(test)]
mod tests;
