//! Sizes of the memories of T&I units that follow from several settings: they leak by them and take area by them.

use super::ti::MissHandling;
use super::whole::MachineConfig;

/// Bytes of a ray's record in a ray buffer.
const RECORD_BYTES: u64 = 64;
/// Bytes of a stack entry.
const STACK_ENTRY_BYTES: u64 = 4;
/// Entries of a full stack (`ti.stack_entries = 0`).
const FULL_STACK_ENTRIES: u64 = 64;

impl MachineConfig {
    /// Bytes of the stacks of a traversal unit.
    pub fn stack_bytes(&self) -> u64 {
        let entries = match u64::from(self.ti.stack_entries) {
            0 => FULL_STACK_ENTRIES,
            entries => entries,
        };
        entries * STACK_ENTRY_BYTES * u64::from(self.ti.rays_per_trv)
    }

    /// Bytes of the ray buffers of all cores, with the rows in which rays accumulate.
    pub fn ray_buffer_bytes(&self) -> u64 {
        let ti = &self.ti;
        let rows = |mode| match mode {
            MissHandling::Accumulate => u64::from(ti.accumulate_rows) * u64::from(self.l2.line_bytes),
            MissHandling::Retry | MissHandling::Reorder => 0,
        };
        let core = u64::from(ti.ray_fifo_entries) * RECORD_BYTES
            + u64::from(ti.trv) * (u64::from(ti.rays_per_trv) * RECORD_BYTES + rows(ti.miss_handling))
            + u64::from(ti.ist) * (u64::from(ti.ist_entries) * RECORD_BYTES + rows(ti.ist_miss_handling));
        u64::from(self.gpu.cores) * core
    }
}
