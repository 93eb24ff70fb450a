//! Captures that are killed or interrupted, and go on as if nothing had happened.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::common::{self, capture, capture_args, digest, run};
use crate::rayreel;

/// Many small batches, and long enough to be hit in the middle: about half a second.
const LONG: &str = "--size 192x144 --samples 2x2 --tile 8 --threads 1";

/// `NAME.partial`.
pub fn partial(file: &Path) -> PathBuf {
    file.with_extension("rtrace.partial")
}

/// What a capture that nobody disturbed gives.
struct Undisturbed {
    bytes: Vec<u8>,
    digest: Value,
    folder: tempfile::TempDir,
}

impl Undisturbed {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("undisturbed.rtrace");
        capture("cornell", LONG, &file);
        Self { bytes: fs::read(&file).unwrap(), digest: digest(&file), folder }
    }

    fn file(&self, name: &str) -> PathBuf {
        self.folder.path().join(format!("{name}.rtrace"))
    }

    /// Starts a capture, waits until its partial file has `share` of the bytes, and sends `signal`. Gives the child, still to
    /// be waited for, or nothing if the capture was faster.
    fn signalled(&self, file: &Path, share: f64, signal: &str) -> Option<Child> {
        let mut child = common::command(&capture_args("cornell", LONG, file)).spawn().unwrap();
        let wanted = ((self.bytes.len() as f64 * share) as u64).max(1);
        let start = Instant::now();
        while fs::metadata(partial(file)).map_or(0, |m| m.len()) < wanted {
            assert!(start.elapsed() < Duration::from_secs(60), "the capture hangs");
            if child.try_wait().unwrap().is_some() {
                return None;
            }
            std::thread::sleep(Duration::from_micros(300));
        }
        let sent = Command::new("sh").args(["-c", &format!("kill -{signal} {}", child.id())]).status().unwrap();
        sent.success().then_some(child)
    }

    /// As [`Self::signalled`], as often as it takes to hit the capture while it runs; gives its exit code and messages.
    fn interrupted(&self, file: &Path, share: f64, signal: &str) -> (Option<i32>, String) {
        for _ in 0..20 {
            let output = self.signalled(file, share, signal).map(|child| child.wait_with_output().unwrap());
            match output {
                Some(output) if !output.status.success() && !file.exists() => {
                    return (output.status.code(), String::from_utf8(output.stderr).unwrap());
                }
                _ => self.discard_finished(file),
            }
        }
        panic!("the capture was never hit at {share}; make it longer");
    }

    /// The signal came too late, perhaps between the renaming and the exit: whatever bears the trace's name is whole.
    fn discard_finished(&self, file: &Path) {
        assert!(fs::read(file).unwrap() == self.bytes, "an unfinished trace does not have its name");
        fs::remove_file(file).unwrap();
    }

    /// Goes on with a partial file, and demands the same trace.
    #[track_caller]
    fn assert_resumes(&self, file: &Path) {
        let mut args = capture_args("cornell", LONG, file);
        args.push("--resume".into());
        run(&args).expect(0);
        assert_eq!(digest(file), self.digest, "{}", file.display());
        assert!(fs::read(file).unwrap() == self.bytes, "{}: other bytes than undisturbed", file.display());
        assert!(!partial(file).exists(), "the partial file is gone");
    }
}

#[test]
fn a_killed_capture_goes_on() {
    let whole = Undisturbed::new();
    for share in [0.0, 0.2, 0.5, 0.8, 0.95] {
        let file = whole.file(&format!("killed-{share}"));
        let (code, _) = whole.interrupted(&file, share, "KILL");
        assert_eq!(code, None, "ended by the signal");
        assert!(partial(&file).exists(), "what was written is kept");
        whole.assert_resumes(&file);
    }
}

