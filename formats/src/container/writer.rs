//! Writes a trace as a stream of chunks: first to `NAME.partial`, which becomes `NAME` when it is complete.

use std::collections::HashSet;
use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

use super::chunk_header::ChunkRecord;
use super::encoded::EncodedChunk;
use super::encoding::{Encoding, compress};
use super::file_header::FileHeader;
use super::index::Index;
use super::tile::TileDirectory;
use super::trailer::Trailer;
use crate::durable::{PARTIAL, behind_links, sync_folder_of};
use crate::error::{Error, Occupant, Result};
use crate::id::{ChunkId, FormatVersion};
#[cfg(unix)]
use crate::locks;

/// Level of the index's zstd frame. Fixed, so that the bytes of a file depend on its chunks alone.
const INDEX_ZSTD_LEVEL: i32 = 9;

/// Bytes gathered before the system is asked to write; chunks longer than this are not copied.
pub(super) const BUFFER_LEN: usize = 256 << 10;

/// A complete file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finished {
    /// The file, under its final name.
    pub path: PathBuf,
    /// Its length in bytes.
    pub len: u64,
    /// Its chunks, without the index.
    pub chunks: u64,
}

/// A file being written. Its memory is 100 bytes or so per chunk, whatever the chunks hold.
///
/// Dropping it before [`Writer::finish`] leaves `NAME.partial`, which [`Writer::resume`] continues.
#[derive(Debug)]
pub struct Writer {
    pub(super) out: BufWriter<File>,
    /// The file being written.
    pub(super) partial: PathBuf,
    /// Its name once it is complete.
    pub(super) path: PathBuf,
    /// Offset of the next byte.
    pub(super) offset: u64,
    pub(super) index: Index,
    pub(super) ids: HashSet<ChunkId>,
    /// Set while a write is under way: after one that failed, nobody knows what lies in the file.
    pub(super) broken: bool,
}

impl Writer {
    /// Starts a new file. `path` itself may exist: it is replaced by [`Writer::finish`], and left alone until then. If it is a link,
    /// what it names is replaced, and the unfinished file lies there.
    ///
    /// # Errors
    /// [`Error::Occupied`] if a killed capture left `NAME.partial`; resume it or [`Writer::discard`] it.
    /// [`Error::Io`], among others if the folder does not exist.
    pub fn create(path: &Path) -> Result<Self> {
        let path = behind(path)?;
        let partial = partial_path(&path)?;
        let new = || OpenOptions::new().read(true).write(true).create_new(true).open(&partial);
        let refused = |error: io::Error| match error.kind() {
            io::ErrorKind::AlreadyExists => {
                // While its writer lives, nobody else may continue it, and the error says who that is.
                if let Ok(other) = File::open(&partial)
                    && let Err(alive) = lock(&other, &partial)
                {
                    return alive;
                }
                let hint = "a command that wrote it was cut short: `rayreel capture --resume` goes on with a capture; else delete it";
                Error::occupied(&partial, Occupant::File { hint })
            }
            _ => Error::io(&partial, "create", error),
        };
        let file = open_locked(&partial, || new().map_err(refused))?;
        Self::start(file, partial, path, FormatVersion::CURRENT)
    }

