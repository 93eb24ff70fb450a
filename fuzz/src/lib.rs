//! Every reader of Rayreel against inputs that nobody wrote.
//!
//! A [`Target`] is one kind of input: how it is read, where its first inputs come from, and what else than its bytes is mended after
//! a change (lengths, checksums), so that lies get past the first door. [`run`](runner::run) makes inputs from those that it
//! keeps and reads them, one after the other, until the time is over. An input is kept if it led to something new: a message that
//! no other led to, and code that no other ran where the build counts that (`fuzz/coverage.sh`).
//!
//! An input fails if it makes the reader panic, hold more memory than [`memory::BUDGET`], or take longer than the limit of time.
//! The program `rayreel-fuzz` runs each target in processes of its own, so that an abort costs one input and not the run.
//!
//! The same seed gives the same inputs, one by one, on every machine that counts the same coverage.

pub mod coverage;
pub mod kept;
pub mod memory;
pub mod mutate;
pub mod place;
pub mod random;
pub mod runner;
pub mod seeds;
pub mod target;
pub mod targets;
pub mod traces;

pub use target::Target;
pub use targets::all;