/// Twice killed, and the tail torn as a power cut would.
#[test]
fn a_torn_tail_is_cut_off() {
    let whole = Undisturbed::new();
    let file = whole.file("torn");
    whole.interrupted(&file, 0.6, "KILL");
    let left = fs::read(partial(&file)).unwrap();
    for (i, keep) in [0, 5, 40, left.len() / 3, left.len() - 1].into_iter().enumerate() {
        let file = whole.file(&format!("torn-{i}"));
        fs::write(partial(&file), &left[..keep]).unwrap();
        whole.assert_resumes(&file);
    }
    let file = whole.file("garbage");
    fs::write(partial(&file), &left).unwrap();
    File::options().append(true).open(partial(&file)).unwrap().write_all(&[0x5a; 777]).unwrap();
    whole.assert_resumes(&file);
}

#[test]
fn a_signal_ends_a_capture_in_order() {
    let whole = Undisturbed::new();
    for signal in ["TERM", "INT", "HUP"] {
        let file = whole.file(signal);
        let (code, messages) = whole.interrupted(&file, 0.3, signal);
        assert_eq!(code, Some(75), "SIG{signal}: {messages}");
        assert!(["interrupted", "tiles", "--resume"].iter().all(|word| messages.contains(word)), "{messages}");
        // Everything flushed: no byte has to be dropped, so repair finds nothing damaged.
        let fixed = whole.file(&format!("{signal}-fixed"));
        let repaired = rayreel!["repair", &partial(&file), "-o", &fixed].expect(3);
        assert!(!repaired.out.contains("damaged"), "{}", repaired.out);
        whole.assert_resumes(&file);
    }
}

/// What a partial file is for is never guessed.
#[test]
fn only_the_same_capture_goes_on() {
    let whole = Undisturbed::new();
    let file = whole.file("refused");
    whole.interrupted(&file, 0.3, "KILL");
    // A signal may fall between two chunks; here the last one is surely torn.
    File::options().append(true).open(partial(&file)).unwrap().write_all(&[0x5a; 35]).unwrap();
    let left = fs::read(partial(&file)).unwrap();
    run(&capture_args("cornell", LONG, &file)).expect(2).says(&["already exists", "--resume", ".partial"]);
    for (scene, options) in [
        ("cornell", LONG.replace("192x144", "192x145")),
        ("cornell", LONG.replace("2x2", "1x1")),
        ("cornell", LONG.replace("--tile 8", "--tile 16")),
        ("cornell", format!("{LONG} --depth 1")),
        ("teapot", LONG.to_string()),
    ] {
        let args = capture_args(scene, &format!("{options} --resume"), &file);
        run(&args).expect(2).says(&["started with another scene, other settings", ".partial"]);
    }
    // What was packed otherwise would stay so, and the file be that of neither level.
    let args = capture_args("cornell", &format!("{LONG} --level 3 --resume"), &file);
    run(&args).expect(2).says(&["started with another --level", ".partial"]);
    assert!(fs::read(partial(&file)).unwrap() == left, "refusing changes nothing");
    whole.assert_resumes(&file);
}

/// A killed process leaves nothing behind its torn chunk. Where tiles are, they are traced again, and it is said.
#[test]
fn tiles_behind_damage_are_traced_again_and_it_is_said() {
    let whole = Undisturbed::new();
    let file = whole.file("damaged");
    whole.interrupted(&file, 0.7, "KILL");
    let mut left = fs::read(partial(&file)).unwrap();
    let resume = capture_args("cornell", &format!("{LONG} --resume"), &file);
    // In the middle, and in the tree, without which no tile can be kept.
    for at in [left.len() / 2, 1000] {
        let _ = fs::remove_file(&file);
        left[at] ^= 1;
        fs::write(partial(&file), &left).unwrap();
        let said = run(&resume).expect(0).err;
        assert!(said.contains("whole tiles behind the damage were cut off and traced again"), "{said}");
        assert!(fs::read(&file).unwrap() == whole.bytes, "other bytes than undisturbed");
    }
}

