//! What the caches of a machine hold: tags without anything under way.

use crate::config::{L1, MachineConfig};
use crate::memory::Tags;

/// The tags of all caches.
#[derive(Clone, Debug)]
pub struct CacheState {
    pub(crate) cores: Vec<CoreTags>,
    pub(crate) l2: Tags,
}

/// The tags of a core's first-level caches.
#[derive(Clone, Debug)]
pub(crate) struct CoreTags {
    pub(crate) trv: Vec<Tags>,
    pub(crate) ist: Vec<Tags>,
    pub(crate) srp: Tags,
}

impl CacheState {
    /// Empty caches.
    pub fn cold(config: &MachineConfig) -> Self {
        let (ti, l2) = (&config.ti, &config.l2);
        let l1 = |l1: &L1| Tags::new(l1.size.0, l1.ways, l2.line_bytes, l1.replacement);
        let core = CoreTags {
            trv: vec![l1(&ti.trv_l1); ti.trv as usize],
            ist: vec![l1(&ti.ist_l1); ti.ist as usize],
            srp: l1(&config.srp.l1),
        };
        Self {
            cores: vec![core; config.gpu.cores as usize],
            l2: Tags::new(l2.size.0, l2.ways, l2.line_bytes, l2.replacement),
        }
    }

    /// Drops lines that left an inclusive L2.
    pub(super) fn drop_evicted(&mut self, lines: impl Iterator<Item = u64>) {
        for line in lines {
            for core in &mut self.cores {
                core.trv.iter_mut().chain(&mut core.ist).chain([&mut core.srp]).for_each(|tags| {
                    tags.invalidate(line);
                });
            }
        }
    }
}
