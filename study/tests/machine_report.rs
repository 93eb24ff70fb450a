//! What a report says of a machine, and the timeline, on a recorded trace: every figure follows from the counters.

use std::collections::BTreeMap;
use std::path::PathBuf;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::system::NoProbe;
use rayreel_machine::timeline::Timeline;
use rayreel_replay::sequence::{FrameLoop, FrameResult, Simulator};
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::{Detail, NamedPolicy, Options, PathSource, ReplayError, Stop};
use rayreel_study::figures::{COMPONENT_PARTS, Form, OverFrames, column, columns, figures};
use rayreel_study::point::row::{Row, role_of};
use rayreel_study::report::{Origin, Report};
use rayreel_study::table::Role;
use serde_json::Value;

fn trace() -> Trace {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace");
    Trace::open(&path, Limits::default()).unwrap()
}

/// The first frame of the trace, `times` times, as JSON with the page, the runs and the timeline.
fn run(machine: &str, overrides: &[&str], times: usize) -> (Value, String, Vec<MachineRun>, Value) {
    let trace = trace();
    let overrides: Vec<_> = overrides.iter().map(ToString::to_string).collect();
    let machine = NamedMachine::load(machine, &overrides).unwrap();
    let policy = NamedPolicy::load(if machine.name.starts_with("raycore") { "full" } else { "adaptive" }, &[]).unwrap();
    let tree = trace.topology();
    let simulator = Some(Simulator { machine: &machine, tree: &tree, detail: Detail::Full });
    let frames = std::iter::repeat_n(trace.meta().first_frame, times);
    let mut replays = FrameLoop::new(&trace, &policy.policy, Options::default(), &Stop::never()).unwrap();
    let (mut stats, mut runs, mut unwatched) = (Vec::new(), Vec::new(), Vec::new());
    let mut timeline = Timeline::new(&machine.config);
    let watch = |frame: FrameResult| {
        stats.push(frame.replay.stats);
        runs.extend(frame.run);
        Ok::<_, ReplayError>(())
    };
    replays.run(frames.clone(), simulator, &mut timeline, watch).unwrap();
    let count = |frame: FrameResult| {
        unwatched.extend(frame.run);
        Ok::<_, ReplayError>(())
    };
    replays.run(frames, simulator, &mut NoProbe, count).unwrap();
    assert_eq!(runs, unwatched, "looking changes nothing");
    let origin = Origin { trace: "cornell".into(), ..Origin::default() };
    let report = Report::new(&origin, &policy, trace.meta(), &stats).with_machine(&machine, &runs);
    let json = serde_json::from_str(&report.to_json().unwrap()).unwrap();
    (json, report.to_string(), runs, serde_json::from_str(&timeline.to_json("{}")).unwrap())
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 1e-9 * a.abs().max(b.abs()), "{a} {b}");
}

