//! Which lines lie where: channel, bank and row.

use crate::config;

/// Where a line lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DramAddress {
    /// Channel.
    pub channel: usize,
    /// Bank of the channel.
    pub bank: u8,
    /// Row of the bank.
    pub row: u64,
}

/// Which lines lie where.
#[derive(Clone, Copy, Debug)]
pub struct AddressMap {
    channels: Divisor,
    banks: Divisor,
    /// Lines of a row, and of what is in a channel before the next channel's turn.
    row_lines: Divisor,
    block_lines: Divisor,
    hash: bool,
}

/// A number to divide by. A power of two, as nearly all are, takes a shift: every line that comes and goes is divided several times, and a
/// division takes longer than all the rest of it.
#[derive(Clone, Copy, Debug)]
struct Divisor {
    number: u64,
    shift: Option<u32>,
}

impl Divisor {
    fn new(number: u64) -> Self {
        Self { number, shift: number.is_power_of_two().then(|| number.trailing_zeros()) }
    }

    /// Quotient and remainder.
    #[inline]
    fn of(self, dividend: u64) -> (u64, u64) {
        match self.shift {
            Some(shift) => (dividend >> shift, dividend & (self.number - 1)),
            None => (dividend / self.number, dividend % self.number),
        }
    }
}

impl AddressMap {
    /// That of `config`, with lines of `line_bytes`.
    pub fn new(config: &config::Dram, line_bytes: u32) -> Self {
        Self {
            channels: Divisor::new(config.channels.into()),
            banks: Divisor::new(config.banks.into()),
            row_lines: Divisor::new((config.row_bytes / line_bytes).into()),
            block_lines: Divisor::new((config.interleave_bytes / line_bytes).max(1).into()),
            hash: config.hash,
        }
    }

    /// Where a line lies.
    #[inline]
    pub fn address(&self, line: u64) -> DramAddress {
        let (block, offset) = self.block_lines.of(line);
        let (above, channel) = self.channels.of(block);
        let (row_number, _) = self.row_lines.of(above * self.block_lines.number + offset);
        let (row, bank) = self.banks.of(row_number);
        if !self.hash {
            return DramAddress { channel: channel as usize, bank: bank as u8, row };
        }
        // Both numbers are powers of two: what is folded in permutes them, so no two lines meet.
        let channel = (channel ^ fold(above, self.channels.number)) as usize;
        DramAddress { channel, bank: (bank ^ fold(row, self.banks.number)) as u8, row }
    }

    /// The channel of a line.
    #[inline]
    pub fn channel(&self, line: u64) -> usize {
        let (above, channel) = self.channels.of(self.block_lines.of(line).0);
        (if self.hash { channel ^ fold(above, self.channels.number) } else { channel }) as usize
    }
}

/// The digits of `bits` to the base of `count`, a power of two, added without carry: a number below `count`.
#[inline]
fn fold(mut bits: u64, count: u64) -> u64 {
    let width = count.trailing_zeros();
    if width == 0 {
        return 0;
    }
    // The upper half of the digits to the lower half, and so on.
    let mut half = width << (u64::BITS.div_ceil(width) - 1).ilog2();
    while half >= width {
        bits ^= bits >> half;
        half /= 2;
    }
    bits & (count - 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_are_added_without_carry() {
        let one_by_one = |mut bits: u64, count: u64| {
            let mut sum = 0;
            while bits != 0 {
                (sum, bits) = (sum ^ bits & (count - 1), bits / count);
            }
            sum
        };
        let mut random = 0x9e37_79b9_7f4a_7c15_u64;
        for width in 1..=8 {
            for _ in 0..200 {
                random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
                for bits in [random, random >> 17, random >> 40, u64::MAX] {
                    assert_eq!(
                        fold(bits, 1 << width),
                        one_by_one(bits, 1 << width),
                        "{bits:x} in digits of {width} bits"
                    );
                }
            }
        }
        assert_eq!(fold(u64::MAX, 1), 0);
    }

    #[test]
    fn any_number_divides() {
        for number in 1..70 {
            let divisor = Divisor::new(number);
            assert!((0..1000).all(|dividend| divisor.of(dividend) == (dividend / number, dividend % number)));
        }
    }
}
