//! Random access to a finished file through its index.

use std::path::Path;

use super::chunk_file::{ChunkFile, TilePayload, mismatch};
use super::chunk_header::{CHUNK_HEADER_LEN, ChunkHeader, ChunkRecord, ENCODING_ZSTD, HeaderFault};
use super::file_header::{FILE_HEADER_LEN, FileHeader};
use super::index::{ColumnTotals, Index};
use super::source::{MemorySource, Source};
use super::tile::TileDirectory;
use super::trailer::{TRAILER_LEN, Trailer, TrailerFault};
use crate::error::{Checked, Error, Missing, Result, check_limit};
use crate::id::{ChunkId, ChunkKind, FormatVersion};
use crate::limits::Limits;

/// What [`Reader::path`] gives for bytes in memory.
const MEMORY: &str = "<memory>";

/// A finished trace file. Share it between threads: every read has its own position.
///
/// Opening reads the file header, the trailer and the index, nothing else.
#[derive(Debug)]
pub struct Reader {
    file: ChunkFile,
    version: FormatVersion,
    index: Index,
    /// Positions in `index.chunks`, sorted by id, then position.
    by_id: Vec<u32>,
}

impl Reader {
    /// Opens a file.
    ///
    /// # Errors
    /// [`Error::Incomplete`] for an unfinished file; [`Error::Unsupported`], [`Error::Damaged`],
    /// [`Error::LimitExceeded`], [`Error::Io`].
    pub fn open(path: &Path, limits: Limits) -> Result<Self> {
        Self::from_file(ChunkFile::open(path, limits)?)
    }

    /// Opens bytes in memory.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn from_bytes(bytes: Vec<u8>, limits: Limits) -> Result<Self> {
        Self::from_source(Box::new(MemorySource(bytes)), Path::new(MEMORY), limits)
    }

    /// Opens any source; `path` names it in errors.
    ///
    /// # Errors
    /// As [`Reader::open`].
    pub fn from_source(source: Box<dyn Source>, path: &Path, limits: Limits) -> Result<Self> {
        Self::from_file(ChunkFile::new(source, path, limits)?)
    }

    fn from_file(file: ChunkFile) -> Result<Self> {
        let (version, index, by_id) = file.twice(0, file.len(), || Self::contents(&file))?;
        file.layout(&index.chunks);
        Ok(Self { file, version, index, by_id })
    }

    /// The version, the index, and the order of its chunks by id.
    fn contents(file: &ChunkFile) -> Result<(FormatVersion, Index, Vec<u32>)> {
        let header = read_file_header(file)?;
        let (trailer, trailer_offset) = read_trailer(file)?;
        let record = index_record(file, &header, &trailer, trailer_offset)?;
        let place = file.place(record.offset);
        let raw = file.read(&record, Index::raw_len_max(trailer.chunks))?;
        let index = Index::parse(&raw).map_err(|detail| Error::corrupt(place.clone(), detail))?;
        if index.chunks.len() as u64 != trailer.chunks {
            return Err(Error::corrupt(place, "index and trailer count different numbers of chunks"));
        }
        index
            .check_layout(header.len, trailer.index_offset)
            .map_err(|(offset, id, detail)| Error::corrupt(file.place(offset).of(id), detail))?;
        let by_id = sorted_by_id(file, &index.chunks)?;
        Ok((header.version, index, by_id))
    }

    /// Version of the format the file was written in; its minor version may be newer than this build.
    pub fn version(&self) -> FormatVersion {
        self.version
    }

    /// Length of the file in bytes.
    #[expect(clippy::len_without_is_empty, reason = "a trace is never empty: it has a header and a trailer")]
    pub fn len(&self) -> u64 {
        self.file.len()
    }

    /// The file, or `<memory>`.
    pub fn path(&self) -> &Path {
        self.file.path()
    }

    /// The limits the file was opened with.
    pub fn limits(&self) -> &Limits {
        self.file.limits()
    }

    /// All chunks but the index, in file order, those of unknown kinds among them.
    pub fn chunks(&self) -> &[ChunkRecord] {
        &self.index.chunks
    }

    /// What each column takes in the whole file, ascending by id.
    pub fn column_totals(&self) -> &[ColumnTotals] {
        &self.index.totals
    }

    /// The chunk with this id, in O(log n). The first in the file, if its kind is unknown and there are several.
    pub fn find(&self, id: ChunkId) -> Option<&ChunkRecord> {
        let at = self.by_id.partition_point(|&at| self.index.chunks[at as usize].id < id);
        let record = self.index.chunks.get(*self.by_id.get(at)? as usize)?;
        (record.id == id).then_some(record)
    }

    /// The chunk with this id.
    ///
    /// # Errors
    /// [`Error::Incomplete`].
    pub fn require(&self, id: ChunkId) -> Result<&ChunkRecord> {
        self.find(id).ok_or_else(|| Error::missing(self.path(), id))
    }

    /// The payload of a chunk, unpacked. Header, checksum and length are checked.
    ///
    /// # Errors
    /// [`Error::Damaged`], also if the file or the record is not what it was; [`Error::Unsupported`],
    /// [`Error::LimitExceeded`], [`Error::Io`].
    pub fn read(&self, record: &ChunkRecord) -> Result<Vec<u8>> {
        self.file.read(record, self.limits().max_chunk_raw_bytes)
    }

    /// The columns of a tile; reads only its header and directory.
    ///
    /// # Errors
    /// As [`Reader::read`]; [`Error::Usage`] if the chunk is not a tile.
    pub fn tile_directory(&self, record: &ChunkRecord) -> Result<TileDirectory> {
        self.file.tile_directory(record)
    }

    /// The coded bytes of one column of a tile, if the tile has it; reads only these and checks them.
    ///
    /// # Errors
    /// As [`Reader::read`]; [`Error::Usage`] if the directory is not that of the tile.
    pub fn read_column(&self, record: &ChunkRecord, directory: &TileDirectory, id: u8) -> Result<Option<Vec<u8>>> {
        self.file.read_column(record, directory, id)
    }

    /// Says that these columns of a tile will be read next: from far away they then come in one request, with those
    /// between them. Needless for a local file.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn announce_columns(&self, record: &ChunkRecord, directory: &TileDirectory, ids: &[u8]) -> Result<()> {
        self.file.announce_columns(record, directory, ids)
    }

    /// A tile with all its columns in one read: cheaper than column by column if most of them are wanted.
    ///
    /// # Errors
    /// As [`Reader::tile_directory`].
    pub fn read_tile(&self, record: &ChunkRecord) -> Result<TilePayload> {
        self.file.read_tile(record)
    }
}

