//! The tables that a simulation makes: who asked memory for what and when, and what units counted over time.

mod counters;
mod issue;

pub use counters::{CounterRows, Intervals, names as counter_names};
pub use issue::{Issue, LookupRows, RequestRows, RouteWord};
