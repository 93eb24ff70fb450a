//! Results by key in a folder, without a plan.
//!
//! ```text
//! STORE/KEY.seg            a row: a segment (see `segment`) of one row
//!       KEY.details        details: their bytes behind their hash
//!       columns/HASH.json  what the columns of the rows are
//! ```
//!
//! Every file is complete or absent, and checked when it is read: one that does not hold what it should is taken for missing and
//! written again, so no damage can enter a result. What a result depends on is in its key, so none is ever out of date; and equal
//! results are equal bytes.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use rayreel_formats::durable;
use rayreel_settings::files;

use crate::error::{Result, StudyError};
use crate::files::write_whole;
use crate::point::columns::{listing, read_columns, write_columns};
use crate::point::details::Details;
use crate::point::row::{Column, Row};
use crate::point::segment::{Belonging, SEGMENT_MAX, decode, encode};

/// What stands in its segments instead of a plan.
const NO_PLAN: Belonging<'static> = Belonging { plan: "none", bucket: 0 };

/// Endings of its files.
const ROW: &str = "seg";
const DETAILS: &str = "details";

/// Most bytes of details: pictures of any size may have been wanted of many frames.
const DETAILS_MAX: u64 = 1 << 30;

/// A folder of results.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

impl Store {
    /// The store in a folder.
    ///
    /// # Errors
    /// When the folder cannot be made.
    pub fn open(folder: &Path) -> Result<Self> {
        durable::create_folders(folder).map_err(|e| StudyError::io(folder, "create folder", e))?;
        Ok(Self { folder: folder.into() })
    }

    /// The store in a folder that is there, for reading only.
    pub fn find(folder: &Path) -> Option<Self> {
        folder.is_dir().then(|| Self { folder: folder.into() })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.folder
    }

    fn file(&self, key: &str, ending: &str) -> PathBuf {
        self.folder.join(format!("{key}.{ending}"))
    }

    fn columns(&self) -> PathBuf {
        self.folder.join("columns")
    }

    /// The row of this key, if it is there and whole.
    pub fn row(&self, key: &str) -> Option<Row> {
        let mut rows = decode(&files::read(&self.file(key, ROW), SEGMENT_MAX).ok()?, NO_PLAN)?;
        rows.pop().filter(|row| rows.is_empty() && row.key == key)
    }

    /// The details of this key with so many pictures, if they are there and whole.
    pub fn details(&self, key: &str, pictures: usize) -> Option<Details> {
        let details = Details::decode(&files::read(&self.file(key, DETAILS), DETAILS_MAX).ok()?)?;
        (details.pictures.len() == pictures).then_some(details)
    }

