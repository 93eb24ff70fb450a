//! The one way in which a file is written whole.
//!
//! A reader finds the old file or the new one, never a part, whatever happens when: the bytes go to a temporary file in
//! the same folder, are forced to the disk, and only then get the file's name.
//!
//! The temporary file of `NAME` is `.NAME.PID-NUMBER.partial`. Readers of a folder can leave out what starts with a dot
//! or ends in [`PARTIAL`]. Such a file is left behind only by a process that was killed.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

/// How the names of unfinished files end.
pub const PARTIAL: &str = ".partial";

/// Writes `parts`, one after the other, as the whole content of `path`, and replaces what was there. File and name are
/// on the disk when this returns. Any number of threads and processes may write the same file at once: the last one
/// wins.
///
/// The folder must exist.
///
/// # Errors
/// Those of the system. If the new file did not get its name, the old one is as it was and no temporary file is left.
pub fn write_whole(path: &Path, parts: &[&[u8]]) -> io::Result<()> {
    replace(path, |file| parts.iter().try_for_each(|part| file.write_all(part)))
}

/// Writes a file that never changes, unless there is one: whether it was written. Of several threads and processes that write it at
/// once one does. Bytes and name are on the disk when this returns `true`.
///
/// The folder must exist.
///
/// # Errors
/// Those of the system. If there was no file there is none then, unless only the name could not be forced to the disk.
pub fn write_once(path: &Path, bytes: &[u8]) -> io::Result<bool> {
    let (file, temporary) = create_temporary(path)?;
    let written = fill_and_sync(file, |file| file.write_all(bytes));
    // Unlike a rename it never takes the place of a file.
    let linked = written.and_then(|()| match fs::hard_link(&temporary, path) {
        Err(error) if path.exists() || error.kind() == io::ErrorKind::AlreadyExists => Ok(false),
        // A file system without second names: the last of several that write at once wins there.
        Err(_) => fs::rename(&temporary, path).map(|()| true),
        Ok(()) => Ok(true),
    });
    // A rename has taken it; else, if this fails, nothing more can be done.
    fs::remove_file(&temporary).ok();
    if linked? { sync_folder_of(path).map(|()| true) } else { Ok(false) }
}

/// Gives `path` what `fill` writes, or leaves it alone.
fn replace(path: &Path, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let path = &behind_links(path)?;
    let (file, temporary) = create_temporary(path)?;
    fill_and_sync(file, fill).and_then(|()| fs::rename(&temporary, path)).inspect_err(|_| {
        // If this fails too, nothing more can be done; the first error is the one to report.
        fs::remove_file(&temporary).ok();
    })?;
    sync_folder_of(path)
}

/// Closes the file too.
fn fill_and_sync(mut file: File, fill: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    fill(&mut file)?;
    file.sync_all()
}

/// A file that is written bit by bit and yet is whole or absent: for what does not fit into memory. Until
/// [`WholeFile::finish`] only the temporary file is there; without it the temporary file goes away.
#[derive(Debug)]
pub struct WholeFile {
    path: PathBuf,
    temporary: PathBuf,
    /// Gone once the file has its name.
    file: Option<BufWriter<File>>,
}

impl WholeFile {
    /// Begins to write `path`, whose folder must exist.
    ///
    /// # Errors
    /// Those of the system.
    pub fn create(path: &Path) -> io::Result<Self> {
        let path = behind_links(path)?;
        let (file, temporary) = create_temporary(&path)?;
        Ok(Self { path, temporary, file: Some(BufWriter::with_capacity(1 << 16, file)) })
    }

    /// Forces what was written to the disk and gives it the file's name, in place of what was there.
    ///
    /// # Errors
    /// Those of the system. The old file is as it was then, and no temporary file is left.
    pub fn finish(mut self) -> io::Result<()> {
        if let Some(file) = self.file.take() {
            let written = file.into_inner().map_err(io::IntoInnerError::into_error).and_then(|file| file.sync_all());
            written.and_then(|()| fs::rename(&self.temporary, &self.path)).inspect_err(|_| {
                fs::remove_file(&self.temporary).ok();
            })?;
        }
        sync_folder_of(&self.path)
    }

    fn open(&mut self) -> io::Result<&mut BufWriter<File>> {
        self.file.as_mut().ok_or_else(|| io::Error::other("the file is finished"))
    }
}

impl Write for WholeFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.open()?.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.open()?.flush()
    }
}

