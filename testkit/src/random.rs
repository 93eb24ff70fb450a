//! One generator of random numbers for all tests: SplitMix64 (Steele, Lea, Flood 2014). Tests need no better one.

/// The generator; its number is the state, any seed will do.
#[derive(Clone, Copy, Debug)]
pub struct Random(pub u64);

impl Random {
    /// 32 random bits.
    #[expect(clippy::should_implement_trait, reason = "a generator without an end is no iterator")]
    pub fn next(&mut self) -> u32 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 32) as u32
    }

    /// A number below `n`; 0 if `n` is 0.
    pub fn below(&mut self, n: u32) -> u32 {
        ((u64::from(self.next()) * u64::from(n)) >> 32) as u32
    }

    /// The index of one of `n` things; 0 if there is none.
    pub fn index(&mut self, n: usize) -> usize {
        ((u64::from(self.next()) * n as u64) >> 32) as usize
    }

    /// A number below `n`, as the remainder of a draw. What the synthetic frames show depends on it, and tests hold exact
    /// figures of theirs.
    ///
    /// # Panics
    /// When `n` is 0.
    pub fn remainder(&mut self, n: u32) -> u32 {
        self.next() % n
    }

    /// True once in `n` times.
    pub fn once_in(&mut self, n: u32) -> bool {
        self.below(n) == 0
    }

    /// From 0 to below 1.
    pub fn unit(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 16_777_216.0
    }

    /// From -1 to below 1.
    pub fn signed(&mut self) -> f32 {
        (self.next() >> 8) as f32 / 8_388_608.0 - 1.0
    }

    /// From `low` to below `high`.
    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        low + (high - low) * self.unit()
    }
}

#[cfg(test)]
mod tests {
    use super::Random;

    /// The high halves of the first outputs that Vigna's `splitmix64.c` gives for this seed.
    #[test]
    fn the_generator_is_splitmix64() {
        let mut random = Random(1_234_567);
        let wide = [6_457_827_717_110_365_317u64, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423];
        for expected in wide {
            assert_eq!(u64::from(random.next()), expected >> 32);
        }
    }

    #[test]
    fn draws_stay_in_their_ranges() {
        let mut random = Random(1);
        for n in 1..1000 {
            assert!(random.below(n) < n && random.remainder(n) < n && random.index(n as usize) < n as usize);
            assert!((0.0..1.0).contains(&random.unit()) && (-1.0..1.0).contains(&random.signed()));
            assert!((2.0..5.0).contains(&random.range(2.0, 5.0)));
        }
    }
}
