//! Locks on files: held by the system, and gone with the process, however it ends.

use std::fmt;
use std::fs::{self, File};
use std::io;

/// Who holds a lock, as far as the system tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Holder(pub Option<u32>);

impl fmt::Display for Holder {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            Some(process) => write!(f, "process {process}"),
            None => f.write_str("another process"),
        }
    }
}

/// Locks a file for this process, until it is closed. Gives who holds it if somebody does. Where files cannot be locked this does
/// nothing.
///
/// # Errors
/// Those of the system, but for those that say that it has no locks.
pub fn try_lock(file: &File) -> io::Result<Result<(), Holder>> {
    match file.try_lock() {
        Ok(()) => Ok(Ok(())),
        Err(fs::TryLockError::WouldBlock) => Ok(Err(Holder(holder(file)))),
        Err(fs::TryLockError::Error(error)) if error.kind() == io::ErrorKind::Unsupported => Ok(Ok(())),
        Err(fs::TryLockError::Error(error)) => Err(error),
    }
}

/// The process that holds a lock on this file: Linux lists them by the file's number.
#[cfg(target_os = "linux")]
fn holder(file: &File) -> Option<u32> {
    use std::os::unix::fs::MetadataExt;
    let inode = format!(":{}", file.metadata().ok()?.ino());
    let locks = fs::read_to_string("/proc/locks").ok()?;
    // "1: FLOCK  ADVISORY  WRITE 1234 08:01:5678 0 EOF"
    let words = locks.lines().map(|line| line.split_whitespace().collect::<Vec<_>>());
    let mut held = words.filter(|words| words.get(5).is_some_and(|place| place.ends_with(&inode)));
    held.next()?.get(4)?.parse().ok()
}

#[cfg(not(target_os = "linux"))]
fn holder(_: &File) -> Option<u32> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lock_has_one_holder_and_goes_with_its_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("lock");
        let open = || File::options().create(true).append(true).open(&path).unwrap();
        let first = open();
        assert_eq!(try_lock(&first).unwrap(), Ok(()));
        let held = try_lock(&open()).unwrap().unwrap_err();
        if cfg!(target_os = "linux") && held.0.is_some() {
            assert_eq!(held.to_string(), format!("process {}", std::process::id()));
        }
        drop(first);
        assert_eq!(try_lock(&open()).unwrap(), Ok(()));
    }
}
