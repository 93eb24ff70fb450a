//! The folder of a replay: its figures and its pictures.

use std::collections::BTreeMap;
use std::io;
use std::path::Path;

use rayreel_settings::files;
use serde_json::Value;

use crate::html::error::ReportError;
use crate::point::pictures::prefix;
use crate::point::wanted::Kind;

/// The figures of a replay.
pub const STATS: &str = "stats.json";

/// Most bytes of a file: a folder may be from anyone.
const BYTES_MAX: u64 = 1 << 28;

/// How every PNG file begins.
const PNG: [u8; 8] = *b"\x89PNG\r\n\x1a\n";

/// Whether a folder is that of a replay.
pub fn is_of_replay(path: &Path) -> bool {
    path.join(STATS).is_file() && !path.join(crate::schema::FILE).exists()
}

/// What a replay left.
pub struct Folder {
    /// `stats.json`.
    pub stats: Value,
    /// Width and height of its pictures.
    pub size: [u64; 2],
    /// The numbers of its frames.
    pub frames: Vec<u64>,
    /// PNG files by kind and frame; a kind that a replay does not have is not there.
    pub pictures: BTreeMap<(usize, u64), Vec<u8>>,
}

impl Folder {
    /// Reads it. A picture of a frame may be missing where all of its kind are.
    pub fn read(folder: &Path) -> Result<Self, ReportError> {
        let path = folder.join(STATS);
        let text = read(&path)?;
        let damaged = |line, column, detail| ReportError::Damaged { path: path.clone(), line, column, detail };
        let stats: Value = serde_json::from_slice(&text).map_err(|e| damaged(e.line(), e.column(), e.to_string()))?;
        let frames: Option<Vec<u64>> =
            stats["frames"].as_array().and_then(|frames| frames.iter().map(|frame| frame["frame"].as_u64()).collect());
        let frames = frames.filter(|frames| !frames.is_empty());
        let frames = frames.ok_or_else(|| damaged(1, 1, "it lists no frames: it is not of rayreel replay".into()))?;
        // They stand in attributes of the page: the file may be a stranger's, and hold anything in their place.
        let length = |key: &str| {
            let detail = format!("{key} is no whole number: it is not of rayreel replay");
            stats[key].as_u64().ok_or_else(|| damaged(1, 1, detail))
        };
        let size = [length("width")?, length("height")?];
        let mut pictures = BTreeMap::new();
        for (kind, name) in Kind::ALL.iter().map(|kind| kind.name()).enumerate() {
            let file = |frame: &u64| {
                let [alone, numbered] = [false, true].map(|several| format!("{}{name}.png", prefix(*frame, several)));
                let several = frames.len() > 1 || folder.join(&numbered).exists();
                if several { numbered } else { alone }
            };
            if !frames.iter().any(|frame| folder.join(file(frame)).exists()) {
                continue;
            }
            for frame in &frames {
                let (path, name) = (folder.join(file(frame)), file(frame));
                if !path.exists() {
                    return Err(ReportError::NoPicture { path: folder.join(STATS), name });
                }
                let bytes = read(&path)?;
                if !bytes.starts_with(&PNG) {
                    let detail = "it is no PNG file";
                    return Err(ReportError::BadPicture { path: folder.join(STATS), name, detail });
                }
                pictures.insert((kind, *frame), bytes);
            }
        }
        Ok(Self { stats, size, frames, pictures })
    }

    /// Bytes of all pictures.
    pub fn bytes(&self) -> usize {
        self.pictures.values().map(Vec::len).sum()
    }
}

fn read(path: &Path) -> Result<Vec<u8>, ReportError> {
    files::read(path, BYTES_MAX).map_err(|source: io::Error| ReportError::Io { path: path.to_path_buf(), source })
}
