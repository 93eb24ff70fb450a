//! Sweeps on the golden trace: plans, keys, segments, runs and merges, through the crate's own functions.

mod failed;
mod hindered;
mod plans;
mod reused;

use std::path::{Path, PathBuf};
use std::time::Duration;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_replay::Stop;
use rayreel_study::StudyError;
use rayreel_study::point::segment::Writer;
use rayreel_study::point::version::MODEL_VERSION;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::merge::merge;
use rayreel_study::sweep::plan::locate::Text;
use rayreel_study::sweep::plan::{Plan, Sources};
use rayreel_study::sweep::reused::ReusedRows;
use rayreel_study::sweep::run::{Outcome, Settings, run};
use rayreel_study::sweep::segment;
use rayreel_study::sweep::shard::Shard;
use rayreel_study::sweep::status::status;
use rayreel_study::table::{Cells, csv, parquet};
use serde_json::json;

fn golden() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace")
}

fn open(location: &str) -> Result<Trace, String> {
    Trace::open(Path::new(location), Limits::default()).map_err(|e| e.to_string())
}

/// The plan of a text whose trace is the golden one.
fn plan(body: &str) -> Result<Plan, String> {
    let text = format!("traces = [{:?}]\n{body}", golden().display().to_string());
    plan_of(&text)
}

fn plan_of(text: &str) -> Result<Plan, String> {
    let text = Text { name: "plan.toml", text };
    Plan::new(&Sources { text, folder: Path::new(""), traces: None, detail: None, stem: "plan", open: &open })
        .map_err(|e| e.to_string())
}

/// Small, but with a machine, without one, with an axis that is for one policy only, and with points that fail.
const SMALL: &str = r#"
machines = ["sgrt-ti2", "raycore", "none"]
policies = ["full", "adaptive"]
exclude = ["machine == 'none' and block == 4"]
[[axis]]
name = "block"
key = "block"
values = [2, 4]
only = ["adaptive"]
"#;

struct Sweep {
    folder: Folder,
    _place: tempfile::TempDir,
}

impl Sweep {
    fn new(plan: Plan) -> Self {
        let place = tempfile::tempdir().unwrap();
        let (folder, _) = Folder::create(&place.path().join("sweep"), plan).unwrap();
        Self { folder, _place: place }
    }

    fn run(&self, shard: Shard, attempt: &str) -> Outcome {
        self.run_with(shard, attempt, &ReusedRows::default())
    }

    fn run_with(&self, shard: Shard, attempt: &str, reused: &ReusedRows) -> Outcome {
        run(&self.folder, &settings(shard, attempt, reused, Stop::default()), |_| {}).unwrap()
    }

    fn bytes(&self) -> (Vec<u8>, Vec<u8>) {
        let merged = merge(&self.folder).unwrap();
        assert!(merged.missing.is_empty());
        (parquet::encode(&merged.results).unwrap(), csv::encode(&merged.results).unwrap())
    }

    fn segments(&self) -> Vec<PathBuf> {
        let folder = self.folder.segments(0);
        let all = std::fs::read_dir(folder).map(|all| all.map(|entry| entry.unwrap().path()).collect());
        all.unwrap_or_default()
    }
}

fn settings<'a>(shard: Shard, attempt: &str, reused: &'a ReusedRows, stop: Stop) -> Settings<'a> {
    Settings {
        shard,
        threads: 2,
        memory: 64 << 20,
        flush: Duration::ZERO,
        writer: Writer { attempt: attempt.into(), host: "here".into() },
        stop,
        open: &open,
        reused,
    }
}