    /// Deletes the `NAME.partial` of a killed capture, if there is one that nobody is writing.
    ///
    /// # Errors
    /// [`Error::Occupied`] if another process is writing it; [`Error::Io`].
    pub fn discard(path: &Path) -> Result<()> {
        let partial = partial_path(path)?;
        let file = match OpenOptions::new().read(true).write(true).open(&partial) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            other => other.map_err(|error| Error::io(&partial, "open", error))?,
        };
        lock(&file, &partial)?;
        if !is_still(&file, &partial) {
            return Ok(());
        }
        fs::remove_file(&partial).map_err(|error| Error::io(&partial, "delete", error))
    }

    /// Writes the file header to an empty file, which the caller has locked.
    pub(super) fn start(file: File, partial: PathBuf, path: PathBuf, version: FormatVersion) -> Result<Self> {
        let out = BufWriter::with_capacity(BUFFER_LEN, file);
        let mut writer =
            Self { out, partial, path, offset: 0, index: Index::default(), ids: HashSet::new(), broken: false };
        writer.append(&[&FileHeader::encode(version)])?;
        Ok(writer)
    }

    /// Packs a payload and writes it as a chunk.
    ///
    /// # Errors
    /// As [`EncodedChunk::new`] and [`Writer::write_encoded`].
    pub fn write(&mut self, id: ChunkId, encoding: Encoding, payload: &[u8]) -> Result<ChunkRecord> {
        self.write_encoded(&EncodedChunk::new(id, encoding, payload)?)
    }

    /// Writes a chunk that was packed elsewhere.
    ///
    /// # Errors
    /// [`Error::Usage`] if the file has a chunk of this id, or an earlier write failed; [`Error::Io`].
    pub fn write_encoded(&mut self, chunk: &EncodedChunk) -> Result<ChunkRecord> {
        let id = chunk.header.id;
        if id.kind.is_known() && self.ids.contains(&id) {
            return Err(Error::usage(format!("the file already has a {id}")));
        }
        let directory_len = chunk.directory.as_ref().map_or(0, TileDirectory::file_len);
        let record = chunk.header.record(self.offset, directory_len);
        self.append(&[&chunk.header.encode(), &chunk.payload])?;
        self.push(record, chunk.directory.as_ref());
        Ok(record)
    }

    /// Notes a chunk that now lies at the end of the file.
    pub(super) fn push(&mut self, record: ChunkRecord, directory: Option<&TileDirectory>) {
        self.ids.insert(record.id);
        self.index.push(record, directory);
    }

    /// Writes bytes at the end of the file.
    pub(super) fn append(&mut self, parts: &[&[u8]]) -> Result<()> {
        if self.broken {
            return Err(Error::usage("an earlier write to this file failed; resume it"));
        }
        self.broken = true;
        for part in parts {
            self.out.write_all(part).map_err(|error| Error::io(&self.partial, "write", error))?;
            self.offset += part.len() as u64;
        }
        self.broken = false;
        Ok(())
    }

    /// The chunks in the file so far, in file order.
    pub fn chunks(&self) -> &[ChunkRecord] {
        &self.index.chunks
    }

    /// Whether the file has a chunk of this id.
    pub fn contains(&self, id: ChunkId) -> bool {
        self.ids.contains(&id)
    }

    /// Bytes written so far.
    pub fn bytes_written(&self) -> u64 {
        self.offset
    }

    /// Hands all bytes to the system: from here on they outlive a killed process, though not yet a power cut.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn flush(&mut self) -> Result<()> {
        self.out.flush().map_err(|error| {
            self.broken = true;
            Error::io(&self.partial, "write", error)
        })
    }

    /// Writes index and trailer, forces everything to the disk, and gives the file its name in one step.
    ///
    /// # Errors
    /// [`Error::Usage`] if an earlier write failed; [`Error::Io`]. `NAME.partial` is left behind, unless the error is that the folder
    /// could not be forced to the disk: then the file is complete under its name, and a power cut may take the name away.
    pub fn finish(mut self) -> Result<Finished> {
        let chunks = self.index.chunks.len() as u64;
        let raw = self.index.encode();
        let packed = compress(&raw, INDEX_ZSTD_LEVEL)?;
        let index = EncodedChunk::packed(ChunkId::INDX, Encoding::Zstd(INDEX_ZSTD_LEVEL), raw.len() as u64, packed)?;
        let trailer = Trailer { index_offset: self.offset, index_len: index.file_len(), chunks };
        self.append(&[&index.header.encode(), &index.payload, &trailer.encode()])?;
        self.flush()?;
        self.out.get_ref().sync_all().map_err(|error| Error::io(&self.partial, "write", error))?;
        fs::rename(&self.partial, &self.path).map_err(|error| Error::io(&self.path, "rename to", error))?;
        sync_folder_of(&self.path).map_err(|error| Error::io(&self.path, "force to the disk the name of", error))?;
        Ok(Finished { path: self.path, len: self.offset, chunks })
    }
}

