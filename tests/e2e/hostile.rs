//! What strangers, other processes and full disks do: one clear error each, in no time.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::{Ran, capture, command, run};

/// A guard against commands that take hours, not a measurement: other programs may share the cores.
const TOO_LONG: Duration = Duration::from_secs(600);

/// Runs a command line; `{}` is the folder.
fn rayreel(folder: &Path, line: &str) -> Ran {
    let place = folder.to_str().unwrap();
    let args: Vec<OsString> = line.split_whitespace().map(|word| word.replace("{}", place).into()).collect();
    let begun = Instant::now();
    let ran = run(&args);
    assert!(begun.elapsed() < TOO_LONG, "{line} took {:?}", begun.elapsed());
    ran
}

/// Before, 50,000 minus signs overflowed the stack.
#[test]
fn deep_expressions_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    for (expression, word) in [
        ("-".repeat(50_000) + "1", "characters"),
        ("-".repeat(5000) + "1", "signs and brackets"),
        ("(".repeat(5000) + "1", "signs and brackets"),
        ("not ".repeat(2000) + "1", "signs and brackets"),
        ("(".repeat(100) + "1" + &")".repeat(100), "brackets stand too deep"),
    ] {
        let text = format!("traces = [\"a.rtrace\"]\npolicies = [\"full\"]\nexclude = ['{expression}']\n");
        fs::write(folder.join("p.toml"), text).unwrap();
        let ran = rayreel(folder, "sweep plan --dry-run --no-estimate {}/p.toml").expect(2).says(&["p.toml:3:", word]);
        assert!(ran.err.len() < 1000, "{}", ran.err.len());
    }
}

/// A policy of a stranger could print a line of any file.
#[test]
fn what_a_file_extends_is_not_told() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    for name in ["private.txt", "private.toml"] {
        fs::write(folder.join(name), "user:hidden word:0\n").unwrap();
        fs::write(folder.join("p.toml"), format!("extends = {:?}\n", folder.join(name))).unwrap();
        let ran = rayreel(folder, "replay {}/a.rtrace --machine none --policy {}/p.toml").expect(2).says(&["private"]);
        assert!(!ran.err.contains("hidden"), "{}", ran.err);
    }
}

/// These were read without end, or waited for ever.
#[test]
#[cfg(unix)]
fn devices_and_pipes_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    assert!(Command::new("mkfifo").arg(folder.join("pipe.toml")).status().unwrap().success());
    std::os::unix::fs::symlink("/dev/zero", folder.join("zero.toml")).unwrap();
    fs::write(folder.join("m.obj"), "mtllib zero.toml\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    for name in ["pipe.toml", "zero.toml"] {
        for (line, code) in [
            ("sweep plan {}/NAME", 2),
            ("replay {}/a.rtrace --machine none --policy {}/NAME", 2),
            ("replay {}/a.rtrace --machine {}/NAME", 2),
            ("info {}/NAME", 2),
            ("scenes show {}/NAME", 2),
        ] {
            rayreel(folder, &line.replace("NAME", name)).expect(code).says(&["no plain file"]);
        }
    }
    rayreel(folder, "scenes show {}/m.obj").expect(65).says(&["no plain file", "m.obj:1"]);
}

/// `gpu.cores` 4 became 5, and the results were wrong with code 0.
#[test]
fn a_changed_plan_is_bad_data() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    capture("cornell", "--size 16x16 --samples 1x1", &folder.join("a.rtrace"));
    fs::write(folder.join("p.toml"), "traces = [\"a.rtrace\"]\npolicies = [\"full\"]\n").unwrap();
    rayreel(folder, "sweep plan --no-estimate {}/p.toml -o {}/s").expect(0);
    let file = folder.join("s/plan.json");
    let mut bytes = fs::read(&file).unwrap();
    let at = bytes.windows(9).position(|text| text == b"value = 4").unwrap() + 8;
    bytes[at] ^= 1;
    fs::write(&file, bytes).unwrap();
    for line in ["sweep run {}/s", "sweep status {}/s", "sweep merge {}/s"] {
        rayreel(folder, line).expect(65).says(&["checksum", "make it again"]);
    }
}

/// 300 copies of a face ended with "deeper than 128 nodes", and 100,000 did not end.
#[test]
fn copies_of_a_face_are_one() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for copies in [300, 20_000] {
        let text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_owned() + &"f 1 2 3\n".repeat(copies);
        fs::write(folder.join("m.obj"), text).unwrap();
        let ran = rayreel(folder, "capture {}/m.obj --size 16x16 -o {}/m.rtrace --force --quiet").expect(0);
        assert!(ran.err.contains(&format!("{} triangles are copies", copies - 1)), "{}", ran.err);
        rayreel(folder, "verify {}/m.rtrace --scene {}/m.obj --quiet").expect(0);
    }
}