#[test]
fn however_it_is_split_the_result_is_the_same() {
    let whole = Sweep::new(plan(SMALL).unwrap());
    let outcome = whole.run(Shard::WHOLE, "a");
    assert_eq!((outcome.points, outcome.computed, outcome.skipped), (8, 8, 0));
    // A machine without the kernels of adaptive sampling: two rows that say so, and the sweep goes on.
    assert_eq!(outcome.failed, 2, "raycore under adaptive");
    assert_eq!(whole.run(Shard::WHOLE, "b").skipped, 8, "nothing twice");
    assert!(whole.segments().is_empty(), "sealed");
    for count in [2, 3, 8, 20] {
        let split = Sweep::new(plan(SMALL).unwrap());
        let computed: usize =
            (0..count).rev().map(|index| split.run(Shard { index, count }, &format!("a{index}")).computed).sum();
        assert_eq!(computed, 8);
        assert!(split.bytes() == whole.bytes(), "{count} shards");
    }
    let merged = merge(&whole.folder).unwrap();
    assert_eq!((merged.failed, merged.duplicates), (2, 0));
    let results = merged.results;
    assert_eq!(parquet::decode(parquet::encode(&results).unwrap(), Path::new("r")).unwrap(), results);
    let texts = |name: &str| match &results.field(name).unwrap().cells {
        Cells::Text(cells) => cells.clone(),
        other => panic!("{name}: {other:?}"),
    };
    assert_eq!(texts("status").iter().flatten().filter(|s| *s == "failed").count(), 2);
    assert!(texts("error")[4].as_ref().unwrap().contains("machine of this point has no kernel"));
    // Without a machine there are rays, and no cycles.
    let (rays, cycles) = (&results.field("rays_traced").unwrap().cells, &results.field("cycles").unwrap().cells);
    assert!(rays.number(6).unwrap() > 0.0 && cycles.number(0).unwrap() > 0.0);
    assert_eq!(cycles.number(6), None);
    assert_eq!(rays.number(0), rays.number(6), "full on any machine");
    let names: std::collections::BTreeSet<_> = results.fields.iter().map(|field| &field.name).collect();
    assert_eq!(names.len(), results.fields.len());
    let described = |f: &&rayreel_study::table::Field| !f.description.is_empty();
    assert_eq!(results.fields.iter().filter(described).count(), results.fields.len());
}

#[test]
fn second_attempts_do_no_harm_and_differences_are_told() {
    let sweep = Sweep::new(plan(SMALL).unwrap());
    sweep.run(Shard { index: 0, count: 2 }, "first");
    // A zombie that began before: it has not seen the rows of the first.
    let other = Sweep::new(plan(SMALL).unwrap());
    other.run(Shard { index: 0, count: 2 }, "zombie");
    for path in other.segments() {
        std::fs::copy(&path, sweep.folder.segments(0).join(path.file_name().unwrap())).unwrap();
    }
    sweep.run(Shard { index: 1, count: 2 }, "second");
    let merged = merge(&sweep.folder).unwrap();
    assert!(merged.missing.is_empty());
    // And one that is wrong.
    let mut row =
        ReusedRows::load([sweep.folder.path()]).unwrap().rows.into_values().find(|row| row.error.is_none()).unwrap();
    let key = row.key.clone();
    row.figures.insert("rays_traced".into(), json!(7));
    let writer = Writer { attempt: "evil".into(), host: "h".into() };
    segment::write(&sweep.folder, 0, 0, &[row], &writer).unwrap();
    match merge(&sweep.folder) {
        Err(StudyError::Conflict { key: told, detail }) => {
            assert_eq!(told, key);
            assert!(detail.contains("rays_traced is "), "{detail}");
        }
        other => panic!("{other:?}"),
    }
}

#[test]
fn torn_empty_and_foreign_segments_are_computed_again() {
    let want = {
        let sweep = Sweep::new(plan(SMALL).unwrap());
        sweep.run(Shard::WHOLE, "a");
        sweep.bytes()
    };
    type Damage = fn(&[u8]) -> Vec<u8>;
    let damage: [(&str, Damage); 5] = [
        ("torn head", |bytes| bytes[..30].to_vec()),
        ("empty", |_| Vec::new()),
        ("torn body", |bytes| bytes[..bytes.len() - 5].to_vec()),
        ("a flipped bit", |bytes| {
            let mut changed = bytes.to_vec();
            let at = changed.len() - 40;
            changed[at] ^= 1;
            changed
        }),
        ("of another plan", |bytes| {
            let text = String::from_utf8(bytes.to_vec()).unwrap();
            let at = text.find("\"plan\":\"").unwrap() + 8;
            let mut changed = text.into_bytes();
            changed[at] = if changed[at] == b'0' { b'1' } else { b'0' };
            changed
        }),
    ];
    for (what, damage) in damage {
        let sweep = Sweep::new(plan(SMALL).unwrap());
        sweep.run(Shard { index: 0, count: 2 }, "a");
        let path = sweep.segments().pop().unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::write(&path, damage(&bytes)).unwrap();
        let before = status(&sweep.folder).unwrap();
        assert_eq!(before.damaged, 1, "{what}");
        assert!(before.missing.len() > 4, "{what}");
        assert_eq!(merge(&sweep.folder).unwrap().missing, before.missing);
        sweep.run(Shard::WHOLE, "b");
        assert!(sweep.bytes() == want, "{what}");
    }
}

