//! Sweeps as a user runs them: killed, resumed, split, planned wrong.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Child, Stdio};
use std::time::{Duration, Instant};

use rayreel_testkit::Random;
use serde_json::Value;

use crate::common::{self, Ran, capture};
use crate::rayreel;

/// A folder with a small trace and plans.
struct Place(tempfile::TempDir);

impl Place {
    fn new(size: &str) -> Self {
        let place = Self(tempfile::tempdir().unwrap());
        capture("cornell", &format!("--size {size} --samples 1x1"), &place.path("small.rtrace"));
        place
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn plan(&self, name: &str, body: &str) -> PathBuf {
        let path = self.path(name);
        fs::write(&path, format!("traces = [\"*.rtrace\"]\n{body}")).unwrap();
        path
    }

    fn run(&self, words: &str) -> Ran {
        common::run(&self.args(words))
    }

    /// Words; those in `{}` are files of this place.
    fn args(&self, words: &str) -> Vec<std::ffi::OsString> {
        let word = |word: &str| match word.strip_prefix('{').and_then(|w| w.strip_suffix('}')) {
            Some(file) => self.path(file).into_os_string(),
            None => word.into(),
        };
        std::iter::once("sweep".into()).chain(words.split_whitespace().map(word)).collect()
    }
}

/// 512 points of some milliseconds each.
const MANY: &str = r#"
policies = ["full", "adaptive"]
[[axis]]
name = "l1"
key = "ti.trv_l1.size"
log = { from = "1KiB", to = "128KiB" }
[[axis]]
name = "trv"
key = "ti.trv"
values = [1, 2, 4, 8]
[[axis]]
name = "rays"
key = "ti.rays_per_trv"
values = [16, 32, 64, 128]
[[axis]]
name = "miss"
key = "ti.miss_handling"
values = ["retry", "accumulate"]
"#;

fn results(sweep: &Path) -> (Vec<u8>, Vec<u8>) {
    (fs::read(sweep.join("results.parquet")).unwrap(), fs::read(sweep.join("results.csv")).unwrap())
}

/// Keys of the rows on disk. Panics if two segments hold the same: then a finished point was computed again.
fn rows_on_disk(sweep: &Path) -> usize {
    // A segment goes away when its bucket is sealed: then look again.
    loop {
        if let Some(keys) = keys_on_disk(sweep) {
            return keys.len();
        }
    }
}

fn keys_on_disk(sweep: &Path) -> Option<BTreeSet<String>> {
    let list = |path: &Path| -> Vec<PathBuf> {
        fs::read_dir(path).map(|all| all.filter_map(|entry| Some(entry.ok()?.path())).collect()).unwrap_or_default()
    };
    let keys = |path: &Path| -> Option<Vec<String>> {
        let text = fs::read_to_string(path).ok()?;
        let key = |line: &str| Some(serde_json::from_str::<Value>(line).ok()?["key"].as_str()?.to_owned());
        text.lines().skip(1).map(key).collect()
    };
    let whole = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "seg");
    // First the segments: what is sealed meanwhile is found in both, and counts once.
    let mut found = BTreeSet::new();
    for path in list(&sweep.join("segments")).iter().flat_map(|bucket| list(bucket)).filter(whole) {
        for key in keys(&path)? {
            assert!(found.insert(key), "two segments hold the same row");
        }
    }
    for path in list(&sweep.join("sealed")).into_iter().filter(whole) {
        found.extend(keys(&path)?);
    }
    Some(found)
}

#[cfg(unix)]
#[test]
fn five_hundred_points_killed_ten_times_are_the_undisturbed_ones() {
    let place = Place::new("16x8");
    place.plan("many.toml", MANY);
    place.run("{many.toml} -o {undisturbed} --quiet").expect(0);
    let whole = results(&place.path("undisturbed"));
    assert_eq!(String::from_utf8(whole.1.clone()).unwrap().lines().count(), 513);

    let sweep = place.path("killed");
    place.run("plan {many.toml} -o {killed} --no-estimate").expect(0);
    let mut kills = 0;
    let mut random = Random(0x9e37_79b9);
    while kills < 10 {
        let before = rows_on_disk(&sweep);
        assert!(before < 512, "the sweep ended after {kills} kills: points are too short for this test");
        // A random number of points from 1 to 40 later.
        let wait = 1 + random.index(40);
        let mut child = start(&place, "run {killed} --quiet --threads 2");
        let begun = Instant::now();
        while rows_on_disk(&sweep) < (before + wait).min(512) && child.try_wait().unwrap().is_none() {
            assert!(begun.elapsed() < Duration::from_secs(120), "the sweep hangs");
            std::thread::sleep(Duration::from_micros(500));
        }
        child.kill().unwrap();
        child.wait().unwrap();
        let after = rows_on_disk(&sweep);
        assert!(after >= before, "a kill lost rows: {before}, then {after}");
        kills += 1;
    }
    let kept = rows_on_disk(&sweep);
    let status: Value = place.run("status {killed} --json").expect(3).json();
    assert_eq!(status["done"], kept, "no row twice, and no finished one lost");
    let last = place.run("resume {killed} --quiet").expect(0);
    last.says(&[&format!("{kept} skipped"), &format!("{} computed", 512 - kept)]);
    place.run("merge {killed}").expect(0).prints(&["512 rows"]);
    assert!(results(&sweep) == whole, "the merged files differ from the undisturbed run's");
}

