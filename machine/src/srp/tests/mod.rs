//! Tests of the SRP between a mock T&I unit and a mock memory.

mod buffers;
mod cycles;
mod flow;
pub(super) mod mocks;
mod skipping;
