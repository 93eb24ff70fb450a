//! Finds the whole chunks of a damaged or unfinished file, without its index.

use std::fmt;
use std::path::Path;

use super::chunk_file::ChunkFile;
use super::chunk_header::{CHUNK_HEADER_LEN, ChunkRecord};
use super::file_header::not_a_trace;
use super::reader::read_file_header;
use super::source::Source;
use super::trailer::{TRAILER_LEN, Trailer};
use super::walk::{Verdict, find_header, judge};
use crate::error::{Error, Result, Unknown, check_limit};
use crate::id::{ChunkId, ChunkKind, FormatVersion};
use crate::limits::Limits;

/// Bytes of a file that belong to no whole chunk.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DamagedRange {
    /// Offset of the first byte.
    pub start: u64,
    /// Offset after the last byte.
    pub end: u64,
    /// Chunks whose headers lie in the range and are whole. There may be others.
    pub chunks: Vec<ChunkId>,
}

impl fmt::Display for DamagedRange {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "bytes {} to {}", self.start, self.end)?;
        for (at, id) in self.chunks.iter().enumerate() {
            write!(f, "{} {id}", if at == 0 { ": the" } else { ", the" })?;
        }
        Ok(())
    }
}

/// What a walk through a file found.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scan {
    /// Length of the file in bytes.
    pub file_len: u64,
    /// Version of the file; `None` if its header is damaged.
    pub version: Option<FormatVersion>,
    /// Whole chunks in file order without the index; duplicates and unknown kinds among them.
    pub chunks: Vec<ChunkRecord>,
    /// What belongs to no whole chunk, in file order, without overlaps.
    pub damaged: Vec<DamagedRange>,
    /// The last whole index chunk.
    pub index: Option<ChunkRecord>,
    /// Whether the file ends in a whole trailer.
    pub has_trailer: bool,
}

impl Scan {
    /// Whether every byte of the file is where it should be. (The index is not compared with the chunks; opening the
    /// file does.)
    pub fn is_whole(&self) -> bool {
        self.damaged.is_empty() && self.version.is_some() && self.index.is_some() && self.has_trailer
    }

    /// Bytes that belong to no whole chunk.
    pub fn damaged_bytes(&self) -> u64 {
        self.damaged.iter().map(|range| range.end - range.start).sum()
    }
}

/// Walks through a file chunk by chunk. Over damage, it looks for the next whole chunk header. Reads every byte, and
/// some twice; time grows with the length of the file whatever it holds.
///
/// # Errors
/// [`Error::Unsupported`] if neither the file header nor any chunk is whole, or for another major version;
/// [`Error::LimitExceeded`] for a whole header that asks for too much; [`Error::Io`]. Damage is not an error.
pub fn scan(path: &Path, limits: &Limits) -> Result<Scan> {
    scan_file(&ChunkFile::open(path, limits.clone())?)
}

/// Walks through any source, as [`scan()`]; `path` names it in errors.
///
/// # Errors
/// As [`scan()`].
pub fn scan_source(source: Box<dyn Source>, path: &Path, limits: &Limits) -> Result<Scan> {
    scan_file(&ChunkFile::new(source, path, limits.clone())?)
}

pub(crate) fn scan_file(file: &ChunkFile) -> Result<Scan> {
    let (version, start) = match read_file_header(file) {
        Ok(header) => (Some(header.version), header.len),
        Err(error @ (Error::Io { .. } | Error::Unsupported { what: Unknown::Version { .. }, .. })) => {
            return Err(error);
        }
        Err(_) => (None, 0),
    };
    let scan = Scan {
        file_len: file.len(),
        version,
        chunks: Vec::new(),
        damaged: Vec::new(),
        index: None,
        has_trailer: false,
    };
    // Payloads that prove damaged are searched for headers, so bytes can be read again and again. Past this many,
    // damaged payloads are skipped whole.
    let budget = file.len().saturating_mul(4);
    let mut walk = FileWalk { file, scan, budget, damage: None, buffer: Vec::new() };
    walk.run(start)?;
    if walk.scan.version.is_none() && walk.scan.chunks.is_empty() {
        return Err(not_a_trace(file.path()));
    }
    Ok(walk.scan)
}

struct FileWalk<'a> {
    file: &'a ChunkFile,
    scan: Scan,
    /// Bytes of damaged payloads that may still be read.
    budget: u64,
    /// The damaged range that is being walked over; its end is not known yet.
    damage: Option<DamagedRange>,
    buffer: Vec<u8>,
}

impl FileWalk<'_> {
    fn run(&mut self, mut offset: u64) -> Result<()> {
        while offset < self.file.len() {
            offset = match judge(self.file, offset, &mut self.buffer)? {
                Verdict::Whole(record, _) => {
                    self.close_damage(offset);
                    self.keep(record)?;
                    record.end()
                }
                Verdict::Torn { id, end, cost } => {
                    self.open_damage(offset).chunks.push(id);
                    match self.budget.checked_sub(cost) {
                        Some(rest) => {
                            self.budget = rest;
                            self.next(offset + CHUNK_HEADER_LEN)?
                        }
                        None => end.min(self.file.len()),
                    }
                }
                Verdict::Nothing if self.trailer_at(offset)? => {
                    self.close_damage(offset);
                    self.scan.has_trailer = true;
                    self.file.len()
                }
                Verdict::Nothing => {
                    self.open_damage(offset);
                    self.next(offset + 1)?
                }
            };
        }
        self.close_damage(self.file.len());
        Ok(())
    }

    fn keep(&mut self, record: ChunkRecord) -> Result<()> {
        if record.id.kind == ChunkKind::INDX {
            self.scan.index = Some(record);
            return Ok(());
        }
        let count = self.scan.chunks.len() as u64 + 1;
        check_limit("number of chunks", count, self.file.limits().max_index_entries)
            .map_err(|error| error.at(&self.file.place(record.offset)))?;
        self.scan.chunks.push(record);
        Ok(())
    }

    /// Where to look on after damage: the next header, else the trailer, else the end of the file.
    fn next(&mut self, from: u64) -> Result<u64> {
        if let Some(found) = find_header(self.file, from, &mut self.buffer)? {
            return Ok(found);
        }
        let trailer = self.file.len().saturating_sub(TRAILER_LEN as u64);
        if trailer >= from && self.trailer_at(trailer)? { Ok(trailer) } else { Ok(self.file.len()) }
    }

    fn trailer_at(&self, offset: u64) -> Result<bool> {
        let mut bytes = [0; TRAILER_LEN];
        let at_end = self.file.len().checked_sub(TRAILER_LEN as u64) == Some(offset);
        Ok(at_end && self.file.fill(offset, &mut bytes)? == TRAILER_LEN && Trailer::parse(&bytes).is_ok())
    }

    fn open_damage(&mut self, start: u64) -> &mut DamagedRange {
        self.damage.get_or_insert_with(|| DamagedRange { start, end: start, chunks: Vec::new() })
    }

    fn close_damage(&mut self, end: u64) {
        if let Some(mut range) = self.damage.take() {
            range.end = end;
            self.scan.damaged.push(range);
        }
    }
}
