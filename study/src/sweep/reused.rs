//! Rows that are there already, elsewhere.

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Result;
use crate::point::columns::read_columns;
use crate::point::row::{Column, Row};
use crate::point::store::Store;
use crate::sweep::folder::{Folder, PLAN};
use crate::sweep::merge::{gather, join};

/// Rows by key, and what their columns are. A row is a pure function of its key, so it does not matter who asked for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReusedRows {
    /// The rows.
    pub rows: BTreeMap<String, Row>,
    /// Their columns.
    pub columns: Vec<Column>,
    /// Rows of sweeps that were left out, because this build would not give their keys to what the plan says.
    pub left_out: usize,
}

/// Where in a cache folder of `rayreel paper` its results lie: a [`Store`].
pub const RESULTS: &str = "results";

impl ReusedRows {
    /// All rows of some folders: of sweeps, or cache folders of `rayreel paper`.
    ///
    /// # Errors
    /// Two rows of one key that differ; a folder that is neither, or that cannot be read.
    pub fn load<P: AsRef<Path>>(folders: impl IntoIterator<Item = P>) -> Result<Self> {
        let mut all = Self::default();
        for folder in folders {
            let folder = folder.as_ref();
            match Store::find(&folder.join(RESULTS)).filter(|_| !folder.join(PLAN).exists()) {
                Some(store) => all.add(store.rows()?, store.read_columns()?)?,
                None => all.add_sweep(folder)?,
            }
        }
        Ok(all)
    }

    fn add_sweep(&mut self, path: &Path) -> Result<()> {
        let (folder, strangers) = Folder::open_for_rows(path)?;
        let mut rows = gather(&folder)?.rows;
        let all = rows.len();
        rows.retain(|key, _| !strangers.contains(key));
        self.left_out += all - rows.len();
        self.add(rows, read_columns(&folder.columns())?)
    }

    fn add(&mut self, rows: BTreeMap<String, Row>, columns: BTreeMap<String, Column>) -> Result<()> {
        join(&mut self.rows, rows)?;
        self.columns.extend(columns.into_values());
        Ok(())
    }
}
