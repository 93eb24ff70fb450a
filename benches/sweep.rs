//! What a sweep costs beside its points, and how it scales.
//!
//! ```text
//! cargo bench -p rayreel --bench sweep                 24 points of chess at 128x64, 2x2 samples
//! cargo bench -p rayreel --bench sweep -- FILE.rtrace  of a trace
//! ```
//!
//! "bare" replays each point by itself, as `rayreel replay` does: it decodes the trace each time and writes nothing.
//! "sweep" is `rayreel sweep run` with one and with two points at a time, into a new folder: keys, queue, segments
//! with fsync, sealing. CPU times are of all threads (Linux; whole hundredths of a second); rounds take turns and the
//! best of each is taken, so that ratios hold on a noisy machine.

mod common;

use std::path::Path;
use std::time::{Duration, Instant};

use common::{captured, cpu_seconds};
use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::system::NoProbe;
use rayreel_replay::sequence::{FrameLoop, FrameResult, Simulator};
use rayreel_replay::{Detail, Options, PathSource, Stop};
use rayreel_study::point::segment::Writer;
use rayreel_study::report::{Origin, Report};
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::merge::merge;
use rayreel_study::sweep::plan::locate::Text;
use rayreel_study::sweep::plan::{Plan, Sources};
use rayreel_study::sweep::reused::ReusedRows;
use rayreel_study::sweep::run::{Settings, run};
use rayreel_study::sweep::shard::Shard;
use rayreel_study::table::{csv, parquet};

const ROUNDS: usize = 3;

const PLAN: &str = r#"
policies = ["full", "multirate"]
set = ["srp.ideal=true"]
[[axis]]
name = "l1"
key = "ti.trv_l1.size"
log = { from = "4KiB", to = "32KiB" }
[[axis]]
name = "trv"
key = "ti.trv"
values = [2, 4, 8]
"#;

/// Best wall clock and CPU time of several rounds, seconds.
#[derive(Clone, Copy)]
struct Best(f64, f64);

impl Best {
    fn round<T>(&mut self, run: impl FnOnce() -> T) -> T {
        let (wall, cpu) = (Instant::now(), cpu_seconds().unwrap_or(0.0));
        let result = run();
        self.0 = self.0.min(wall.elapsed().as_secs_f64());
        self.1 = self.1.min(cpu_seconds().unwrap_or(0.0) - cpu);
        result
    }
}

fn open(location: &str) -> Result<Trace, String> {
    Trace::open(Path::new(location), Limits::default()).map_err(|e| e.to_string())
}

/// Each point by itself.
fn bare(plan: &Plan) {
    for point in &plan.points {
        let resolved = plan.resolve(point).unwrap();
        let trace = open(&plan.traces[point.trace].location).unwrap();
        let machine = resolved.machine.clone().unwrap();
        let tree = trace.topology();
        let simulator = Some(Simulator { machine: &machine, tree: &tree, detail: Detail::Full });
        let (mut counted, mut runs) = (Vec::new(), Vec::new());
        let mut frames = FrameLoop::new(&trace, &resolved.policy.policy, Options::default(), &Stop::never()).unwrap();
        let sink = |frame: FrameResult| {
            counted.push(frame.replay.stats);
            runs.extend(frame.run);
            Ok::<_, rayreel_replay::ReplayError>(())
        };
        frames.run(resolved.frame_numbers(), simulator, &mut NoProbe, sink).unwrap();
        let origin = Origin::default();
        let report = Report::new(&origin, &resolved.policy, trace.meta(), &counted).with_machine(&machine, &runs);
        assert!(report.run.cycles > Some(0));
    }
}

/// The sweep in a new folder.
fn swept(plan: &Plan, threads: usize) -> usize {
    let place = tempfile::tempdir().unwrap();
    let (folder, _) = Folder::create(&place.path().join("sweep"), plan.clone()).unwrap();
    let reused = ReusedRows::default();
    let settings = Settings {
        shard: Shard::WHOLE,
        threads,
        memory: 1 << 30,
        flush: Duration::ZERO,
        writer: Writer { attempt: "bench".into(), host: "here".into() },
        stop: Stop::default(),
        open: &open,
        reused: &reused,
    };
    let outcome = run(&folder, &settings, |_| {}).unwrap();
    assert_eq!(outcome.computed, plan.points.len());
    let merged = merge(&folder).unwrap();
    parquet::encode(&merged.results).unwrap().len() + csv::encode(&merged.results).unwrap().len()
}

fn main() {
    let named = std::env::args().skip(1).find(|argument| argument != "--bench");
    let (file, _folder) = match named {
        Some(file) => (file.into(), None),
        None => {
            let (file, folder) = captured("chess", (128, 64));
            (file, Some(folder))
        }
    };
    let text = format!("traces = [{:?}]\n{PLAN}", file.canonicalize().unwrap().display().to_string());
    let text = Text { name: "bench", text: &text };
    let plan =
        Plan::new(&Sources { text, folder: Path::new(""), traces: None, detail: None, stem: "bench", open: &open })
            .unwrap();
    let points = plan.points.len() as f64;
    let mut all = [Best(f64::MAX, f64::MAX); 3];
    for _ in 0..ROUNDS {
        all[0].round(|| bare(&plan));
        all[1].round(|| swept(&plan, 1));
        all[2].round(|| swept(&plan, 2));
    }
    println!("{points} points of {}", file.file_name().unwrap_or_default().display());
    println!("{:<26} {:>9} {:>9} {:>10} {:>12} {:>10}", "", "wall s", "CPU s", "points/s", "CPU s/point", "CPU/bare");
    for (name, Best(wall, cpu)) in ["bare", "sweep, one at a time", "sweep, two at a time"].iter().zip(all) {
        let (rate, each, ratio) = (points / wall, cpu / points, cpu / all[0].1);
        println!("{name:<26} {wall:>9.2} {cpu:>9.2} {rate:>10.2} {each:>12.4} {ratio:>10.3}");
    }
    println!("two at a time: {:.2} times the points per second of one", all[1].0 / all[2].0);
}
