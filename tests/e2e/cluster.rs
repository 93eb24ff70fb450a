//! Sweeps on a cluster, as far as they can be seen without one: what would be submitted, what is exported, what is refused. The rest
//! is `tests/slurm/acceptance.sh`, on a real Slurm.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{capture, command};

const PLAN: &str = "name = \"small\"\ntraces = [\"cornell.rtrace\"]\npolicies = [\"full\"]\n\n[[axis]]\nname = \"fifo\"\n\
                    key = \"ti.ray_fifo_entries\"\nrange = { from = 1, to = 40 }\n";

/// A folder with the folder of a sweep in it, with a blank in its name.
fn sweep() -> (tempfile::TempDir, PathBuf) {
    let folder = tempfile::tempdir().unwrap();
    capture("cornell", "--size 32x32 --samples 1x1", &folder.path().join("cornell.rtrace"));
    let plan = folder.path().join("small.toml");
    fs::write(&plan, PLAN).unwrap();
    let sweep = folder.path().join("my sweep");
    ran(&["sweep", "plan", "--no-estimate", plan.to_str().unwrap(), "-o", sweep.to_str().unwrap()], 0);
    (folder, sweep)
}

/// Runs the binary where no Slurm is found; gives both outputs.
#[track_caller]
fn ran(args: &[&str], code: i32) -> String {
    let args: Vec<OsString> = args.iter().map(OsString::from).collect();
    let output = command(&args).env("PATH", "/nowhere").output().unwrap();
    let text = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{args:?}\n{text}");
    text
}

fn names(folder: &Path) -> Vec<String> {
    let mut all: Vec<String> =
        fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    all.sort();
    all
}

#[test]
fn a_dry_run_shows_everything_and_writes_nothing() {
    let (_folder, sweep) = sweep();
    let path = sweep.to_str().unwrap();
    let site = ["--shards", "40", "-p", "cpu", "-A", "proj", "--time", "2h", "--mem", "4G", "--max-running", "7"];
    let start = ["sweep", "submit", path, "--engine", "slurm", "--dry-run", "--setup", "module load gcc"];
    let text = ran(&[&start[..], &site, &["--", "--qos=long"]].concat(), 0);
    let real = fs::canonicalize(&sweep).unwrap();
    let real = real.display();
    for words in [
        "\nmodule load gcc\n".to_owned(),
        format!("sweep run '{real}' --shard auto/40 --index-offset \"$offset\" --flush 30s --memory 1024 &"),
        format!("sweep merge '{real}' --patience 90s"),
        "--array=0-39%7 --signal=B:USR1@60".to_owned(),
        format!("'--output={real}/logs/shard-%a.log' --partition=cpu --account=proj --time=120 --mem=4G --qos=long"),
        format!("--qos=long '{real}/submissions/001/shard.sh' 0\n"),
        "--dependency=afterany:JOB1".to_owned(),
    ] {
        assert!(text.contains(&words), "no {words:?} in\n{text}");
    }
    assert_eq!(names(&sweep), ["plan.json"]);
}

#[test]
fn where_there_is_no_slurm_that_is_said() {
    let (_folder, sweep) = sweep();
    let path = sweep.to_str().unwrap();
    let text = ran(&["sweep", "submit", path, "--engine", "slurm", "--shards", "4"], 2);
    assert!(text.contains("no sbatch in PATH") && text.contains("sweep run '"), "{text}");
    assert!(ran(&["sweep", "cancel", path], 0).contains("never submitted"));
    assert!(ran(&["sweep", "submit", path, "--time", "soon"], 2).contains("is no time limit"));
    assert_eq!(names(&sweep), ["plan.json"]);
    // And auto computes here.
    ran(&["sweep", "submit", path, "--quiet"], 0);
    assert!(sweep.join("results.parquet").exists());
    assert!(
        ran(&["sweep", "submit", path, "--engine", "slurm", "--dry-run", "--shards", "4"], 0).contains("all 40 points")
    );
}

#[test]
fn templates_are_written_for_every_engine() {
    let (_folder, sweep) = sweep();
    let path = sweep.to_str().unwrap();
    for engine in ["htcondor", "lsf", "k8s", "aws-batch", "hq", "parallel"] {
        let text = ran(&["sweep", "export", path, "--engine", engine, "--shards", "8"], 0);
        assert!(text.contains("NOT TESTED"), "{text}");
        let files = names(&sweep.join(engine));
        assert!(!files.is_empty() && files.iter().all(|name| text.contains(name)), "{files:?}\n{text}");
    }
    assert!(ran(&["sweep", "export", path, "--engine", "pbs"], 2).contains("possible values"));
}
