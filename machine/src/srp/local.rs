//! The tile buffer: how much fits, what spills, and how often it is touched.
//!
//! * Each of the `tiles_in_flight` slots owns an equal share of the local memory. A tile needs `sample.total()` bytes for each of
//!   its samples and of the neighbouring samples that it traces again. Samples beyond the share are spilled: written to memory
//!   and read back once, at the end of the tile (estimate).
//! * `geometry_buffer = "external"`: only the colour stays in local memory. After each round `sample.total() - colour` bytes a
//!   traced sample are written, and what an interpolated hit has that later tests read. At the beginning of a round each test reads
//!   what it tests of two samples, and each interpolated hit what it is made of. The bytes of a round are packed densely into lines
//!   (estimate). Nothing spills.
//! * Local memory is accessed in words of `local_word_bytes`, each field rounded up. A shaded or missed primary writes a whole sample; a
//!   shaded or missed secondary ray and a shadow result read and write the colour; a test reads what it tests of two samples, and
//!   a difference of colours two colours; an interpolation reads two colours and writes one; an interpolated hit that later tests
//!   read reads what it is made of twice and writes it; resolve reads the colour; a rate is a word (estimate).
//! * Fields that a policy does not read (length of the ray, local colour, weights) take no room.

use super::kernels::KernelId;
use super::stats::LocalCounters;
use crate::config::{GeometryBuffer, MachineConfig, SampleFields};
use crate::work::{PolicyReads, Round, TileWork};

/// Sizes of the tile buffer.
#[derive(Clone, Debug)]
pub struct TileBuffer {
    fields: SampleFields,
    policy: PolicyReads,
    share_bytes: u64,
    word_bytes: u32,
    /// Whether attributes are kept in memory.
    pub external: bool,
}

impl TileBuffer {
    /// The tile buffer of a machine under a policy.
    pub fn new(config: &MachineConfig, policy: &PolicyReads) -> Self {
        Self {
            fields: fields_under(&config.srp.sample, policy),
            policy: *policy,
            share_bytes: config.srp.local_memory.0 / u64::from(config.gpu.tiles_in_flight.max(1)),
            word_bytes: config.srp.local_word_bytes.max(1),
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
        let total = |fields: [u32; 8]| 2 * fields.into_iter().map(u64::from).sum::<u64>();
        u64::from(round.tests) * total(self.tested())
            + u64::from(round.colours) * 2 * u64::from(self.fields.local)
            + u64::from(round.attributes) * total(self.mixed())
    }

    /// Bytes of the external buffer that a round writes when it is done.
    pub fn round_written_bytes(&self, round: &Round) -> u64 {
        if !self.external {
            return 0;
        }
        let traced = round.starts.len() as u64 * u64::from(self.fields.total() - self.fields.colour);
        let mixed: u64 = self.mixed().into_iter().map(u64::from).sum();
        traced + u64::from(round.attributes) * mixed
    }

    /// Bytes of a sample that a test reads, by field; fields that the policy does not test are 0.
    fn tested(&self) -> [u32; 8] {
        let (f, p) = (&self.fields, &self.policy);
        let only = |field, is_read: bool| if is_read { field } else { 0 };
        [
            only(f.object, p.object),
            only(f.normal, p.normal || p.plane),
            only(f.shadow, p.shadow),
            only(f.position, p.distance()),
            only(f.distance, p.distance()),
            0,
            0,
            0,
        ]
    }

    /// Bytes of an entry of a history that is looked at, by field.
    fn looked_at(&self) -> [u32; 5] {
        let f = &self.fields;
        [f.object, f.normal, f.shadow, f.flags, f.distance]
    }

    /// Bytes of a sample that an interpolated hit is made of and has, by field.
    fn mixed(&self) -> [u32; 8] {
        let mut mixed = self.tested();
        (mixed[5], mixed[6]) = (self.fields.local, self.fields.weights);
        mixed
    }

    /// Counts the accesses of `items` items; `primary` tells whether they are those of primary rays.
    #[inline]
    pub fn count(&self, kernel: KernelId, primary: bool, items: u64, counters: &mut LocalCounters) {
        let f = &self.fields;
        let words = |bytes: u32| u64::from(bytes.div_ceil(self.word_bytes));
        let colour = words(f.colour);
        let attributes = |of: u64| if self.external { 0 } else { of };
        let (reads, writes) = match kernel {
            KernelId::Raygen => (0, 0),
            KernelId::Shade | KernelId::Miss if primary => {
                let all = [f.object, f.normal, f.position, f.shadow, f.flags, f.distance, f.local, f.weights];
                (0, colour + attributes(all.into_iter().map(words).sum()))
            }
            KernelId::Shade | KernelId::Miss | KernelId::ShadowResult => (colour, colour),
            KernelId::Similarity => (attributes(2 * self.tested().into_iter().map(words).sum::<u64>()), 0),
            KernelId::Colour => (2 * colour + attributes(2 * words(f.local)), 0),
            KernelId::Interpolate => (2 * colour, colour + attributes(words(f.flags))),
            KernelId::Attributes => {
                let mixed = self.mixed().into_iter().map(words).sum::<u64>();
                (attributes(2 * mixed), attributes(mixed))
            }
            KernelId::Reshade => (colour + attributes(self.mixed().into_iter().map(words).sum()), colour),
            // A sample with its hits below, each read whole.
            KernelId::LookBack => (attributes(4 * self.looked_at().into_iter().map(words).sum::<u64>()), 0),
            KernelId::Control => (0, 1),
            KernelId::Resolve => (colour, 0),
        };
        counters.reads += reads * items;
        counters.writes += writes * items;
    }
}

/// What a sample takes under a policy: fields that it does not read are not there.
fn fields_under(fields: &SampleFields, policy: &PolicyReads) -> SampleFields {
    let only = |field, is_read: bool| if is_read { field } else { 0 };
    SampleFields {
        distance: only(fields.distance, policy.distance()),
        local: only(fields.local, policy.local),
        weights: only(fields.weights, policy.weights),
        ..fields.clone()
    }
}
