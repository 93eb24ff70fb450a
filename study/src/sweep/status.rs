//! How far a sweep is.

use serde::Serialize;

use crate::error::Result;
use crate::sweep::folder::Folder;
use crate::sweep::segment;
use crate::sweep::shard::Shard;

/// How far a sweep is, from its segments alone.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Status {
    /// Id of the plan.
    pub plan: String,
    /// Points of the plan.
    pub points: usize,
    /// Points that have a row.
    pub done: usize,
    /// Those of them that cannot be computed.
    pub failed: usize,
    /// Rows beyond the first of a key.
    pub duplicates: usize,
    /// Segments that are damaged and were ignored.
    pub damaged: usize,
    /// Points without a row.
    #[serde(skip)]
    pub missing: Vec<usize>,
}

/// Looks at all buckets.
///
/// # Errors
/// A folder that cannot be read.
pub fn status(folder: &Folder) -> Result<Status> {
    let points = &folder.plan().points;
    let mut found = Status {
        plan: folder.id().into(),
        points: points.len(),
        done: 0,
        failed: 0,
        duplicates: 0,
        damaged: 0,
        missing: Vec::new(),
    };
    for bucket in 0..folder.buckets() {
        let held = segment::read(folder, bucket)?;
        found.duplicates += held.duplicates;
        found.damaged += held.damaged.len();
        for point in folder.bucket(bucket) {
            match held.rows.get(&points[point].key) {
                None => found.missing.push(point),
                Some(row) => {
                    found.done += 1;
                    found.failed += usize::from(row.error.is_some());
                }
            }
        }
    }
    Ok(found)
}

impl Status {
    /// The shards of `count` that miss points.
    pub fn shards(&self, count: usize) -> Vec<usize> {
        Shard::with(&self.missing, self.points, count)
    }
}
