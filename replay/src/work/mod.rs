//! Decided tiles as work for the machine.

pub mod build;
pub(crate) mod stream;
