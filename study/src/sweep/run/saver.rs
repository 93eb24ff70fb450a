//! The writer of a run: rows into segments, finished buckets into sealed files.

use std::collections::{BTreeMap, BTreeSet};

use super::shape::{Outcome, Settings};
use crate::error::Result;
use crate::point::columns::write_columns;
use crate::point::row::{Column, Row};
use crate::sweep::folder::Folder;
use crate::sweep::plan::BUCKET;
use crate::sweep::segment;

/// Puts rows into segments, and seals buckets.
pub(super) struct Saver<'a> {
    folder: &'a Folder,
    settings: &'a Settings<'a>,
    /// Rows that are not on disk yet, by bucket.
    pending: BTreeMap<usize, Vec<Row>>,
    /// Points of each bucket that this shard still has to do.
    left: BTreeMap<usize, usize>,
    /// Other buckets with points of a key that is computed for one of them.
    also: BTreeMap<&'a str, BTreeSet<usize>>,
    /// Segments written.
    number: u64,
    /// The columns that were written last: most rows have the same.
    kept: Option<Vec<Column>>,
    /// Whether the columns of rows from elsewhere are written.
    explained: bool,
}

impl<'a> Saver<'a> {
    pub fn new(folder: &'a Folder, settings: &'a Settings<'a>) -> Self {
        Self {
            folder,
            settings,
            pending: BTreeMap::new(),
            left: BTreeMap::new(),
            also: BTreeMap::new(),
            number: 0,
            kept: None,
            explained: false,
        }
    }

    /// Takes a row from elsewhere, if there is one.
    pub fn reuse(&mut self, bucket: usize, key: &str) -> Result<bool> {
        let Some(row) = self.settings.reused.rows.get(key) else { return Ok(false) };
        self.pending.entry(bucket).or_default().push(row.clone());
        if !self.explained {
            write_columns(&self.folder.columns(), &self.settings.reused.columns)?;
            self.explained = true;
        }
        Ok(true)
    }

    /// The row of this key, computed for another bucket, is to be put into this one too: whether that is new.
    pub fn also_in(&mut self, key: &'a str, bucket: usize) -> bool {
        self.also.entry(key).or_default().insert(bucket)
    }

    /// So many points of a bucket are to come.
    pub fn expect(&mut self, bucket: usize, points: usize) -> Result<()> {
        self.left.insert(bucket, points);
        self.flush(bucket)
    }

    /// Rows that are not on disk yet.
    pub fn waiting(&self) -> usize {
        self.pending.values().map(Vec::len).sum()
    }

    /// Takes the row of a point.
    pub fn take(&mut self, point: usize, row: Row, columns: Vec<Column>, outcome: &mut Outcome) -> Result<()> {
        if row.error.is_none() && self.kept.as_ref() != Some(&columns) {
            // Before the rows: a row whose columns nobody can explain must not be on disk.
            write_columns(&self.folder.columns(), &columns)?;
            self.kept = Some(columns);
        }
        outcome.computed += 1;
        outcome.failed += usize::from(row.error.is_some());
        let others = self.also.remove(row.key.as_str()).unwrap_or_default();
        for bucket in others.into_iter().chain([point / BUCKET]) {
            self.pending.entry(bucket).or_default().push(row.clone());
            self.left.entry(bucket).and_modify(|left| *left = left.saturating_sub(1));
        }
        Ok(())
    }

    /// Writes all rows that are not on disk yet.
    pub fn flush_all(&mut self) -> Result<()> {
        let buckets: Vec<usize> = self.pending.keys().copied().collect();
        buckets.into_iter().try_for_each(|bucket| self.flush(bucket))
    }

    /// Writes the rows of a bucket; seals it when this shard has done its part. Another shard may have done the rest.
    fn flush(&mut self, bucket: usize) -> Result<()> {
        if let Some(rows) = self.pending.remove(&bucket).filter(|rows| !rows.is_empty()) {
            segment::write(self.folder, bucket, self.number, &rows, &self.settings.writer)?;
            self.number += 1;
        }
        if self.left.get(&bucket) == Some(&0) {
            segment::seal(self.folder, bucket)?;
            self.left.remove(&bucket);
        }
        Ok(())
    }
}
