//! What is said of figures that were estimated, from made-up estimates: reports, rows, comparisons.

use std::path::PathBuf;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::system::NoProbe;
use rayreel_replay::counts::FrameStats;
use rayreel_replay::detail::{Estimate, FLOOR, Replicate, WholeFrames, WhyWhole};
use rayreel_replay::sequence::{FrameLoop, Simulator};
use rayreel_replay::simulate::MachineRun;
use rayreel_replay::{Detail, NamedPolicy, Options, PathSource, Stop};
use rayreel_study::compare::{Comparison, Options as CompareOptions, run as one_run};
use rayreel_study::figures::is_key;
use rayreel_study::point::estimates::{RowEstimates, Sampled};
use rayreel_study::point::row::{Row, role_of};
use rayreel_study::report::{Origin, Report};
use rayreel_study::table::Role;
use serde_json::{Value, json};

/// A frame that was simulated, and what is needed to report it.
struct Simulated {
    trace: Trace,
    machine: NamedMachine,
    policy: NamedPolicy,
    stats: FrameStats,
    run: MachineRun,
}

fn simulated() -> Simulated {
    simulated_on("sgrt-ti2")
}

fn simulated_on(machine: &str) -> Simulated {
    let path = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../traces/v1_0_cornell.rtrace");
    let trace = Trace::open(&path, Limits::default()).unwrap();
    let machine = NamedMachine::load(machine, &[]).unwrap();
    let policy = NamedPolicy::load("adaptive", &[]).unwrap();
    let tree = trace.topology();
    let simulator = Some(Simulator { machine: &machine, tree: &tree, detail: Detail::Full });
    let mut frames = FrameLoop::new(&trace, &policy.policy, Options::default(), &Stop::never()).unwrap();
    let frame = frames.step(trace.meta().first_frame, simulator, &mut NoProbe).unwrap();
    Simulated { machine, policy, stats: frame.replay.stats, run: frame.run.unwrap(), trace }
}

impl Simulated {
    /// The run as if it had been estimated, with replicates whose cycles and lines read from DRAM are off by these parts.
    fn estimated(&self, detail: &str, off: &[(f64, f64)]) -> MachineRun {
        let replicate = |(cycles, lines): &(f64, f64)| {
            let mut stats = self.run.stats.clone();
            stats.cycles = (stats.cycles as f64 * (1.0 + cycles)) as u64;
            stats.memory.channels[0].reads = (stats.memory.channels[0].reads as f64 * (1.0 + lines)) as u64;
            stats.memory.traffic.read[0] = (stats.memory.traffic.read[0] as f64 * (1.0 + lines)) as u64;
            let energy = EnergyReport::new(&self.machine.config, &stats);
            Replicate { stats, energy }
        };
        let estimate = Estimate {
            detail: detail.parse().unwrap(),
            tiles: 4000,
            detailed_tiles: 400,
            windows: 5,
            frames: 1,
            whole_frames: WholeFrames::default(),
            freedom: off.len().saturating_sub(1) as u32,
            replicates: off.iter().map(replicate).collect(),
        };
        MachineRun { estimate: Some(estimate), ..self.run.clone() }
    }

    fn report(&self, runs: &[MachineRun]) -> Report {
        let frames = vec![self.stats.clone(); runs.len()];
        let fingerprint = Some("of cornell".into());
        let origin = Origin { trace: "cornell".into(), trace_fingerprint: fingerprint, ..Origin::default() };
        Report::new(&origin, &self.policy, self.trace.meta(), &frames).with_machine(&self.machine, runs)
    }

    fn json(&self, run: &MachineRun) -> Value {
        serde_json::from_str(&self.report(std::slice::from_ref(run)).to_json().unwrap()).unwrap()
    }
}

const OFF: [(f64, f64); 5] = [(0.01, 0.02), (-0.01, -0.02), (0.005, 0.0), (-0.005, 0.0), (0.0, 0.0)];

fn near(a: f64, b: f64) {
    assert!((a - b).abs() <= 2e-3 * a.abs().max(b.abs()), "{a} {b}");
}

