//! What changed from one table of results to another: the regression gate of `rayreel compare`.
//!
//! Points are matched by what they are and not by their keys: a key changes with every constant of the model, and what that does to
//! the results is the very question.

mod change;
mod comparison;
mod estimates;
mod json;
mod options;
mod pairs;
pub mod run;
mod select;
mod side;
#[cfg(test)]
mod tests;
mod text;

pub use change::{Change, ConfigChange, Largest, StateChange};
pub use comparison::Comparison;
pub use json::json;
pub use options::Options;
pub use select::Select;
pub use side::Side;
pub use text::text;
