//! Adaptive binary range coding, one code path for both directions.
//!
//! A column is described once, as a sequence of modelled bits; an [`Encoder`] takes each bit from the data, a
//! [`Decoder`] gives it back. So reader and writer cannot disagree. The arithmetic is integer only.

/// The model of one bit: the probability that it is set (22 bits) and how often it was seen (10 bits).
#[derive(Clone, Copy, Debug)]
pub struct Bit(u32);

/// Observations that are counted. From then on the adaptation rate stays at 1 / (COUNT_MAX + 1.5).
const COUNT_MAX: u32 = 254;
/// Probabilities passed to the coder stay this far from 0 and 65536.
const PROBABILITY_MARGIN: u32 = 24;

/// `65536 / (count + 1.5)`: the adaptation rate after `count` observations.
static RATES: [u32; COUNT_MAX as usize + 1] = {
    let mut rates = [0; COUNT_MAX as usize + 1];
    let mut n = 0;
    while n < rates.len() {
        rates[n] = 131_072 / (2 * n as u32 + 3);
        n += 1;
    }
    rates
};

impl Bit {
    /// Nothing is known: both values are equally likely.
    pub const EVEN: Self = Self::of(32_768, 0);

    /// A bit that is set with probability `p / 65536`, as if seen `count` times.
    pub const fn of(p: u32, count: u32) -> Self {
        Self(p << 16 | count)
    }

    #[inline(always)]
    fn probability(self) -> u32 {
        (self.0 >> 16).clamp(PROBABILITY_MARGIN, 65_536 - PROBABILITY_MARGIN)
    }

    #[inline(always)]
    fn update(&mut self, bit: bool) {
        let (p, count) = (self.0 >> 10, self.0 & 1023);
        let rate = RATES[count as usize];
        // Without branches: whether a bit is set is what no processor can predict.
        let target = u32::from(bit).wrapping_neg() & ((1 << 22) - 1);
        let moved = i64::from(p) + (((i64::from(target) - i64::from(p)) * i64::from(rate)) >> 16);
        self.0 = ((moved as u32) << 10) | (count + u32::from(count < COUNT_MAX));
    }

    /// [`Bit::update`] with a bit that is set.
    #[inline(always)]
    fn was_set(&mut self) {
        let (p, count) = (self.0 >> 10, self.0 & 1023);
        let up = (u64::from((1 << 22) - 1 - p) * u64::from(RATES[count as usize])) >> 16;
        self.0 = ((p + up as u32) << 10) | (count + u32::from(count < COUNT_MAX));
    }

    /// [`Bit::update`] with a bit that is not.
    #[inline(always)]
    fn was_clear(&mut self) {
        let (p, count) = (self.0 >> 10, self.0 & 1023);
        // Rounded up, since the change is below zero.
        let down = (u64::from(p) * u64::from(RATES[count as usize]) + 0xffff) >> 16;
        self.0 = ((p - down as u32) << 10) | (count + u32::from(count < COUNT_MAX));
    }
}

/// A range coder in one direction.
pub trait Coder {
    /// True for an encoder: values passed in are coded. A decoder ignores them.
    const ENCODES: bool;

    /// Codes one bit under a model and returns it.
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool;

    /// As [`Coder::bit`], for a bit that is often not what it was: a decoder does not bet on it.
    fn doubtful_bit(&mut self, model: &mut Bit, bit: bool) -> bool;

    /// Codes `count` (at most 32) bits without a model, highest first.
    fn raw(&mut self, count: u32, value: u32) -> u32;
}

/// Renormalise when the range falls below this; it is then widened by 16 bits. One modelled bit takes at most 12 off
/// it, so once is enough.
const RANGE_MIN: u64 = 1 << 32;
const RANGE_START: u64 = (1 << 48) - 1;
const LOW_MASK: u64 = (1 << 48) - 1;

/// Writes a range-coded stream.
#[derive(Debug)]
pub struct Encoder {
    low: u64,
    range: u64,
    /// The last word that a carry can still change, and how many words of ones follow it.
    held: Option<u16>,
    held_ones: u64,
    out: Vec<u8>,
}

impl Default for Encoder {
    fn default() -> Self {
        Self { low: 0, range: RANGE_START, held: None, held_ones: 0, out: Vec::new() }
    }
}

impl Encoder {
    fn shift_low(&mut self) {
        let carry = u16::from(self.low > LOW_MASK);
        let word = (self.low >> 32) as u16;
        if word != 0xffff || carry == 1 {
            if let Some(held) = self.held {
                self.out.extend_from_slice(&held.wrapping_add(carry).to_be_bytes());
            }
            for _ in 0..self.held_ones {
                self.out.extend_from_slice(&0xffffu16.wrapping_add(carry).to_be_bytes());
            }
            (self.held, self.held_ones) = (Some(word), 0);
        } else {
            self.held_ones += 1;
        }
        self.low = (self.low << 16) & LOW_MASK;
    }