#[test]
fn every_figure_that_differs_between_replicates_has_an_interval() {
    let frame = simulated();
    let json = frame.json(&frame.estimated("0.1", &OFF));
    let detail = &json["detail"];
    for (key, value) in [("mode", "\"sampled\""), ("asked", "0.1"), ("precision", "null"), ("fraction", "0.1")] {
        assert_eq!(detail[key].to_string(), value, "{key}");
    }
    assert_eq!((detail["windows"].as_u64(), detail["whole_frames"].as_u64()), (Some(5), Some(0)));
    let percent = |name: &str| detail["interval_percent"][name].as_f64();
    // Deviations from their mean, the jackknife's factor of four fifths, and Student's t with four degrees of freedom.
    let squares = 2.0 * (0.01f64.powi(2) + 0.005f64.powi(2));
    let cycles = 100.0 * (2.776 * (squares * 0.8).sqrt()).hypot(FLOOR);
    for name in ["cycles", "time_ms", "fps", "mrays_per_s", "run_cycles"] {
        near(percent(name).unwrap(), cycles);
    }
    for name in ["energy_mj", "gpu_power_w", "gpu_perf_per_watt", "energy_dram_dynamic_mj", "dram_reads", "dram_bytes"]
    {
        assert!(percent(name) > Some(100.0 * FLOOR), "{name}: {:?}", percent(name));
    }
    // What is counted in any case is exact, and so is the picture.
    for name in ["rays_machine", "rays_traced", "paths_rays", "ti_dispatch_rays", "psnr_db", "energy_trv_dynamic_mj"] {
        assert_eq!(detail["interval_percent"].get(name), None, "{name}");
    }
    let (_, columns) = Row::of_json(String::new(), &json);
    for name in detail["interval_percent"].as_object().unwrap().keys().filter(|name| *name != "dram_bytes") {
        assert!(columns.iter().any(|column| column.name == *name), "{name} is no column");
    }
    // The sum of frames has the intervals of the sum; each frame has its own, of figures.
    let two: Value = serde_json::from_str(
        &frame.report(&[frame.estimated("0.1", &OFF), frame.estimated("0.1", &OFF)]).to_json().unwrap(),
    )
    .unwrap();
    near(two["detail"]["interval_percent"]["cycles"].as_f64().unwrap(), cycles);
    near(two["frames"][1]["detail"]["interval_percent"]["cycles"].as_f64().unwrap(), cycles);
    assert!(two["frames"][1]["detail"]["interval_percent"]["dram_reads"].is_null());
}

#[test]
fn the_page_says_what_is_estimated() {
    let frame = simulated();
    let page = |run: MachineRun| frame.report(&[run]).to_string();
    let told = page(frame.estimated("0.1", &OFF));
    assert!(told.contains("estimates from 5 windows with 10.0 % of the tiles"), "{told}");
    let json = frame.json(&frame.estimated("0.1", &OFF));
    let cycles = format!(" ±{:.1}%", json["detail"]["interval_percent"]["cycles"].as_f64().unwrap());
    assert!(told.lines().any(|line| line.contains("cycles ") && line.contains(&cycles)), "{told}");
    assert_eq!(told.lines().find(|line| line.contains("  rays  ")).map(|line| line.matches('±').count()), Some(1));
    let full = page(frame.run.clone());
    assert!(!full.contains('±') && !full.contains("estimate"), "{full}");
    // It was simulated whole, and why is said.
    let mut whole = frame.estimated("0.1", &[]);
    whole
        .estimate
        .as_mut()
        .map(|estimate| (estimate.windows, estimate.whole_frames) = (0, WholeFrames::one(WhyWhole::OneTile)))
        .unwrap();
    let told = page(whole.clone());
    assert!(
        told.contains("nothing is estimated; 1 frame was simulated whole (one tile is a large part of a frame)")
            && !told.contains('±'),
        "{told}"
    );
    assert_eq!(frame.json(&whole)["detail"]["whole_because"], json!({ "one_tile": 1 }));
    assert!(frame.json(&whole)["detail"]["interval_percent"].as_object().unwrap().is_empty());
}

#[test]
fn without_replicates_everything_that_takes_time_has_the_least_interval() {
    let frame = simulated();
    let json = frame.json(&frame.estimated("all", &[]));
    let percent = |name: &str| json["detail"]["interval_percent"][name].as_f64();
    assert_eq!((percent("cycles"), percent("gpu_energy_mj")), (Some(100.0 * FLOOR), Some(100.0 * FLOOR)));
    for name in ["paths_rays", "paths_node_visits", "rays_machine"] {
        assert_eq!(json["detail"]["interval_percent"].get(name), None, "{name} is exact");
    }
    assert!(json["detail"]["replicates"].is_null());
}

#[test]
fn counts_have_no_time() {
    let frame = simulated();
    let mut run = frame.estimated("counts", &[]);
    run.stats.cycles = 0;
    run.energy = EnergyReport::new(&frame.machine.config, &run.stats);
    run.estimate.as_mut().map(|estimate| (estimate.windows, estimate.detailed_tiles) = (0, 0)).unwrap();
    let json = frame.json(&run);
    for key in ["cycles", "time_ms", "fps", "mrays_per_s", "power_w", "perf_per_watt", "units"] {
        assert!(json[key].is_null(), "{key}: {}", json[key]);
    }
    assert!(json["energy_mj"].as_f64() > Some(0.0) && json["gpu"]["perf_per_watt"].is_null());
    assert_eq!(
        json["gpu"]["energy_mj"].as_f64().map(|mj| mj < frame.json(&frame.run)["gpu"]["energy_mj"].as_f64().unwrap()),
        Some(true)
    );
    assert!(json["energy"].as_array().unwrap().iter().all(|part| part["leakage_mj"].is_null()));
    assert!(json["counters"]["ti/trv/inner/busy"]["value"].is_null());
    assert!(json["counters"]["ti/trv/l1/misses"]["value"].as_u64() > Some(0));
    assert_eq!((&json["detail"]["mode"], &json["detail"]["fraction"]), (&"counts".into(), &0.0.into()));
    let page = frame.report(&[run]).to_string();
    assert!(page.contains("no cycle was simulated") && !page.contains("T&I units, %"), "{page}");
}

