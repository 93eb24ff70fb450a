//! The footer of a Parquet file, walked before the library reads it: lists are as long as they say.
//!
//! The library steps over lists of flags in fields that it does not know without reading a byte for each, so a few bytes that claim
//! billions of them keep it busy for ever. Here each element takes a byte, as the compact protocol of Thrift has it.

/// Deepest nesting of a footer.
const DEPTH_MAX: u32 = 32;

/// Whether the footer of a file is well-formed, or not found: the library says what is wrong then.
pub fn is_bounded(file: &[u8]) -> bool {
    let Some((rest, end)) = file.split_last_chunk::<8>() else { return true };
    let length = u32::from_le_bytes([end[0], end[1], end[2], end[3]]) as usize;
    let Some(start) = rest.len().checked_sub(length) else { return true };
    Walk(&rest[start..]).value(STRUCT, DEPTH_MAX).is_some()
}

const STRUCT: u8 = 12;

/// What is left of the bytes.
struct Walk<'a>(&'a [u8]);

impl Walk<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn skip(&mut self, bytes: u64) -> Option<()> {
        self.0 = self.0.get(usize::try_from(bytes).ok()?..)?;
        Some(())
    }

    fn number(&mut self) -> Option<u64> {
        let mut number = 0;
        for shift in (0..64).step_by(7) {
            let byte = self.byte()?;
            number |= u64::from(byte & 0x7f) << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    /// A value of a type, as it stands in a list; none if the bytes end before it does.
    fn value(&mut self, kind: u8, depth: u32) -> Option<()> {
        let depth = depth.checked_sub(1)?;
        match kind {
            1..=3 => self.skip(1),
            4..=6 => self.number().map(drop),
            7 => self.skip(8),
            8 => self.number().and_then(|length| self.skip(length)),
            9 | 10 => {
                let head = self.byte()?;
                let count = if head >> 4 == 15 { self.number()? } else { u64::from(head >> 4) };
                (0..count).try_for_each(|_| self.value(head & 15, depth))
            }
            11 => {
                let count = self.number()?;
                let kinds = if count > 0 { self.byte()? } else { 0 };
                (0..count).try_for_each(|_| self.value(kinds >> 4, depth).and_then(|()| self.value(kinds & 15, depth)))
            }
            STRUCT => loop {
                let head = self.byte()?;
                if head == 0 {
                    return Some(());
                }
                if head >> 4 == 0 {
                    self.number()?;
                }
                // A flag of a struct is in its type.
                if !matches!(head & 15, 1 | 2) {
                    self.value(head & 15, depth)?;
                }
            },
            13 => self.skip(16),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(footer: &[u8]) -> Vec<u8> {
        [b"PAR1", footer, &(footer.len() as u32).to_le_bytes(), b"PAR1"].concat()
    }

    #[test]
    fn lists_are_no_longer_than_their_bytes() {
        assert!(is_bounded(&file(&[0])), "an empty struct");
        assert!(is_bounded(&file(&[0x19, 0x31, 1, 2, 1, 0])), "three flags");
        assert!(!is_bounded(&file(&[0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 7, 1, 1, 0])), "billions of flags");
        assert!(!is_bounded(&file(&[0x1c; 100])), "deep structs");
        assert!(!is_bounded(&file(&[0x18, 9, 1, 0])), "a word that is cut short");
        assert!(is_bounded(b"PAR1") && is_bounded(&[255; 20]), "the library says what is wrong");
    }
}
