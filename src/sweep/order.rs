//! Carrying out a submission to Slurm: scripts, arrays, merge, record.

use std::path::PathBuf;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use anyhow::{Context, Result};
use rayreel_study::cluster::shell::{line, quote};
use rayreel_study::cluster::slurm::arrays::{Array, running, split};
use rayreel_study::cluster::slurm::limits::Limits;
use rayreel_study::cluster::slurm::queue::Task;
use rayreel_study::cluster::slurm::sbatch::{self, Common, parts};
use rayreel_study::cluster::slurm::script::{self, Job};
use rayreel_study::cluster::submission::{self, Jobs, SLURM, Submission};
use rayreel_study::files::write_whole;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::plan::LAYOUT;
use rayreel_study::sweep::status;

use super::folder::absolute;
pub use super::request::Submit;
use super::{merge, plan, slurm, trust};
use crate::common::print;
use crate::exit::Exit;

/// What happens beside submitting.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct SubmitArgs {
    /// Print the scripts and the sbatch lines; submit and write nothing.
    #[arg(long)]
    pub dry_run: bool,
    /// Wait for the merge, and end with its code. Ctrl-C leaves the jobs alone.
    #[arg(long, conflicts_with = "dry_run")]
    pub wait: bool,
}

/// What else decides how it is submitted.
pub struct SubmitContext<'a> {
    /// What was asked for.
    pub args: SubmitArgs,
    /// Shards that are in the queue already, with the ids of their arrays.
    pub active: &'a [(usize, String)],
    /// The last submission, for one that has nothing to add.
    pub last: Option<&'a Submission>,
}

/// Submits the shards that miss points and are not in the queue.
pub fn carry_out(folder: &Folder, order: &Submit, limits: Limits, how: SubmitContext<'_>) -> Result<Exit> {
    let status = status::status(folder)?;
    let sweep = quote(&folder.path().display().to_string());
    let missing = status.shards(order.shards);
    if missing.is_empty() {
        print(&format!("all {} points are there: `rayreel sweep merge {sweep}`\n", status.points))?;
        return if how.args.wait { merge::all(folder, 0.0) } else { Ok(Exit::Done) };
    }
    let queued = |shard: &usize| how.active.iter().any(|(active, _)| active == shard);
    let todo: Vec<usize> = missing.iter().copied().filter(|shard| !queued(shard)).collect();
    if todo.is_empty() {
        print(&format!(
            "all {} shards that miss points are in the queue: `rayreel sweep status {sweep}`\n",
            missing.len()
        ))?;
        return match how.last {
            Some(last) if how.args.wait => wait(folder, last),
            _ => Ok(Exit::Incomplete),
        };
    }
    let batch = Batch::new(folder, order, split(&todo, limits)?, how.args.dry_run)?;
    if how.args.dry_run {
        return batch.show();
    }
    let mut waiting: Vec<String> = how.active.iter().map(|(_, job)| job.clone()).collect();
    waiting.sort();
    waiting.dedup();
    let submitted = batch.submit(waiting)?;
    if how.args.wait { wait(folder, &submitted) } else { Ok(Exit::Done) }
}

/// Arrays with their scripts, ready to be submitted.
struct Batch<'a> {
    folder: &'a Folder,
    order: &'a Submit,
    arrays: Vec<Array>,
    number: u32,
    name: String,
    sweep: PathBuf,
    scripts: PathBuf,
    shard: String,
    merge: String,
}

impl<'a> Batch<'a> {
    fn new(folder: &'a Folder, order: &'a Submit, arrays: Vec<Array>, dry: bool) -> Result<Self> {
        let sweep = absolute(folder.path())?;
        sbatch::check(&sweep)?;
        let program = std::env::current_exe().context("cannot tell where this program is")?;
        let job = Job { program: &program, sweep: &sweep, setup: order.options.setup.as_deref() };
        let shard = script::shard(job, order.shards, &order.run);
        let merge = script::merge(job, &order.patience);
        let number = if dry { submission::next(folder)? } else { submission::claim(folder)? };
        let scripts = absolute(folder.path())?.join(submission::scripts(folder, number).strip_prefix(folder.path())?);
        Ok(Self { folder, order, arrays, number, name: sbatch::name(folder.id()), sweep, scripts, shard, merge })
    }

    fn files(&self) -> [(PathBuf, &str); 2] {
        [(self.scripts.join("shard.sh"), &self.shard), (self.scripts.join("merge.sh"), &self.merge)]
    }

    /// The sbatch line of an array.
    fn array(&self, array: &Array) -> Vec<String> {
        let most = self.order.options.max_running.map(|most| running(most, self.arrays.len()));
        self.common(|common| sbatch::array(common, array, most, &self.scripts.join("shard.sh")))
    }

