//! Reads chunks whose records are known, from a finished or an unfinished file. Checks everything that it reads.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};

use super::chunk_header::{CHUNK_HEADER_LEN, ChunkHeader, ChunkRecord, ENCODING_STORED, ENCODING_ZSTD, HeaderFault};
use super::encoding::decompress;
use super::source::{FileSource, Source};
use super::tile::{ColumnInfo, TileDirectory};
use super::wire::Mismatch;
use crate::error::{Checked, Error, Fault, Place, Result, Unknown, check_limit};
use crate::id::ChunkKind;
use crate::limits::Limits;

/// First step of memory growth when reading, in bytes; each further step at most doubles what has arrived.
const STEP: usize = 64 << 10;

/// A tile read as a whole.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct TilePayload {
    /// Its columns.
    pub directory: TileDirectory,
    bytes: Vec<u8>,
}

impl TilePayload {
    /// The coded bytes of the column with this id.
    pub fn column(&self, id: u8) -> Option<(&ColumnInfo, &[u8])> {
        let info = self.directory.column(id)?;
        let start = usize::try_from(info.offset).ok()?;
        let end = start.checked_add(usize::try_from(info.packed_len).ok()?)?;
        Some((info, self.bytes.get(start..end)?))
    }
}

/// A source of bytes with the name and the limits that go with it.
#[derive(Debug)]
pub(crate) struct ChunkFile {
    source: Box<dyn Source>,
    path: PathBuf,
    /// Length when it was opened, in bytes.
    len: u64,
    limits: Limits,
}

impl ChunkFile {
    pub(crate) fn open(path: &Path, limits: Limits) -> Result<Self> {
        let refused = |error| Error::io(path, "open", error);
        // Opening a pipe would wait for somebody to write into it.
        let kind = std::fs::metadata(path).map_err(refused)?.file_type();
        if !kind.is_file() && !kind.is_dir() {
            let why = "it is no plain file but a pipe, a device or a socket; save it as a file first";
            return Err(refused(io::Error::new(io::ErrorKind::InvalidInput, why)));
        }
        let file = File::open(path).map_err(refused)?;
        Self::new(Box::new(FileSource::new(file)), path, limits)
    }

