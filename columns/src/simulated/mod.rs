//! The tables that a simulation makes: who asked memory for what and when, what units counted over time, and when tiles were under way.

mod counters;
mod issue;
mod table_probe;
mod tiles;

pub use counters::{CounterRows, Intervals, names as counter_names};
pub use issue::{Issue, LookupRows, RequestRows, RouteWord};
pub use table_probe::TableProbe;
pub use tiles::{TileTimeRows, TileTimes};