/// Triangles of one box took a time that grew with the square of their number: 32,000 took 54 s. A ray that meets the box still tests
/// them all, so the many are looked away from.
#[test]
fn triangles_of_one_box_are_halved() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    for (faces, view) in [(2000, "--eye 0.4,0.6,2 --target 0.4,0.6,0"), (150_000, "--eye 3,3,1 --target 4,4,1")] {
        let third = |i: usize| format!("v {} 1 0\nf 1 2 {}\n", i as f32 / (faces + 1) as f32, i + 2);
        let text = "v 0 0 0\nv 1 0 0\n".to_owned() + &(1..=faces).map(third).collect::<String>();
        fs::write(folder.join("m.obj"), text).unwrap();
        let line = format!("capture {{}}/m.obj --size 16x16 --depth 0 {view} -o {{}}/m.rtrace --force --quiet");
        rayreel(folder, &line).expect(0);
        rayreel(folder, "info {}/m.rtrace").expect(0).prints(&[&format!("{faces}")]);
        rayreel(folder, "verify {}/m.rtrace --quiet").expect(0);
    }
}

/// The second was told to continue what the first was writing.
#[test]
#[cfg(target_os = "linux")]
fn a_second_writer_is_told_who_writes() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let line = format!("capture teapot --size 2048x1024 --quiet -o {}/t.rtrace", folder.display());
    let args: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
    let mut first = command(&args).spawn().unwrap();
    let begun = Instant::now();
    while !folder.join("t.rtrace.partial").exists() {
        assert!(begun.elapsed() < TOO_LONG);
        std::thread::sleep(Duration::from_millis(10));
    }
    let holder = format!("is being written by process {}", first.id());
    for option in ["", "--resume", "--force"] {
        let ran = rayreel(folder, &format!("capture teapot --size 2048x1024 --quiet -o {{}}/t.rtrace {option}"));
        ran.expect(2).says(&[&holder]);
    }
    first.kill().unwrap();
    first.wait().unwrap();
    rayreel(folder, "capture teapot --size 2048x1024 -o {}/t.rtrace")
        .expect(2)
        .says(&["`rayreel capture --resume` goes on"]);
}

/// While a scene was loaded, SIGTERM killed the process: a queue saw no code.
#[test]
#[cfg(unix)]
fn an_early_signal_is_an_interruption() {
    let folder = tempfile::tempdir().unwrap();
    let line = format!("capture provence --size 64x32 --quiet -o {}/t.rtrace", folder.path().display());
    let args: Vec<OsString> = line.split_whitespace().map(OsString::from).collect();
    let mut child = command(&args).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(200));
    assert!(Command::new("kill").arg(child.id().to_string()).status().unwrap().success());
    assert_eq!(child.wait().unwrap().code(), Some(75));
}

#[test]
#[cfg(target_os = "linux")]
fn a_full_disk_is_74() {
    let full = || Stdio::from(fs::File::options().write(true).open("/dev/full").unwrap());
    let status = command(&["scenes".into(), "list".into()]).stdout(full()).status().unwrap();
    assert_eq!(status.code(), Some(74));
}

/// What is said on standard error is beside the point: the work is done, and the code is that of the work.
#[test]
#[cfg(target_os = "linux")]
fn nobody_has_to_hear_what_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    fs::write(at("m.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 3\n").unwrap();
    let deaf = |line: &str| {
        let words: Vec<_> = line.split(' ').map(|word| word.replace("{}", &at("")).into()).collect();
        let full = fs::File::options().write(true).open("/dev/full").unwrap();
        command(&words).stdout(Stdio::null()).stderr(full).status().unwrap().code()
    };
    assert_eq!(deaf("capture {}m.obj --size 16x16 -o {}a.rtrace"), Some(0), "of two warnings");
    assert_eq!(deaf("replay {}a.rtrace --machine none"), Some(0));
    assert_eq!(deaf("info {}none.rtrace"), Some(2));
}

/// Rayon tried to start them, for minutes, and panicked.
#[test]
fn threads_are_as_many_as_can_be_started() {
    for many in ["1025", "99999999999999999999"] {
        let mut listing = command(&["scenes".into(), "list".into()]);
        let output = listing.env("RAYON_NUM_THREADS", many).output().unwrap();
        let said = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains(&format!("RAYON_NUM_THREADS is {many}; give at most 1024")), "{said}");
    }
}
