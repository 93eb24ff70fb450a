//! What keeps runs apart, and what is not done for a stranger: the lock of a cache, submissions of others, servers that fail.

use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{BufRead, BufReader};
use std::os::unix::fs::PermissionsExt;
use std::path::Path;
use std::process::Command;

use rayreel_formats::locks::try_lock;

use crate::common::{capture, command, run};

fn args(line: &str, folder: &Path) -> Vec<OsString> {
    line.split_whitespace().map(|word| word.replace("{}", folder.to_str().unwrap()).into()).collect()
}

/// A second `paper` waits for the cache, says for whom, and a signal ends that.
#[test]
fn a_cache_in_use_is_waited_for() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::create_dir(folder.join("cache")).unwrap();
    let held = File::create(folder.join("cache/.lock")).unwrap();
    assert_eq!(try_lock(&held).unwrap(), Ok(()));
    let line = "paper --size 16x8 --scene cornell --cache {}/cache --out {}/out";
    let mut child = command(&args(line, folder)).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let said = lines.find_map(|line| line.ok().filter(|line| line.starts_with("waiting: "))).expect("it says so");
    assert!(said.contains("uses the folder") && said.contains("--cache names another"), "{said}");
    if cfg!(target_os = "linux") {
        assert!(said.contains(&format!("process {}", std::process::id())), "{said}");
    }
    assert!(child.try_wait().unwrap().is_none(), "it waits");
    let sent = Command::new("sh").args(["-c", &format!("kill -TERM {}", child.id())]).status().unwrap();
    assert!(sent.success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
    assert!(!folder.join("out/study.json").exists());
}

/// A file that may not grow as large as it has to is an error like that of a full disk; what was captured stays behind as partial.
#[test]
fn a_limit_on_the_size_of_files_is_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    // Eight blocks are 4 or 8 KiB, by the shell; the trace has 73.
    let line = "capture cornell --size 64x64 --samples 2x2 -o {}/a.rtrace";
    let limited = ["-c", "ulimit -f 8; exec \"$0\" \"$@\"", env!("CARGO_BIN_EXE_rayreel")].map(OsString::from);
    let output = Command::new("sh").args(limited).args(args(line, folder)).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(74), "{said}");
    assert!(said.contains("a.rtrace") && said.contains("too large"), "{said}");
    assert!(!folder.join("a.rtrace").exists() && folder.join("a.rtrace.partial").exists(), "{said}");
}

/// A Slurm that takes every job and knows none.
fn slurm(folder: &Path) {
    fs::create_dir(folder.join("bin")).unwrap();
    for (name, text) in [
        ("sbatch", "#!/bin/sh\necho \"$@\" >> \"$(dirname \"$0\")/../jobs\"\necho 7\n"),
        ("squeue", "#!/bin/sh\n"),
        ("scontrol", "#!/bin/sh\necho 'MaxArraySize = 1001'\necho 'MaxJobCount = 10000'\n"),
    ] {
        let file = folder.join("bin").join(name);
        fs::write(&file, text).unwrap();
        fs::set_permissions(&file, fs::Permissions::from_mode(0o755)).unwrap();
    }
}

/// What this user submitted is submitted again; what somebody else submitted is shown, and runs only if that is trusted.
#[test]
fn a_strangers_submission_is_not_submitted_again() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    slurm(folder);
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    fs::write(folder.join("p.toml"), "traces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n")
        .unwrap();
    run(&args("sweep plan --no-estimate {}/p.toml -o {}/s", folder)).expect(0);
    let path = format!("{}:{}", folder.join("bin").display(), std::env::var("PATH").unwrap());
    let ran = |line: &str, user: &str, code: i32| {
        let output = command(&args(line, folder)).env("PATH", &path).env("XDG_STATE_HOME", folder.join(user)).output();
        let output = output.unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(code), "{line}\n{said}");
        said
    };
    let jobs = || fs::read_to_string(folder.join("jobs")).unwrap_or_default().lines().count();
    ran("sweep submit {}/s --engine slurm --setup echo_hidden", "me", 0);
    let first = jobs();
    assert!(first > 0);
    ran("sweep resume {}/s", "me", 0);
    let second = jobs();
    assert!(second > first, "our own is submitted again");
    let said = ran("sweep resume {}/s", "stranger", 2);
    assert!(said.contains("echo_hidden") && said.contains("nothing was submitted"), "{said}");
    assert_eq!(jobs(), second, "nothing was submitted");
    ran("sweep resume {}/s --trust", "stranger", 0);
    assert!(jobs() > second);
    // What is given again takes the place of what was given then.
    ran("sweep resume {}/s --memory 64 --flush 9s", "me", 0);
    let scripts =
        fs::read_dir(folder.join("s/submissions")).unwrap().map(|entry| entry.unwrap().path().join("shard.sh"));
    let last = fs::read_to_string(scripts.filter(|script| script.is_file()).max().unwrap()).unwrap();
    assert!(
        last.contains("--memory 64") && last.contains("--flush 9s") && last.matches("--memory").count() == 1,
        "{last}"
    );
    ran("sweep resume {}/s --memory 1024", "me", 0);
    let script = |name: &str| fs::read_to_string(folder.join("s/submissions").join(name).join("shard.sh"));
    let all: Vec<String> = (1..9).filter_map(|number| script(&format!("{number:03}")).ok()).collect();
    assert!(all.last().unwrap().contains("--memory 1024"), "the default, but given: {all:?}");
    let said = ran("sweep resume {}/s --reuse {}/s", "me", 2);
    assert!(said.contains("--reuse is for computing on this machine"), "{said}");
    // What may load code is given anew or not at all.
    ran("sweep submit {}/s --engine slurm -- --export=LD_PRELOAD=x", "me", 0);
    let third = jobs();
    let said = ran("sweep resume {}/s --trust", "stranger", 2);
    assert!(said.contains("may load code") && jobs() == third, "{said}");
}
