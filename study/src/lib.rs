//! Studies: points of a design space, their results, and what is shown of them.

pub mod analysis;
#[cfg(feature = "cluster")]
pub mod cluster;
pub mod compare;
pub mod error;
pub mod files;
#[cfg(feature = "html")]
pub mod html;
pub mod point;
pub mod policy_text;
pub mod pool;
pub mod report;
pub mod schema;
pub mod sweep;
pub mod table;

pub use error::{Result, StudyError};
