//! Decided tiles as work for the machine.

pub mod build;
pub mod part;
pub(crate) mod recorded;
pub(crate) mod stream;
