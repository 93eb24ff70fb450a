//! What is in Slurm's queue.

use std::collections::BTreeMap;

use serde::Serialize;

/// The fields of a task that are asked for: id of its array, index in it, state, why it waits. The names of states are never cut
/// off: `%T` is as wide as it must be.
pub const FORMAT: &str = "%F|%K|%T|%r";

/// A task, or a job without tasks.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Id of its array, or its own.
    pub job: String,
    /// Index in the array; none for a job.
    pub index: Option<usize>,
    /// State, as Slurm spells it.
    pub state: String,
    /// Why it waits.
    pub reason: String,
}

/// States behind which nothing happens any more. All others, those that a later Slurm invents too, are of a task that may still run:
/// to wait for one that is gone costs a look, to submit a second one costs its work.
const ENDED: &[&str] = &[
    "BOOT_FAIL",
    "CANCELLED",
    "COMPLETED",
    "DEADLINE",
    "FAILED",
    "LAUNCH_FAILED",
    "NODE_FAIL",
    "OUT_OF_MEMORY",
    "PREEMPTED",
    "RECONFIG_FAIL",
    "REVOKED",
    "TIMEOUT",
];

impl Task {
    /// Whether it waits or runs.
    pub fn is_active(&self) -> bool {
        !ENDED.contains(&self.state.as_str())
    }
}

/// The tasks in what `squeue --noheader --array --format=FORMAT` prints; lines of another kind, such as the name of a cluster, are
/// left out.
pub fn parse(text: &str) -> Vec<Task> {
    let task = |line: &str| {
        let mut fields = line.trim().splitn(4, '|');
        let (job, index, state, reason) = (fields.next()?, fields.next()?, fields.next()?, fields.next()?);
        let whole = !job.is_empty() && job.bytes().all(|b| b.is_ascii_digit());
        whole.then(|| Task { job: job.into(), index: index.parse().ok(), state: state.into(), reason: reason.into() })
    };
    text.lines().filter_map(task).collect()
}

/// The tasks of a submission, counted.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct Counts {
    /// Tasks that wait.
    pub pending: usize,
    /// Tasks that run.
    pub running: usize,
    /// Tasks that ended well, of those that Slurm still knows: it forgets a task some minutes after its end.
    pub completed: usize,
    /// Tasks that ended in any other way, of those.
    pub failed: usize,
    /// Why tasks wait: reasons and how many have them.
    pub reasons: BTreeMap<String, usize>,
    /// State of the merge, if Slurm knows it.
    pub merge: Option<String>,
}

impl Counts {
    /// Counts tasks of these arrays, and finds this merge.
    pub fn new(tasks: &[Task], arrays: &[&str], merge: Option<&str>) -> Self {
        let mut counts = Self::default();
        for task in tasks {
            if merge == Some(task.job.as_str()) {
                counts.merge = Some(task.state.clone());
            } else if arrays.contains(&task.job.as_str()) {
                counts.add(task);
            }
        }
        counts
    }

    fn add(&mut self, task: &Task) {
        match task.state.as_str() {
            "COMPLETED" => self.completed += 1,
            // The work of a completing task is done; its node is being cleaned.
            "RUNNING" | "COMPLETING" | "CONFIGURING" | "SUSPENDED" | "STAGE_OUT" | "SIGNALING" => self.running += 1,
            _ if task.is_active() => {
                self.pending += 1;
                *self.reasons.entry(task.reason.clone()).or_default() += 1;
            }
            _ => self.failed += 1,
        }
    }

    /// One line for people.
    pub fn line(&self) -> String {
        let mut parts = Vec::new();
        let mut part = |count: usize, what: String| {
            if count > 0 {
                parts.push(format!("{count} {what}"));
            }
        };
        let reasons: Vec<String> = self.reasons.iter().map(|(reason, count)| format!("{reason} {count}")).collect();
        part(self.running, "running".into());
        part(self.pending, format!("pending ({})", reasons.join(", ")));
        part(self.completed, "ended".into());
        part(self.failed, "failed".into());
        if parts.is_empty() {
            parts.push("no task in the queue".into());
        }
        if let Some(merge) = &self.merge {
            parts.push(format!("merge {}", merge.to_lowercase()));
        }
        parts.join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SEEN: &str = "CLUSTER: alpha\n7|0|RUNNING|None\n7|1|PENDING|Resources\n7|2|PENDING|BeginTime\n7|10|PENDING|Resources\n\
                        7|3|FAILED|NonZeroExitCode\n7|4|COMPLETED|None\n7|5|COMPLETING|None\n8|N/A|PENDING|Dependency\n\
                        9|0|RUNNING|None\n7|6|REQUEUE_HOLD|launch failed, requeued held\n\n";

    #[test]
    fn tasks_are_read() {
        let tasks = parse(SEEN);
        assert_eq!(tasks.len(), 10);
        let state = |state: &str, reason: &str| (state.to_owned(), reason.to_owned());
        let of = |i: usize| (tasks[i].job.as_str(), tasks[i].index, state(&tasks[i].state, &tasks[i].reason));
        assert_eq!(of(0), ("7", Some(0), state("RUNNING", "None")));
        assert_eq!(of(3), ("7", Some(10), state("PENDING", "Resources")));
        assert_eq!(of(7), ("8", None, state("PENDING", "Dependency")));
        assert_eq!(of(9), ("7", Some(6), state("REQUEUE_HOLD", "launch failed, requeued held")));
        assert!(parse("slurm_load_jobs error: Invalid job id specified\n").is_empty());
    }

    #[test]
    fn tasks_are_counted() {
        let counts = Counts::new(&parse(SEEN), &["7"], Some("8"));
        assert_eq!((counts.running, counts.pending, counts.completed, counts.failed), (2, 4, 1, 1));
        assert_eq!(
            counts.line(),
            "2 running, 4 pending (BeginTime 1, Resources 2, launch failed, requeued held 1), 1 ended, 1 failed, merge pending"
        );
        assert_eq!(Counts::new(&[], &["7"], Some("8")).line(), "no task in the queue");
    }

    #[test]
    fn a_state_that_nobody_knows_is_not_the_end() {
        let active: Vec<bool> = parse(SEEN).iter().map(Task::is_active).collect();
        assert_eq!(active, [true, true, true, true, false, false, true, true, true, true]);
        assert!(parse("1|2|SOMETHING_NEW|None")[0].is_active());
    }
}
