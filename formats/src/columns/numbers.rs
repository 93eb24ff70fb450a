//! Models of more than a bit: symbols and numbers.

use super::coder::{Bit, Coder};

/// Models for one symbol of `2^BITS` values, as a binary tree of bits. `N` must be `2^BITS`.
#[derive(Clone, Copy, Debug)]
pub struct Symbol<const N: usize>([Bit; N]);

impl<const N: usize> Default for Symbol<N> {
    fn default() -> Self {
        Self([Bit::EVEN; N])
    }
}

impl<const N: usize> Symbol<N> {
    /// Codes a value below `N`, highest bit first.
    #[inline(always)]
    pub fn code<C: Coder>(&mut self, coder: &mut C, value: usize) -> usize {
        let bits = N.trailing_zeros();
        let mut node = 1;
        for i in (0..bits).rev() {
            node = node << 1 | usize::from(coder.bit(&mut self.0[node], value >> i & 1 == 1));
        }
        node - N
    }
}

/// Models for numbers of any size: Elias-gamma with modelled length and modelled upper bits.
///
/// `0` has length 0; a number of `n` bits has length `n`, its highest bit is implied, the next two are modelled, the
/// rest raw.
#[derive(Clone, Debug)]
pub struct Number {
    length: [Bit; 33],
    upper: [[Bit; 4]; 33],
}

impl Default for Number {
    fn default() -> Self {
        Self { length: [Bit::EVEN; 33], upper: [[Bit::EVEN; 4]; 33] }
    }
}

impl Number {
    /// Codes a number.
    #[inline(always)]
    pub fn code<C: Coder>(&mut self, coder: &mut C, value: u32) -> u32 {
        let wanted = 32 - value.leading_zeros();
        let mut length = 0;
        while length < 32 && coder.bit(&mut self.length[length as usize], wanted > length) {
            length += 1;
        }
        if length < 2 {
            return length;
        }
        let upper = &mut self.upper[length as usize];
        let below = length - 1;
        let first = coder.doubtful_bit(&mut upper[1], value >> (below - 1) & 1 == 1);
        let mut result = 2 | u32::from(first);
        if below > 1 {
            let second = coder.doubtful_bit(&mut upper[2 + usize::from(first)], value >> (below - 2) & 1 == 1);
            result = result << 1 | u32::from(second);
            let rest = below - 2;
            if rest > 0 {
                result = result << rest | coder.raw(rest, value & ((1 << rest) - 1));
            }
        }
        result
    }
}

/// Folds a signed difference into an unsigned number, small magnitudes first.
#[inline]
pub fn zigzag(v: i32) -> u32 {
    (v << 1 ^ v >> 31) as u32
}

/// The inverse of [`zigzag`].
#[inline]
pub fn unzigzag(v: u32) -> i32 {
    (v >> 1) as i32 ^ -((v & 1) as i32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::coder::{Decoder, Encoder};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_goes_in_comes_out(items in prop::collection::vec((0u8..4, any::<u32>()), 0..2000)) {
            fn run<C: Coder>(coder: &mut C, items: &[(u8, u32)]) -> Vec<u32> {
                let (mut bits, mut symbol, mut number) = ([Bit::EVEN; 3], Symbol::<8>::default(), Number::default());
                let take = |v| if C::ENCODES { v } else { 0 };
                items.iter().map(|&(kind, value)| match kind {
                    0 => u32::from(coder.bit(&mut bits[0], take(value) % 100 == 1)),
                    1 => symbol.code(coder, take(value) as usize % 8) as u32,
                    2 => number.code(coder, take(value)),
                    _ => coder.raw(17, take(value) & 0x1ffff),
                }).collect()
            }
            let mut encoder = Encoder::default();
            let expected = run(&mut encoder, &items);
            let bytes = encoder.finish();
            prop_assert_eq!(run(&mut Decoder::new(&bytes), &items), expected);
        }

        #[test]
        fn any_bytes_decode_to_something(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
            let (mut decoder, mut bit, mut number) = (Decoder::new(&bytes), Bit::EVEN, Number::default());
            for _ in 0..1000 {
                decoder.bit(&mut bit, false);
                number.code(&mut decoder, 0);
            }
        }
    }

    /// The last row of the table of check values in FORMAT.md.
    #[test]
    fn format_md_states_a_stream_of_numbers() {
        let (mut coder, mut number) = (Encoder::default(), Number::default());
        for value in [0, 1, 2, 7, 100, 65_535, 4_000_000_000, 0] {
            number.code(&mut coder, value);
        }
        let stream: String = coder.finish().iter().map(|byte| format!("{byte:02X}")).collect();
        let row = format!("| 0, 1, 2, 7, 100, 65535, 4000000000, 0 under one number model | {stream} |\n");
        assert!(include_str!("../../FORMAT.md").contains(&row), "FORMAT.md lacks {row}");
    }

    #[test]
    fn zigzag_is_its_own_inverse() {
        for v in [0, 1, -1, 2, -2, i32::MAX, i32::MIN] {
            assert_eq!(unzigzag(zigzag(v)), v);
        }
    }
}