fn start(place: &Place, words: &str) -> Child {
    common::command(&place.args(words)).stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

/// A few points of half a second or so.
const FEW: &str = r#"
policies = ["full"]
[[axis]]
name = "trv"
key = "ti.trv"
values = [1, 2, 3, 4, 5, 6]
"#;

#[cfg(unix)]
#[test]
fn a_signal_flushes_and_stops() {
    let place = Place::new("128x64");
    place.plan("few.toml", FEW);
    place.run("plan {few.toml} -o {sweep} --no-estimate").expect(0);
    for signal in ["INT", "TERM"] {
        let child = common::command(&place.args("run {sweep} --quiet --threads 1"))
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let before = rows_on_disk(&place.path("sweep"));
        let begun = Instant::now();
        while rows_on_disk(&place.path("sweep")) == before {
            assert!(begun.elapsed() < Duration::from_secs(60), "the sweep hangs");
            std::thread::sleep(Duration::from_millis(2));
        }
        let sent = std::process::Command::new("kill").args([&format!("-{signal}"), &child.id().to_string()]).status();
        assert!(sent.unwrap().success());
        let ended = child.wait_with_output().unwrap();
        let text = String::from_utf8(ended.stderr).unwrap();
        assert_eq!(ended.status.code(), Some(75), "{text}");
        assert!(text.contains("interrupted, flushed"), "{text}");
    }
    place.run("resume {sweep} --quiet").expect(0);
    place.run("merge {sweep}").expect(0).prints(&["6 rows", "0 duplicates"]);
}

/// Frames so large that policies go through them side by side, where there is more than one thread.
#[test]
fn policies_side_by_side_give_what_each_gives_alone() {
    let place = Place::new("1024x512");
    place.plan("large.toml", "policies = [\"full\", \"paper-ss\", \"multirate\"]\ndetail = [\"5%\"]\n");
    place.run("{large.toml} -o {alone} --threads 1 --quiet").expect(0);
    for threads in [2, 3] {
        place.run(&format!("{{large.toml}} -o {{beside}} --threads {threads} --quiet")).expect(0);
        assert!(results(&place.path("beside")) == results(&place.path("alone")), "{threads} threads");
        fs::remove_dir_all(place.path("beside")).unwrap();
    }
    // Interrupted on their way, and taken up again.
    place.run("plan {large.toml} -o {sweep} --no-estimate").expect(0);
    let mut child = common::command(&place.args("run {sweep} --quiet --threads 2")).spawn().unwrap();
    std::thread::sleep(Duration::from_millis(300));
    child.kill().unwrap();
    child.wait().unwrap();
    place.run("resume {sweep} --quiet").expect(0);
    place.run("merge {sweep}").expect(0).prints(&["3 rows", "0 duplicates"]);
    assert!(results(&place.path("sweep")) == results(&place.path("alone")));
}

/// Machines that share one pass, each with windows of its own.
#[test]
fn machines_in_one_pass_are_estimated_as_alone() {
    let place = Place::new("1024x320");
    let rows = |machines: &str| {
        place.plan("plan.toml", &format!("machines = {machines}\npolicies = [\"full\"]\ndetail = [\"5%\"]\n"));
        place.run("{plan.toml} -o {out} --quiet").expect(0);
        let mut table = csv::Reader::from_path(place.path("out/results.csv")).unwrap();
        let points: Vec<BTreeMap<String, String>> = table.deserialize().collect::<Result<_, _>>().unwrap();
        fs::remove_dir_all(place.path("out")).unwrap();
        // Another machine brings columns of its own, and points their numbers.
        let has = |(name, value): &(String, String)| name != "point" && !value.is_empty();
        points.into_iter().map(|point| point.into_iter().filter(has).collect()).collect::<Vec<BTreeMap<_, _>>>()
    };
    let together = rows("[\"sgrt-ti2\", \"sgrt-ti1\"]");
    assert!(
        together.iter().all(|point| point.contains_key("cycles_interval_percent")),
        "they are estimates: {together:?}"
    );
    assert_eq!(together, [rows("[\"sgrt-ti2\"]"), rows("[\"sgrt-ti1\"]")].concat());
}

#[test]
fn shards_on_the_command_line_make_the_whole() {
    let place = Place::new("32x16");
    place.plan("few.toml", FEW);
    place.run("{few.toml} -o {whole} --quiet").expect(0);
    place.run("plan {few.toml} -o {split} --no-estimate").expect(0);
    let told = place.run("resume {split} --dry-run").expect(0);
    assert!(told.out.contains("6 of 6 points on this machine") && told.err.is_empty(), "{told:?}");
    place.run("resume {split} --mem 8G").expect(2).says(&["--mem", "are for a cluster", "sweep submit"]);
    for option in ["--mem 8G", "--shards 3", "--setup true", "-- --qos=long"] {
        place.run(&format!("submit {{split}} --engine local {option}")).expect(2).says(&["--mem", "are for a cluster"]);
    }
    place
        .run("submit {split} --engine slurm --dry-run --mem much")
        .expect(2)
        .says(&["a whole number with K, M, G or T"]);
    place.run("submit {split} --engine slurm --dry-run -- long").expect(2).says(&["long is none: they begin with -"]);
    place.run("status {split}").expect(3).prints(&["0 of 6 points done"]);
    place.run("run {split} --shard 2/3 --quiet").expect(0).says(&["shard 2/3", "2 points", "2 computed"]);
    place.run("merge {split}").expect(3).says(&["missing 4 of 6 points", "sweep resume"]);
    place.run("merge {split} --partial").expect(3).prints(&["2 rows"]);
    place.run("status {split}").expect(3).prints(&["2 of 6 points done", "4 missing"]);
    let mut child = common::command(&place.args("run {split} --shard auto/3 --index-offset 1 --quiet"));
    assert!(child.env("SLURM_ARRAY_TASK_ID", "0").status().unwrap().success());
    place.run("run {split} --shard 0/3 --quiet").expect(0);
    place.run("merge {split}").expect(0);
    assert!(results(&place.path("split")) == results(&place.path("whole")));
    // It wrapped round to shard 0.
    let last = usize::MAX;
    let mut child = common::command(&place.args(&format!("run {{split}} --shard auto/3 --index-offset {last}")));
    let ended = child.env("SLURM_ARRAY_TASK_ID", "1").output().unwrap();
    assert_eq!(ended.status.code(), Some(2));
    assert!(String::from_utf8(ended.stderr).unwrap().contains(&format!("--index-offset {last} is too large")));
    for (words, want) in [
        ("run {split} --shard 3/3", "is no shard"),
        ("run {split} --shard auto/3", "needs one of SLURM_ARRAY_TASK_ID"),
        ("run {nowhere}", "is this the folder of a sweep?"),
        ("status {few.toml}", "is this the folder of a sweep?"),
    ] {
        place.run(words).expect(2).says(&[want]);
    }
}

#[test]
fn a_bad_plan_is_one_error_and_a_dry_run_writes_nothing() {
    let place = Place::new("32x16");
    place.plan("good.toml", FEW);
    let before = listing(place.0.path());
    place.run("plan {good.toml} -o {sweep} --dry-run").expect(0).prints(&[
        "6 points",
        "about",
        "trv: 1, 2, 3, 4, 5, 6",
    ]);
    assert_eq!(listing(place.0.path()), before);
    for (body, want) in [
        ("policies = [\"full\"]\ntraces_ = 1\n", "bad.toml:3:1: unknown field `traces_`"),
        ("policies = [\"ful\"]\n", "bad.toml:2:13: no policy preset \"ful\""),
        (
            "policies = [\"full\"]\n[[axis]]\nname = \"a\"\nkey = \"ti.trv\"\nvalues = []\n",
            "bad.toml:6:10: axis \"a\" has no values",
        ),
        (
            "policies = [\"full\"]\n[[axis]]\nname = \"a\"\nkey = \"ti.trv\"\nrange = { from = 0, to = 1e12, step = 1 }\n",
            "bad.toml:6:9: axis",
        ),
    ] {
        place.plan("bad.toml", body);
        let ran = place.run("plan {bad.toml} -o {sweep}").expect(2);
        ran.says(&[want]);
        assert!(!place.path("sweep").exists());
    }
    fs::write(place.path("bad.toml"), "traces = [\"none.rtrace\"]\npolicies = [\"full\"]\n").unwrap();
    place.run("plan {bad.toml} -o {sweep}").expect(2).says(&["bad.toml:1:11: trace ", "none.rtrace"]);
}

fn listing(path: &Path) -> Vec<PathBuf> {
    let mut all: Vec<PathBuf> = fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()).collect();
    all.sort();
    all
}

