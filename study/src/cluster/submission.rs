//! What was submitted to an engine, and when.
//!
//! ```text
//! SWEEP/submissions/001.json      the record: job ids, arrays, options, command lines
//!       submissions/001/shard.sh  the scripts, as they were submitted
//! ```
//!
//! Records say which jobs to ask about and to cancel, and how to submit again. No result depends on them: a folder without them
//! merges just as well.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use rayreel_formats::durable;

use crate::cluster::slurm::queue::Task;
use crate::cluster::slurm::sbatch::{Options, parts};
use crate::error::{Result, StudyError};
use crate::files::write_whole;
use crate::point::columns::listing;
use crate::sweep::folder::Folder;
use crate::sweep::plan::LAYOUT;

/// The engine that there is.
pub const SLURM: &str = "slurm";

/// An array of jobs.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Jobs {
    /// Its id, with `;CLUSTER` behind it where there are several clusters.
    pub job: String,
    /// Task `t` is shard `offset + t`.
    pub offset: usize,
    /// Its tasks, as `sbatch --array` has them.
    pub tasks: String,
}

/// A submission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Submission {
    /// [`LAYOUT`].
    pub layout: u32,
    /// From 1.
    pub number: u32,
    /// [`SLURM`].
    pub engine: String,
    /// Id of the plan.
    pub plan: String,
    /// Into how many shards the plan was split.
    pub shards: usize,
    /// The arrays.
    pub arrays: Vec<Jobs>,
    /// The merge, once it is submitted.
    pub merge: Option<String>,
    /// The options.
    pub options: Options,
    /// Arguments of `sweep run` in the script.
    pub run: Vec<String>,
    /// `--patience` of the merge.
    pub patience: String,
    /// The command lines, to be pasted into a shell.
    pub commands: Vec<String>,
    /// When.
    pub submitted_unix_s: u64,
}

impl Submission {
    /// All submissions of a sweep, the first one first.
    ///
    /// # Errors
    /// A record that cannot be read.
    pub fn all(folder: &Folder) -> Result<Vec<Self>> {
        let files = listing(&records(folder), "json")?;
        let mut all = files.iter().map(|file| Self::read(file)).collect::<Result<Vec<_>>>()?;
        all.sort_by_key(|submission| submission.number);
        Ok(all)
    }

    /// The last one.
    ///
    /// # Errors
    /// As [`Self::all`].
    pub fn last(folder: &Folder) -> Result<Option<Self>> {
        Ok(Self::all(folder)?.pop())
    }

    fn read(file: &Path) -> Result<Self> {
        let bytes = rayreel_settings::files::read(file, 1 << 24).map_err(|e| StudyError::io(file, "read", e))?;
        let bad = |why: String| {
            StudyError::input(file, format!("is no record of a submission: {why}; remove it if its jobs are gone"))
        };
        let submission: Self = serde_json::from_slice(&bytes).map_err(|e| bad(e.to_string()))?;
        let Self { layout, shards, number, .. } = submission;
        // The next one has a number too.
        if layout != LAYOUT || shards == 0 || number == u32::MAX {
            return Err(bad(format!("layout {layout}, {shards} shards, number {number}")));
        }
        // They become words of squeue and scancel.
        if let Some(job) = submission.jobs().find(|job| !is_job(job)) {
            return Err(bad(format!("{job:?} is no id of a job")));
        }
        Ok(submission)
    }

    /// Writes the record: again after every job that was submitted, so that no job is forgotten if this program is killed meanwhile.
    ///
    /// # Errors
    /// When it cannot be written.
    pub fn write(&self, folder: &Folder) -> Result<()> {
        let mut bytes = serde_json::to_vec_pretty(self).map_err(StudyError::json)?;
        bytes.push(b'\n');
        write_whole(&records(folder).join(format!("{:03}.json", self.number)), &bytes)
    }

    /// Ids of all its jobs.
    pub fn jobs(&self) -> impl Iterator<Item = &str> {
        self.arrays.iter().map(|array| array.job.as_str()).chain(self.merge.as_deref())
    }

