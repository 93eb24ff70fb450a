//! The results that the cache folder keeps: one file a simulation, named by a hash of all that enters it.
//!
//! A file begins with the BLAKE3 hash of all that follows its first line, in hexadecimal; then comes a line of JSON, then the
//! pictures, one after the other. A file that does not hold what its hash says is taken for missing and written again, so no
//! damage can enter a result. What a result depends on is in its name, so none is ever out of date.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use rayreel_replay::image::files::write_atomically;
use serde::{Deserialize, Serialize};

use super::record::Record;
use crate::common::TOOL;

/// A result with its pictures.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// The figures.
    pub record: Record,
    /// PNG files, in the order in which they were asked for.
    pub pictures: Vec<Vec<u8>>,
}

/// The line of JSON.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Head {
    record: Record,
    /// Length of each picture, bytes.
    pictures: Vec<usize>,
}

/// The folder of results.
pub struct Cache {
    folder: PathBuf,
    program: blake3::Hash,
}

impl Cache {
    /// The results in the cache folder `folder`.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn open(folder: &Path) -> Result<Self> {
        let folder = folder.join("results");
        std::fs::create_dir_all(&folder).with_context(|| format!("cannot create folder {}", folder.display()))?;
        Ok(Self { folder, program: program() })
    }

    /// The name of the result that depends on `inputs`, and on this program.
    pub fn key(&self, inputs: &str) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(self.program.as_bytes()).update(inputs.as_bytes());
        hasher.finalize().to_hex()[..32].to_owned()
    }

    fn path(&self, key: &str) -> PathBuf {
        self.folder.join(format!("{key}.result"))
    }

    /// The result of this name with `pictures` pictures, if it is there and whole.
    pub fn load(&self, key: &str, pictures: usize) -> Option<Entry> {
        let entry = decode(&std::fs::read(self.path(key)).ok()?)?;
        (entry.pictures.len() == pictures).then_some(entry)
    }

    /// Keeps a result; gives back what a later run will read, so that the two cannot differ.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn store(&self, key: &str, entry: &Entry) -> Result<Entry> {
        let (path, bytes) = (self.path(key), encode(entry)?);
        write_atomically(&path, &bytes)?;
        decode(&bytes).with_context(|| format!("{} does not read back as it was written", path.display()))
    }
}

/// What this program is: a result of another build may be another one, though the version is the same.
fn program() -> blake3::Hash {
    let own = std::env::current_exe().and_then(std::fs::read);
    own.map_or_else(|_| blake3::hash(TOOL.as_bytes()), |bytes| blake3::hash(&bytes))
}

fn encode(entry: &Entry) -> Result<Vec<u8>> {
    let head = Head { record: entry.record.clone(), pictures: entry.pictures.iter().map(Vec::len).collect() };
    let mut body = serde_json::to_vec(&head)?;
    body.push(b'\n');
    entry.pictures.iter().for_each(|picture| body.extend_from_slice(picture));
    let mut bytes = format!("{}\n", blake3::hash(&body)).into_bytes();
    bytes.append(&mut body);
    Ok(bytes)
}

fn decode(bytes: &[u8]) -> Option<Entry> {
    let (hash, body) = line(bytes)?;
    if hash != blake3::hash(body).to_hex().as_bytes() {
        return None;
    }
    let (head, mut rest) = line(body)?;
    let head: Head = serde_json::from_slice(head).ok()?;
    let mut pictures = Vec::new();
    for len in head.pictures {
        let (picture, after) = rest.split_at_checked(len)?;
        pictures.push(picture.to_vec());
        rest = after;
    }
    rest.is_empty().then_some(Entry { record: head.record, pictures })
}

/// The first line without its end, and the rest.
fn line(bytes: &[u8]) -> Option<(&[u8], &[u8])> {
    let end = bytes.iter().position(|b| *b == b'\n')?;
    Some((&bytes[..end], &bytes[end + 1..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry() -> Entry {
        Entry { record: Record { frames: Vec::new() }, pictures: vec![vec![1, 2, b'\n'], vec![], vec![9; 40]] }
    }

    #[test]
    fn a_result_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let cache = Cache::open(folder.path()).unwrap();
        let key = cache.key("a");
        assert_eq!(cache.load(&key, 3), None);
        assert_eq!(cache.store(&key, &entry()).unwrap(), entry());
        assert_eq!(cache.load(&key, 3), Some(entry()));
        assert_eq!(cache.load(&key, 2), None, "of another question");
        assert_ne!(key, cache.key("b"));
    }

    #[test]
    fn no_damage_is_believed() {
        let whole = encode(&entry()).unwrap();
        assert!(decode(&whole).is_some());
        for i in 0..whole.len() {
            let mut bytes = whole.clone();
            bytes[i] ^= 1;
            assert_eq!(decode(&bytes), None, "byte {i}");
            assert_eq!(decode(&whole[..i]), None, "cut at {i}");
        }
    }
}
