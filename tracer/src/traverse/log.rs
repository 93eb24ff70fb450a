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
    /// Per lane where its next step goes.
    ends: [u32; LANES],
}

impl Default for PathLog {
    fn default() -> Self {
        let room = 256;
        let mut log = Self { bytes: vec![0; room * LANES], room, longest: 0, ends: [0; LANES] };
        log.clear();
        log
    }
}

impl PathLog {
    /// Forgets all steps.
    pub fn clear(&mut self) {
        self.longest = 0;
        self.ends = std::array::from_fn(|lane| (lane * self.room) as u32);
    }

    /// Adds to the lanes of `mask` the step that `steps` holds in their bytes.
    #[inline(always)]
    pub fn push(&mut self, mask: u8, steps: u64) {
        if self.longest == self.room {
            self.grow();
        }
        self.longest += 1;
        let (kept, steps) = (BYTES[usize::from(mask)].to_le_bytes(), steps.to_le_bytes());
        let bytes = &mut self.bytes[..];
        // Every lane writes; only those of the mask keep it. Which they are is what no processor can predict.
        for lane in 0..LANES {
            let end = self.ends[lane];
            bytes[end as usize] = steps[lane];
            self.ends[lane] = end + u32::from(kept[lane]);
        }
    }

    #[cold]
    fn grow(&mut self) {
        let lengths: [usize; LANES] = std::array::from_fn(|lane| self.lane(lane).len());
        self.longest = lengths.into_iter().max().unwrap_or(0);
        if self.longest <= self.room / 2 {
            return;
        }
        let mut bytes = vec![0; self.bytes.len() * 2];
        for (new, old) in bytes.chunks_exact_mut(self.room * 2).zip(self.bytes.chunks_exact(self.room)) {
            new[..self.room].copy_from_slice(old);
        }
        (self.bytes, self.room) = (bytes, self.room * 2);
        self.ends = std::array::from_fn(|lane| (lane * self.room + lengths[lane]) as u32);
    }

    /// The steps of a lane.
    pub fn lane(&self, lane: usize) -> &[u8] {
        &self.bytes[lane * self.room..self.ends[lane] as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lanes_keep_their_steps_apart_however_many_there_are() {
        let mut log = PathLog::default();
        for round in 0..2 {
            log.clear();
            let mut expected: [Vec<u8>; LANES] = Default::default();
            for i in 0..20_000u32 {
                // The last lane is in every step, the others ever less often.
                let mask = (i.wrapping_mul(0x9e37_79b9) >> 24) as u8 & (i >> 3) as u8 | 0x80;
                let step = (i % 10) as u8;
                log.push(mask, super::steps(mask, step));
                let lanes = expected.iter_mut().enumerate().filter(|(lane, _)| mask >> lane & 1 != 0);
                lanes.for_each(|(_, steps)| steps.push(step));
            }
            for (lane, steps) in expected.iter().enumerate() {
                assert_eq!(log.lane(lane), steps, "lane {lane}, round {round}");
            }
        }
    }
}
