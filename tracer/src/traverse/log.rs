//! The steps of a packet's rays, each ray's kept apart.

use super::lanes::LANES;

/// Per set of lanes, a byte of one for each lane in it.
static BYTES: [u64; 256] = {
    let mut table = [0; 256];
    let mut mask = 0;
    while mask < 256 {
        let mut lane = 0;
        while lane < LANES {
            table[mask] |= ((mask as u64 >> lane) & 1) << (8 * lane);
            lane += 1;
        }
        mask += 1;
    }
    table
};

/// The same step in the lanes of `mask`; steps of other lanes are added to it.
#[inline(always)]
pub(super) fn steps(mask: u8, step: u8) -> u64 {
    BYTES[usize::from(mask)] * u64::from(step)
}

/// Steps by ray.
#[derive(Debug)]
pub(super) struct PathLog {
    /// `room` bytes a lane.
    bytes: Vec<u8>,
    room: usize,
    /// No lane has more steps than this.
    longest: usize,
    lengths: [usize; LANES],
}

impl Default for PathLog {
    fn default() -> Self {
        let room = 256;
        Self { bytes: vec![0; room * LANES], room, longest: 0, lengths: [0; LANES] }
    }
}

impl PathLog {
    /// Forgets all steps.
    pub fn clear(&mut self) {
        self.longest = 0;
        self.lengths = [0; LANES];
    }

    /// Adds to the lanes of `mask` the step that `steps` holds in their bytes.
    #[inline(always)]
    pub fn push(&mut self, mask: u8, steps: u64) {
        if self.longest == self.room {
            self.grow();
        }
        self.longest += 1;
        // Every lane writes; only those of the mask keep it. Which they are is what no processor can predict.
        for lane in 0..LANES {
            let length = &mut self.lengths[lane];
            self.bytes[lane * self.room + *length] = (steps >> (8 * lane)) as u8;
            *length += usize::from(mask >> lane & 1);
        }
    }

    #[cold]
    fn grow(&mut self) {
        self.longest = self.lengths.into_iter().max().unwrap_or(0);
        if self.longest <= self.room / 2 {
            return;
        }
        let mut bytes = vec![0; self.bytes.len() * 2];
        for (new, old) in bytes.chunks_exact_mut(self.room * 2).zip(self.bytes.chunks_exact(self.room)) {
            new[..self.room].copy_from_slice(old);
        }
        (self.bytes, self.room) = (bytes, self.room * 2);
    }

    /// The steps of a lane.
    pub fn lane(&self, lane: usize) -> &[u8] {
        let start = lane * self.room;
        &self.bytes[start..start + self.lengths[lane]]
    }
}
