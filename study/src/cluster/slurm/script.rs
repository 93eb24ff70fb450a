//! The batch scripts.

use std::path::Path;

use crate::cluster::shell::{filled, quote};

/// What a script does.
#[derive(Clone, Copy, Debug)]
pub struct Job<'a> {
    /// This program, absolute.
    pub program: &'a Path,
    /// The folder of the sweep, absolute.
    pub sweep: &'a Path,
    /// Shell commands before anything else, such as `module load`.
    pub setup: Option<&'a str>,
}

/// How often a task that meets its time limit is put back.
pub const REQUEUES_MAX: u32 = 20;

/// The script of a shard: its first argument is the offset of its array.
///
/// Slurm signals a time limit but ends the job there; and it requeues a preempted job by itself. So the script is told the two apart,
/// by two signals: USR1 (asked for with `--signal`) comes before the time limit only, TERM with preemption, requeue and scancel.
/// `scontrol requeue` at a TERM would bring a job back to life that its user has just cancelled.
pub fn shard(job: Job<'_>, shards: usize, run: &[String]) -> String {
    let words: Vec<String> = run.iter().map(|word| quote(word)).collect();
    let run = if words.is_empty() { String::new() } else { format!(" {}", words.join(" ")) };
    filled(
        SHARD,
        &[
            ("SETUP", &setup(job)),
            ("PROGRAM", &quoted(job.program)),
            ("RUN", &run),
            ("SHARDS", &shards.to_string()),
            ("MAX", &REQUEUES_MAX.to_string()),
            ("SWEEP", &quoted(job.sweep)),
        ],
    )
}

/// The script of the merge. `patience` is for file systems that show a file some time after another machine wrote it.
pub fn merge(job: Job<'_>, patience: &str) -> String {
    let (setup, patience) = (setup(job), quote(patience));
    let values =
        [("SETUP", &setup), ("PROGRAM", &quoted(job.program)), ("PATIENCE", &patience), ("SWEEP", &quoted(job.sweep))];
    filled(MERGE, &values.map(|(name, value)| (name, value.as_str())))
}

fn quoted(path: &Path) -> String {
    quote(&path.display().to_string())
}

fn setup(job: Job<'_>) -> String {
    job.setup.map_or_else(String::new, |setup| format!("\n# --setup\n{setup}\n"))
}

const SHARD: &str = include_str!("shard.sh");
const MERGE: &str = include_str!("merge.sh");

#[cfg(test)]
mod tests {
    use super::*;

    fn job() -> Job<'static> {
        Job {
            program: Path::new("/opt/my tools/rayreel"),
            sweep: Path::new("/data/it's a @RUN@/x.sweep"),
            setup: Some("echo @PROGRAM@; module load gcc"),
        }
    }

    #[test]
    fn the_shard_script_calls_the_contract() {
        let text = shard(job(), 1240, &["--flush".into(), "30s".into()]);
        let call = "'/opt/my tools/rayreel' --quiet --threads \"${SLURM_CPUS_PER_TASK:-1}\" sweep run '/data/it'\\''s a @RUN@/x.sweep' \
                    --shard auto/1240 --index-offset \"$offset\" --flush 30s &";
        assert!(text.contains(call), "{text}");
        assert!(text.contains("\n# --setup\necho @PROGRAM@; module load gcc\n"), "{text}");
        assert!(text.starts_with("#!/bin/bash\n") && !text.contains("@SH") && !text.contains("@SETUP"), "{text}");
        assert!(text.contains("-ge 20 ]"), "{text}");
    }

    #[test]
    fn the_merge_script_waits_for_late_files() {
        let text = merge(Job { setup: None, ..job() }, "90s");
        let call = "exec '/opt/my tools/rayreel' sweep merge '/data/it'\\''s a @RUN@/x.sweep' --patience 90s\n";
        assert!(text.ends_with(call), "{text}");
    }

    #[test]
    fn scripts_are_shell() {
        for text in [shard(job(), 8, &[]), merge(job(), "90s")] {
            let output = std::process::Command::new("bash").args(["-n", "-c", &text]).output().unwrap();
            assert!(output.status.success(), "{}\n{text}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