    /// The sbatch line of the merge.
    fn merge(&self, after: &[String]) -> Vec<String> {
        self.common(|common| sbatch::merge(common, after, self.number, &self.scripts.join("merge.sh")))
    }

    fn common(&self, make: impl Fn(Common<'_>) -> Vec<String>) -> Vec<String> {
        make(Common { name: &self.name, options: &self.order.options, logs: &self.logs() })
    }

    fn logs(&self) -> PathBuf {
        self.sweep.join("logs")
    }

    fn count(&self) -> usize {
        self.arrays.iter().map(|array| array.tasks.len()).sum()
    }

    /// Prints all of it.
    fn show(&self) -> Result<Exit> {
        let mut text = String::new();
        for (path, script) in self.files() {
            text += &format!("# {}\n{script}\n", path.display());
        }
        for array in &self.arrays {
            text += &format!("{}\n", line(&self.array(array)));
        }
        let jobs: Vec<String> = (1..=self.arrays.len()).map(|i| format!("JOB{i}")).collect();
        text += &format!("{}\n", line(&self.merge(&jobs)));
        print(&text)?;
        Ok(Exit::Done)
    }

    /// Submits all of it; the merge waits for these arrays too.
    fn submit(&self, mut after: Vec<String>) -> Result<Submission> {
        for (path, script) in self.files() {
            write_whole(&path, script.as_bytes())?;
        }
        let logs = self.logs();
        std::fs::create_dir_all(&logs).with_context(|| format!("cannot create {}", logs.display()))?;
        let order = self.order;
        let mut submission = Submission {
            layout: LAYOUT,
            number: self.number,
            engine: SLURM.into(),
            plan: self.folder.id().into(),
            shards: order.shards,
            arrays: Vec::new(),
            merge: None,
            options: order.options.clone(),
            run: order.run.clone(),
            patience: order.patience.clone(),
            commands: Vec::new(),
            submitted_unix_s: SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |t| t.as_secs()),
        };
        trust::remember(self.folder, order);
        print(&self.arrays.iter().map(|array| line(&self.array(array)) + "\n").collect::<String>())?;
        let done = self.jobs(&mut submission, &mut after);
        if let Err(error) = done {
            return Err(self.undo(&submission, error));
        }
        print(&format!(
            "submission {}: {} of {} shards, merge {}; `rayreel sweep status {}` shows how far they are\n",
            submission.number,
            self.count(),
            submission.shards,
            submission.merge.as_deref().unwrap_or_default(),
            quote(&self.folder.path().display().to_string()),
        ))?;
        Ok(submission)
    }

    fn jobs(&self, submission: &mut Submission, after: &mut Vec<String>) -> Result<()> {
        for array in &self.arrays {
            let words = self.array(array);
            let job = slurm::submit(&words)?;
            after.push(parts(&job).0.to_owned());
            submission.arrays.push(Jobs { job, offset: array.offset, tasks: array.spec(None) });
            submission.commands.push(line(&words));
            submission.write(self.folder)?;
        }
        let words = self.merge(after);
        print(&format!("{}\n", line(&words)))?;
        submission.merge = Some(slurm::submit(&words)?);
        submission.commands.push(line(&words));
        Ok(submission.write(self.folder)?)
    }

    /// Half a submission is none: without its merge, or with some of its shards only, it would be told as one that went wrong.
    fn undo(&self, submission: &Submission, error: anyhow::Error) -> anyhow::Error {
        let jobs: Vec<&str> = submission.jobs().collect();
        if jobs.is_empty() {
            return error;
        }
        match slurm::cancel(&jobs) {
            Ok(()) => error.context(format!("jobs {} were submitted before, and cancelled", jobs.join(", "))),
            Err(second) => {
                error.context(format!("jobs {} were submitted before and run on: {second:#}", jobs.join(", ")))
            }
        }
    }
}

/// Waits until the merge has ended, then merges here: the same rows give the same files and the code, and Slurm, which forgets how
/// a job ended, need not be asked for it.
fn wait(folder: &Folder, submission: &Submission) -> Result<Exit> {
    let merge = submission.merge.as_deref().map_or("", |job| parts(job).0);
    let is_merge = |task: &Task| task.job == merge && task.is_active();
    let mut pause = Duration::from_millis(500);
    let mut failures = 0;
    loop {
        match slurm::tasks(folder.id(), std::slice::from_ref(submission)) {
            Ok(tasks) if !tasks.iter().any(is_merge) => break,
            Ok(_) => failures = 0,
            // The controller may be restarted while jobs go on.
            Err(error) if failures < 20 => {
                failures += 1;
                tell!("warning: {error:#}; asking again");
            }
            Err(error) => return Err(error),
        }
        std::thread::sleep(pause);
        // Sites mind programs that ask every second for hours.
        pause = (pause * 5 / 4).min(Duration::from_secs(15));
    }
    merge::all(folder, plan::duration(&submission.patience).unwrap_or_default())
}
