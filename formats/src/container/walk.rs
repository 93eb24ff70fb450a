//! Judges what lies at an offset of a file whose index is missing or not trusted.

use super::chunk_file::ChunkFile;
use super::chunk_header::{CHUNK_HEADER_LEN, ChunkHeader, ChunkRecord, ENCODING_STORED, SYNC};
use super::tile::{DIRECTORY_LEN_MAX, TileDirectory};
use crate::error::{Error, Result, check_limit};
use crate::id::{ChunkId, ChunkKind};

/// Bytes read at a time: memory does not depend on the length of a payload.
pub(crate) const STEP: usize = 256 << 10;

/// What lies at an offset.
#[derive(Debug)]
pub(crate) enum Verdict {
    /// A chunk that is whole, with its directory if it is a tile.
    Whole(ChunkRecord, Option<TileDirectory>),
    /// A header that is whole, before a payload that is not.
    Torn {
        /// What the header names.
        id: ChunkId,
        /// Where the payload would end.
        end: u64,
        /// Bytes of payload read to find out.
        cost: u64,
    },
    /// No chunk header.
    Nothing,
}

/// Judges the bytes at `offset` by header, checksums and, for tiles, the column directory.
///
/// Fails only if the file cannot be read, or if a whole header asks for more than the limits allow: such a chunk is not
/// damaged, and dropping it silently would be wrong.
pub(crate) fn judge(file: &ChunkFile, offset: u64, buffer: &mut Vec<u8>) -> Result<Verdict> {
    let mut bytes = [0; CHUNK_HEADER_LEN as usize];
    let filled = file.fill(offset, &mut bytes)?;
    let Ok(header) = ChunkHeader::parse(&bytes[..filled]) else {
        return Ok(Verdict::Nothing);
    };
    let end = offset.saturating_add(CHUNK_HEADER_LEN).saturating_add(header.packed_len);
    let torn = |cost| Ok(Verdict::Torn { id: header.id, end, cost });
    if end > file.len() || !is_consistent(&header) {
        return torn(0);
    }
    let place = file.place(offset).of(header.id);
    check_limit("packed length of a chunk in bytes", header.packed_len, file.limits().max_chunk_packed_bytes)
        .map_err(|error| error.at(&place))?;
    if payload_crc(file, offset + CHUNK_HEADER_LEN, header.packed_len, buffer)? != Some(header.payload_crc) {
        return torn(header.packed_len);
    }
    if header.id.kind != ChunkKind::TILE {
        return Ok(Verdict::Whole(header.record(offset, 0), None));
    }
    let start = file.bytes(offset + CHUNK_HEADER_LEN, header.packed_len.min(DIRECTORY_LEN_MAX))?;
    match TileDirectory::parse(&start, header.packed_len, &place, file.limits()) {
        Ok(directory) => Ok(Verdict::Whole(header.record(offset, directory.file_len()), Some(directory))),
        Err(error @ Error::LimitExceeded { .. }) => Err(error),
        Err(_) => torn(header.packed_len),
    }
}

/// Whether a reader would accept the header's fields together.
fn is_consistent(header: &ChunkHeader) -> bool {
    let lengths = header.encoding != ENCODING_STORED || header.raw_len == header.packed_len;
    let tile = header.id.kind != ChunkKind::TILE || header.encoding == ENCODING_STORED;
    header.id.is_well_formed() && lengths && tile
}

/// The CRC-32 of `len` bytes from `offset`; `None` if the file ends before.
fn payload_crc(file: &ChunkFile, offset: u64, len: u64, buffer: &mut Vec<u8>) -> Result<Option<u32>> {
    buffer.resize(STEP, 0);
    let mut hasher = crc32fast::Hasher::new();
    let mut done = 0;
    while done < len {
        let step = usize::try_from(len - done).unwrap_or(STEP).min(STEP);
        if file.fill(offset + done, &mut buffer[..step])? < step {
            return Ok(None);
        }
        hasher.update(&buffer[..step]);
        done += step as u64;
    }
    Ok(Some(hasher.finalize()))
}

/// Offset of the first whole chunk header at or after `from`.
pub(crate) fn find_header(file: &ChunkFile, mut from: u64, buffer: &mut Vec<u8>) -> Result<Option<u64>> {
    const HEADER: usize = CHUNK_HEADER_LEN as usize;
    buffer.resize(STEP, 0);
    // Starts small: a file of nothing but damaged chunks asks for many short searches.
    let mut step = 1 << 10;
    loop {
        let filled = file.fill(from, &mut buffer[..step])?;
        let window = &buffer[..filled];
        let at = (0..filled.saturating_sub(HEADER - 1))
            .find(|&at| window[at] == SYNC[0] && ChunkHeader::parse(&window[at..]).is_ok());
        if let Some(at) = at {
            return Ok(Some(from + at as u64));
        }
        if filled < step {
            return Ok(None);
        }
        // A header may straddle two windows.
        from += (step - (HEADER - 1)) as u64;
        step = (step * 2).min(STEP);
    }
}