impl Seek for WholeFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.open()?.seek(to)
    }
}

impl Drop for WholeFile {
    fn drop(&mut self) {
        if self.file.take().is_some() {
            // Whoever dropped it has an error of its own to report.
            fs::remove_file(&self.temporary).ok();
        }
    }
}

/// Where a file of this name lies: a link stays, and what it names is replaced.
///
/// # Errors
/// When the name is that of a folder, a device or a pipe: whoever reads one of these would read on from what is no longer there. When
/// links go round in a circle, or a folder may not be looked into.
pub(crate) fn behind_links(path: &Path) -> io::Result<PathBuf> {
    if path.as_os_str().as_encoded_bytes().last().is_some_and(|byte| std::path::is_separator(char::from(*byte))) {
        return Err(io::Error::new(io::ErrorKind::IsADirectory, "it ends as the name of a folder does; name a file"));
    }
    let found = match fs::metadata(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return behind_dangling(path),
        found => found?,
    };
    if !found.is_file() && !found.is_dir() {
        let detail = "it is a device or a pipe, and a file cannot take its place; name a file";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, detail));
    }
    if fs::symlink_metadata(path)?.is_symlink() { fs::canonicalize(path) } else { Ok(path.to_path_buf()) }
}

/// As [`behind_links`], where nothing is yet: a link may say where it is to be.
fn behind_dangling(path: &Path) -> io::Result<PathBuf> {
    match fs::read_link(path) {
        Ok(to) => behind_links(&path.parent().unwrap_or(Path::new("")).join(to)),
        Err(_) => Ok(path.to_path_buf()),
    }
}

/// A new file beside `path`, under a name that nobody else has: the system refuses a second file of one name, also to
/// other machines that share the folder.
fn create_temporary(path: &Path) -> io::Result<(File, PathBuf)> {
    static NUMBER: AtomicU64 = AtomicU64::new(0);
    let Some(name) = path.file_name() else {
        return Err(io::Error::new(io::ErrorKind::InvalidInput, "the path does not name a file"));
    };
    loop {
        let mut temporary = OsString::from(".");
        temporary.push(name);
        temporary.push(format!(".{}-{}{PARTIAL}", std::process::id(), NUMBER.fetch_add(1, Ordering::Relaxed)));
        let temporary = path.with_file_name(temporary);
        match File::create_new(&temporary) {
            // A killed process of the same number, or one on another machine.
            Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
            created => return created.map(|file| (file, temporary)),
        }
    }
}

/// Makes a folder and those above it that are missing, as [`fs::create_dir_all`] does. Their names are on the disk when this returns:
/// what is written into them is not lost with a folder that a power cut takes away.
///
/// # Errors
/// Those of the system.
pub fn create_folders(path: &Path) -> io::Result<()> {
    let missing: Vec<&Path> =
        path.ancestors().take_while(|folder| !folder.as_os_str().is_empty() && !folder.exists()).collect();
    fs::create_dir_all(path)?;
    // From the top: a name is worth nothing before those above it.
    missing.iter().rev().try_for_each(|folder| sync_folder_of(folder))
}

/// Forces the names in the folder of `path` to the disk. Does nothing where a folder cannot be opened or forced.
///
/// # Errors
/// Those of the disk.
pub(crate) fn sync_folder_of(path: &Path) -> io::Result<()> {
    let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
    match File::open(folder).and_then(|folder| folder.sync_all()) {
        Err(error) if !cfg!(unix) || is_no_support(&error) => Ok(()),
        synced => synced,
    }
}

