//! Rows on disk.
//!
//! A segment is a line of JSON, then one line of JSON a row. The first line names the plan and the bucket, counts the rows and
//! holds the CRC-32 of all that follows it, so a file that was torn, emptied or put there by another sweep is seen and ignored: its
//! points are computed again. A sealed bucket is a segment too, with every row of its bucket in the order of the plan and nothing
//! in its head that depends on who wrote it.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Result, StudyError};
use crate::point::row::{Column, Row};
use crate::sweep::folder::{Folder, write_whole};
use crate::sweep::plan::LAYOUT;

/// The first line.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
struct Head {
    /// [`LAYOUT`].
    rayreel_segment: u32,
    /// Id of the plan.
    plan: String,
    /// Bucket of the rows.
    bucket: usize,
    /// How many rows.
    rows: usize,
    /// CRC-32 of the rows.
    crc: u32,
    /// Who wrote them; not in a sealed bucket.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    attempt: Option<String>,
    /// Where; not in a sealed bucket.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    host: Option<String>,
}

/// Who writes segments.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Writer {
    /// Name of the attempt; no two have the same.
    pub attempt: String,
    /// Name of the machine that it runs on.
    pub host: String,
}

/// What a bucket holds.
#[derive(Clone, Debug, Default)]
pub struct Bucket {
    /// The rows by key.
    pub rows: BTreeMap<String, Row>,
    /// Rows that stand there more than once.
    pub duplicates: usize,
    /// The first two rows of one key that differ: the key, and what differs.
    pub conflict: Option<(String, String)>,
    /// Segments that are no whole segments of this plan.
    pub damaged: Vec<PathBuf>,
    /// The segments that were read.
    segments: Vec<PathBuf>,
    /// Whether it is sealed.
    pub sealed: bool,
}

/// Writes rows of one bucket, as number `number` of this writer.
///
/// # Errors
/// When the folder cannot be written.
pub fn write(folder: &Folder, bucket: usize, number: u64, rows: &[Row], writer: &Writer) -> Result<()> {
    let path = folder.segments(bucket).join(format!("{}-{number:06}.seg", writer.attempt));
    write_whole(&path, &encode(folder, bucket, rows, Some(writer))?, &writer.attempt)
}

/// Seals a bucket that holds a row for each of its points: one file for all. Whoever does it, and if two do it at once, writes the
/// same bytes. Whether it is sealed now.
///
/// # Errors
/// When the folder cannot be read or written.
pub fn seal(folder: &Folder, bucket: usize, writer: &Writer) -> Result<bool> {
    let own = read(folder, bucket)?;
    if own.sealed && own.segments.is_empty() {
        return Ok(true);
    }
    let points = &folder.plan().points[folder.bucket(bucket)];
    if own.conflict.is_some() || points.iter().any(|point| !own.rows.contains_key(&point.key)) {
        // A conflict is for merge to tell: it needs both rows.
        return Ok(false);
    }
    if !own.sealed {
        let mut rows: Vec<Row> = Vec::new();
        for point in points {
            if !rows.iter().any(|row| row.key == point.key) {
                rows.push(own.rows[&point.key].clone());
            }
        }
        write_whole(&folder.sealed(bucket), &encode(folder, bucket, &rows, None)?, &writer.attempt)?;
    }
    // Everything in them is in the sealed file now. One that another attempt writes meanwhile stays, and does no harm.
    own.segments.iter().for_each(|path| drop(fs::remove_file(path)));
    Ok(true)
}

/// Reads a bucket.
///
/// # Errors
/// When the folder cannot be read.
pub fn read(folder: &Folder, bucket: usize) -> Result<Bucket> {
    // A segment may go away between the listing and its reading, because somebody sealed the bucket: then the sealed file is
    // there. Seals come once a bucket, so this ends.
    loop {
        let mut own = Bucket::default();
        own.sealed = own.add(folder, bucket, &folder.sealed(bucket))?.unwrap_or(false);
        let mut gone = false;
        for path in listing(&folder.segments(bucket))? {
            match own.add(folder, bucket, &path)? {
                None => gone = true,
                Some(true) => own.segments.push(path),
                Some(false) => {}
            }
        }
        if !gone || own.sealed {
            return Ok(own);
        }
    }
}

impl Bucket {
    /// Takes in a file: whether it was whole; nothing if it is not there.
    fn add(&mut self, folder: &Folder, bucket: usize, path: &Path) -> Result<Option<bool>> {
        let bytes = match fs::read(path) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(StudyError::output(path, "read", e)),
        };
        let Some(rows) = decode(&bytes, folder.id(), bucket) else {
            self.damaged.push(path.into());
            return Ok(Some(false));
        };
        for row in rows {
            match self.rows.get(&row.key) {
                None => drop(self.rows.insert(row.key.clone(), row)),
                Some(known) => {
                    self.duplicates += 1;
                    if *known != row && self.conflict.is_none() {
                        self.conflict = Some((row.key.clone(), difference(known, &row)));
                    }
                }
            }
        }
        Ok(Some(true))
    }
}

