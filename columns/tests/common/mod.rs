//! What the tests share: the traces of the repository, and columns by name.

#![allow(dead_code, reason = "no test uses all of it")]

use std::path::Path;

use rayreel_columns::{Batch, Column, Data, What};
use rayreel_formats::{Limits, Trace};

/// The traces of the repository.
pub fn traces() -> Vec<Trace> {
    ["cornell", "teapot"].map(trace).into()
}

/// One of them.
pub fn trace(scene: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../traces/v1_0_{scene}.rtrace"));
    Trace::open(&path, Limits::default()).unwrap()
}

/// A batch of all columns of a table.
pub struct Rows(pub What, pub Batch);

impl Rows {
    /// All rows.
    pub fn of(data: &Data<'_>) -> Self {
        Self(data.what, data.collect().unwrap())
    }

    /// How many rows.
    pub fn len(&self) -> usize {
        self.1.rows()
    }

    /// A column.
    pub fn column(&self, name: &str) -> &Column {
        let place = self.0.table().columns.iter().position(|column| column.name == name);
        &self.1.columns[place.unwrap_or_else(|| panic!("no column {name}"))]
    }

    /// The whole numbers of a column.
    pub fn integers(&self, name: &str) -> Vec<i64> {
        match self.column(name) {
            Column::U8(values) => values.iter().map(|&v| v.into()).collect(),
            Column::I8(values) => values.iter().map(|&v| v.into()).collect(),
            Column::U16(values) => values.iter().map(|&v| v.into()).collect(),
            Column::U32(values) => values.iter().map(|&v| v.into()).collect(),
            Column::I32(values) => values.iter().map(|&v| v.into()).collect(),
            Column::U64(values) => values.iter().map(|&v| v.try_into().unwrap()).collect(),
            Column::I64(values) => values.clone(),
            Column::Bool(values) => values.iter().map(|&v| v.into()).collect(),
            other => panic!("{name} holds no whole numbers: {other:?}"),
        }
    }

    /// The floats of a column.
    pub fn floats(&self, name: &str) -> &[f32] {
        let Column::F32(values) = self.column(name) else { panic!("{name} holds no floats") };
        values
    }

    /// The words of a column.
    pub fn words(&self, name: &str) -> Vec<&str> {
        let Column::Word(words) = self.column(name) else { panic!("{name} holds no words") };
        words.codes.iter().map(|&code| words.names.get(code)).collect()
    }

    /// How many rows have this word in a column.
    pub fn count(&self, name: &str, word: &str) -> u64 {
        self.words(name).into_iter().filter(|other| *other == word).count() as u64
    }
}
