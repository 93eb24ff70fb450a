//! Studies: points of a design space, their results, and what is shown of them.

pub mod error;
pub mod report;
pub mod sweep;

pub use error::{Result, StudyError};