/// The segments of a folder, by name.
fn listing(folder: &Path) -> Result<Vec<PathBuf>> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(e) => return Err(StudyError::output(folder, "read", e)),
    };
    let mut all = Vec::new();
    for entry in entries {
        let path = entry.map_err(|e| StudyError::output(folder, "read", e))?.path();
        if path.extension().is_some_and(|own| own == "seg") {
            all.push(path);
        }
    }
    all.sort();
    Ok(all)
}

fn encode(folder: &Folder, bucket: usize, rows: &[Row], writer: Option<&Writer>) -> Result<Vec<u8>> {
    let json = |e: serde_json::Error| StudyError::Usage { detail: e.to_string() };
    let mut body = Vec::new();
    for row in rows {
        serde_json::to_writer(&mut body, row).map_err(json)?;
        body.push(b'\n');
    }
    let head = Head {
        rayreel_segment: LAYOUT,
        plan: folder.id().into(),
        bucket,
        rows: rows.len(),
        crc: crc32fast::hash(&body),
        attempt: writer.map(|w| w.attempt.clone()),
        host: writer.map(|w| w.host.clone()),
    };
    let mut bytes = serde_json::to_vec(&head).map_err(json)?;
    bytes.push(b'\n');
    bytes.append(&mut body);
    Ok(bytes)
}

/// The rows of a segment of this plan and bucket, if it is whole.
fn decode(bytes: &[u8], plan: &str, bucket: usize) -> Option<Vec<Row>> {
    let end = bytes.iter().position(|b| *b == b'\n')?;
    let (head, body) = (&bytes[..end], &bytes[end + 1..]);
    let head: Head = serde_json::from_slice(head).ok()?;
    if head.rayreel_segment != LAYOUT || head.plan != plan || head.bucket != bucket || head.crc != crc32fast::hash(body)
    {
        return None;
    }
    let rows: Option<Vec<Row>> =
        body.split_inclusive(|b| *b == b'\n').map(|line| serde_json::from_slice(line).ok()).collect();
    rows.filter(|rows| rows.len() == head.rows)
}

/// What is different between two rows of one key.
fn difference(a: &Row, b: &Row) -> String {
    if a.error != b.error {
        let word = |row: &Row| row.error.clone().unwrap_or_else(|| "none".into());
        return format!("error {} and {}", word(a), word(b));
    }
    let names = a.figures.keys().chain(b.figures.keys());
    let value = |row: &Row, name: &str| row.figures.get(name).map_or_else(|| "nothing".into(), ToString::to_string);
    let first = names.into_iter().find(|name| a.figures.get(*name) != b.figures.get(*name));
    first.map_or_else(String::new, |name| format!("{name} is {} and {}", value(a, name), value(b, name)))
}

/// Keeps what the columns of rows are, once for all rows that have the same.
///
/// # Errors
/// When the folder cannot be written.
pub fn write_columns(folder: &Folder, columns: &[Column], writer: &Writer) -> Result<()> {
    let bytes = serde_json::to_vec(columns).map_err(|e| StudyError::Usage { detail: e.to_string() })?;
    let path = folder.columns().join(format!("{}.json", &blake3::hash(&bytes).to_hex()[..16]));
    if path.exists() { Ok(()) } else { write_whole(&path, &bytes, &writer.attempt) }
}

/// What all columns are, by name.
///
/// # Errors
/// When the folder cannot be read.
pub fn read_columns(folder: &Folder) -> Result<BTreeMap<String, Column>> {
    let path = folder.columns();
    let entries = match fs::read_dir(&path) {
        Ok(entries) => entries,
        Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(BTreeMap::new()),
        Err(e) => return Err(StudyError::output(&path, "read", e)),
    };
    let mut all = BTreeMap::new();
    for entry in entries {
        let file = entry.map_err(|e| StudyError::output(&path, "read", e))?.path();
        if file.extension().is_none_or(|own| own != "json") {
            continue;
        }
        let bytes = fs::read(&file).map_err(|e| StudyError::output(&file, "read", e))?;
        let columns: Vec<Column> = serde_json::from_slice(&bytes).map_err(|e| StudyError::Sweep {
            path: file.clone(),
            detail: format!("does not say what columns are: {e}; remove it, and the next run writes it again"),
        })?;
        all.extend(columns.into_iter().map(|column| (column.name.clone(), column)));
    }
    Ok(all)
}
