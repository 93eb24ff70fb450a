//! The calls to Slurm: its own commands, and only what they promise to scripts.

use std::collections::BTreeSet;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use rayreel_study::cluster::slurm::limits::Limits;
use rayreel_study::cluster::slurm::queue::{self, Task};
use rayreel_study::cluster::slurm::sbatch::{name, parts, submitted};
use rayreel_study::cluster::submission::Submission;

/// Whether this machine can submit.
pub fn is_here() -> bool {
    on_path("sbatch").is_some()
}

fn on_path(program: &str) -> Option<PathBuf> {
    let folders = std::env::var_os("PATH")?;
    std::env::split_paths(&folders).map(|folder| folder.join(program)).find(|file| file.is_file())
}

/// Runs a command, gives what it printed. `clear` is what variables of the environment begin with that would change its answer.
fn call(words: &[String], clear: &str) -> Result<String> {
    let (program, args) = words.split_first().context("no command")?;
    let mut command = Command::new(program);
    command.args(args).stdin(Stdio::null());
    for (key, _) in std::env::vars_os() {
        if !clear.is_empty() && key.to_string_lossy().starts_with(clear) {
            command.env_remove(&key);
        }
    }
    let output = command.output().with_context(|| format!("cannot run {program}"))?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!("{program} failed ({}): {}", output.status, said.trim().replace('\n', "; "));
    }
    Ok(String::from_utf8_lossy(&output.stdout).into_owned())
}

fn words<const N: usize>(words: [&str; N]) -> Vec<String> {
    words.map(String::from).to_vec()
}

/// What the site allows.
pub fn limits() -> Result<Limits> {
    Ok(Limits::parse(&call(&words(["scontrol", "show", "config"]), "")?))
}

/// Submits a job, gives its id. `SBATCH_WAIT` would make it wait for the job's end; the other variables are the user's wishes.
pub fn submit(line: &[String]) -> Result<String> {
    Ok(submitted(&call(line, "SBATCH_WAIT")?)?)
}

/// All tasks that Slurm knows of these submissions of a plan.
///
/// Asked by the name of the jobs: a list of ids is refused as soon as Slurm has forgotten one of them.
pub fn tasks(plan: &str, submissions: &[Submission]) -> Result<Vec<Task>> {
    let known: BTreeSet<(&str, Option<&str>)> = submissions.iter().flat_map(Submission::jobs).map(parts).collect();
    let clusters: BTreeSet<Option<&str>> = known.iter().map(|(_, cluster)| *cluster).collect();
    let mut all = Vec::new();
    for cluster in clusters {
        let mut line = words(["squeue", "--noheader", "--array", "--states=all"]);
        line.extend([format!("--name={}", name(plan)), format!("--format={}", queue::FORMAT)]);
        line.extend(cluster.map(|cluster| format!("--clusters={cluster}")));
        let seen = queue::parse(&call(&line, "SQUEUE_")?);
        // Another folder may hold the same plan.
        all.extend(seen.into_iter().filter(|task| known.contains(&(task.job.as_str(), cluster))));
    }
    Ok(all)
}

/// Cancels jobs. Their tasks get a TERM: they write what is finished.
pub fn cancel(jobs: &[&str]) -> Result<()> {
    let clusters: BTreeSet<Option<&str>> = jobs.iter().map(|job| parts(job).1).collect();
    for cluster in clusters {
        let mut line = words(["scancel"]);
        line.extend(cluster.map(|cluster| format!("--clusters={cluster}")));
        line.extend(jobs.iter().map(|job| parts(job)).filter(|job| job.1 == cluster).map(|job| job.0.to_owned()));
        call(&line, "SCANCEL_")?;
    }
    Ok(())
}
