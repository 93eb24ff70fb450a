//! Reading a study and its pictures from their folder.

use std::fs;
use std::io;
use std::path::{Component, Path};

use rayreel_settings::files;
use serde_json::Value;

use crate::html::error::ReportError;
use crate::schema::{FILE, SCHEMA, Study};

/// Most bytes of a picture: a study may be written by anyone.
const PICTURE_BYTES_MAX: u64 = 1 << 28;

/// Most bytes of study.json.
const STUDY_BYTES_MAX: u64 = 1 << 28;

/// How every PNG file begins.
const PNG: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Reads `study.json` of a folder.
///
/// # Errors
/// When it is missing, damaged or of another version.
pub fn load(folder: &Path) -> Result<Study, ReportError> {
    let path = folder.join(FILE);
    let text = match files::read(&path, STUDY_BYTES_MAX) {
        Ok(text) => text,
        Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => {
            return Err(ReportError::NoStudy { folder: folder.into() });
        }
        Err(source) => return Err(ReportError::Io { path, source }),
    };
    let damaged = |e: serde_json::Error| ReportError::Damaged {
        path: path.clone(),
        line: e.line(),
        column: e.column(),
        detail: detail(&e),
    };
    // The version first: a study of another version lacks fields or has more, and that would be the wrong message.
    let value: Value = serde_json::from_slice(&text).map_err(damaged)?;
    if let Some(found) = value["schema"].as_u64().filter(|&found| found != u64::from(SCHEMA)) {
        return Err(ReportError::Schema { path, found });
    }
    serde_json::from_slice(&text).map_err(damaged)
}

/// What is wrong, without the place, which stands elsewhere in the message.
fn detail(error: &serde_json::Error) -> String {
    let text = error.to_string();
    text.rsplit_once(" at line ").map_or(text.clone(), |(what, _)| what.to_owned())
}

/// Reads a picture that the study in `folder` names.
///
/// # Errors
/// When it is not there, or no PNG, or named so that it could lie outside the folder.
pub fn picture(folder: &Path, name: &str) -> Result<Vec<u8>, ReportError> {
    let study = || folder.join(FILE);
    let bad = |detail| ReportError::BadPicture { path: study(), name: name.into(), detail };
    let relative = Path::new(name);
    if name.is_empty() || !relative.components().all(|part| matches!(part, Component::Normal(_))) {
        return Err(bad("the name does not lie inside the folder"));
    }
    let path = folder.join(relative);
    let read = |result: io::Result<_>| {
        result.map_err(|source| match source.kind() {
            io::ErrorKind::NotFound => ReportError::NoPicture { path: study(), name: name.into() },
            _ => ReportError::Io { path: path.clone(), source },
        })
    };
    if read(fs::metadata(&path).map(|meta| meta.len()))? > PICTURE_BYTES_MAX {
        return Err(bad("it is larger than 256 MiB"));
    }
    let bytes =
        files::read(&path, PICTURE_BYTES_MAX).map_err(|source| ReportError::Io { path: path.clone(), source })?;
    if bytes.starts_with(&PNG) { Ok(bytes) } else { Err(bad("it is no PNG file")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn folder_with(text: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(FILE), text).unwrap();
        folder
    }

    #[test]
    fn a_study_comes_back_as_it_was() {
        let study = Study { schema: SCHEMA, title: "a < b".into(), ..Study::default() };
        let folder = folder_with(&serde_json::to_string(&study).unwrap());
        assert_eq!(load(folder.path()).unwrap(), study);
    }

    #[test]
    fn errors_say_what_is_wrong() {
        let empty = tempfile::tempdir().unwrap();
        assert!(matches!(load(empty.path()), Err(ReportError::NoStudy { .. })));
        let other = folder_with("{\"schema\": 99, \"unknown\": 1}");
        assert!(matches!(load(other.path()), Err(ReportError::Schema { found: 99, .. })));
        let text = serde_json::to_string_pretty(&Study { schema: SCHEMA, ..Study::default() }).unwrap();
        let cut = folder_with(&text[..40]);
        assert!(matches!(load(cut.path()), Err(ReportError::Damaged { line: 2.., .. })));
        let unknown = folder_with(&text.replacen("\"tool\"", "\"tols\"", 1));
        let message = load(unknown.path()).unwrap_err().to_string();
        assert!(message.contains("tols") && message.contains("line 3"), "{message}");
    }

    #[test]
    fn pictures_stay_inside_the_folder() {
        let folder = folder_with("{}");
        fs::write(folder.path().join("a.png"), PNG).unwrap();
        assert_eq!(picture(folder.path(), "a.png").unwrap(), PNG);
        for name in ["", "../a.png", "/etc/hostname", "x/../a.png", FILE] {
            assert!(matches!(picture(folder.path(), name), Err(ReportError::BadPicture { .. })), "{name}");
        }
        assert!(matches!(picture(folder.path(), "b.png"), Err(ReportError::NoPicture { .. })));
    }
}
