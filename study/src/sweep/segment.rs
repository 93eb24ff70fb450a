//! Rows of a sweep on disk.
//!
//! Rows lie in segments (see [`crate::point::segment`]) by buckets of the plan. A sealed bucket is a segment too, with every row of
//! its bucket in the order of the plan and nothing in its head that depends on who wrote it.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::Duration;

use crate::error::{Result, StudyError};
use crate::files::write_whole;
use crate::point::columns::listing;
use crate::point::row::Row;
use crate::point::segment::{Belonging, SEGMENT_MAX, Writer, decode, encode};
use crate::sweep::folder::Folder;
use rayreel_settings::files;

/// How often a bucket is listed whose segments go away while they are read, and how long before it is listed again. Once would do on
/// a disk; other machines may see a sealed file somewhat after the segments that it took the place of went away.
const LISTINGS: usize = 20;
const PAUSE: Duration = Duration::from_millis(50);

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
    write_whole(&path, &encode(belonging(folder, bucket), rows, Some(writer))?)
}

/// Seals a bucket that holds a row for each of its points: one file for all. Whoever does it, and if two do it at once, writes the
/// same bytes. Whether it is sealed now.
///
/// # Errors
/// When the folder cannot be read or written.
pub fn seal(folder: &Folder, bucket: usize) -> Result<bool> {
    let held = read(folder, bucket)?;
    if held.sealed && held.segments.is_empty() {
        return Ok(true);
    }
    let points = &folder.plan().points[folder.bucket(bucket)];
    if held.conflict.is_some() || points.iter().any(|point| !held.rows.contains_key(&point.key)) {
        // A conflict is for merge to tell: it needs both rows.
        return Ok(false);
    }
    if !held.sealed {
        let mut rows: Vec<&Row> = Vec::new();
        for point in points {
            if !rows.iter().any(|row| row.key == point.key) {
                rows.push(&held.rows[&point.key]);
            }
        }
        write_whole(&folder.sealed(bucket), &encode(belonging(folder, bucket), rows, None)?)?;
    }
    // Everything in them is in the sealed file now. One that another attempt writes meanwhile stays, and does no harm.
    held.segments.iter().for_each(|path| drop(fs::remove_file(path)));
    Ok(true)
}

/// Reads a bucket.
///
/// # Errors
/// When the folder cannot be read; a segment that has a name and is not there.
pub fn read(folder: &Folder, bucket: usize) -> Result<Bucket> {
    read_beside(folder, bucket, || ())
}

/// As [`read`]; `meanwhile` is what happens between the look for a sealed file and the listing of segments.
fn read_beside(folder: &Folder, bucket: usize, mut meanwhile: impl FnMut()) -> Result<Bucket> {
    let mut listings = 1;
    loop {
        let (mut held, path) = (Bucket::default(), folder.sealed(bucket));
        let sealed = held.add(folder, bucket, &path)?;
        held.sealed = sealed.unwrap_or(false);
        meanwhile();
        let (listed, mut gone) = (listing(&folder.segments(bucket), "seg")?, None);
        // Sealed since the look for it: segments may have gone before they were listed.
        if sealed.is_none() && path.exists() {
            continue;
        }
        for path in listed {
            match held.add(folder, bucket, &path)? {
                None => gone = Some(path),
                Some(true) => held.segments.push(path),
                Some(false) => {}
            }
        }
        // A segment may go away between the listing and its reading, because somebody sealed the bucket: then the sealed file is
        // there. A link to nothing is listed for ever.
        match gone.filter(|_| !held.sealed) {
            None => return Ok(held),
            Some(path) if listings == LISTINGS || path.is_symlink() => {
                let detail = "it has a name and is not there, as a link to nothing; remove it, and its points are computed again";
                return Err(StudyError::input(&path, detail));
            }
            Some(_) => sleep(PAUSE),
        }
        listings += 1;
    }
}

impl Bucket {
    /// Takes in a file: whether it was whole; nothing if it is not there.
    fn add(&mut self, folder: &Folder, bucket: usize, path: &Path) -> Result<Option<bool>> {
        let bytes = match files::read(path, SEGMENT_MAX) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(e) => return Err(StudyError::io(path, "read", e)),
        };
        let Some(rows) = decode(&bytes, belonging(folder, bucket)) else {
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

fn belonging(folder: &Folder, bucket: usize) -> Belonging<'_> {
    Belonging { plan: folder.id(), bucket }
}

/// What is different between two rows of one key.
pub(super) fn difference(a: &Row, b: &Row) -> String {
    if a.error != b.error {
        let word = |row: &Row| row.error.clone().unwrap_or_else(|| "none".into());
        return format!("error {} and {}", word(a), word(b));
    }
    let names = a.figures.keys().chain(b.figures.keys());
    let value = |row: &Row, name: &str| row.figures.get(name).map_or_else(|| "nothing".into(), ToString::to_string);
    let first = names.into_iter().find(|name| a.figures.get(*name) != b.figures.get(*name));
    first.map_or_else(String::new, |name| format!("{name} is {} and {}", value(a, name), value(b, name)))
}

#[cfg(test)]
pub(in crate::sweep) mod tests {
    use rayreel_formats::Limits;
    use rayreel_formats::trace::Trace;

    use super::*;
    use crate::sweep::plan::locate::Text;
    use crate::sweep::plan::{Plan, Sources};

    pub fn open(location: &str) -> Result<Trace, String> {
        Trace::open(Path::new(location), Limits::default()).map_err(|e| e.to_string())
    }

    /// Two buckets of points.
    pub fn two_buckets(path: &Path) -> Folder {
        let trace = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace");
        let text = format!(
            "traces = [{trace:?}]\npolicies = [\"adaptive\"]\nmachines = [\"none\"]\n[[axis]]\nname = \"normal\"\n\
             key = \"similarity.normal_deg\"\nrange = {{ from = 1, to = 70 }}\n"
        );
        let text = Text { name: "plan.toml", text: &text };
        let sources = Sources { text, folder: Path::new(""), traces: None, detail: None, stem: "plan", open: &open };
        Folder::create(path, Plan::new(&sources).unwrap()).unwrap().0
    }

    /// The listing came after the segments were gone, and the look for the sealed file before it was there: rows were missing.
    #[test]
    fn a_bucket_that_is_sealed_meanwhile_is_read_whole() {
        let place = tempfile::tempdir().unwrap();
        let folder = two_buckets(place.path());
        let writer = Writer { attempt: "a".into(), host: "here".into() };
        let points = &folder.plan().points[folder.bucket(1)];
        let row = |key: &String| Row { key: key.clone(), error: Some("none".into()), figures: Default::default() };
        let rows: Vec<Row> = points.iter().map(|point| row(&point.key)).collect();
        write(&folder, 1, 0, &rows, &writer).unwrap();
        let mut times = 0;
        let held = read_beside(&folder, 1, || {
            times += 1;
            assert!(seal(&folder, 1).unwrap());
        });
        let held = held.unwrap();
        assert_eq!((held.sealed, held.rows.len(), times), (true, points.len(), 2));
    }
}