    pub(crate) fn new(source: Box<dyn Source>, path: &Path, limits: Limits) -> Result<Self> {
        let len = source.size().map_err(|error| Error::io(path, "read the length of", error))?;
        Ok(Self { source, path: path.to_path_buf(), len, limits })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn len(&self) -> u64 {
        self.len
    }

    pub(crate) fn limits(&self) -> &Limits {
        &self.limits
    }

    pub(crate) fn place(&self, offset: u64) -> Place {
        Place::new(&self.path, offset)
    }

    /// Tells the source that these bytes will be read next, as far as the file has them.
    pub(crate) fn announce(&self, offset: u64, len: u64) -> Result<()> {
        let len = len.min(self.len.saturating_sub(offset));
        self.source.announce(offset, len).map_err(|error| Error::io(&self.path, "read", error))
    }

    /// Tells the source where the chunks lie.
    pub(crate) fn layout(&self, chunks: &[ChunkRecord]) {
        self.source.layout(chunks);
    }

    /// Fills as much of `buffer` as the file has from `offset` on; gives the number of bytes.
    pub(crate) fn fill(&self, offset: u64, buffer: &mut [u8]) -> Result<usize> {
        let mut filled = 0;
        while filled < buffer.len() {
            match self.source.read_at(offset.saturating_add(filled as u64), &mut buffer[filled..]) {
                Ok(0) => break,
                // A source that claims more than was asked for is held to what was asked for.
                Ok(count) => filled = filled.saturating_add(count).min(buffer.len()),
                Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                Err(error) => return Err(Error::io(&self.path, "read", error)),
            }
        }
        Ok(filled)
    }

    /// What `read` gives, which reads and checks `len` bytes from `offset`. Where they do not hold and came from far away, they are
    /// fetched once more: an answer may have been corrupted on its way, and must not stay in a cache.
    pub(crate) fn twice<T>(&self, offset: u64, len: u64, read: impl Fn() -> Result<T>) -> Result<T> {
        let wrong = |error: &Error| matches!(error, Error::Damaged { .. } | Error::Unsupported { .. });
        let error = match read() {
            Err(error) if wrong(&error) => error,
            other => return other,
        };
        if self.source.distrust(offset, len).is_none() {
            return Err(error);
        }
        read().map_err(|again| match again {
            Error::Damaged { place, fault } => {
                let fetched = self.source.distrust(offset, len).unwrap_or_default();
                Error::Damaged { place, fault: Fault::Again { fault: Box::new(fault), fetched } }
            }
            other => other,
        })
    }

    /// Exactly `len` bytes from `offset`. Memory grows in steps with the bytes that arrive.
    pub(crate) fn bytes(&self, offset: u64, len: u64) -> Result<Vec<u8>> {
        let truncated = |available| Error::damaged(self.place(offset), Fault::Truncated { needed: len, available });
        let available = self.len.saturating_sub(offset);
        if len > available {
            return Err(truncated(available));
        }
        self.announce(offset, len)?;
        let len = usize::try_from(len).map_err(|_| truncated(available))?;
        let mut bytes = Vec::new();
        while bytes.len() < len {
            let start = bytes.len();
            let step = (len - start).min(start.max(STEP));
            let out_of_memory = |_| Error::io(&self.path, "hold", io::ErrorKind::OutOfMemory.into());
            bytes.try_reserve_exact(step).map_err(out_of_memory)?;
            bytes.resize(start + step, 0);
            let filled = self.fill(offset + start as u64, &mut bytes[start..])?;
            if filled < step {
                return Err(truncated((start + filled) as u64));
            }
        }
        Ok(bytes)
    }

    /// Reads the header of a chunk and the first `len` bytes of its payload in one go, and checks the header against
    /// the record. Gives the payload bytes.
    fn header_and(&self, record: &ChunkRecord, len: u64) -> Result<Vec<u8>> {
        let place = self.place(record.offset).of(record.id);
        if record.end() > self.len {
            let available = self.len.saturating_sub(record.offset);
            return Err(Error::damaged(place, Fault::Truncated { needed: record.total_len(), available }));
        }
        let mut bytes = self.bytes(record.offset, CHUNK_HEADER_LEN.saturating_add(len)).map_err(|e| e.at(&place))?;
        match ChunkHeader::parse(&bytes) {
            Ok(header) if header == record.header() => {}
            Ok(_) => {
                return Err(Error::corrupt(place, "the header of this chunk is not what the index says"));
            }
            Err(HeaderFault::NoMarker) => {
                return Err(Error::corrupt(place, "no chunk starts here"));
            }
            Err(HeaderFault::Checksum(bad)) => {
                return Err(mismatch(place, Checked::ChunkHeader, bad));
            }
        }
        bytes.drain(..CHUNK_HEADER_LEN as usize);
        Ok(bytes)
    }

    /// The payload of a chunk as it lies in the file, checked.
    pub(crate) fn packed(&self, record: &ChunkRecord) -> Result<Vec<u8>> {
        self.twice(record.offset, record.total_len(), || self.packed_once(record))
    }

    fn packed_once(&self, record: &ChunkRecord) -> Result<Vec<u8>> {
        let place = self.place(record.offset).of(record.id);
        check_limit("packed length of a chunk in bytes", record.packed_len, self.limits.max_chunk_packed_bytes)
            .map_err(|error| error.at(&place))?;
        let packed = self.header_and(record, record.packed_len)?;
        let part = if record.id.kind == ChunkKind::INDX { Checked::Index } else { Checked::Payload };
        check_crc(&packed, record.payload_crc, part, place)?;
        Ok(packed)
    }

    /// The payload of a chunk, checked and unpacked, of at most `raw_len_max` bytes.
    pub(crate) fn read(&self, record: &ChunkRecord, raw_len_max: u64) -> Result<Vec<u8>> {
        let place = self.place(record.offset).of(record.id);
        check_limit("raw length of a chunk in bytes", record.raw_len, raw_len_max).map_err(|e| e.at(&place))?;
        let stored = match record.encoding {
            ENCODING_STORED => true,
            ENCODING_ZSTD => false,
            encoding => return Err(Error::unknown(place, Unknown::Encoding(encoding))),
        };
        if stored && record.raw_len != record.packed_len {
            return Err(Error::corrupt(place, "a stored chunk has two different lengths"));
        }
        if !stored {
            let earned = Limits::unpacked_max(record.packed_len);
            check_limit("raw length of a chunk in bytes", record.raw_len, earned).map_err(|e| e.at(&place))?;
        }
        let packed = self.packed(record)?;
        if stored { Ok(packed) } else { decompress(&packed, record.raw_len).map_err(|e| Error::corrupt(place, e)) }
    }

    /// The directory of a tile; reads nothing else of it but its header.
    pub(crate) fn tile_directory(&self, record: &ChunkRecord) -> Result<TileDirectory> {
        self.twice(record.offset, record.total_len(), || self.tile_directory_once(record))
    }

    fn tile_directory_once(&self, record: &ChunkRecord) -> Result<TileDirectory> {
        self.require_tile(record)?;
        let place = self.payload_place(record);
        let directory = self.header_and(record, u64::from(record.directory_len).min(record.packed_len))?;
        let parsed = TileDirectory::parse(&directory, record.packed_len, &place, &self.limits)?;
        self.check_directory_len(record, &parsed)?;
        Ok(parsed)
    }

    /// A tile as a whole, in one read.
    pub(crate) fn read_tile(&self, record: &ChunkRecord) -> Result<TilePayload> {
        self.require_tile(record)?;
        let bytes = self.read(record, self.limits.max_chunk_raw_bytes)?;
        let directory = TileDirectory::parse(&bytes, record.packed_len, &self.payload_place(record), &self.limits)?;
        self.check_directory_len(record, &directory)?;
        Ok(TilePayload { directory, bytes })
    }

    /// The coded bytes of one column; reads nothing else.
    pub(crate) fn read_column(
        &self,
        record: &ChunkRecord,
        directory: &TileDirectory,
        id: u8,
    ) -> Result<Option<Vec<u8>>> {
        let Some(column) = directory.column(id) else {
            return Ok(None);
        };
        let start = record.offset.saturating_add(CHUNK_HEADER_LEN).saturating_add(column.offset);
        let place = self.place(start).of(record.id);
        check_limit("packed length of a column in bytes", column.packed_len, self.limits.max_chunk_packed_bytes)
            .map_err(|error| error.at(&place))?;
        if column.offset.checked_add(column.packed_len).is_none_or(|end| end > record.packed_len) {
            return Err(Error::usage(format!("this directory is not that of the {}", record.id)));
        }
        self.twice(start, column.packed_len, || {
            let packed = self.bytes(start, column.packed_len).map_err(|error| error.at(&place))?;
            check_crc(&packed, column.crc, Checked::Column(id), place.clone())?;
            Ok(Some(packed))
        })
    }

    /// Tells the source that these columns of a tile will be read next, one by one.
    pub(crate) fn announce_columns(&self, record: &ChunkRecord, directory: &TileDirectory, ids: &[u8]) -> Result<()> {
        let wanted = || directory.columns().iter().filter(|column| ids.contains(&column.id));
        let start = wanted().map(|column| column.offset).min().unwrap_or(0);
        let end = wanted().map(|column| column.offset.saturating_add(column.packed_len)).max().unwrap_or(0);
        if end > record.packed_len || end - start > self.limits.max_chunk_packed_bytes {
            return Ok(()); // reading them will say what is wrong
        }
        self.announce(record.offset.saturating_add(CHUNK_HEADER_LEN).saturating_add(start), end - start)
    }

    fn payload_place(&self, record: &ChunkRecord) -> Place {
        self.place(record.offset.saturating_add(CHUNK_HEADER_LEN)).of(record.id)
    }

    fn require_tile(&self, record: &ChunkRecord) -> Result<()> {
        if record.id.kind != ChunkKind::TILE {
            return Err(Error::usage(format!("a {} has no columns", record.id)));
        }
        if record.encoding != ENCODING_STORED {
            let place = self.place(record.offset).of(record.id);
            return Err(Error::unknown(place, Unknown::Encoding(record.encoding)));
        }
        Ok(())
    }

    fn check_directory_len(&self, record: &ChunkRecord, directory: &TileDirectory) -> Result<()> {
        if directory.file_len() == record.directory_len {
            return Ok(());
        }
        let detail = "the column directory is not as long as the index says";
        Err(Error::corrupt(self.payload_place(record), detail))
    }
}

fn check_crc(bytes: &[u8], stored: u32, part: Checked, place: Place) -> Result<()> {
    let computed = crc32fast::hash(bytes);
    if stored == computed { Ok(()) } else { Err(mismatch(place, part, Mismatch { stored, computed })) }
}

pub(crate) fn mismatch(place: Place, part: Checked, Mismatch { stored, computed }: Mismatch) -> Error {
    Error::damaged(place, Fault::Checksum { part, stored, computed })
}
