//! The folder of a sweep.
//!
//! ```text
//! SWEEP/plan.json                          the plan, written once
//!       segments/000012/ATTEMPT-000003.seg rows of points 768..832, written by one attempt, never changed
//!       sealed/000012.seg                  all rows of these points: any attempt writes the same bytes
//!       columns/HASH.json                  what the columns of the rows are
//!       attempts/ATTEMPT.json              who did what, when: telemetry, in no result
//!       submissions/001.json               what was submitted to a cluster
//!       logs/                              output of cluster jobs
//!       results.parquet, results.csv       made by merge
//! ```
//!
//! Rows lie by *buckets* of consecutive points and not by shards: so every way of splitting the plan finds what any other way
//! has finished. Every file is complete or absent.

use std::collections::BTreeSet;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use crate::error::{Result, StudyError};
use crate::files::write_once;
use crate::sweep::plan::{BUCKET, Plan};
use rayreel_formats::durable;
use rayreel_settings::files;

/// The folder with its plan.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
    plan: Plan,
    id: String,
}

/// What came of [`Folder::create`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Created {
    /// The plan was written.
    New,
    /// The folder held this very plan.
    Known,
}

/// Name of the plan in its folder.
pub const PLAN: &str = "plan.json";

/// Most bytes of it: some hundreds for each of a million points.
const PLAN_MAX: u64 = 1 << 30;

impl Folder {
    /// Puts a plan into a folder. The plan of a folder never changes.
    ///
    /// # Errors
    /// The folder holds another plan, or cannot be written.
    pub fn create(path: &Path, plan: Plan) -> Result<(Self, Created)> {
        let (id, file) = (plan.id(), path.join(PLAN));
        durable::create_folders(path).map_err(|e| StudyError::io(path, "create", e))?;
        // Of two plans for one folder at the same moment one is refused: that there was none a moment ago does not count.
        if file.exists() || !write_once(&file, &plan.to_json()?)? {
            let known = Self::open(path)?;
            if known.id == id {
                return Ok((known, Created::Known));
            }
            let detail = format!(
                "holds plan {} ({} points), not plan {id} ({} points); choose another folder with -o, and --reuse this one to keep \
                 the rows that both need",
                known.id,
                known.plan.points.len(),
                plan.points.len()
            );
            return Err(StudyError::input(path, detail));
        }
        Ok((Self { path: path.into(), plan, id }, Created::New))
    }

    /// Opens the folder of a sweep.
    ///
    /// # Errors
    /// No plan in it, one that this program cannot carry out, or one that was changed or damaged.
    pub fn open(path: &Path) -> Result<Self> {
        Self::open_as(path, |bytes| Ok((Plan::from_json(bytes)?, ()))).map(|(folder, ())| folder)
    }

    /// Opens the folder of a sweep whose rows are wanted: that of a build with other presets will do. Gives also the keys under which rows
    /// are not to be trusted ([`Plan::for_its_rows`]).
    ///
    /// # Errors
    /// No plan in it, one of another layout or model, or one that was changed or damaged.
    pub fn open_for_rows(path: &Path) -> Result<(Self, BTreeSet<String>)> {
        Self::open_as(path, Plan::for_its_rows)
    }

    fn open_as<T>(path: &Path, plan: impl Fn(&[u8]) -> Result<(Plan, T), String>) -> Result<(Self, T)> {
        let file = path.join(PLAN);
        let bytes = files::read(&file, PLAN_MAX).map_err(|e| match e.kind() {
            ErrorKind::NotFound | ErrorKind::NotADirectory | ErrorKind::InvalidInput | ErrorKind::InvalidData => {
                StudyError::input(&file, format!("{e}; is this the folder of a sweep? `rayreel sweep plan` makes one"))
            }
            _ => StudyError::io(&file, "read", e),
        })?;
        let (plan, more) = plan(&bytes).map_err(|detail| StudyError::Corrupt { path: file.clone(), detail })?;
        let id = plan.id();
        Ok((Self { path: path.into(), plan, id }, more))
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its plan.
    pub fn plan(&self) -> &Plan {
        &self.plan
    }

    /// The id of its plan.
    pub fn id(&self) -> &str {
        &self.id
    }

    /// How many buckets its points are in.
    pub fn buckets(&self) -> usize {
        self.plan.points.len().div_ceil(BUCKET)
    }

    /// The points of a bucket.
    pub fn bucket(&self, bucket: usize) -> std::ops::Range<usize> {
        bucket * BUCKET..((bucket + 1) * BUCKET).min(self.plan.points.len())
    }

    /// The folder of a bucket's segments.
    pub fn segments(&self, bucket: usize) -> PathBuf {
        self.path.join("segments").join(format!("{bucket:06}"))
    }

    /// The file of a bucket that is done.
    pub fn sealed(&self, bucket: usize) -> PathBuf {
        self.path.join("sealed").join(format!("{bucket:06}.seg"))
    }

    /// The descriptions of columns.
    pub fn columns(&self) -> PathBuf {
        self.path.join("columns")
    }

    /// Telemetry.
    pub fn attempts(&self) -> PathBuf {
        self.path.join("attempts")
    }
}
