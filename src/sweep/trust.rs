//! Whether a record of a submission is our own.
//!
//! A record says what runs on a cluster: shell commands, options, arguments. The folder of a sweep may be a stranger's, so only what
//! this user submitted from this machine is submitted again without a word. That is noted beside the user's own files and never in
//! the folder: a file for each, named by a hash of what was submitted.

use std::ffi::OsString;
use std::io::{self, BufRead, IsTerminal, Write};
use std::path::PathBuf;

use anyhow::{Result, bail};
use rayreel_study::cluster::shell::{line, quote};
use rayreel_study::cluster::submission::Submission;
use rayreel_study::files::write_whole;
use rayreel_study::sweep::folder::Folder;

use super::request::Submit;

/// Options of sbatch that a stranger's record may hold. All others may load code, change where it runs, or write files.
const HARMLESS: &[&str] = &[
    "--account",
    "--begin",
    "--comment",
    "--constraint",
    "--contiguous",
    "--cpus-per-task",
    "--deadline",
    "--exclude",
    "--exclusive",
    "--gres",
    "--gpus",
    "--hint",
    "--licenses",
    "--mem",
    "--mem-per-cpu",
    "--nice",
    "--nodelist",
    "--nodes",
    "--ntasks",
    "--partition",
    "--priority",
    "--qos",
    "--reservation",
    "--time",
    "--time-min",
    "--tmp",
];

/// Notes that this was submitted here. Where it cannot be noted, `resume` asks.
pub fn remember(folder: &Folder, order: &Submit) {
    if let Some(file) = note(folder, order) {
        write_whole(&file, b"submitted by this user from this machine\n").ok();
    }
}

/// Goes on if the last submission is our own, or is trusted; otherwise shows what it would run.
pub fn check(folder: &Folder, last: &Submission, trusted: bool, given_anew: bool) -> Result<()> {
    let stored = Submit {
        shards: last.shards,
        run: last.run.clone(),
        patience: last.patience.clone(),
        options: last.options.clone(),
    };
    let file = note(folder, &stored);
    if file.is_some_and(|file| file.is_file()) {
        return Ok(());
    }
    let sweep = quote(&folder.path().display().to_string());
    if let Some(option) = last.options.others.iter().find(|option| !is_harmless(option)).filter(|_| !given_anew) {
        bail!(
            "submission {} of {sweep} was not made by this user on this machine, and holds the option {}, which may load code or write \
             files; give the options that you want anew, behind --",
            last.number,
            quote(option),
        );
    }
    tell!("submission {} was not made by this user on this machine. It would run:", last.number);
    tell!(
        "  commands before each task: {}",
        last.options.setup.as_ref().map_or_else(|| "none".into(), |setup| format!("{setup:?}"))
    );
    tell!("  arguments of sweep run:    {}", line(&last.run));
    tell!("  tasks, at most:            {}", last.shards);
    let options = &last.options;
    let named = [
        ("--partition", &options.partition),
        ("--account", &options.account),
        ("--time", &options.time),
        ("--mem", &options.mem),
    ];
    let mut words: Vec<String> =
        named.into_iter().filter_map(|(name, value)| Some(format!("{name}={}", value.as_ref()?))).collect();
    words.extend(options.others.iter().cloned());
    tell!("  options of sbatch:         {}", line(&words));
    if trusted || agreed()? {
        return Ok(());
    }
    bail!(
        "nothing was submitted; --trust submits it, `rayreel sweep submit {sweep}` takes options of your own, --local computes here"
    )
}

/// Asks, where somebody can answer.
fn agreed() -> Result<bool> {
    if !io::stdin().is_terminal() {
        return Ok(false);
    }
    write!(io::stderr(), "submit that? [y/N] ")?;
    io::stderr().flush()?;
    let mut answer = String::new();
    io::stdin().lock().read_line(&mut answer)?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}

/// Whether an option is in the list, with a value behind `=` or without one. A word that is no option is not.
fn is_harmless(option: &str) -> bool {
    let name = option.split('=').next().unwrap_or_default();
    HARMLESS.contains(&name)
}

/// The file that notes a submission; none where this user has no place for it.
fn note(folder: &Folder, order: &Submit) -> Option<PathBuf> {
    let variable = |name: &str| std::env::var_os(name).filter(|value: &OsString| !value.is_empty()).map(PathBuf::from);
    let state = variable("XDG_STATE_HOME").filter(|path| path.is_absolute());
    let state = state.or_else(|| Some(variable("HOME")?.join(".local").join("state")))?;
    let mut hasher = blake3::Hasher::new();
    let mut part = |text: &str| {
        hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
    };
    part(&std::fs::canonicalize(folder.path()).ok()?.display().to_string());
    part(folder.id());
    part(&order.shards.to_string());
    part(&order.patience);
    order.run.iter().for_each(|word| part(word));
    part(&serde_json::to_string(&order.options).ok()?);
    Some(state.join("rayreel").join("submitted").join(&hasher.finalize().to_hex()[..32]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn options_that_load_code_are_not_harmless() {
        for option in [
            "--export=LD_PRELOAD=/x.so",
            "--wrap=sh",
            "--chdir=/x",
            "-D",
            "/x",
            "--get-user-env",
            "--bcast",
            "--output=/x",
        ] {
            assert!(!is_harmless(option), "{option}");
        }
        assert!(is_harmless("--qos=long") && is_harmless("--exclusive"));
    }
}
