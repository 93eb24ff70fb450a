//! The footer of a Parquet file and the headers of its pages, walked before the library reads them: lists are as long as they say, and
//! what the file unpacks to is earned by its bytes.
//!
//! The library steps over lists of flags in fields that it does not know without reading a byte for each, so a few bytes that claim
//! billions of them keep it busy for ever. Here each element takes a byte, as the compact protocol of Thrift has it.

/// Deepest nesting of a footer or a header.
const DEPTH_MAX: u32 = 32;

/// What a file of so many bytes may unpack to, of whatever: cells of a table, or bytes of its texts. A page of equal values takes a
/// hundred bytes for 16,384 rows.
pub fn earned(bytes: usize) -> u64 {
    (16_u64 << 20).saturating_add((bytes as u64).saturating_mul(256))
}

/// Whether these bytes are pages, one behind the other, whose headers are well-formed; none unpacks to more than it earns.
pub fn are_pages(mut bytes: &[u8]) -> bool {
    while !bytes.is_empty() {
        let mut walk = Walk(bytes);
        let Some([unpacked, packed]) = walk.page_header() else { return false };
        let Some(rest) = walk.0.get(packed..) else { return false };
        if unpacked as u64 > earned(packed) {
            return false;
        }
        bytes = rest;
    }
    true
}

/// Whether the footer of a file is well-formed, or not found: the library says what is wrong then.
pub fn has_footer(file: &[u8]) -> bool {
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

    /// Steps over a page's header; gives how long the page is, unpacked and in the file: fields 2 and 3.
    fn page_header(&mut self) -> Option<[usize; 2]> {
        let (mut lengths, mut field) = ([None; 2], 0_i16);
        loop {
            let head = self.byte()?;
            match head {
                0 => return Some([lengths[0]?, lengths[1]?]),
                _ if head >> 4 == 0 => field = self.number().and_then(|id| i16::try_from(unfold(id)).ok())?,
                _ => field = field.checked_add(i16::from(head >> 4))?,
            }
            match (field, head & 15) {
                (2 | 3, 5) => {
                    let length = usize::try_from(unfold(self.number()?)).ok()?;
                    lengths[field as usize - 2] = Some(length);
                }
                (_, 1 | 2) => {}
                (_, kind) => self.value(kind, DEPTH_MAX)?,
            }
        }
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

/// A signed number, whose lowest bit is its sign.
fn unfold(number: u64) -> i64 {
    (number >> 1) as i64 ^ -((number & 1) as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn file(footer: &[u8]) -> Vec<u8> {
        [b"PAR1", footer, &(footer.len() as u32).to_le_bytes(), b"PAR1"].concat()
    }

    #[test]
    fn lists_are_no_longer_than_their_bytes() {
        assert!(has_footer(&file(&[0])), "an empty struct");
        assert!(has_footer(&file(&[0x19, 0x31, 1, 2, 1, 0])), "three flags");
        assert!(!has_footer(&file(&[0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 7, 1, 1, 0])), "billions of flags");
        assert!(!has_footer(&file(&[0x1c; 100])), "deep structs");
        assert!(!has_footer(&file(&[0x18, 9, 1, 0])), "a word that is cut short");
        assert!(has_footer(b"PAR1") && has_footer(&[255; 20]), "the library says what is wrong");
    }

    #[test]
    fn pages_follow_one_another_and_earn_what_they_unpack_to() {
        // Kind 0, four bytes that are four, then a struct that says what they are.
        let page = [0x15, 0, 0x15, 8, 0x15, 8, 0x2c, 0x15, 2, 0, 0, 1, 2, 3, 4];
        assert!(are_pages(&[]) && are_pages(&page) && are_pages(&page.repeat(3)));
        assert!((1..page.len()).all(|cut| !are_pages(&page[..cut])), "one that is cut short");
        let large = |unpacked: &[u8]| are_pages(&[&[0x15, 0, 0x15], unpacked, &[0x15, 0, 0]].concat());
        assert!(large(&[0x80, 0x80, 0x80, 0x10]), "16 MiB of no byte");
        assert!(!large(&[0x82, 0x80, 0x80, 0x10]), "a byte more");
        assert!(!large(&[1]), "less than nothing");
        let flags = [0x15, 0, 0x15, 0, 0x15, 0, 0x19, 0xf1, 0xff, 0xff, 0xff, 0xff, 7, 1, 1, 0];
        assert!(!are_pages(&[0xf1; 3000]), "more fields than have numbers");
        assert!(!are_pages(&flags), "billions of flags in a field that nobody knows");
    }
}
