//! Little-endian fields of a byte slice, read in order. Running out of bytes is a value, never a panic.

/// The bytes not read yet.
pub(crate) struct Fields<'a>(pub(crate) &'a [u8]);

impl Fields<'_> {
    /// The next `N` bytes.
    pub(crate) fn bytes<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (head, rest) = self.0.split_first_chunk::<N>()?;
        self.0 = rest;
        Some(*head)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.bytes::<1>().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.bytes().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.bytes().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.bytes().map(u64::from_le_bytes)
    }
}

/// A checksum that does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Mismatch {
    pub(crate) stored: u32,
    pub(crate) computed: u32,
}

/// Splits `bytes` into what comes before a final CRC-32 and checks it. `None` if there are fewer than four bytes.
pub(crate) fn split_crc(bytes: &[u8]) -> Option<Result<&[u8], Mismatch>> {
    let (body, stored) = bytes.split_last_chunk::<4>()?;
    let stored = u32::from_le_bytes(*stored);
    let computed = crc32fast::hash(body);
    Some(if stored == computed { Ok(body) } else { Err(Mismatch { stored, computed }) })
}

/// Appends the CRC-32 of everything in `bytes` to it.
pub(crate) fn push_crc(bytes: &mut Vec<u8>) {
    let crc = crc32fast::hash(bytes);
    bytes.extend_from_slice(&crc.to_le_bytes());
}
