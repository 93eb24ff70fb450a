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
    /// How many of them were computed for a point of that bucket.
    waiting: BTreeMap<usize, usize>,
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
            waiting: BTreeMap::new(),
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

    /// Points that were computed and whose rows are not on disk yet. A row that goes into several buckets is of one of them.
    pub fn waiting(&self) -> usize {
        self.waiting.values().sum()
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
        *self.waiting.entry(point / BUCKET).or_default() += 1;
        let others = self.also.remove(row.key.as_str()).unwrap_or_default();
        for bucket in others.into_iter().chain([point / BUCKET]) {
            self.pending.entry(bucket).or_default().push(row.clone());
            self.left.entry(bucket).and_modify(|left| *left = left.saturating_sub(1));
        }
        Ok(())
    }

    /// Writes all rows that are not on disk yet. A bucket that cannot be written keeps none of the others from it; the first error is
    /// told.
    pub fn flush_all(&mut self) -> Result<()> {
        let buckets: Vec<usize> = self.pending.keys().copied().collect();
        let mut ended = Ok(());
        for bucket in buckets {
            // Written whatever came of those before it.
            ended = ended.and(self.flush(bucket));
        }
        ended
    }

    /// Writes the rows of a bucket; seals it when this shard has done its part. Another shard may have done the rest.
    fn flush(&mut self, bucket: usize) -> Result<()> {
        if let Some(rows) = self.pending.get(&bucket).filter(|rows| !rows.is_empty()) {
            segment::write(self.folder, bucket, self.number, rows, &self.settings.writer)?;
            self.number += 1;
        }
        // Not before they are written: after an error they are tried once more.
        self.pending.remove(&bucket);
        self.waiting.remove(&bucket);
        if self.left.get(&bucket) == Some(&0) {
            segment::seal(self.folder, bucket)?;
            self.left.remove(&bucket);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::fs;
    use std::time::Duration;

    use rayreel_replay::Stop;

    use super::*;
    use crate::point::segment::Writer;
    use crate::sweep::reused::ReusedRows;
    use crate::sweep::segment::tests::{open, two_buckets};
    use crate::sweep::shard::Shard;

    fn settings(reused: &ReusedRows) -> Settings<'_> {
        Settings {
            shard: Shard::WHOLE,
            threads: 1,
            memory: 0,
            flush: Duration::ZERO,
            writer: Writer { attempt: "a".into(), host: "here".into() },
            stop: Stop::never(),
            open: &open,
            reused,
        }
    }

    fn failed(key: &str) -> Row {
        Row { key: key.into(), error: Some("of some kind".into()), figures: Default::default() }
    }

    /// How many rows of a bucket are on disk.
    fn written(folder: &Folder, bucket: usize) -> usize {
        segment::read(folder, bucket).unwrap().rows.len()
    }

    /// Rows of a bucket that could not be written for a moment were lost, and with them those of the buckets behind it.
    #[test]
    fn rows_stay_until_they_are_written() {
        let place = tempfile::tempdir().unwrap();
        let (folder, reused) = (two_buckets(place.path()), ReusedRows::default());
        let settings = settings(&reused);
        let (mut saver, mut outcome) = (Saver::new(&folder, &settings), Outcome::default());
        for point in [0, BUCKET] {
            let row = failed(&folder.plan().points[point].key);
            saver.take(point, row, Vec::new(), &mut outcome).unwrap();
        }
        let rows = |bucket| written(&folder, bucket);
        fs::create_dir_all(folder.path().join("segments")).unwrap();
        fs::write(folder.segments(0), "in the way").unwrap();
        assert!(saver.flush_all().is_err());
        assert_eq!((rows(1), saver.waiting()), (1, 1));
        fs::remove_file(folder.segments(0)).unwrap();
        saver.flush_all().unwrap();
        assert_eq!((rows(0), rows(1), saver.waiting()), (1, 1, 0));
    }

    /// Were it counted in each, more would wait than was computed.
    #[test]
    fn a_row_of_several_buckets_waits_once() {
        let place = tempfile::tempdir().unwrap();
        let (folder, reused) = (two_buckets(place.path()), ReusedRows::default());
        let settings = settings(&reused);
        let (mut saver, mut outcome) = (Saver::new(&folder, &settings), Outcome::default());
        let key = folder.plan().points[0].key.as_str();
        assert!(saver.also_in(key, 1));
        saver.take(0, failed(key), Vec::new(), &mut outcome).unwrap();
        assert_eq!((outcome.computed, saver.waiting()), (1, 1));
        saver.flush_all().unwrap();
        assert_eq!((written(&folder, 0), written(&folder, 1), saver.waiting()), (1, 1, 0));
    }
}