/// Some file systems refuse to sync a folder, and a folder that may be written to need not be readable.
fn is_no_support(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::InvalidInput | io::ErrorKind::Unsupported | io::ErrorKind::PermissionDenied)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = entries.collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_replaced_as_a_whole() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_whole(&path, &[b"a long first content"]).unwrap();
        write_whole(&path, &[b"sec", b"", b"ond"]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"second");
        write_whole(&path, &[]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_failure_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_whole(&path, &[b"old"]).unwrap();
        let full = |file: &mut File| {
            file.write_all(b"half of the ne")?;
            let unfinished = names(folder.path()).remove(0);
            assert!(unfinished.starts_with(".a.bin.") && unfinished.ends_with(PARTIAL), "{unfinished}");
            Err(io::ErrorKind::StorageFull.into())
        };
        assert_eq!(replace(&path, full).unwrap_err().kind(), io::ErrorKind::StorageFull);
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }

    #[test]
    fn a_file_that_never_changes_is_written_once() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        assert!(write_once(&path, b"first").unwrap());
        assert!(!write_once(&path, b"second").unwrap());
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"first".to_vec(), vec!["a.bin".to_string()]));
        let nowhere = write_once(&folder.path().join("no/a.bin"), b"x").unwrap_err();
        assert_eq!(nowhere.kind(), io::ErrorKind::NotFound);
        let both = folder.path().join("b.bin");
        let write = |byte| write_once(&both, &[byte; 5000]).unwrap();
        let written = std::thread::scope(|scope| {
            let writers: Vec<_> = (0..8u8).map(|byte| scope.spawn(move || write(byte))).collect();
            writers.into_iter().map(|writer| writer.join().unwrap()).filter(|written| *written).count()
        });
        assert_eq!(written, 1, "of several that write at once one does");
        let bytes = fs::read(&both).unwrap();
        assert!(bytes.len() == 5000 && bytes.iter().all(|byte| *byte == bytes[0]), "whole");
        assert_eq!(names(folder.path()), ["a.bin", "b.bin"]);
    }

    #[test]
    fn a_file_written_bit_by_bit_is_whole_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        write_whole(&path, &[b"old"]).unwrap();
        let mut dropped = WholeFile::create(&path).unwrap();
        dropped.write_all(b"half of the ne").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(names(folder.path()).len(), 2, "a temporary file stands beside it");
        drop(dropped);
        assert_eq!((fs::read(&path).unwrap(), names(folder.path())), (b"old".to_vec(), vec!["a.bin".to_string()]));
        let mut whole = WholeFile::create(&path).unwrap();
        whole.write_all(b"?? content").unwrap();
        whole.seek(SeekFrom::Start(0)).unwrap();
        whole.write_all(b"my").unwrap();
        whole.finish().unwrap();
        assert_eq!(
            (fs::read(&path).unwrap(), names(folder.path())),
            (b"my content".to_vec(), vec!["a.bin".to_string()])
        );
    }

    #[test]
    fn what_cannot_be_replaced_stays() {
        let folder = tempfile::tempdir().unwrap();
        let taken = folder.path().join("taken");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("x"), "x").unwrap();
        assert!(write_whole(&taken, &[b"new"]).is_err());
        assert_eq!(names(folder.path()), ["taken"]);
        assert_eq!(fs::read(taken.join("x")).unwrap(), b"x");
    }

    #[test]
    fn a_folder_must_exist_and_a_file_have_a_name() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_whole(&folder.path().join("no/a.bin"), &[b"x"]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::NotFound);
        assert!(names(folder.path()).is_empty());
        let error = write_whole(&folder.path().join(".."), &[b"x"]).unwrap_err();
        assert_eq!(error.kind(), io::ErrorKind::InvalidInput);
    }

    #[test]
    fn folders_are_made_with_those_above() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a/b/c");
        create_folders(&path).unwrap();
        assert!(path.is_dir());
        create_folders(&path).unwrap();
        fs::write(path.join("x"), "x").unwrap();
        assert!(create_folders(&path.join("x")).is_err());
    }

    /// What a killed process left under the very name is neither used nor touched.
    #[test]
    fn a_leftover_is_not_shared() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        let (_, temporary) = create_temporary(&path).unwrap();
        let name = temporary.file_name().unwrap().to_str().unwrap();
        let number: u64 = name.rsplit_once('-').unwrap().1.trim_end_matches(PARTIAL).parse().unwrap();
        let next =
            |add: u64| temporary.with_file_name(name.replace(&format!("-{number}."), &format!("-{}.", number + add)));
        (1..200).for_each(|add| fs::write(next(add), "left").unwrap());
        write_whole(&path, &[b"new"]).unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"new");
        assert!((1..200).all(|add| fs::read(next(add)).unwrap() == b"left"));
    }

    #[test]
    fn writers_of_one_file_do_not_meet() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.bin");
        std::thread::scope(|scope| {
            for writer in 0..4u8 {
                let path = &path;
                scope.spawn(move || {
                    let half = vec![writer; 5000];
                    (0..20).for_each(|_| write_whole(path, &[&half, &half]).unwrap());
                });
            }
        });
        let bytes = fs::read(&path).unwrap();
        assert!(bytes.len() == 10_000 && bytes.iter().all(|byte| *byte == bytes[0]), "of one writer alone");
        assert_eq!(names(folder.path()), ["a.bin"]);
    }
}