    /// The shards of which a task still waits or runs, with the id of its array.
    pub fn active(&self, tasks: &[Task]) -> Vec<(usize, String)> {
        let shard = |task: &Task| {
            let array = self.arrays.iter().find(|array| parts(&array.job).0 == task.job)?;
            Some((array.offset.saturating_add(task.index?), task.job.clone()))
        };
        tasks.iter().filter(|task| task.is_active()).filter_map(shard).collect()
    }
}

/// Whether a text is the id of a job, with `;CLUSTER` behind it where there are several.
fn is_job(text: &str) -> bool {
    let (id, cluster) = text.split_once(';').unwrap_or((text, "c"));
    let plain = |c: u8| c.is_ascii_alphanumeric() || b"_.".contains(&c) || c == b'-';
    let digits = !id.is_empty() && id.bytes().all(|b| b.is_ascii_digit());
    digits && !cluster.is_empty() && !cluster.starts_with('-') && cluster.bytes().all(plain)
}

fn records(folder: &Folder) -> PathBuf {
    folder.path().join("submissions")
}

/// Where the scripts of a submission are.
pub fn scripts(folder: &Folder, number: u32) -> PathBuf {
    records(folder).join(format!("{number:03}"))
}

/// Takes the next number, for this program alone, by making the folder of its scripts.
///
/// # Errors
/// When the folder cannot be written.
pub fn claim(folder: &Folder) -> Result<u32> {
    durable::create_folders(&records(folder)).map_err(|e| StudyError::io(&records(folder), "create", e))?;
    let mut number = next(folder)?;
    loop {
        let path = scripts(folder, number);
        match fs::create_dir(&path) {
            Ok(()) => return Ok(number),
            Err(e) if e.kind() == io::ErrorKind::AlreadyExists => number += 1,
            Err(e) => return Err(StudyError::io(&path, "create", e)),
        }
    }
}

/// The number that [`claim`] would begin with.
///
/// # Errors
/// As [`Submission::all`].
pub fn next(folder: &Folder) -> Result<u32> {
    Ok(Submission::last(folder)?.map_or(1, |last| last.number + 1))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cluster::slurm::queue;

    fn submission() -> Submission {
        let jobs = |job: &str, offset: usize, tasks: &str| Jobs { job: job.into(), offset, tasks: tasks.into() };
        Submission {
            layout: LAYOUT,
            number: 2,
            engine: SLURM.into(),
            plan: "8c62bfbd01234567".into(),
            shards: 1500,
            arrays: vec![jobs("7;alpha", 0, "0-1000"), jobs("8;alpha", 1001, "0-498")],
            merge: Some("9;alpha".into()),
            options: Options::default(),
            run: Vec::new(),
            patience: "90s".into(),
            commands: Vec::new(),
            submitted_unix_s: 0,
        }
    }

    #[test]
    fn active_shards_are_those_of_tasks_that_may_still_run() {
        let tasks = queue::parse(
            "7|3|RUNNING|None\n8|2|PENDING|Resources\n8|3|FAILED|None\n9|N/A|PENDING|Dependency\n1|1|RUNNING|None",
        );
        assert_eq!(submission().active(&tasks), [(3, "7".to_owned()), (1003, "8".to_owned())]);
        assert_eq!(submission().jobs().collect::<Vec<_>>(), ["7;alpha", "8;alpha", "9;alpha"]);
    }

    #[test]
    fn records_are_read_as_they_were_written() {
        let text = serde_json::to_vec(&submission()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("002.json");
        fs::write(&file, &text).unwrap();
        assert_eq!(Submission::read(&file).unwrap(), submission());
        let foreign = Submission { merge: Some("--all".into()), ..submission() };
        fs::write(&file, serde_json::to_vec(&foreign).unwrap()).unwrap();
        assert!(Submission::read(&file).unwrap_err().to_string().contains("is no id of a job"));
        fs::write(&file, &text[..text.len() / 2]).unwrap();
        assert!(Submission::read(&file).unwrap_err().to_string().contains("is no record of a submission"));
    }
}
