//! Where the bytes of a trace come from: positioned reads, shared between threads.

use std::fmt;
use std::fs::File;
use std::io;

use super::chunk_header::ChunkRecord;

/// Bytes that can be read at any position, by several threads at once.
pub trait Source: Send + Sync + fmt::Debug {
    /// Length in bytes.
    ///
    /// # Errors
    /// Those of the system.
    fn size(&self) -> io::Result<u64>;

    /// Reads up to `buffer.len()` bytes at `offset`; 0 means that there are none.
    ///
    /// # Errors
    /// Those of the system.
    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize>;

    /// Told that the `len` bytes from `offset` will be read next, in pieces: a source far away fetches them in one
    /// request.
    ///
    /// # Errors
    /// Those of fetching them.
    fn announce(&self, _offset: u64, _len: u64) -> io::Result<()> {
        Ok(())
    }

    /// Told that what it gave of these bytes is not what the file's checksums say. A source that keeps copies of bytes far away drops
    /// them, and gives in words where it will ask again; nothing where asking again gives the same.
    fn distrust(&self, _offset: u64, _len: u64) -> Option<String> {
        None
    }

    /// Told once, after the index was checked, where the chunks lie, in file order: a source far away may fetch
    /// neighbours together that are read one after the other.
    fn layout(&self, _chunks: &[ChunkRecord]) {}
}

/// A file. Has no shared position where the system offers positioned reads.
#[derive(Debug)]
pub(crate) struct FileSource {
    #[cfg(unix)]
    file: File,
    #[cfg(not(unix))]
    file: std::sync::Mutex<File>,
}

impl FileSource {
    #[cfg(unix)]
    pub(crate) fn new(file: File) -> Self {
        Self { file }
    }

    #[cfg(not(unix))]
    pub(crate) fn new(file: File) -> Self {
        Self { file: std::sync::Mutex::new(file) }
    }
}

#[cfg(unix)]
impl Source for FileSource {
    fn size(&self) -> io::Result<u64> {
        self.file.metadata().map(|metadata| metadata.len())
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        std::os::unix::fs::FileExt::read_at(&self.file, buffer, offset)
    }
}

#[cfg(not(unix))]
impl FileSource {
    fn locked(&self) -> std::sync::MutexGuard<'_, File> {
        // The position is set before every read: a panic elsewhere cannot have left it wrong.
        self.file.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
    }
}

#[cfg(not(unix))]
impl Source for FileSource {
    fn size(&self) -> io::Result<u64> {
        self.locked().metadata().map(|metadata| metadata.len())
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        use std::io::{Read, Seek, SeekFrom};
        let mut file = self.locked();
        file.seek(SeekFrom::Start(offset))?;
        file.read(buffer)
    }
}

/// Bytes in memory.
pub(crate) struct MemorySource(pub(crate) Vec<u8>);

impl fmt::Debug for MemorySource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "MemorySource({} bytes)", self.0.len())
    }
}

impl Source for MemorySource {
    fn size(&self) -> io::Result<u64> {
        Ok(self.0.len() as u64)
    }

    fn read_at(&self, offset: u64, buffer: &mut [u8]) -> io::Result<usize> {
        let start = usize::try_from(offset).unwrap_or(usize::MAX).min(self.0.len());
        let count = buffer.len().min(self.0.len() - start);
        buffer[..count].copy_from_slice(&self.0[start..start + count]);
        Ok(count)
    }
}
