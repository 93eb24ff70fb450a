//! What is asked of a cluster.

use rayreel_study::cluster::slurm::sbatch::Options;

/// What is to be submitted.
pub struct Submit {
    /// Into how many shards the plan is split.
    pub shards: usize,
    /// Arguments of `sweep run`.
    pub run: Vec<String>,
    /// `--patience` of the merge.
    pub patience: String,
    /// Options of sbatch.
    pub options: Options,
}