#[test]
fn figures_follow_from_the_counters() {
    let (json, _, runs, _) = run("sgrt-ti2", &[], 2);
    let counter = |name: &str| json["counters"][name]["value"].as_u64().unwrap_or_else(|| panic!("{name}"));
    let cycles = json["cycles"].as_u64().unwrap();
    assert_eq!(cycles, runs.iter().map(|run| run.stats.cycles).sum::<u64>());
    assert_eq!(cycles, counter("run/cycles"));
    near(number(&json["time_ms"]), cycles as f64 / 500e3);
    let seconds = number(&json["time_ms"]) / 1e3;
    near(number(&json["fps"]), 2.0 / seconds);
    // All rays of the policy come back from the units, and the paths' work is done.
    let rays = counter("ti/dispatch/rays");
    assert_eq!((json["rays_machine"].as_u64(), counter("paths/rays")), (Some(rays), rays));
    assert_eq!(rays, json["rays_traced"].as_u64().unwrap() + json["rays_apron"].as_u64().unwrap());
    assert_eq!(counter("ti/ist/triangle_tests"), counter("paths/triangle_tests"));
    near(number(&json["mrays_per_s"]), rays as f64 / seconds / 1e6);
    let components = json["energy"].as_array().unwrap();
    let sum = |group: &str| {
        let chosen = components.iter().filter(|c| group == "all" || c["group"] == group);
        chosen.map(|c| number(&c["dynamic_mj"]) + number(&c["leakage_mj"])).sum::<f64>()
    };
    for (cost, group) in [(&json, "ti"), (&json["gpu"], "all")] {
        near(number(&cost["energy_mj"]), sum(group));
        near(number(&cost["power_w"]) * seconds * 1e3, number(&cost["energy_mj"]));
        near(number(&cost["perf_per_watt"]), number(&json["fps"]) / number(&cost["power_w"]));
        near(number(&cost["energy_per_ray_nj"]) * rays as f64, number(&cost["energy_mj"]) * 1e6);
    }
    let between = [&json, &json["ti_with_memory"], &json["gpu"]].map(|cost| number(&cost["energy_mj"]));
    assert!(between.is_sorted(), "{between:?}");
    // Frames that are alike cost alike.
    let frames = json["frames"].as_array().unwrap();
    assert_eq!(frames.len(), 2);
    for key in ["cycles", "time_ms", "rays_machine", "energy_mj"] {
        near(number(&frames[0][key]) + number(&frames[1][key]), number(&json[key]));
    }
    near(number(&frames[0]["gpu"]["power_w"]), number(&json["gpu"]["power_w"]));
}

#[test]
fn every_cycle_of_every_unit_is_in_a_class() {
    for (machine, stages) in [("sgrt-ti2", 4 * (4 * 3 + 1 + 1)), ("raycore", 6 * 2)] {
        let (json, ..) = run(machine, &[], 1);
        let units = json["units"].as_array().unwrap();
        if machine == "sgrt-ti2" {
            assert_eq!(units.len(), stages, "{machine}");
        }
        let mut sums = BTreeMap::new();
        for unit in units {
            let classes = unit["classes"].as_object().unwrap();
            let all: u64 = classes.values().map(|v| v.as_u64().unwrap()).sum();
            assert_eq!(Some(all), unit["cycles"].as_u64(), "{unit}");
            let group = match (unit["unit"].as_str().unwrap(), unit["stage"].as_str().unwrap()) {
                ("srp", _) => "srp/activity".to_owned(),
                (unit, stage) => format!("ti/{unit}/{stage}"),
            };
            for (name, value) in classes {
                *sums.entry(format!("{group}/{name}")).or_insert(0) += value.as_u64().unwrap();
            }
        }
        for (name, sum) in sums {
            assert_eq!(json["counters"][&name]["value"].as_u64(), Some(sum), "{name}");
        }
    }
}

#[test]
fn everything_is_described() {
    let (json, ..) = run("no-direct-interface", &["ti.trv_l1.size=32KiB"], 1);
    assert_eq!(json["machine"], "no-direct-interface+ti.trv_l1.size=32KiB");
    for key in figures().iter().map(|figure| figure.name) {
        assert!(json.get(key).is_some(), "{key}");
        for part in ["unit", "description"] {
            assert!(!json["descriptions"][key][part].as_str().unwrap().is_empty(), "{key}");
        }
    }
    for (name, counter) in json["counters"].as_object().unwrap() {
        assert!(counter["value"].is_u64() && !counter["unit"].as_str().unwrap().is_empty(), "{name}: {counter}");
        assert!(counter["description"].as_str().unwrap().len() > 4, "{name}: {counter}");
    }
    for group in [
        "ti/trv/inner/busy",
        "ti/trv/l1/hits",
        "ti/ist/test/busy",
        "ti/dispatch/full",
        "srp/activity/idle",
        "srp/l1/hits",
    ] {
        assert!(json["counters"][group].is_object(), "{group}");
    }
    for group in ["srp/kernel/shade/cycles", "srp/interface/rays", "srp/dma/ray_written", "srp/local/tiles", "l2/hits"]
    {
        assert!(json["counters"][group].is_object(), "{group}");
    }
    assert!(json["counters"]["traffic/ray_read"]["value"].as_u64() > Some(0), "rays travel through memory");
    let value = &json["machine_config"]["ti.trv_l1.size"];
    assert_eq!((&value["value"], &value["class"]), (&32768.into(), &"override".into()));
    assert!(json["machine_config"]["ti.clock_mhz"]["source"].is_string());
}

