//! The first 32 bytes of a file. Their meaning is the same in every version, so that every version can be told apart.

use std::path::Path;

use super::wire::{Fields, push_crc, split_crc};
use crate::error::{Checked, Error, Fault, Place, Result, Unknown};
use crate::id::FormatVersion;

/// Not ASCII, with both kinds of line ending: a transfer in text mode breaks it at once.
pub const MAGIC: [u8; 8] = *b"\x89RRT\r\n\x1a\n";

/// Bytes of the file header in this version.
pub(crate) const FILE_HEADER_LEN: usize = 32;

/// Longest header that a newer minor version may have, in bytes.
const FILE_HEADER_LEN_MAX: u32 = 4096;

/// What the file header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileHeader {
    pub(crate) version: FormatVersion,
    /// Offset of the first chunk.
    pub(crate) len: u64,
}

impl FileHeader {
    /// The header that this build writes in front of a file of `version`.
    pub(crate) fn encode(version: FormatVersion) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(FILE_HEADER_LEN);
        bytes.extend_from_slice(&MAGIC);
        bytes.extend_from_slice(&version.major.to_le_bytes());
        bytes.extend_from_slice(&version.minor.to_le_bytes());
        bytes.extend_from_slice(&(FILE_HEADER_LEN as u32).to_le_bytes());
        bytes.extend_from_slice(&[0; 12]);
        push_crc(&mut bytes);
        bytes
    }

    /// Reads the header from the first bytes of a file; more than 32 are not looked at.
    pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<Self> {
        let known = bytes.len().min(MAGIC.len());
        if bytes[..known] != MAGIC[..known] || bytes.is_empty() {
            return Err(not_a_trace(path));
        }
        let Some(bytes) = bytes.get(..FILE_HEADER_LEN) else {
            let (needed, available) = (FILE_HEADER_LEN as u64, bytes.len() as u64);
            return Err(Error::damaged(Place::new(path, 0), Fault::Truncated { needed, available }));
        };
        let body = match split_crc(bytes) {
            Some(Ok(body)) => body,
            Some(Err(bad)) => {
                let (stored, computed, part) = (bad.stored, bad.computed, Checked::FileHeader);
                return Err(Error::damaged(Place::new(path, 0), Fault::Checksum { part, stored, computed }));
            }
            None => {
                return Err(not_a_trace(path));
            }
        };
        Self::parse_body(&body[MAGIC.len()..], path).unwrap_or_else(|| Err(not_a_trace(path)))
    }

    /// The fields after the magic; `None` if there are too few bytes.
    fn parse_body(body: &[u8], path: &Path) -> Option<Result<Self>> {
        let mut fields = Fields(body);
        let version = FormatVersion { major: fields.u16()?, minor: fields.u16()? };
        let len = fields.u32()?;
        let known = FormatVersion::CURRENT;
        if version.major != known.major {
            return Some(Err(Error::unknown(Place::new(path, 0), Unknown::Version { found: version, known })));
        }
        let len_max = match version.minor > known.minor {
            true => FILE_HEADER_LEN_MAX,
            false => FILE_HEADER_LEN as u32,
        };
        if !(FILE_HEADER_LEN as u32..=len_max).contains(&len) {
            let detail = format!("the file header claims to be {len} bytes long");
            return Some(Err(Error::corrupt(Place::new(path, 12), detail)));
        }
        Some(Ok(Self { version, len: u64::from(len) }))
    }
}

/// The file does not start as a trace does.
pub(crate) fn not_a_trace(path: &Path) -> Error {
    Error::unknown(Place::new(path, 0), Unknown::File)
}
