//! Sweeps on a Slurm cluster: what is said to Slurm, and what it answers.
//!
//! ```text
//! shards that miss points -> arrays (by the site's limits) -> sbatch lines + scripts -> submission record
//! squeue's lines -> states of the tasks -> which shards need not be submitted again
//! ```
//!
//! Everything here is text in, text out; the program makes the calls. Only formats that Slurm promises to scripts are read
//! (`--parsable`, `--noheader --format`, `scontrol show config`). Slurm decides when and where a shard runs, and never whether
//! a result is right: rows are found in the segments alone, so a task that ran twice, or that Slurm lost, changes nothing.

pub mod arrays;
pub mod indices;
pub mod limits;
pub mod queue;
pub mod sbatch;
pub mod script;
