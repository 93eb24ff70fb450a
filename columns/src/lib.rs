//! What a trace holds, and what a simulation of it does, as typed columns: for data frames, for files that Python and databases read,
//! for programs of your own.
//!
//! ```text
//! Data (trace, table, frames, tiles, policy, machine) -> batches of columns, in order -> Encoder -> Sink (a file, whole or absent)
//! ```
//!
//! A table ([`What`]) is declared once, where its rows are made: the name, type, unit and meaning of each column ([`Table`]).
//! [`Data::run`] makes batches in parallel and hands them on in order, few at a time, so memory does not depend on the length of a
//! trace. [`Data::collect`] gives all at once. Files are NumPy arrays or, with the features of these names, `parquet`, `csv` and
//! `jsonl`; their bytes do not depend on the number of threads.
//!
//! ```
//! use rayreel_columns::{Column, Data, What};
//! use rayreel_formats::{Limits, Trace};
//!
//! let trace = Trace::open("../traces/v1_0_cornell.rtrace".as_ref(), Limits::default())?;
//! let rays = Data::new(&trace, What::Rays).collect()?;
//! let t = What::Rays.table().columns.iter().position(|column| column.name == "t").expect("it is declared");
//! let Column::F32(t) = &rays.columns[t] else { panic!("declared as f32") };
//! assert_eq!((rays.rows(), t.iter().filter(|t| t.is_finite()).count()), (10_051, 5_252));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod aov;
pub mod data;
pub mod error;
pub mod order;
pub mod rows;
pub mod schema;
pub mod select;
pub mod simulated;
pub mod sink;
pub mod value;
pub mod what;

pub use data::{Data, Use};
pub use error::{ColumnsError, Result};
pub use schema::{Batch, ColumnInfo, Head, Table};
pub use select::Selection;
pub use sink::{Encoded, Encoder, Format, Sink};
pub use value::{Column, Names, Type, Words};
pub use what::{Choice, What};
