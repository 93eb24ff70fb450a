//! Tables and their columns: each declared once, where its rows are made, with type, unit and meaning.

use crate::error::{ColumnsError, Result};
use crate::value::{Column, Names, Type};

/// A column of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ColumnInfo {
    /// Its name: lower-case letters, digits and underscores.
    pub name: &'static str,
    /// Type of its values.
    pub kind: Type,
    /// Unit of its values; empty where they have none.
    pub unit: &'static str,
    /// What they are.
    pub meaning: &'static str,
}

/// A table: what a row is, and its columns.
#[derive(Debug, PartialEq, Eq)]
pub struct Table {
    /// Its name, as `rayreel export --what` takes it.
    pub name: &'static str,
    /// What a row is.
    pub row: &'static str,
    /// Its columns, in order.
    pub columns: &'static [ColumnInfo],
}

/// Rows of a table, column by column; all columns have the same number of rows.
#[derive(Clone, Debug, Default)]
pub struct Batch {
    /// In the order of the table's columns.
    pub columns: Vec<Column>,
}

impl Batch {
    /// How many rows.
    pub fn rows(&self) -> usize {
        self.columns.first().map_or(0, Column::len)
    }

    /// Parts of about the same size, of `most` rows at most; none if there is no row.
    pub fn parts(mut self, most: usize) -> Vec<Self> {
        let rows = self.rows();
        if rows == 0 {
            return Vec::new();
        }
        let size = rows.div_ceil(rows.div_ceil(most.max(1)));
        let mut parts = Vec::new();
        // From the end, so that each row is moved once.
        for at in (size..rows).step_by(size).rev() {
            parts.push(Self { columns: self.columns.iter_mut().map(|column| column.split_off(at)).collect() });
        }
        if !parts.is_empty() {
            self.columns.iter_mut().for_each(Column::shrink);
        }
        parts.push(self);
        parts.reverse();
        parts
    }

    /// The columns at `places` alone, in that order.
    #[must_use]
    pub fn select(self, places: &[usize]) -> Self {
        let mut columns: Vec<Option<Column>> = self.columns.into_iter().map(Some).collect();
        Self { columns: places.iter().filter_map(|&place| columns.get_mut(place)?.take()).collect() }
    }
}

/// What is known of rows before the first: the columns that are wanted, and the words of those that hold words.
#[derive(Clone, Debug)]
pub struct Head {
    /// The table.
    pub table: &'static Table,
    /// Which of its columns.
    pub places: Vec<usize>,
    /// The words of each of these columns; no words where a column holds none.
    pub names: Vec<Names>,
}

impl Head {
    /// All columns of a table, of which `empty` is a batch without rows.
    pub fn new(table: &'static Table, empty: &Batch) -> Self {
        let names = empty.columns.iter().map(|column| column.names().cloned().unwrap_or_default()).collect();
        Self { table, places: (0..table.columns.len()).collect(), names }
    }

    /// The columns.
    pub fn columns(&self) -> impl Iterator<Item = (&'static ColumnInfo, &Names)> {
        self.places.iter().map(|&place| &self.table.columns[place]).zip(&self.names)
    }

    /// Only the columns of these names, in this order.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] for a name that the table does not have, one that comes twice, or no name at all.
    pub fn only<S: AsRef<str>>(self, wanted: &[S]) -> Result<Self> {
        let (mut places, mut names) = (Vec::new(), Vec::new());
        for name in wanted.iter().map(AsRef::as_ref) {
            let place = self.places.iter().position(|&place| self.table.columns[place].name == name);
            let Some(place) = place else {
                let all: Vec<_> = self.columns().map(|(column, _)| column.name).collect();
                let table = self.table.name;
                return Err(ColumnsError::Request(format!(
                    "table {table} has no column {name:?}; it has {}",
                    all.join(", ")
                )));
            };
            if places.contains(&self.places[place]) {
                return Err(ColumnsError::Request(format!("column {name:?} is asked for twice; name it once")));
            }
            places.push(self.places[place]);
            names.push(self.names[place].clone());
        }
        if places.is_empty() {
            return Err(ColumnsError::Request("no column is asked for; name one at least".into()));
        }
        Ok(Self { table: self.table, places, names })
    }
}

/// Declares a table with the rows that fill it: a struct with the values of each column, the table's description, and how the one
/// becomes a batch of the other.
macro_rules! table {
    ($(#[$doc:meta])* pub struct $rows:ident = $name:literal, $row:literal {
        $($column:ident: $values:ty, $unit:literal, $meaning:literal;)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Debug, Default)]
        pub struct $rows { $(#[doc = $meaning] pub $column: $values,)* }

        impl $rows {
            /// What the table is.
            pub const TABLE: $crate::schema::Table = $crate::schema::Table {
                name: $name,
                row: $row,
                columns: &[$($crate::schema::ColumnInfo {
                    name: stringify!($column),
                    kind: <$values as $crate::value::Values>::TYPE,
                    unit: $unit,
                    meaning: $meaning,
                },)*],
            };

            /// The rows as a batch.
            pub fn batch(self) -> $crate::schema::Batch {
                $crate::schema::Batch { columns: vec![$($crate::value::Values::column(self.$column),)*] }
            }
        }
    };
}
pub(crate) use table;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_all_rows_in_order() {
        let batch = |rows: u32| Batch {
            columns: vec![Column::U32((0..rows).collect()), Column::Bool(vec![true; rows as usize])],
        };
        for (rows, most, sizes) in [
            (0, 4, vec![]),
            (1, 4, vec![1]),
            (4, 4, vec![4]),
            (5, 4, vec![3, 2]),
            (8, 4, vec![4, 4]),
            (9, 4, vec![3, 3, 3]),
        ] {
            let parts = batch(rows).parts(most);
            assert_eq!(parts.iter().map(Batch::rows).collect::<Vec<_>>(), sizes, "{rows} rows");
            let mut joined = Vec::new();
            for part in &parts {
                let Column::U32(values) = &part.columns[0] else { panic!("another type") };
                assert_eq!(part.columns[1].len(), values.len());
                joined.extend_from_slice(values);
            }
            assert_eq!(joined, (0..rows).collect::<Vec<_>>());
        }
    }
}
