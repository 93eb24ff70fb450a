//! Sweeps: many points of a design space over recorded traces, on one machine or on many.
//!
//! ```text
//! plan.toml -> Plan (plan.json) -> shards of points -> rows in segments -> merge -> results.parquet
//! ```
//!
//! A [`plan::Plan`] is everything that a worker needs beside the traces: machines and policies as text, and the points. A
//! point's [`key`](crate::point::key) is a hash of all that its result depends on; its [`crate::Row`] is a pure function of the key, so it does
//! not matter who computes it, when, or how often. Rows lie in immutable [`segment`]s of a [`folder::Folder`], and [`merge`] puts
//! them together in the order of the plan. No part of this knows a scheduler: a cluster only calls [`run`] with a shard.

pub mod estimate;
pub mod folder;
pub mod merge;
pub mod plan;
pub mod reused;
pub mod run;
pub mod segment;
pub mod shard;
pub mod status;