    /// Keeps a row, and before it what its columns are: a row whose columns nobody can explain must not be on disk.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn keep_row(&self, row: &Row, columns: &[Column]) -> Result<()> {
        write_columns(&self.columns(), columns)?;
        write_whole(&self.file(&row.key, ROW), &encode(NO_PLAN, [row], None)?)
    }

    /// Keeps details.
    ///
    /// # Errors
    /// When the folder cannot be written.
    pub fn keep_details(&self, key: &str, details: &Details) -> Result<()> {
        write_whole(&self.file(key, DETAILS), &details.encode()?)
    }

    /// All rows that are whole, by key.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn rows(&self) -> Result<BTreeMap<String, Row>> {
        let key = |path: &PathBuf| Some(path.file_stem()?.to_str()?.to_owned());
        let keys = listing(&self.folder, ROW)?.iter().filter_map(key).collect::<Vec<_>>();
        Ok(keys.iter().filter_map(|key| Some((key.clone(), self.row(key)?))).collect())
    }

    /// What the columns of its rows are, by name.
    ///
    /// # Errors
    /// When the folder cannot be read.
    pub fn read_columns(&self) -> Result<BTreeMap<String, Column>> {
        read_columns(&self.columns())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use serde_json::{Map, json};

    use super::*;
    use crate::point::details::FrameDetails;

    fn row(key: &str) -> (Row, Vec<Column>) {
        let column = Column { name: "cycles".into(), unit: "cycles".into(), description: "length".into() };
        let figures = Map::from_iter([("cycles".to_owned(), json!(12)), ("psnr_db".to_owned(), json!(0.1 + 0.2))]);
        (Row { key: key.into(), error: None, figures }, vec![column])
    }

    fn details() -> Details {
        let frame = FrameDetails { frame: 3, figures: None, tiles: Vec::new() };
        Details { frames: vec![frame], pictures: vec![vec![1, 2, b'\n'], vec![], vec![9; 40]] }
    }

    #[test]
    fn results_come_back() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(&folder.path().join("results")).unwrap();
        assert_eq!((store.row("a"), store.details("a", 3)), (None, None));
        let (kept, columns) = row("a");
        store.keep_row(&kept, &columns).unwrap();
        store.keep_details("a", &details()).unwrap();
        assert_eq!((store.row("a"), store.details("a", 3)), (Some(kept.clone()), Some(details())));
        assert_eq!(store.details("a", 2), None, "asked for with other pictures");
        assert_eq!(store.rows().unwrap().into_values().collect::<Vec<_>>(), [kept]);
        assert_eq!(store.read_columns().unwrap().into_values().collect::<Vec<_>>(), columns);
        assert!(Store::find(&folder.path().join("nothing")).is_none());
    }

    #[test]
    fn no_damage_is_believed() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let (kept, columns) = row("a");
        store.keep_row(&kept, &columns).unwrap();
        store.keep_details("a", &details()).unwrap();
        let spoilt = |ending: &str, there: &dyn Fn() -> bool| {
            let path = store.file("a", ending);
            let bytes = fs::read(&path).unwrap();
            for i in 0..bytes.len() {
                fs::write(&path, &bytes[..i]).unwrap();
                assert!(!there(), "{ending}: {i} of {} bytes", bytes.len());
                let mut changed = bytes.clone();
                changed[i] ^= 1;
                fs::write(&path, changed).unwrap();
                assert!(!there(), "{ending}: bit {i} changed");
            }
            fs::write(&path, bytes).unwrap();
            assert!(there());
        };
        spoilt(DETAILS, &|| store.details("a", 3).is_some());
        spoilt(ROW, &|| store.row("a").is_some());
        // A row under another name is not the one asked for.
        fs::copy(store.file("a", ROW), store.file("b", ROW)).unwrap();
        assert_eq!(store.row("b"), None);
        assert_eq!(store.rows().unwrap().len(), 1);
    }

    /// The first was waited for, the second read without end.
    #[test]
    #[cfg(unix)]
    fn pipes_and_devices_are_no_results() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let place = |name: &str| folder.path().join(name);
        for name in ["a.seg", "a.details"] {
            assert!(std::process::Command::new("mkfifo").arg(place(name)).status().unwrap().success());
        }
        std::os::unix::fs::symlink("/dev/zero", place("b.seg")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", place("b.details")).unwrap();
        for key in ["a", "b"] {
            assert_eq!((store.row(key), store.details(key, 3)), (None, None));
        }
        assert!(store.rows().unwrap().is_empty());
        // What columns are is read before it is written, to see whether it is there.
        let (kept, columns) = row("c");
        store.keep_row(&kept, &columns).unwrap();
        let file = listing(&store.columns(), "json").unwrap().pop().unwrap();
        fs::remove_file(&file).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&file).status().unwrap().success());
        assert!(store.keep_row(&kept, &columns).unwrap_err().to_string().contains("cannot write"));
    }

    #[test]
    fn the_same_result_is_the_same_bytes_and_damaged_columns_are_written_again() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let (kept, columns) = row("a");
        store.keep_row(&kept, &columns).unwrap();
        let file = listing(&store.columns(), "json").unwrap().pop().unwrap();
        let (bytes, described) = (fs::read(store.file("a", ROW)).unwrap(), fs::read(&file).unwrap());
        fs::write(&file, "{").unwrap();
        assert!(store.read_columns().is_err());
        store.keep_row(&kept, &columns).unwrap();
        assert_eq!(fs::read(store.file("a", ROW)).unwrap(), bytes);
        assert_eq!(fs::read(&file).unwrap(), described);
    }
}