    /// Takes the lower part of the range, `bound` wide, if `lower`, else the rest.
    #[inline(always)]
    fn narrow(&mut self, bound: u64, lower: bool) {
        let mask = u64::from(lower).wrapping_neg();
        self.low += bound & !mask;
        self.range = (bound & mask) | ((self.range - bound) & !mask);
        if self.range < RANGE_MIN {
            self.range <<= 16;
            self.shift_low();
        }
    }

    /// Ends the stream. The decoder reads zeros past the end, so trailing zero bytes are left out.
    pub fn finish(mut self) -> Vec<u8> {
        // The value with the most trailing zeros inside [low, low + range).
        let top = self.low + self.range - 1;
        for zeros in (0..48).rev() {
            let candidate = (top >> zeros) << zeros;
            if candidate >= self.low {
                self.low = candidate;
                break;
            }
        }
        for _ in 0..4 {
            self.shift_low();
        }
        while self.out.last() == Some(&0) {
            self.out.pop();
        }
        self.out
    }
}

impl Coder for Encoder {
    const ENCODES: bool = true;

    #[inline(always)]
    fn bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        let bound = (self.range >> 16) * u64::from(model.probability());
        model.update(bit);
        self.narrow(bound, bit);
        bit
    }

    #[inline(always)]
    fn doubtful_bit(&mut self, model: &mut Bit, bit: bool) -> bool {
        self.bit(model, bit)
    }

    fn raw(&mut self, count: u32, value: u32) -> u32 {
        for i in (0..count).rev() {
            self.narrow(self.range >> 1, (value >> i) & 1 == 1);
        }
        value
    }
}

/// Reads a range-coded stream. Past its end it reads zeros, so it never fails; callers bound what they ask for.
#[derive(Debug)]
pub struct Decoder<'a> {
    code: u64,
    range: u64,
    rest: &'a [u8],
}

impl<'a> Decoder<'a> {
    /// Starts on a stream that [`Encoder::finish`] made.
    pub fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { code: 0, range: RANGE_START, rest: bytes };
        for _ in 0..3 {
            decoder.code = (decoder.code << 16) | decoder.word();
        }
        decoder
    }

    #[inline]
    fn word(&mut self) -> u64 {
        if let Some((word, rest)) = self.rest.split_first_chunk::<2>() {
            self.rest = rest;
            return u64::from(u16::from_be_bytes(*word));
        }
        let last = self.rest.first().map_or(0, |&b| u64::from(b) << 8);
        self.rest = &[];
        last
    }

    /// True if the code lies in the lower part of the range, `bound` wide; takes that part.
    #[inline(always)]
    fn narrow(&mut self, bound: u64) -> bool {
        let lower = self.code < bound;
        let mask = u64::from(lower).wrapping_neg();
        self.code -= bound & !mask;
        self.range = (bound & mask) | ((self.range - bound) & !mask);
        self.widen();
        lower
    }

    #[inline(always)]
    fn widen(&mut self) {
        if self.range < RANGE_MIN {
            self.range <<= 16;
            self.code = (self.code << 16) | self.word();
        }
    }
}

impl Coder for Decoder<'_> {
    const ENCODES: bool = false;

    /// With a branch: where a model is good, a processor foresees the bit too, and goes on before the bound is known.
    #[inline(always)]
    fn bit(&mut self, model: &mut Bit, _: bool) -> bool {
        let bound = (self.range >> 16) * u64::from(model.probability());
        let bit = self.code < bound;
        if bit {
            self.range = bound;
            model.was_set();
        } else {
            self.range -= bound;
            self.code -= bound;
            model.was_clear();
        }
        self.widen();
        bit
    }

    #[inline(always)]
    fn doubtful_bit(&mut self, model: &mut Bit, _: bool) -> bool {
        let bit = self.narrow((self.range >> 16) * u64::from(model.probability()));
        model.update(bit);
        bit
    }

    fn raw(&mut self, count: u32, _: u32) -> u32 {
        let mut value = 0;
        for _ in 0..count {
            value = (value << 1) | u32::from(self.narrow(self.range >> 1));
        }
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_decoder_that_bets_learns_as_one_that_does_not() {
        for count in 0..=COUNT_MAX {
            for p in (0..1 << 22).step_by(977).chain([1, (1 << 22) - 1]) {
                let mut models = [Bit(p << 10 | count); 4];
                models[0].update(true);
                models[1].was_set();
                models[2].update(false);
                models[3].was_clear();
                assert_eq!([models[0].0, models[2].0], [models[1].0, models[3].0], "{p} after {count}");
            }
        }
    }

    #[test]
    fn a_long_run_of_carries_is_coded() {
        let mut encoder = Encoder::default();
        let (mut rare, mut even) = (Bit::of(24, 254), Bit::EVEN);
        for i in 0..100_000u32 {
            encoder.bit(&mut rare, false);
            encoder.bit(&mut even, i % 3 == 0);
        }
        let bytes = encoder.finish();
        let mut decoder = Decoder::new(&bytes);
        let (mut rare, mut even) = (Bit::of(24, 254), Bit::EVEN);
        for i in 0..100_000u32 {
            assert!(!decoder.bit(&mut rare, false));
            assert_eq!(decoder.bit(&mut even, false), i % 3 == 0);
        }
    }
}
