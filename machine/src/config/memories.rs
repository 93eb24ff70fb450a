//! Sizes that follow from several settings: those of the memories of T&I units, which leak and take area by them, and how many rays
//! are few.

use super::ti::{MissHandling, Pipeline};
use super::whole::MachineConfig;

impl MachineConfig {
    /// Rays that the T&I unit of a core holds.
    pub fn unit_rays(&self) -> u32 {
        self.ti.ray_fifo_entries + self.ti.trv * self.ti.rays_per_trv
    }

    /// With fewer rays out than this, a core's kernels that send rays go first.
    pub fn low_rays(&self) -> u32 {
        (self.unit_rays() * self.srp.rays_low_percent).div_ceil(100)
    }

    /// With more rays than this in its output queue a core begins no primary rays.
    pub fn output_high_rays(&self) -> u32 {
        self.srp.output_rays * self.srp.output_high_percent / 100
    }

    /// Bytes of the stacks of a traversal unit.
    pub fn stack_bytes(&self) -> u64 {
        let ti = &self.ti;
        let entries = if ti.stack_entries == 0 { ti.full_stack_entries } else { ti.stack_entries };
        u64::from(entries) * u64::from(ti.stack_entry_bytes) * u64::from(ti.rays_per_trv)
    }

    /// Bytes of the ray buffers of all cores, with the rows in which rays accumulate.
    pub fn ray_buffer_bytes(&self) -> u64 {
        let ti = &self.ti;
        // Units that gather rays, and processors, handle misses in their own ways: they have no rows, whatever is set.
        let has_rows = matches!(ti.pipeline, Pipeline::Parallel | Pipeline::Single | Pipeline::Unified);
        let rows = |mode| match mode {
            MissHandling::Accumulate if has_rows => u64::from(ti.accumulate_rows) * u64::from(self.l2.line_bytes),
            MissHandling::Accumulate | MissHandling::Retry | MissHandling::Reorder => 0,
        };
        let records = |count: u32| u64::from(count) * u64::from(ti.ray_record_bytes);
        let core = records(ti.ray_fifo_entries)
            + u64::from(ti.trv) * (records(ti.rays_per_trv) + rows(ti.miss_handling))
            + u64::from(ti.ist) * (records(ti.ist_entries) + rows(ti.ist_miss_handling));
        u64::from(self.gpu.cores) * core
    }
}
