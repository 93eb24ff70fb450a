//! Files of others, read as a whole: plain files only, and no more bytes than such a file may have.
//!
//! A device such as `/dev/zero` never ends, and a pipe waits for somebody to write; neither is opened.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read};
use std::path::Path;

/// Most bytes of a file that a person writes: settings, plans, scenes.
pub const TEXT_MAX: u64 = 16 << 20;

/// Reads a plain file of at most `most` bytes.
///
/// # Errors
/// One that is not there, is no plain file, has more bytes, or cannot be read.
pub fn read(path: &Path, most: u64) -> io::Result<Vec<u8>> {
    check(path, most)?;
    let mut bytes = Vec::new();
    File::open(path)?.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
    // It may have grown, or be one of those whose length the system does not tell.
    if bytes.len() as u64 > most { Err(too_long(most)) } else { Ok(bytes) }
}

/// The same as text.
///
/// # Errors
/// As [`read`]; bytes that are no UTF-8.
pub fn read_text(path: &Path, most: u64) -> io::Result<String> {
    String::from_utf8(read(path, most)?).map_err(|_| io::Error::new(ErrorKind::InvalidData, "it is no UTF-8 text"))
}

/// Whether a plain file begins with these bytes. One that cannot be read does not.
pub fn begins_with(path: &Path, begin: &[u8]) -> bool {
    let mut found = vec![0; begin.len()];
    let open = || check(path, u64::MAX).and_then(|()| File::open(path));
    open().is_ok_and(|mut file| file.read_exact(&mut found).is_ok()) && found == begin
}

/// Refuses what [`read`] would refuse, without opening it.
///
/// # Errors
/// As [`read`].
pub fn check(path: &Path, most: u64) -> io::Result<()> {
    let known = fs::metadata(path)?;
    if known.is_dir() {
        return Err(ErrorKind::IsADirectory.into());
    }
    if !known.is_file() {
        return Err(io::Error::new(
            ErrorKind::InvalidInput,
            "it is no plain file but a pipe, a device or a socket; save it as a file first",
        ));
    }
    if known.len() > most { Err(too_long(most)) } else { Ok(()) }
}

fn too_long(most: u64) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, format!("it has more than {most} bytes, too many for such a file"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_read_up_to_its_limit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("plain");
        fs::write(&path, "12345").unwrap();
        assert_eq!(read(&path, 5).unwrap(), b"12345");
        assert_eq!(read_text(&path, 6).unwrap(), "12345");
        assert!(read(&path, 4).unwrap_err().to_string().contains("more than 4 bytes"));
        assert_eq!(read(&folder.path().join("missing"), 9).unwrap_err().kind(), ErrorKind::NotFound);
        assert_eq!(read(folder.path(), 9).unwrap_err().kind(), ErrorKind::IsADirectory);
        assert!(begins_with(&path, b"123") && !begins_with(&path, b"124") && !begins_with(&path, b"123456"));
        fs::write(&path, [0xff]).unwrap();
        assert!(read_text(&path, 9).unwrap_err().to_string().contains("UTF-8"));
    }

    /// Before, the first was read without end and the second waited for ever.
    #[test]
    #[cfg(unix)]
    fn devices_and_pipes_are_not_opened() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [Path::new("/dev/zero"), &pipe] {
            assert!(read(path, TEXT_MAX).unwrap_err().to_string().contains("no plain file"), "{}", path.display());
            assert!(!begins_with(path, b"\0"), "{}", path.display());
        }
    }
}
