//! Settings of machines and policies: what is common to both.

mod near;

pub use near::near;
