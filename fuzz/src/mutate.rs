//! Changes of inputs: bits, bytes, numbers, pieces, words, pieces of other inputs.

use crate::random::Random;

/// Longest input.
pub const LENGTH_MAX: usize = 1 << 16;

/// Numbers at whose edges code breaks.
const NUMBERS: [u64; 16] =
    [0, 1, 2, 7, 16, 31, 32, 127, 128, 255, 1 << 15, u16::MAX as u64, 1 << 31, u32::MAX as u64, 1 << 63, u64::MAX];

/// The same as they are written in text, and what else parsers stumble over.
const WORDS: [&str; 40] = [
    "0",
    "-0",
    "1",
    "-1",
    "255",
    "256",
    "65535",
    "65536",
    "2147483647",
    "2147483648",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "9223372036854775808",
    "18446744073709551616",
    "1e308",
    "1e309",
    "-1e309",
    "1e-320",
    "0.0",
    "nan",
    "inf",
    "-inf",
    "null",
    "true",
    "false",
    "\"\"",
    "[]",
    "{}",
    "[[",
    "]]",
    "\n",
    "\r\n",
    "\0",
    "\u{feff}",
    "=",
    ".",
    "/",
    "\\",
    "..",
];

/// Changes `bytes` once to eight times. `others` are inputs of the same kind, `words` are words of it.
pub fn change(bytes: &mut Vec<u8>, others: &[&[u8]], words: &[Vec<u8>], random: &mut Random) {
    let times = 1 + random.below(8).min(random.below(8));
    for _ in 0..times {
        once(bytes, others, words, random);
    }
    bytes.truncate(LENGTH_MAX);
}

fn once(bytes: &mut Vec<u8>, others: &[&[u8]], words: &[Vec<u8>], random: &mut Random) {
    if bytes.is_empty() {
        bytes.push(random.bits() as u8);
    }
    let at = random.below(bytes.len());
    match random.below(15) {
        0 | 1 => bytes[at] ^= 1 << random.below(8),
        2 => bytes[at] = random.bits() as u8,
        3 => bytes[at] = NUMBERS[random.below(NUMBERS.len())] as u8,
        4 => overwrite(bytes, at, &number(random)),
        5 => bytes[at] = bytes[at].wrapping_add(1 + random.below(4) as u8).wrapping_sub(2),
        6 => drop(bytes.drain(piece(bytes.len(), random))),
        7 => {
            let copy = bytes[piece(bytes.len(), random)].to_vec();
            let times = if random.once_in(20) { 1 + random.below(2000) } else { 1 };
            insert(bytes, at, &copy.repeat(times.min(1 + LENGTH_MAX / copy.len().max(1))));
        }
        8 => {
            let copy = bytes[piece(bytes.len(), random)].to_vec();
            overwrite(bytes, at, &copy);
        }
        9 | 10 => {
            let word = word(words, random);
            if random.once_in(2) { insert(bytes, at, &word) } else { overwrite(bytes, at, &word) }
        }
        11 => {
            let (from, to) = written_number(bytes, at);
            let new = WORDS[random.below(20)];
            bytes.splice(from..to, new.bytes());
        }
        12 if !others.is_empty() => {
            let other = random.pick(others);
            let piece = &other[piece(other.len(), random)];
            if random.once_in(2) { insert(bytes, at, piece) } else { overwrite(bytes, at, piece) }
        }
        13 if random.once_in(4) => bytes.truncate(at),
        _ => {
            let noise: Vec<u8> = (0..1 + random.below(16)).map(|_| random.bits() as u8).collect();
            overwrite(bytes, at, &noise);
        }
    }
}

/// A number of one to eight bytes, in either order.
fn number(random: &mut Random) -> Vec<u8> {
    let number = NUMBERS[random.below(NUMBERS.len())].wrapping_sub(u64::from(random.once_in(4)));
    let mut bytes = number.to_le_bytes()[..[1, 2, 4, 8][random.below(4)]].to_vec();
    if random.once_in(4) {
        bytes.reverse();
    }
    bytes
}

fn word(words: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    if words.is_empty() || random.once_in(3) {
        return WORDS[random.below(WORDS.len())].as_bytes().to_vec();
    }
    words[random.below(words.len())].clone()
}

/// The digits around a place; empty if there are none.
fn written_number(bytes: &[u8], at: usize) -> (usize, usize) {
    let part = |byte: &u8| byte.is_ascii_digit() || matches!(byte, b'.' | b'-' | b'e');
    let at = bytes[at..].iter().position(u8::is_ascii_digit).map_or(at, |far| at + far);
    let from = at - bytes[..at].iter().rev().take_while(|byte| part(byte)).count();
    (from, at + bytes[at..].iter().take_while(|byte| part(byte)).count())
}

/// A piece: mostly short.
fn piece(len: usize, random: &mut Random) -> std::ops::Range<usize> {
    let longest = if random.once_in(4) { len } else { len.min(32) };
    let length = random.below(longest + 1);
    let start = random.below(len - length + 1);
    start..start + length
}

fn overwrite(bytes: &mut [u8], at: usize, new: &[u8]) {
    bytes[at..].iter_mut().zip(new).for_each(|(old, new)| *old = *new);
}

fn insert(bytes: &mut Vec<u8>, at: usize, new: &[u8]) {
    bytes.splice(at..at, new.iter().copied());
}

/// The words of texts, each once, in order: names and numbers, and lines.
pub fn words(texts: &[Vec<u8>]) -> Vec<Vec<u8>> {
    let text = |byte: u8| byte.is_ascii_alphanumeric() || matches!(byte, b'_' | b'-' | b'.');
    let mut words: Vec<Vec<u8>> = Vec::new();
    for bytes in texts.iter().filter(|bytes| std::str::from_utf8(bytes).is_ok()) {
        let names = bytes.split(|byte| !text(*byte)).chain(bytes.split_inclusive(|byte| *byte == b'\n'));
        words.extend(names.filter(|word| (2..200).contains(&word.len())).map(<[u8]>::to_vec));
    }
    words.sort();
    words.dedup();
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_seed_gives_the_same_changes_and_every_length_is_bounded() {
        let texts = [b"width = 12.5\nname = \"a\"\n".to_vec()];
        let words = words(&texts);
        assert!(words.contains(&b"width".to_vec()) && words.contains(&b"12.5".to_vec()));
        let others: Vec<&[u8]> = texts.iter().map(Vec::as_slice).collect();
        for seed in 0..2000 {
            let mut runs = [texts[0].clone(), texts[0].clone()];
            for bytes in &mut runs {
                let random = &mut Random(seed);
                (0..20).for_each(|_| change(bytes, &others, &words, random));
            }
            assert_eq!(runs[0], runs[1]);
            assert!(runs[0].len() <= LENGTH_MAX);
        }
    }
}
