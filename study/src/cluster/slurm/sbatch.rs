//! The command lines of `sbatch`.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::cluster::slurm::arrays::Array;
use crate::error::{Result, StudyError};

/// What a site and its users decide; kept with a submission, so that `resume` submits alike.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Options {
    /// Partition.
    pub partition: Option<String>,
    /// Account.
    pub account: Option<String>,
    /// Time limit of a task, as Slurm writes it.
    pub time: Option<String>,
    /// Memory of a task, as Slurm writes it.
    pub mem: Option<String>,
    /// Most tasks at a time.
    pub max_running: Option<usize>,
    /// Shell commands before each task.
    pub setup: Option<String>,
    /// Any other options of sbatch. They come last: they win.
    pub others: Vec<String>,
}

impl Options {
    /// These options; each that is not given here is taken from `defaults`.
    pub fn or(self, defaults: &Self) -> Self {
        let of = |given: Option<String>, default: &Option<String>| given.or_else(|| default.clone());
        Self {
            partition: of(self.partition, &defaults.partition),
            account: of(self.account, &defaults.account),
            time: of(self.time, &defaults.time),
            mem: of(self.mem, &defaults.mem),
            max_running: self.max_running.or(defaults.max_running),
            setup: of(self.setup, &defaults.setup),
            others: if self.others.is_empty() { defaults.others.clone() } else { self.others },
        }
    }
}

/// What is the same for every job of a submission.
#[derive(Clone, Copy, Debug)]
pub struct Common<'a> {
    /// Name of the jobs.
    pub name: &'a str,
    /// What was asked for.
    pub options: &'a Options,
    /// Folder of the logs, absolute.
    pub logs: &'a Path,
}

/// Name of the jobs of a plan: squeue finds them by it.
pub fn name(plan: &str) -> String {
    format!("rayreel-{}", &plan[..plan.len().min(8)])
}

/// Submits an array. `running` is the most tasks of it at a time.
///
/// Everything stands on the command line and nothing in the script: variables of the user's environment (`SBATCH_NO_REQUEUE`,
/// `SBATCH_OPEN_MODE`, `SBATCH_SIGNAL`) overrule what a script says, but not this, and the printed line is the whole truth.
pub fn array(common: Common<'_>, array: &Array, running: Option<usize>, script: &Path) -> Vec<String> {
    let mut words = begin(common);
    words.push(format!("--array={}", array.spec(running)));
    // To the batch shell alone, a minute before the time limit (Slurm rounds: up to another minute earlier).
    words.push("--signal=B:USR1@60".into());
    let from = if array.offset == 0 { String::new() } else { format!("-from-{}", array.offset) };
    words.push(output(common.logs, &format!("shard{from}-%a.log")));
    finish(&mut words, common.options, script);
    words.push(array.offset.to_string());
    words
}

/// Submits the merge behind arrays.
///
/// `afterany` and not `afterok`: behind a task that failed, `afterok` would wait for ever. Merge finds out itself what is missing.
pub fn merge(common: Common<'_>, after: &[String], number: u32, script: &Path) -> Vec<String> {
    let mut words = begin(common);
    words.push(format!("--dependency=afterany:{}", after.join(":")));
    words.push(output(common.logs, &format!("merge-{number:03}.log")));
    finish(&mut words, common.options, script);
    words
}

fn begin(common: Common<'_>) -> Vec<String> {
    let mut words: Vec<String> = ["sbatch", "--parsable"].map(String::from).to_vec();
    words.push(format!("--job-name={}", common.name));
    // Put back into the queue when a node dies, whatever the site does otherwise; and then the log goes on where it was.
    words.extend(["--ntasks=1", "--cpus-per-task=1", "--requeue", "--open-mode=append"].map(String::from));
    words
}

/// In file names of sbatch `%` begins a pattern; the pattern of `file` is meant, any in the folder's path is not.
fn output(logs: &Path, file: &str) -> String {
    format!("--output={}/{file}", logs.display().to_string().replace('%', "%%"))
}

fn finish(words: &mut Vec<String>, options: &Options, script: &Path) {
    let Options { partition, account, time, mem, others, .. } = options;
    for (name, value) in [("partition", partition), ("account", account), ("time", time), ("mem", mem)] {
        words.extend(value.as_ref().map(|value| format!("--{name}={value}")));
    }
    words.extend(others.iter().cloned());
    words.push(script.display().to_string());
}

/// The job in what `sbatch --parsable` prints: its id, with the cluster's name behind it where there are several.
///
/// # Errors
/// It printed something else.
pub fn submitted(text: &str) -> Result<String> {
    let word = text.lines().next_back().unwrap_or_default().trim();
    let id = word.split(';').next().unwrap_or_default();
    if !id.is_empty() && id.bytes().all(|b| b.is_ascii_digit()) {
        return Ok(word.into());
    }
    Err(StudyError::Usage { detail: format!("sbatch printed {text:?} and no job id") })
}

/// Id and cluster of a job.
pub fn parts(job: &str) -> (&str, Option<&str>) {
    job.split_once(';').map_or((job, None), |(id, cluster)| (id, Some(cluster)))
}