/// Reads the file header; works on unfinished files too.
pub(crate) fn read_file_header(file: &ChunkFile) -> Result<FileHeader> {
    let mut bytes = [0; FILE_HEADER_LEN];
    let filled = file.fill(0, &mut bytes)?;
    FileHeader::parse(&bytes[..filled], file.path())
}

/// The trailer and its offset. A file without one was not finished, or lost its end.
fn read_trailer(file: &ChunkFile) -> Result<(Trailer, u64)> {
    let missing = || Error::Incomplete { path: file.path().to_path_buf(), missing: Missing::Index };
    let offset = file.len().checked_sub(TRAILER_LEN as u64).ok_or_else(missing)?;
    let mut bytes = [0; TRAILER_LEN];
    if file.fill(offset, &mut bytes)? < TRAILER_LEN {
        return Err(missing());
    }
    match Trailer::parse(&bytes) {
        Ok(trailer) => Ok((trailer, offset)),
        Err(TrailerFault::NoMagic) => Err(missing()),
        Err(TrailerFault::Checksum(bad)) => Err(mismatch(file.place(offset), Checked::Trailer, bad)),
    }
}

/// The record of the index, after checks that bound the memory it can take: every chunk it lists has a header in the
/// file.
fn index_record(file: &ChunkFile, header: &FileHeader, trailer: &Trailer, trailer_offset: u64) -> Result<ChunkRecord> {
    let corrupt = |detail: &str| Error::corrupt(file.place(trailer_offset), detail);
    if trailer.index_offset < header.len || trailer.index_offset.checked_add(trailer.index_len) != Some(trailer_offset)
    {
        return Err(corrupt(
            "the trailer does not point at an index that ends where the trailer starts: bytes were lost or added; recover with `rayreel repair`",
        ));
    }
    if trailer.chunks > (trailer.index_offset - header.len) / CHUNK_HEADER_LEN {
        return Err(corrupt("the trailer counts more chunks than the file has room for"));
    }
    check_limit("number of chunks", trailer.chunks, file.limits().max_index_entries)
        .map_err(|error| error.at(&file.place(trailer_offset)))?;
    let place = file.place(trailer.index_offset);
    let mut bytes = [0; CHUNK_HEADER_LEN as usize];
    let filled = file.fill(trailer.index_offset, &mut bytes)?;
    let index = match ChunkHeader::parse(&bytes[..filled]) {
        Ok(index) => index,
        Err(HeaderFault::NoMarker) => {
            return Err(Error::corrupt(place, "the trailer does not point at a chunk"));
        }
        Err(HeaderFault::Checksum(bad)) => return Err(mismatch(place, Checked::ChunkHeader, bad)),
    };
    let record = index.record(trailer.index_offset, 0);
    if index.id != ChunkId::INDX || index.encoding != ENCODING_ZSTD || record.total_len() != trailer.index_len {
        return Err(Error::corrupt(place, "the chunk that the trailer points at is not the index it describes"));
    }
    Ok(record)
}

/// Positions sorted by id; refuses two chunks of the same known id.
fn sorted_by_id(file: &ChunkFile, chunks: &[ChunkRecord]) -> Result<Vec<u32>> {
    let count = u32::try_from(chunks.len())
        .map_err(|_| Error::limit("number of chunks", chunks.len() as u64, u64::from(u32::MAX)))?;
    let mut by_id: Vec<u32> = (0..count).collect();
    by_id.sort_unstable_by_key(|&at| (chunks[at as usize].id, at));
    for pair in by_id.windows(2) {
        let (first, second) = (&chunks[pair[0] as usize], &chunks[pair[1] as usize]);
        if first.id == second.id && ChunkKind::is_known(first.id.kind) {
            let detail = format!("second {}, the first is at byte {}", second.id, first.offset);
            return Err(Error::corrupt(file.place(second.offset).of(second.id), detail));
        }
    }
    Ok(by_id)
}