/// A row has the columns of the table of figures, then those of the energy's components, then those of the counters.
#[test]
fn every_column_of_a_row_is_declared() {
    let (json, ..) = run("sgrt-ti2", &[], 1);
    let (row, columns_of_row) = Row::of_json("key".into(), &json);
    let fixed = columns();
    for (column, declared) in columns_of_row.iter().zip(fixed) {
        let declared = (declared.name.as_str(), declared.unit, declared.description.as_str());
        assert_eq!((column.name.as_str(), column.unit.as_str(), column.description.as_str()), declared);
        let by_kind = column.description.contains(" rays of rays_");
        assert_eq!(role_of(&column.name), if by_kind { Role::Counter } else { Role::Figure }, "{}", column.name);
    }
    let costs = ["power_w", "energy_mj", "energy_per_ray_nj", "perf_per_watt"];
    for (part, cost) in ["ti_with_memory", "gpu"].into_iter().flat_map(|part| costs.map(|cost| (part, cost))) {
        let value = &row.figures[&format!("{part}_{cost}")];
        assert!(value.is_number() && *value == json[part][cost], "{part} {cost}");
    }
    let components = json["energy"].as_array().unwrap();
    let counters = json["counters"].as_object().unwrap();
    assert_eq!(columns_of_row.len(), fixed.len() + components.len() * COMPONENT_PARTS.len() + counters.len());
    assert!(columns_of_row[fixed.len()..].iter().all(|column| column_is_counted(&column.name)));
    for (component, part) in
        components.iter().flat_map(|component| COMPONENT_PARTS.iter().map(move |part| (component, part)))
    {
        assert!(component[part.key].is_number(), "{component}");
    }
}

fn column_is_counted(name: &str) -> bool {
    column(name).is_none() && role_of(name) == Role::Counter
}

/// Figures of several frames are the sums and means that the table says.
#[test]
fn frames_add_up_as_declared() {
    let (json, ..) = run("sgrt-ti2", &[], 3);
    let frames = json["frames"].as_array().unwrap();
    let mut checked = [0, 0];
    for figure in figures().iter().filter(|figure| figure.form == Form::Value) {
        let values: Vec<f64> = frames.iter().filter_map(|frame| frame[figure.name].as_f64()).collect();
        let sum: f64 = values.iter().sum();
        match figure.frames {
            OverFrames::Sum => near(number(&json[figure.name]), sum),
            OverFrames::Mean => near(number(&json[figure.name]), sum / 3.0),
            OverFrames::Whole => continue,
        }
        assert_eq!(values.len(), 3, "{}", figure.name);
        checked[usize::from(figure.frames == OverFrames::Mean)] += 1;
    }
    assert!(checked[0] > 10 && checked[1] == 3, "{checked:?}");
}

#[test]
fn the_page_can_be_read() {
    for machine in ["sgrt-ti2", "raycore", "hybrid-raster"] {
        let (json, page, ..) = run(machine, &[], 2);
        let rate = format!("{:.2} Mrays/s", number(&json["mrays_per_s"]));
        let rate = &rate[..rate.find('.').unwrap()];
        for part in [
            "machine ",
            "cycles",
            "frames/s",
            "Mrays/s",
            "TRV L1",
            "row hits ",
            "% of GPU",
            "shade",
            "starved",
            "PSNR",
            rate,
        ] {
            assert!(page.contains(part), "{machine}: no {part:?} in\n{page}");
        }
        for line in page.lines() {
            assert!(line.chars().count() <= 100 && !line.contains("NaN") && !line.contains("inf "), "{line:?}\n{page}");
        }
    }
}