#[test]
fn an_interrupted_run_keeps_what_is_finished() {
    let sweep = Sweep::new(plan(SMALL).unwrap());
    let want = {
        let other = Sweep::new(plan(SMALL).unwrap());
        other.run(Shard::WHOLE, "a");
        other.bytes()
    };
    let (reused, stop) = (ReusedRows::default(), Stop::default());
    let settings = settings(Shard::WHOLE, "a", &reused, stop.clone());
    let settings = Settings { threads: 1, ..settings };
    let first = run(&sweep.folder, &settings, |now| {
        if now.saved >= 2 {
            stop.request();
        }
    })
    .unwrap();
    assert!(first.interrupted && first.computed >= 2 && first.computed < 8, "{first:?}");
    assert!(first.troubles.is_empty(), "{first:?}");
    let second = sweep.run(Shard::WHOLE, "b");
    assert_eq!(second.skipped, first.computed, "nothing lost");
    assert_eq!(second.computed, 8 - first.computed, "nothing twice");
    assert!(sweep.bytes() == want);
}

#[test]
fn points_of_one_key_are_computed_once() {
    // Two machines that are one, under two names.
    let place = tempfile::tempdir().unwrap();
    let file = place.path().join("twin.toml");
    std::fs::write(&file, "extends = \"sgrt-ti2\"\nwhy = \"the same\"\n").unwrap();
    let values: Vec<u32> = (1..=40).collect();
    let text = format!(
        "policies = [\"full\"]\nmachines = [\"sgrt-ti2\", {:?}]\n[[axis]]\nname = \"rays\"\nkey = \"ti.rays_per_trv\"\nvalues = {values:?}",
        file.display().to_string()
    );
    let sweep = Sweep::new(plan(&text).unwrap());
    // Some twins lie in another bucket of segments.
    let outcome = sweep.run(Shard::WHOLE, "a");
    assert_eq!((outcome.points, outcome.computed, outcome.failed), (80, 40, 0));
    assert_eq!(sweep.run(Shard::WHOLE, "b").skipped, 80);
    assert!(sweep.folder.sealed(0).exists() && sweep.folder.sealed(1).exists());
    let results = merge(&sweep.folder).unwrap().results;
    let cycles = &results.field("cycles").unwrap().cells;
    assert!((0..40).all(|i| cycles.number(i).is_some() && cycles.number(i) == cycles.number(i + 40)));
}

#[test]
fn another_trace_in_its_place_is_noticed() {
    let mut moved = plan(SMALL).unwrap();
    moved.traces[0].location = moved.traces[0].location.replace("cornell", "teapot");
    let sweep = Sweep::new(moved);
    let outcome = sweep.run(Shard::WHOLE, "a");
    assert_eq!((outcome.computed, outcome.troubles.len()), (0, 8));
    assert!(outcome.troubles[0].1.contains("is not the trace that the plan was made for"), "{:?}", outcome.troubles[0]);
}

#[test]
fn a_folder_keeps_its_plan() {
    let place = tempfile::tempdir().unwrap();
    let path = place.path().join("sweep");
    Folder::create(&path, plan(SMALL).unwrap()).unwrap();
    Folder::create(&path, plan(SMALL).unwrap()).unwrap();
    let error = Folder::create(&path, plan("policies = [\"full\"]").unwrap()).unwrap_err().to_string();
    assert!(error.contains("holds plan") && error.contains("choose another folder"), "{error}");
    let file = path.join("plan.json");
    let text = std::fs::read_to_string(&file).unwrap();
    for (from, to, want) in [
        ("\"layout\":2", "\"layout\":9", "has layout 9"),
        (format!("\"model\":{MODEL_VERSION}").as_str(), "\"model\":99", "was made for model version 99"),
        ("\"trace\":0", "\"trace\":5", "does not have the checksum"),
        ("{", "[", "not a plan of a sweep"),
    ] {
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
        let error = Folder::open(&path).unwrap_err().to_string();
        assert!(error.contains(want), "{error}");
    }
    let nowhere = Folder::open(place.path()).unwrap_err().to_string();
    assert!(nowhere.contains("is this the folder of a sweep?"), "{nowhere}");
}

