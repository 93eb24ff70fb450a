//! Continues a capture that was cut short: keeps the whole chunks of `NAME.partial` and drops what follows them.

use std::collections::HashSet;
use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom};
use std::path::{Path, PathBuf};

use super::chunk_file::{ChunkFile, TilePayload};
use super::chunk_header::ChunkRecord;
use super::file_header::FILE_HEADER_LEN;
use super::index::Index;
use super::reader::read_file_header;
use super::scan::scan;
use super::tile::TileDirectory;
use super::walk::{Verdict, judge};
use super::writer::{BUFFER_LEN, Writer, behind, is_still, lock, partial_path};
use crate::error::{Error, Fault, Result, Unknown, check_limit};
use crate::id::{ChunkId, ChunkKind, FormatVersion};
use crate::limits::Limits;

/// An unfinished file that can be read and continued.
///
/// Whether it is the same capture is for the caller to say: compare the `META` payload before writing on. Until
/// [`Resumed::go_on`] not a byte of the file changes.
#[derive(Debug)]
pub struct Resumed {
    /// Open for writing, and locked.
    out: File,
    partial: PathBuf,
    path: PathBuf,
    /// Its whole chunks.
    index: Index,
    ids: HashSet<ChunkId>,
    /// Where they end; 0 if not even the file header is whole.
    end: u64,
    file: ChunkFile,
}

impl Resumed {
    /// The whole chunks, in file order.
    pub fn chunks(&self) -> &[ChunkRecord] {
        &self.index.chunks
    }

    /// Bytes of the file header and the whole chunks.
    pub fn kept_bytes(&self) -> u64 {
        self.end
    }

    /// Bytes behind them, which are no whole chunk or an index that is written anew: [`Resumed::go_on`] cuts them off.
    pub fn dropped_bytes(&self) -> u64 {
        self.file.len() - self.end
    }

    /// Whole tiles in the file, those behind damage too.
    ///
    /// # Errors
    /// Those of [`scan`].
    pub fn tiles_in_file(&self) -> Result<u64> {
        if self.end == 0 {
            // Not even a whole header.
            return Ok(0);
        }
        let tiles = |chunks: &[ChunkRecord]| chunks.iter().filter(|record| record.id.kind == ChunkKind::TILE).count();
        Ok(tiles(&scan(&self.partial, self.file.limits())?.chunks) as u64)
    }

    /// Whole tiles among the bytes that are cut off: a killed process leaves none there.
    ///
    /// # Errors
    /// As [`Resumed::tiles_in_file`].
    pub fn dropped_tiles(&self) -> Result<u64> {
        let kept = self.chunks().iter().filter(|record| record.id.kind == ChunkKind::TILE).count();
        Ok(if self.dropped_bytes() > 0 { self.tiles_in_file()?.saturating_sub(kept as u64) } else { 0 })
    }

    /// Continues the file after its last whole chunk.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn go_on(self) -> Result<Writer> {
        let Self { out, partial, path, index, ids, end: offset, .. } = self;
        out.set_len(offset).map_err(|error| Error::io(&partial, "truncate", error))?;
        if offset == 0 {
            return Writer::start(out, partial, path, FormatVersion::CURRENT);
        }
        let mut out = BufWriter::with_capacity(BUFFER_LEN, out);
        out.seek(SeekFrom::Start(offset)).map_err(|error| Error::io(&partial, "seek in", error))?;
        Ok(Writer { out, partial, path, offset, index, ids, broken: false })
    }

    /// The payload of a chunk that was there already, as [`Reader::read`](super::Reader::read).
    ///
    /// # Errors
    /// As there.
    pub fn read(&self, record: &ChunkRecord) -> Result<Vec<u8>> {
        self.file.read(record, self.file.limits().max_chunk_raw_bytes)
    }

    /// A tile that was there already, as [`Reader::read_tile`](super::Reader::read_tile).
    ///
    /// # Errors
    /// As there.
    pub fn read_tile(&self, record: &ChunkRecord) -> Result<TilePayload> {
        self.file.read_tile(record)
    }

    /// The columns of a tile that was there already, as [`Reader::tile_directory`](super::Reader::tile_directory).
    ///
    /// # Errors
    /// As there.
    pub fn tile_directory(&self, record: &ChunkRecord) -> Result<TileDirectory> {
        self.file.tile_directory(record)
    }

    /// One column of a tile that was there already, as [`Reader::read_column`](super::Reader::read_column).
    ///
    /// # Errors
    /// As there.
    pub fn read_column(&self, record: &ChunkRecord, directory: &TileDirectory, id: u8) -> Result<Option<Vec<u8>>> {
        self.file.read_column(record, directory, id)
    }
}

impl Writer {
    /// Opens `NAME.partial` to continue it, if there is one. The first byte that belongs to no whole chunk, and all that
    /// follow it, will be cut off: a killed process leaves only its last chunks torn. (After worse damage,
    /// [`repair`](super::repair()) saves more.)
    ///
    /// The chunks written next give the same file, byte for byte, as if nothing had happened.
    ///
    /// # Errors
    /// [`Error::Occupied`] if another process is writing the file; [`Error::Damaged`] if its header is;
    /// [`Error::Unsupported`] if it is no trace or a newer version began it; [`Error::LimitExceeded`]; [`Error::Io`].
    pub fn resume(path: &Path, limits: &Limits) -> Result<Option<Resumed>> {
        let path = behind(path)?;
        let partial = partial_path(&path)?;
        let out = match OpenOptions::new().read(true).write(true).open(&partial) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
            other => other.map_err(|error| Error::io(&partial, "open", error))?,
        };
        lock(&out, &partial)?;
        if !is_still(&out, &partial) {
            return Ok(None);
        }
        let file = ChunkFile::open(&partial, limits.clone())?;
        let (index, ids, end) =
            if header_is_torn(&file)? { Default::default() } else { whole_chunks(&file, whole_header(&file)?)? };
        Ok(Some(Resumed { out, partial, path, index, ids, end, file }))
    }
}

/// Length of a file header that this version can continue.
fn whole_header(file: &ChunkFile) -> Result<u64> {
    let header = read_file_header(file)?;
    let known = FormatVersion::CURRENT;
    if header.version > known {
        return Err(Error::unknown(file.place(0), Unknown::Version { found: header.version, known }));
    }
    Ok(header.len)
}

/// Whether the process was killed before the whole file header was written: the file is a beginning of it.
pub(super) fn header_is_torn(file: &ChunkFile) -> Result<bool> {
    if file.len() == 0 {
        return Ok(true);
    }
    match read_file_header(file) {
        Err(Error::Damaged { fault: Fault::Truncated { .. }, .. }) if file.len() < FILE_HEADER_LEN as u64 => Ok(true),
        _ => Ok(false),
    }
}

/// The chunks from `offset` up to the first that is not whole, and where that is. The index counts as not whole: it
/// would have to move.
fn whole_chunks(file: &ChunkFile, mut offset: u64) -> Result<(Index, HashSet<ChunkId>, u64)> {
    let (mut index, mut ids, mut buffer) = (Index::default(), HashSet::new(), Vec::new());
    while let Verdict::Whole(record, directory) = judge(file, offset, &mut buffer)? {
        if record.id.kind == ChunkKind::INDX || (!ids.insert(record.id) && record.id.kind.is_known()) {
            break;
        }
        let count = index.chunks.len() as u64 + 1;
        check_limit("number of chunks", count, file.limits().max_index_entries)
            .map_err(|error| error.at(&file.place(offset)))?;
        offset = record.end();
        index.push(record, directory.as_ref());
    }
    Ok((index, ids, offset))
}