/// Length of a counter's steps times their height, per process and name; and its events.
fn integrals(timeline: &Value) -> BTreeMap<(u64, String), f64> {
    let mut sums = BTreeMap::new();
    let mut last: BTreeMap<(u64, String), (f64, f64)> = BTreeMap::new();
    for event in timeline["traceEvents"].as_array().unwrap() {
        if event["ph"] != "C" {
            continue;
        }
        let key = (event["pid"].as_u64().unwrap(), event["name"].as_str().unwrap().to_owned());
        let args = event["args"].as_object().unwrap();
        let now = (number(&event["ts"]), number(args.values().next().unwrap()));
        if let Some(before) = last.insert(key.clone(), now) {
            assert!(now.0 > before.0, "time goes on: {event}");
            *sums.entry(key).or_insert(0.0) += (now.0 - before.0) * before.1;
        } else {
            sums.insert(key, 0.0);
        }
    }
    assert!(last.values().all(|end| end.1 == 0.0), "all counters end at 0");
    sums
}

#[test]
fn the_timeline_loses_no_busy_cycle() {
    for (machine, times) in [("sgrt-ti2", 2), ("sgrt-ti1", 1)] {
        let (json, _, runs, timeline) = run(machine, &[], times);
        let found = integrals(&timeline);
        let length = number(&json["time_ms"]) * 1e3;
        // A unit's busy time in microseconds of 100 %; each step is rounded to a hundredth of a percent.
        let check = |core: usize, name: &str, percent_microseconds: f64| {
            let measured = found[&(core as u64, name.to_owned())];
            assert!(
                (measured - percent_microseconds).abs() < 0.011 * length,
                "{name}: {measured} {percent_microseconds}"
            );
            assert!(measured > 0.0, "{name} is never busy");
        };
        for unit in json["units"].as_array().unwrap() {
            let (core, index) = (unit["core"].as_u64().unwrap() as usize, &unit["index"]);
            let busy = unit["classes"]["busy"].as_f64();
            match (unit["unit"].as_str().unwrap(), unit["stage"].as_str().unwrap()) {
                ("srp", _) => {
                    let cycles = runs.iter().map(|run| run.stats.cores[core].srp.activity.busy_cycles()).sum::<u64>();
                    check(core, "SRP", cycles as f64 / 10.0);
                }
                ("ist", _) => check(core, &format!("IST {index}"), busy.unwrap() / 5.0),
                (_, stage) => check(core, &format!("TRV {index} {stage}"), busy.unwrap() / 5.0),
            }
        }
        let bursts = runs.iter().map(|run| run.stats.memory.dram());
        let bytes: u64 = bursts.map(|dram| (dram.reads + dram.writes) * 32).sum();
        check(runs[0].stats.cores.len(), "DRAM", bytes as f64 / 25_600.0 * 100.0);
        // Frames follow one another.
        // Tracks of tiles, kernels and states stand with the cores.
        let is_frame = |event: &&Value| event["ph"] == "X" && event["pid"] == runs[0].stats.cores.len();
        let frames: Vec<_> = timeline["traceEvents"].as_array().unwrap().iter().filter(is_frame).collect();
        assert_eq!(frames.len(), times);
        let mut end = 0.0;
        for frame in frames {
            near(number(&frame["ts"]), end);
            end += number(&frame["dur"]);
        }
        assert!((end - length).abs() < 0.01, "{end} {length}");
        assert!(timeline["traceEvents"].as_array().unwrap().iter().all(|e| e["pid"].is_u64() && e["name"].is_string()));
    }
}
