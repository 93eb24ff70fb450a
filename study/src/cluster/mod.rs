//! Sweeps on clusters: submission to Slurm, and scripts for other engines.

pub mod export;
pub mod shell;
pub mod slurm;
pub mod submission;