/// `NAME.partial` in the same folder. If `path` is a link, beside what it names.
///
/// # Errors
/// [`Error::Usage`] if `path` does not end in a file name; [`Error::Io`] if it is a device or a pipe.
pub fn partial_path(path: &Path) -> Result<PathBuf> {
    with_suffix(&behind(path)?, PARTIAL)
}

/// Where a trace of this name lies.
pub(super) fn behind(path: &Path) -> Result<PathBuf> {
    behind_links(path).map_err(|error| Error::io(path, "create", error))
}

/// Locks the file that `open` gives. Between the two another process may delete it, or finish it and give it its name; then it is
/// not to be written to, and `open` is asked again.
pub(super) fn open_locked(path: &Path, mut open: impl FnMut() -> Result<File>) -> Result<File> {
    // Nobody is that unlucky: the end is for file systems on which one file has two numbers.
    for _ in 0..100 {
        let file = open()?;
        lock(&file, path)?;
        if is_still(&file, path) {
            return Ok(file);
        }
    }
    Err(Error::io(path, "lock", io::Error::other("it is another file whenever it is looked at")))
}

/// The same path with something after its file name.
pub(super) fn with_suffix(path: &Path, suffix: &str) -> Result<PathBuf> {
    let name = path.file_name().ok_or_else(|| Error::usage(format!("{} does not name a file", path.display())))?;
    let mut name = name.to_os_string();
    name.push(suffix);
    Ok(path.with_file_name(name))
}

/// Keeps a second writer out. Where files cannot be locked, this does nothing.
pub(super) fn lock(file: &File, path: &Path) -> Result<()> {
    // Elsewhere a lock would also keep out readers, which need none.
    #[cfg(unix)]
    if let Err(by) = locks::try_lock(file).map_err(|error| Error::io(path, "lock", error))? {
        return Err(Error::occupied(path, Occupant::Writer { by }));
    }
    let _ = (file, path);
    Ok(())
}

/// Whether `path` still names this open and locked file. Its writer may have finished and renamed it after it was opened: it is
/// complete then, under its own name, and must not be written to.
pub(super) fn is_still(file: &File, path: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let same = |a: &fs::Metadata, b: &fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
        matches!((file.metadata(), fs::metadata(path)), (Ok(open), Ok(named)) if same(&open, &named))
    }
    #[cfg(not(unix))]
    {
        let _ = (file, path);
        true
    }
}

#[cfg(all(test, unix))]
mod tests {
    use std::os::unix::fs::symlink;

    use super::*;
    use crate::limits::Limits;

    /// Another process deletes the first file before it is locked: what is written to it would be lost.
    #[test]
    fn a_file_that_was_deleted_before_it_was_locked_is_not_written() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("t.partial");
        let mut opened = 0;
        let file = open_locked(&path, || {
            let file = File::create_new(&path).map_err(|error| Error::io(&path, "create", error))?;
            opened += 1;
            if opened == 1 {
                fs::remove_file(&path).unwrap();
            }
            Ok(file)
        });
        assert!(is_still(&file.unwrap(), &path));
        assert_eq!(opened, 2);
    }

    #[test]
    fn a_link_stays_and_what_it_names_is_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let disk = folder.path().join("disk");
        fs::create_dir(&disk).unwrap();
        let (link, real) = (folder.path().join("t"), disk.join("real"));
        fs::write(&real, "old").unwrap();
        symlink(&real, &link).unwrap();
        let partial = disk.canonicalize().unwrap().join("real.partial");
        drop(Writer::create(&link).unwrap());
        assert!(partial.exists() && partial_path(&link).unwrap() == partial);
        Writer::discard(&link).unwrap();
        assert!(!partial.exists());
        drop(Writer::create(&link).unwrap());
        Writer::resume(&link, &Limits::default()).unwrap().unwrap().go_on().unwrap().finish().unwrap();
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
        assert!(!partial.exists() && fs::read(&real).unwrap().starts_with(&super::super::file_header::MAGIC));
        fs::write(&real, "old").unwrap();
        let finished = Writer::create(&link).unwrap().finish().unwrap();
        assert_eq!(finished.path, real.canonicalize().unwrap());
        assert_eq!(fs::metadata(&link).unwrap().len(), finished.len);
        assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    }
}