/// A key names the checksums of its trace: bytes that do not fit them make no row, and a sound copy does.
#[test]
fn a_damaged_trace_leaves_no_row() {
    let place = Place::new("32x32");
    place.plan("p.toml", "machines = [\"none\"]\npolicies = [\"full\", \"adaptive\"]\n");
    place.run("plan {p.toml} -o {s} --no-estimate --quiet").expect(0);
    let sound = fs::read(place.path("small.rtrace")).unwrap();
    let mut damaged = sound.clone();
    damaged[sound.len() / 2] ^= 1;
    fs::write(place.path("small.rtrace"), damaged).unwrap();
    place.run("run {s} --quiet").expect(3).says(&["not done", "checksum"]);
    fs::write(place.path("small.rtrace"), sound).unwrap();
    place.run("resume {s} --quiet").expect(0);
    place.run("merge {s} --quiet").expect(0);
    let csv = fs::read_to_string(place.path("s/results.csv")).unwrap();
    assert!(csv.lines().count() == 3 && !csv.contains("failed"), "{csv}");
}

/// A row of it stood for ever, and `--reuse` took it to other sweeps.
#[test]
fn too_little_memory_leaves_no_row() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("cornell", "--size 64x64 --samples 2x2 --tile 128", &at("a.rtrace"));
    fs::write(at("p.toml"), "traces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n").unwrap();
    let run = |memory: &str| rayreel!["-q", "sweep", "run", &at("p.toml"), "-o", &at("s"), "--memory", memory];
    run("1").expect(3).says(&["memory for decoding"]);
    run("1000").expect(0).says(&["1 computed"]);
}

