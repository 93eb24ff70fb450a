//! Studies: points of a design space, their results, and what is shown of them.

pub mod analysis;
pub mod cluster;
pub mod compare;
pub mod error;
pub mod figures;
pub mod html;
pub mod point;
pub mod report;
pub mod schema;
pub mod sweep;
pub mod table;

pub use error::{Result, StudyError};