/// One flipped bit of a plan gave wrong results under the names of right ones, and `--reuse` carried them on.
#[test]
fn a_plan_that_is_not_what_its_keys_say_is_refused() {
    let sweep = Sweep::new(plan(SMALL).unwrap());
    sweep.run(Shard::WHOLE, "a");
    let file = sweep.folder.path().join("plan.json");
    let (whole, plan) = (std::fs::read(&file).unwrap(), sweep.folder.plan().clone());
    let reused = || ReusedRows::load([sweep.folder.path()]).map(|reused| reused.rows.len());
    let is_refused = |error: &StudyError, want: &str| {
        assert!(error.is_bad_data() && error.to_string().contains(want), "{error}");
    };
    let opened = |bytes: &[u8], want: &str| {
        std::fs::write(&file, bytes).unwrap();
        is_refused(&Folder::open(sweep.folder.path()).map(|folder| merge(&folder).is_ok()).unwrap_err(), want);
    };
    let refused = |bytes: &[u8], want: &str| {
        opened(bytes, want);
        is_refused(&reused().unwrap_err(), want);
    };
    // Four cores become five: the digit is one bit away.
    let text = String::from_utf8(whole.clone()).unwrap();
    let leaf = text.find("gpu.cores = ").unwrap();
    let at = leaf + text[leaf..].find("value = 4").unwrap() + "value = ".len();
    let mut flipped = whole.clone();
    flipped[at] ^= 1;
    assert_eq!((whole[at], flipped[at]), (b'4', b'5'));
    refused(&flipped, "does not have the checksum");
    // With a checksum of its own it is still not what its keys say.
    let mut changed = plan.clone();
    let toml = &mut changed.machines[0].toml;
    let leaf = toml.find("gpu.cores = ").unwrap();
    *toml = toml[..leaf].to_owned() + &toml[leaf..].replacen("value = 4", "value = 5", 1);
    assert_ne!(changed, plan);
    opened(&changed.to_json().unwrap(), "and what it is to compute has the key");
    assert_eq!(reused().unwrap(), 5, "all but the rows of that machine");
    let mut other = plan.clone();
    other.points[0].key = other.points[1].key.clone();
    opened(&other.to_json().unwrap(), "point 0 of the plan");
    assert_eq!(reused().unwrap(), 0, "a segment with a row of none of its points is none of this plan");
    let mut beyond = plan.clone();
    beyond.points[0].frames = (1, u32::MAX);
    refused(&beyond.to_json().unwrap(), "points nowhere");
    std::fs::write(&file, &whole).unwrap();
    assert_eq!(reused().unwrap(), 8);
}

/// [`MODEL_VERSION`] and the BLAKE3 hash of `traces/machine.txt`, the golden results of machines and policies, that goes with it. Other golden
/// traces change the hash and not the version: results are kept under what their traces hold.
const GOLDEN: (u32, &str) = (9, "298d53bfafb9db02128259f219ff474500fba6d528ebc86280d1a44207981368");

#[test]
fn other_results_are_another_model() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces/machine.txt");
    let hash = blake3::hash(&std::fs::read(path).unwrap()).to_string();
    let (version, known) = GOLDEN;
    assert!(
        MODEL_VERSION == version && hash == known,
        "golden results or model version changed: if results did, raise MODEL_VERSION (it is {MODEL_VERSION}), or sweeps would \
         mix old rows with new ones; then write ({MODEL_VERSION}, {hash:?}) here"
    );
}

#[test]
fn results_say_how_much_was_simulated() {
    let sweep = Sweep::new(
        plan("detail = [\"full\", \"all\"]\nmachines = [\"sgrt-ti2\", \"none\"]\npolicies = [\"full\"]").unwrap(),
    );
    // Without a machine there is one point.
    assert_eq!(sweep.run(Shard::WHOLE, "a").computed, 3);
    let results = merge(&sweep.folder).unwrap().results;
    let detail = &results.field("detail").unwrap().cells;
    let said: Vec<_> = (0..results.rows()).map(|row| detail.text(row)).collect();
    assert_eq!(said, [Some("full".into()), Some("all".into()), None]);
}
