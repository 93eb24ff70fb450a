//! Where files lie that a reader wants to have by name: in memory, if the system has such a folder.

use std::fs;
use std::path::{Path, PathBuf};

use tempfile::TempDir;

/// A folder that goes away with this.
#[derive(Debug)]
pub struct Place(TempDir);

impl Place {
    /// A new folder.
    ///
    /// # Panics
    /// When the system has no place for files.
    pub fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
        Self(folder.or_else(|_| tempfile::tempdir()).expect("a place for temporary files"))
    }

    /// The path of a name in it.
    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file. Gives its path.
    ///
    /// # Panics
    /// When the system cannot write.
    pub fn put(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, bytes).expect("a temporary file can be written");
        path
    }
}

impl Default for Place {
    fn default() -> Self {
        Self::new()
    }
}

thread_local! {
    static PLACE: Place = Place::new();
}

/// Calls with the folder of this thread.
pub fn with<T>(call: impl FnOnce(&Place) -> T) -> T {
    PLACE.with(call)
}