/// Refuses a folder that sbatch cannot write logs to: a backslash in a file name switches off its patterns, and all tasks would
/// write to one file.
///
/// # Errors
/// The path has one, or a line break, or is no text.
pub fn check(path: &Path) -> Result<()> {
    if path.to_str().is_none() {
        return Err(StudyError::input(
            path,
            "has bytes in its path that are no UTF-8, which a script cannot hold; rename or move it",
        ));
    }
    if path.to_string_lossy().contains(['\\', '\n', '\r']) {
        let detail = "has a backslash or a line break in its path, which sbatch cannot take; rename or move it";
        return Err(StudyError::input(path, detail));
    }
    Ok(())
}

/// Time limits as Slurm writes them; `90s`, `15m` and `2h` become minutes, rounded up.
///
/// # Errors
/// Neither.
pub fn time(text: &str) -> Result<String, String> {
    let wrong =
        || format!("{text:?} is no time limit; write 90m or 2h, or as Slurm does: 90 (minutes), 1:30:00, 1-12:00");
    let (number, minutes) = match text.char_indices().next_back() {
        Some((at, 's')) => (&text[..at], 1.0 / 60.0),
        Some((at, 'm')) => (&text[..at], 1.0),
        Some((at, 'h')) => (&text[..at], 60.0),
        _ => {
            let slurm = text.starts_with(|c: char| c.is_ascii_digit())
                && text.chars().all(|c| c.is_ascii_digit() || c == ':' || c == '-');
            return if slurm { Ok(text.into()) } else { Err(wrong()) };
        }
    };
    let number: f64 = number.parse().map_err(|_| wrong())?;
    let all = (number * minutes).ceil();
    if (1.0..1e7).contains(&all) { Ok((all as u64).to_string()) } else { Err(wrong()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn options() -> Options {
        Options {
            partition: Some("cpu".into()),
            account: Some("proj1".into()),
            time: Some("60".into()),
            mem: Some("4G".into()),
            max_running: Some(200),
            setup: None,
            others: vec!["--qos=long".into()],
        }
    }

    #[test]
    fn lines_are_as_agreed() {
        let options = options();
        let common =
            Common { name: "rayreel-8c62bfbd", options: &options, logs: Path::new("/data/50% off/s.sweep/logs") };
        let shards = Array { offset: 1001, tasks: vec![0, 1, 2, 7] };
        assert_eq!(
            array(common, &shards, Some(200), Path::new("/data/shard.sh")).join(" "),
            "sbatch --parsable --job-name=rayreel-8c62bfbd --ntasks=1 --cpus-per-task=1 --requeue --open-mode=append \
             --array=0-2,7%200 --signal=B:USR1@60 --output=/data/50%% off/s.sweep/logs/shard-from-1001-%a.log --partition=cpu \
             --account=proj1 --time=60 --mem=4G --qos=long /data/shard.sh 1001"
        );
        let after = ["12".to_owned(), "13".to_owned()];
        assert_eq!(
            merge(Common { options: &Options::default(), ..common }, &after, 2, Path::new("/data/merge.sh")).join(" "),
            "sbatch --parsable --job-name=rayreel-8c62bfbd --ntasks=1 --cpus-per-task=1 --requeue --open-mode=append \
             --dependency=afterany:12:13 --output=/data/50%% off/s.sweep/logs/merge-002.log /data/merge.sh"
        );
    }

    #[test]
    fn job_ids_are_read() {
        assert_eq!(submitted("1234\n").unwrap(), "1234");
        assert_eq!(submitted("a banner of the site\n1234;alpha\n").unwrap(), "1234;alpha");
        assert_eq!((parts("1234;alpha"), parts("7")), (("1234", Some("alpha")), ("7", None)));
        for bad in ["", "Submitted batch job 7\n", ";alpha"] {
            assert!(submitted(bad).unwrap_err().to_string().contains("no job id"), "{bad}");
        }
    }

    #[test]
    fn a_second_submission_keeps_what_it_does_not_change() {
        let more = Options { mem: Some("8G".into()), ..Options::default() };
        assert_eq!(more.or(&options()), Options { mem: Some("8G".into()), ..options() });
        let other = Options { others: vec!["--qos=short".into()], ..Options::default() };
        assert_eq!(other.or(&options()).others, ["--qos=short"]);
    }

    #[test]
    fn time_limits() {
        let good = [("90m", "90"), ("2h", "120"), ("61s", "2"), ("0.5h", "30"), ("90", "90"), ("1-12:00", "1-12:00")];
        good.iter().for_each(|(text, want)| assert_eq!(time(text).as_deref(), Ok(*want)));
        for bad in ["", "h", "-5", "soon", "1d", "0s", "-2h", "1 2", "é"] {
            assert!(time(bad).unwrap_err().contains("is no time limit"), "{bad}");
        }
    }

    #[test]
    fn folders_that_sbatch_would_misread_are_refused() {
        assert!(check(Path::new("/a b/50%/x")).is_ok());
        assert!(check(Path::new("/a\\b")).unwrap_err().to_string().contains("backslash"));
        #[cfg(unix)]
        {
            use std::os::unix::ffi::OsStrExt as _;
            let odd = Path::new(std::ffi::OsStr::from_bytes(b"/a\xff"));
            assert!(check(odd).unwrap_err().to_string().contains("no UTF-8"));
        }
    }
}