#[test]
fn force_begins_anew() {
    let whole = Undisturbed::new();
    let file = whole.file("forced");
    whole.interrupted(&file, 0.3, "KILL");
    run(&capture_args("cornell", &format!("{LONG} --force"), &file)).expect(0);
    assert!(fs::read(&file).unwrap() == whole.bytes);
    run(&capture_args("cornell", LONG, &file)).expect(2).says(&["already exists", "--force"]);
    assert!(fs::read(&file).unwrap() == whole.bytes, "a refused capture leaves the file");
}

/// The second writer is told, and neither spoils the file.
#[test]
fn two_captures_do_not_write_one_file() {
    let whole = Undisturbed::new();
    let file = whole.file("shared");
    let go_on = |child: &Child| {
        assert!(Command::new("sh").args(["-c", &format!("kill -CONT {}", child.id())]).status().unwrap().success());
    };
    let stopped = (0..20).find_map(|_| {
        let mut child = whole.signalled(&file, 0.1, "STOP");
        if let Some(late) = child.as_mut().filter(|_| !partial(&file).exists()) {
            go_on(late);
            late.wait().unwrap();
            child = None;
        }
        if child.is_none() {
            whole.discard_finished(&file);
        }
        child
    });
    let child = stopped.expect("the capture was never hit");
    let second = run(&capture_args("cornell", &format!("{LONG} --resume"), &file));
    go_on(&child);
    assert!(child.wait_with_output().unwrap().status.success());
    second.expect(2).says(&["is being written by"]);
    assert!(fs::read(&file).unwrap() == whole.bytes);
}

/// A sequence is cut short between and inside frames alike.
#[test]
fn a_sequence_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let scene = common::scenes::moving(folder.path());
    let options = "--size 60x40 --tile 16 --frames 0..5";
    let (file, again) = (folder.path().join("a.rtrace"), folder.path().join("b.rtrace"));
    capture(&scene, options, &file);
    let bytes = fs::read(&file).unwrap();
    for share in [2, 5, 7, 9] {
        fs::write(partial(&again), &bytes[..bytes.len() * share / 10]).unwrap();
        let resumed = capture(&scene, &format!("{options} --resume"), &again);
        assert!(fs::read(&again).unwrap() == bytes, "cut at {share} tenths");
        assert_eq!(resumed["frames"], 5);
        assert_eq!(resumed["rays"], rayreel!["info", "--json", &file].json()["rays"], "kept tiles are counted too");
        fs::remove_file(&again).unwrap();
    }
}

/// A signal while pictures were written left their temporary files.
#[test]
fn a_signal_ends_a_replay_in_order() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, out) = (folder.path().join("a.rtrace"), folder.path().join("out"));
    let scene = common::scenes::moving(folder.path());
    capture(&scene, "--size 512x384 --samples 1x1 --frames 0..3", &trace);
    let args = ["replay", "--quiet", "--machine", "none", "--out"].map(std::ffi::OsString::from);
    let args = [&args[..], &[out.clone().into(), trace.into()]].concat();
    let names = || {
        let entries = fs::read_dir(&out).into_iter().flatten();
        entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect::<Vec<_>>()
    };
    let unfinished = || names().iter().any(|name| name.ends_with(".partial"));
    let mut hit = 0;
    for _ in 0..5 {
        let _ = fs::remove_dir_all(&out);
        let mut child = common::command(&args).spawn().unwrap();
        while !unfinished() && child.try_wait().unwrap().is_none() {}
        let sent = Command::new("sh").args(["-c", &format!("kill -TERM {}", child.id())]).status().unwrap();
        let ended = child.wait_with_output().unwrap();
        assert!(!unfinished(), "{:?}", names());
        if sent.success() && ended.status.code() == Some(75) {
            hit += 1;
            assert_eq!(String::from_utf8(ended.stderr).unwrap(), "interrupted\n");
            assert!(!out.join("stats.json").exists(), "nothing says that this is whole");
        }
    }
    assert!(hit > 0, "the replay was never hit; make it longer");
}
