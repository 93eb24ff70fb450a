//! The jobs of a sweep, for people who ask how far it is.

use anyhow::Result;
use rayreel_study::cluster::slurm::indices;
use rayreel_study::cluster::slurm::queue::Counts;
use rayreel_study::cluster::slurm::sbatch::parts;
use rayreel_study::cluster::submission::Submission;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::shard::Shard;
use rayreel_study::sweep::status::Status;
use serde_json::{Value, json};

use super::slurm;

/// The last submission, and what the engine says of it.
pub struct Jobs {
    last: Submission,
    /// Why there are none: no Slurm here, or one that does not answer.
    counts: Result<Counts, String>,
}

impl Jobs {
    /// Asks; nothing if the sweep was never submitted.
    pub fn look(folder: &Folder) -> Result<Option<Self>> {
        let all = Submission::all(folder)?;
        let Some(last) = all.last().cloned() else { return Ok(None) };
        let counts = if slurm::is_here() {
            slurm::tasks(folder.id(), &all).map_err(|e| format!("{e:#}"))
        } else {
            Err("no Slurm here".into())
        };
        let counts = counts.map(|mut tasks| {
            // Of earlier submissions only what is still to come counts: what failed there was submitted again since.
            tasks.retain(|task| task.is_active() || last.jobs().any(|job| parts(job).0 == task.job));
            let arrays: Vec<&str> =
                all.iter().flat_map(|submission| &submission.arrays).map(|array| parts(&array.job).0).collect();
            Counts::new(&tasks, &arrays, last.merge.as_deref().map(|job| parts(job).0))
        });
        Ok(Some(Self { last, counts }))
    }

    /// Lines for people.
    pub fn text(&self, status: &Status) -> String {
        let jobs: Vec<&str> = self.last.jobs().collect();
        let seen = self.counts.as_ref().map_or_else(|why| format!("unknown, {why}"), Counts::line);
        let mut text = format!(
            "submission {} to {}, {} shards, jobs {}: {seen}\n",
            self.last.number,
            self.last.engine,
            self.last.shards,
            jobs.join(" "),
        );
        let missing = status.shards(self.last.shards);
        if !missing.is_empty() {
            text += &format!("shards that miss points: {}\n", indices::list(&missing));
        }
        text
    }

    /// The same for programs.
    pub fn json(&self, status: &Status) -> Value {
        json!({
            "number": self.last.number,
            "engine": self.last.engine,
            "shards": self.last.shards,
            "missing_shards": status.shards(self.last.shards),
            "jobs": self.last.jobs().collect::<Vec<_>>(),
            "queue": self.counts.as_ref().ok(),
        })
    }
}

/// The shards of the last submission that miss points, as merge tells them. A record that cannot be read is no reason not to merge.
pub fn shards(folder: &Folder, missing: &[usize]) -> Option<String> {
    let last = match Submission::last(folder) {
        Ok(last) => last?,
        Err(error) => return Some(format!("warning: {error}")),
    };
    let shards = Shard::with(missing, folder.plan().points.len(), last.shards);
    let (list, all, number) = (indices::list(&shards), last.shards, last.number);
    Some(format!("shards that miss points: {list} (of {all}, submission {number})"))
}