/// Instructions take time to count: what they cost is not known then, nor is what contains it.
#[test]
fn counts_of_processors_know_no_energy_of_instructions() {
    let frame = simulated_on("mimd-trax");
    let run = frame.estimated("counts", &[]);
    let (json, full) = (frame.json(&run), frame.json(&frame.run));
    let dynamic = |json: &Value, name: &str| {
        let parts = json["energy"].as_array().unwrap();
        parts.iter().find(|part| part["name"] == name).unwrap()["dynamic_mj"].as_f64()
    };
    for name in ["processors", "data_l1", "code_l1"] {
        assert_eq!((dynamic(&json, name), dynamic(&full, name).is_some()), (None, true), "{name}");
    }
    assert!(dynamic(&json, "ray_buffers") > Some(0.0) && dynamic(&json, "dram") > Some(0.0));
    for key in ["energy_mj", "energy_per_ray_nj"] {
        assert!(json["gpu"][key].is_null() && full["gpu"][key].as_f64() > Some(0.0), "{key}: {}", json["gpu"]);
    }
    let page = frame.report(&[run]).to_string();
    let line = |start: &str| page.lines().find(|line| line.trim_start().starts_with(start)).unwrap().to_owned();
    assert!(line("processors").split_whitespace().nth(1) == Some("-"), "{page}");
    assert!(line("energy a ray").ends_with('-') && page.contains("is not known"), "{page}");
}

#[test]
fn a_row_of_every_cycle_has_no_new_columns_and_one_of_estimates_has() {
    let frame = simulated();
    let full = frame.json(&frame.run);
    assert_eq!(full["detail"]["mode"], "full");
    assert_eq!((full["detail"]["fraction"].as_f64(), full["detail"]["whole_frames"].as_u64()), (Some(1.0), Some(1)));
    let (row, _) = Row::of_json(String::new(), &full);
    assert!(row.figures.keys().all(|name| !name.contains("interval") && !name.starts_with("detail")));
    let (estimated, columns) = Row::of_json(String::new(), &frame.json(&frame.estimated("0.1", &OFF)));
    let added: Vec<&str> =
        columns.iter().map(|c| c.name.as_str()).filter(|name| !row.figures.contains_key(*name)).collect();
    assert!(
        ["detail_fraction", "detail_windows", "cycles_interval_percent", "gpu_perf_per_watt_interval_percent"]
            .iter()
            .all(|name| added.contains(name))
    );
    // None of them is a result: no comparison and no chart takes one for a figure.
    assert!(
        added.iter().all(|name| matches!(role_of(name), Role::Status | Role::Config) && !is_key(name)),
        "{added:?}"
    );
    // What the row keeps is enough for ratios.
    let known = RowEstimates::of_row(&estimated.figures, Sampled::new("cornell", (0, 1), "0.1", "{}"));
    near(known.interval("cycles"), 0.01 * estimated.figures["cycles_interval_percent"].as_f64().unwrap());
    assert_eq!(known.interval_of_ratio(&known, "gpu_perf_per_watt"), FLOOR);
    assert!(known.interval("gpu_perf_per_watt") > FLOOR);
}

#[test]
fn a_change_within_the_intervals_is_none() {
    let frame = simulated();
    let table = |run: &MachineRun| {
        let json = frame.report(std::slice::from_ref(run)).to_json().unwrap();
        one_run::decode(json.as_bytes(), "a.json".as_ref()).unwrap()
    };
    let compare = |a: &MachineRun, b: &MachineRun| {
        let options = CompareOptions {
            across: one_run::ACROSS.iter().map(|name| (*name).to_owned()).collect(),
            ..Default::default()
        };
        Comparison::new(&table(a), &table(b), &options).unwrap()
    };
    let slower = |run: &MachineRun, part: f64| {
        let mut run = run.clone();
        let times = |cycles: &mut u64| *cycles = (*cycles as f64 * (1.0 + part)) as u64;
        times(&mut run.stats.cycles);
        run.estimate.iter_mut().flat_map(|e| &mut e.replicates).for_each(|r| times(&mut r.stats.cycles));
        run
    };
    let exact = &frame.run;
    let estimate = frame.estimated("0.1", &OFF);
    // Against every cycle an estimate is as uncertain as it is.
    let found = compare(exact, &slower(&estimate, 0.02));
    assert!(found.results.is_empty() && found.within > 2, "{:?}", found.results);
    assert_eq!(found.configuration.iter().map(|c| c.key.as_str()).collect::<Vec<_>>(), ["detail"]);
    let found = compare(exact, &slower(&estimate, 0.1));
    assert!(found.results.iter().any(|change| change.name == "cycles" && change.largest.interval.is_some()));
    // Two estimates of the same windows share what they are off by: two percent are seen.
    let found = compare(&estimate, &slower(&estimate, 0.02));
    let cycles = found.results.iter().find(|change| change.name == "cycles").expect("a change of cycles");
    assert!(cycles.largest.interval < Some(0.01), "{:?}", cycles.largest);
    assert!(!compare(&estimate, &estimate).changed() && !compare(exact, exact).changed());
}
