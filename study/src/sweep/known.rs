//! Rows that other sweeps have.

use std::collections::BTreeMap;

use crate::error::Result;
use crate::point::row::{Column, Row};
use crate::sweep::folder::Folder;
use crate::sweep::merge::gather;
use crate::sweep::segment;

/// Rows by key, and what their columns are. A row is a pure function of its key, so it does not matter which plan asked for it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// The rows.
    pub rows: BTreeMap<String, Row>,
    /// Their columns.
    pub columns: Vec<Column>,
}

impl Known {
    /// All rows of some sweeps.
    ///
    /// # Errors
    /// Two rows of one key that differ; a folder that cannot be read.
    pub fn load<'a>(folders: impl IntoIterator<Item = &'a Folder>) -> Result<Self> {
        let mut all = Self::default();
        for folder in folders {
            all.rows.extend(gather(folder)?.rows);
            all.columns.extend(segment::read_columns(folder)?.into_values());
        }
        Ok(all)
    }
}
