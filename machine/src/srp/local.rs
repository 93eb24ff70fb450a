//! The tile buffer: how much fits, what spills, and how often it is touched.
//!
//! * Each of the `tiles_in_flight` slots owns an equal share of the local memory. A tile needs `sample.total()` bytes for each of
//!   its samples and of the neighbouring samples that it traces again. Samples beyond the share are spilled: written to memory
//!   and read back once, at the end of the tile (estimate).
//! * `geometry_buffer = "external"`: only the colour stays in local memory. After each round `sample.total() - colour` bytes a
//!   traced sample are written. At the beginning of a round each test reads object, normal and shadow bits of two samples, each
//!   interpolation the position of two. The bytes of a round are packed densely into lines (estimate). Nothing spills.
//! * Local memory is accessed in 4-byte words, each field rounded up. A shaded or missed primary writes a whole sample; a
//!   shaded or missed secondary ray and a shadow result read and write the colour; a test reads object, normal and shadow of two
//!   samples; an interpolation reads colour and position of two and writes a whole sample; resolve reads the colour (estimate).

use super::kernels::KernelId;
use super::stats::LocalCounters;
use crate::config::{GeometryBuffer, MachineConfig, SampleFields};
use crate::work::{Round, TileWork};

/// Sizes of the tile buffer.
#[derive(Clone, Debug)]
pub struct TileBuffer {
    fields: SampleFields,
    share_bytes: u64,
    /// Whether attributes are kept in memory.
    pub external: bool,
}

impl TileBuffer {
    /// The tile buffer of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        Self {
            fields: config.srp.sample.clone(),
            share_bytes: config.srp.local_memory.0 / u64::from(config.gpu.tiles_in_flight.max(1)),
            external: config.gpu.geometry_buffer == GeometryBuffer::External,
        }
    }

    /// Bytes of a sample.
    pub fn sample_bytes(&self) -> u64 {
        self.fields.total().into()
    }

    /// Samples of a tile that do not fit.
    pub fn spilled_samples(&self, work: &TileWork) -> u64 {
        let bytes = self.sample_bytes();
        if self.external || bytes == 0 {
            return 0;
        }
        // A secondary hit that tests look at takes as much as a sample.
        let samples = work.rect.len() as u64 + u64::from(work.apron_samples) + u64::from(work.secondary_hits);
        (samples * bytes).saturating_sub(self.share_bytes).div_ceil(bytes)
    }

    /// Bytes of the external buffer that a round reads before it begins.
    pub fn round_read_bytes(&self, round: &Round) -> u64 {
        if !self.external {
            return 0;
        }
        let f = &self.fields;
        let test = 2 * u64::from(f.object + f.normal + f.shadow);
        u64::from(round.tests) * test + u64::from(round.interpolated) * 2 * u64::from(f.position)
    }

    /// Bytes of the external buffer that a round writes when it is done.
    pub fn round_written_bytes(&self, round: &Round) -> u64 {
        if self.external { round.starts.len() as u64 * u64::from(self.fields.total() - self.fields.colour) } else { 0 }
    }

    /// Counts the accesses of `items` items; `primary` tells whether they are those of primary rays.
    #[inline]
    pub fn count(&self, kernel: KernelId, primary: bool, items: u64, counters: &mut LocalCounters) {
        let f = &self.fields;
        let colour = words(f.colour);
        let attributes = |of: u64| if self.external { 0 } else { of };
        let (reads, writes) = match kernel {
            KernelId::Raygen => (0, 0),
            KernelId::Shade | KernelId::Miss if primary => {
                let all = words(f.object) + words(f.normal) + words(f.position) + words(f.shadow) + words(f.flags);
                (0, colour + attributes(all))
            }
            KernelId::Shade | KernelId::Miss | KernelId::ShadowResult => (colour, colour),
            KernelId::Similarity => (attributes(2 * (words(f.object) + words(f.normal) + words(f.shadow))), 0),
            KernelId::Interpolate => {
                let all = words(f.object) + words(f.normal) + words(f.position) + words(f.shadow) + words(f.flags);
                (2 * colour + attributes(2 * words(f.position)), colour + attributes(all))
            }
            KernelId::Resolve => (colour, 0),
        };
        counters.reads += reads * items;
        counters.writes += writes * items;
    }
}

fn words(bytes: u32) -> u64 {
    u64::from(bytes.div_ceil(4))
}