/// Folders are taken as they are, and files of a sweep are checked when they are read.
#[test]
fn names_of_folders_and_meanings_of_columns() {
    let folder = tempfile::tempdir().unwrap();
    let place = folder.path().join("run[1]");
    fs::create_dir(&place).unwrap();
    capture("cornell", "--size 16x16 --samples 1x1", &place.join("a.rtrace"));
    let (plan, sweep) = (place.join("p.toml"), place.join("s"));
    fs::write(&plan, "traces = [\"*.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n").unwrap();
    rayreel!["-q", "sweep", "run", &plan, "-o", &sweep].expect(0);
    for file in fs::read_dir(sweep.join("columns")).unwrap() {
        let file = file.unwrap().path();
        let text = fs::read_to_string(&file).unwrap();
        fs::write(&file, text.replace("rays of all samples", "bananas of all samples")).unwrap();
    }
    rayreel!["sweep", "merge", &sweep].expect(65).says(&["its name is the checksum of other bytes"]);
}

/// Tables of two sweeps can be put together: a column is of one type, whether anything has a value of it or not. Points that are alike have
/// one row, and the last line says so.
#[test]
fn columns_have_one_type_and_points_one_row() {
    use rayreel_study::analysis::load::load;
    use rayreel_study::table::Cells;

    let place = Place::new("32x32");
    let types = |name: &str, machine: &str| {
        place.plan(
            &format!("{name}.toml"),
            &format!("machines = [\"{machine}\"]\npolicies = [\"adaptive\", \"paper-ss\"]\n"),
        );
        let ran = place.run(&format!("run {{{name}.toml}} -o {{{name}}} --quiet")).expect(0);
        ran.says(&["2 points, 0 skipped, 0 reused, 1 computed, 1 the same as another, 0 failed"]);
        place.run(&format!("merge {{{name}}} --quiet")).expect(0);
        let fields = load(&place.path(name)).unwrap().0.fields;
        let kind = |cells: &Cells| format!("{cells:?}").split('(').next().unwrap().to_owned();
        fields
            .iter()
            .map(|field| (field.name.clone(), kind(&field.cells)))
            .collect::<std::collections::BTreeMap<_, _>>()
    };
    let (all, none) = (types("a", "sgrt-ti2"), types("b", "none"));
    assert!(none.len() > 40 && none.keys().all(|name| all.contains_key(name)));
    for (name, kind) in &none {
        assert_eq!(kind, &all[name], "{name}");
    }
}
