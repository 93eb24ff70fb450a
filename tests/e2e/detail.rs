//! `--detail` and `--precision`: what is simulated, what is said of it, and what is refused.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::common::{capture, replay};
use crate::rayreel;

/// A trace with tiles enough for a sample.
fn trace(folder: &Path) -> PathBuf {
    let file = folder.join("many.rtrace");
    capture("cornell", "--size 512x160 --samples 2x2", &file);
    file
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is no number"))
}

#[test]
fn a_part_is_simulated_and_the_rest_is_estimated() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path());
    let [one, two] =
        [1, 2].map(|n| replay(&file, &format!("--machine sgrt-ti2 --detail 5% --threads {n}")).expect(0).out);
    assert_eq!(one, two, "the same bytes with any number of threads");
    let sampled: Value = serde_json::from_str(&one).unwrap();
    let full = replay(&file, "--machine sgrt-ti2").expect(0).result();
    assert_eq!(replay(&file, "--machine sgrt-ti2 --detail full").expect(0).result(), full, "the default");
    assert_eq!((&full["detail"]["mode"], &full["detail"]["fraction"]), (&json!("full"), &json!(1.0)));
    let detail = &sampled["detail"];
    assert_eq!(
        (&detail["mode"], &detail["asked"], &detail["precision"]),
        (&json!("sampled"), &json!(0.05), &json!(null))
    );
    assert!(number(&detail["fraction"]) < 0.5 && detail["windows"].as_u64() > Some(3), "{detail}");
    // What a picture and the work are made of does not depend on it.
    for key in ["rays_traced", "psnr_db", "flip", "rays_machine", "rays_by_kind"] {
        assert_eq!(sampled[key], full[key], "{key}");
        assert!(detail["interval_percent"][key].is_null(), "{key} is exact");
    }
    for name in ["cycles", "energy_mj", "time_ms", "perf_per_watt", "gpu_energy_mj", "dram_bytes", "dram_reads"] {
        assert!(number(&detail["interval_percent"][name]) >= 0.2, "{name}");
    }
    // Pass and windows may read too much together, which no difference between them shows.
    assert!(number(&detail["interval_percent"]["dram_bytes"]) > 4.0);
    assert_eq!(
        detail["replicates"]["cycles"].as_array().map(Vec::len),
        detail["replicates"]["energy_mj"].as_array().map(Vec::len)
    );

    // A counter that is not listed is exact, and what lookups found adds up to them.
    let counter = |of: &Value, name: &str| of["counters"][name]["value"].clone();
    for (name, known) in full["counters"].as_object().unwrap() {
        let column: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '_' }).collect();
        let is_listed = detail["interval_percent"].as_object().unwrap().contains_key(&column);
        assert!(is_listed || counter(&sampled, name) == known["value"], "{name} is neither listed nor exact");
    }
    // Refusals come in bursts, which windows do not tell of.
    for name in ["ti_ist_l1_full", "l2_full", "dram_refused_writes"] {
        assert_eq!(detail["interval_percent"].get(name), Some(&Value::Null), "{name}");
    }
    for l1 in ["ti/trv/l1", "ti/ist/l1", "srp/l1"] {
        let of = |what: &str| counter(&sampled, &format!("{l1}/{what}")).as_u64().unwrap();
        assert_eq!(of("hits") + of("misses") + of("merges"), of("lookups"), "{l1}");
    }

    let counts = replay(&file, "--machine sgrt-ti2 --detail counts").expect(0).json();
    assert!(
        counts["cycles"].is_null() && counts["power_w"].is_null() && counts["rays_machine"] == full["rays_machine"]
    );
    // Nobody knows which rows were open, what merged or how long things leaked.
    let page = rayreel!["replay", "--quiet", &file, "--detail", "counts"].expect(0).out;
    assert!(
        !page.contains("row hits") && page.lines().any(|line| line.starts_with("  L2 ") && line.contains(" -  ")),
        "{page}"
    );
    assert_eq!(counts["counters"]["ti/ist/triangle_tests"], full["counters"]["ti/ist/triangle_tests"]);

    // The page, and a comparison that knows what is an estimate.
    let page = rayreel!["replay", "--quiet", &file, "--detail", "5%"].expect(0).out;
    assert!(page.contains("estimates from") && page.contains('±'), "{page}");
    let [a, b] = ["a.json", "b.json"].map(|name| folder.path().join(name));
    fs::write(&a, full.to_string()).unwrap();
    fs::write(&b, &one).unwrap();
    let compared = rayreel!["compare", "--json", "--only", "cycles", &a, &b].json();
    let apart = (number(&sampled["cycles"]) / number(&full["cycles"]) - 1.0).abs();
    let is_within = 100.0 * apart
        <= number(&detail["interval_percent"]["cycles"]) * number(&sampled["cycles"]) / number(&full["cycles"]);
    assert_eq!(compared["results"].as_array().map(Vec::is_empty), Some(is_within), "{compared}");
}

#[test]
fn uniform_frames_are_simulated_whole_and_that_is_said() {
    // Nothing but sky: all windows do the same, so their differences say nothing of how far they are off.
    let folder = tempfile::tempdir().unwrap();
    let (model, file) = (folder.path().join("sky.obj"), folder.path().join("sky.rtrace"));
    fs::write(&model, "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    capture(model.to_str().unwrap(), "--size 256x320 --eye 0,0,5 --target 0,0,10", &file);
    for (machine, policy) in [("sgrt-ti2", "paper-ss"), ("gr6500", "multirate")] {
        let of =
            |detail: &str| replay(&file, &format!("--machine {machine} --policy {policy} {detail}")).expect(0).json();
        let full = of("--detail full");
        for asked in ["--detail 5%", "--precision 1%"] {
            let whole = of(asked);
            assert_eq!((&whole["cycles"], &whole["gpu"]), (&full["cycles"], &full["gpu"]), "{machine}, {asked}");
            assert_eq!((&whole["detail"]["windows"], &whole["detail"]["whole_frames"]), (&json!(0), &json!(1)));
            let why = if machine == "gr6500" { "machine" } else { "uniform" };
            assert_eq!(whole["detail"]["whole_because"], json!({ why: 1 }), "{machine}, {asked}");
        }
        // Where all is simulated seams alone are off.
        let all = of("--detail all");
        let off = 100.0 * (number(&full["cycles"]) / number(&all["cycles"]) - 1.0);
        let said = number(&all["detail"]["interval_percent"]["cycles"]);
        assert!(all["detail"]["windows"].as_u64() > Some(0) && off.abs() < said, "{machine}: {off} of {said}");
    }
    let page = rayreel!["replay", "--quiet", &file, "--detail", "5%"].expect(0).out;
    assert!(page.contains("1 frame was simulated whole (tiles too alike)") && !page.contains('±'), "{page}");
}

#[test]
fn machines_that_the_pass_does_not_know_are_not_sampled() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("c.rtrace");
    capture("cornell", "--size 256x320 --samples 2x2 --tile 32 --depth 0", &file);
    let of = |options: &str| replay(&file, &format!("--policy adaptive --detail {options}")).expect(0).json();
    assert!(
        of("5% --machine sgrt-ti2")["detail"]["windows"].as_u64() > Some(0),
        "the frame is large enough for a sample"
    );
    for machine in ["mimd-trax", "gr6500", "hybrid-raster"] {
        let (sampled, full) = (of(&format!("5% --machine {machine}")), of(&format!("full --machine {machine}")));
        assert_eq!(
            (&sampled["cycles"], &sampled["detail"]["whole_because"]),
            (&full["cycles"], &json!({ "machine": 1 })),
            "{machine}"
        );
        assert!(of(&format!("counts --machine {machine}"))["cycles"].is_null());
    }
    // Sixteen tiles a core are sixty-four in flight, of 320: windows would have to be as long as the frame.
    let many = of("5% --machine sgrt-ti2 --set gpu.tiles_in_flight=16");
    assert_eq!(many["detail"]["whole_because"], json!({ "few_tiles": 1 }));
}

#[test]
fn what_ends_whole_leaves_its_own_caches_to_the_next_frame() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pot.rtrace");
    capture("teapot", "--size 256x320 --depth 0 --frames 0..2 --eye 0,60,60 --target 5,2,0 --fov 12", &file);
    let of =
        |detail: &str| replay(&file, &format!("--machine sgrt-ti2 --policy full --warm {detail}")).expect(0).json();
    assert!(of("--detail 5%")["detail"]["windows"].as_u64() > Some(0), "it is large enough for a sample");
    // More than there are windows for.
    let (whole, full) = (of("--precision 0.6%"), of("--detail full"));
    assert_eq!(whole["detail"]["whole_because"], json!({ "precision": 2 }));
    assert_eq!((&whole["frames"][1]["cycles"], &whole["counters"]), (&full["frames"][1]["cycles"], &full["counters"]));
}

#[test]
fn small_frames_are_simulated_whole_and_that_is_said() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("few.rtrace");
    capture("cornell", "--size 40x24", &file);
    let full = replay(&file, "--machine sgrt-ti2").expect(0).json();
    for asked in ["--detail 10%", "--detail all", "--precision 1%"] {
        let json = replay(&file, &format!("--machine sgrt-ti2 {asked}")).expect(0).json();
        let detail = &json["detail"];
        assert_eq!((&json["cycles"], &json["gpu"]), (&full["cycles"], &full["gpu"]), "{asked}");
        assert_eq!(
            (&detail["windows"], &detail["whole_frames"], &detail["fraction"]),
            (&json!(0), &json!(1), &json!(1.0))
        );
        assert_eq!(detail["interval_percent"], json!({}), "{asked}");
    }
    let page = rayreel!["replay", "--quiet", &file, "--precision", "1%"].expect(0).out;
    assert!(page.contains("too few tiles") && !page.contains('±'), "{page}");
}

#[test]
fn what_cannot_be_is_one_error() {
    let folder = tempfile::tempdir().unwrap();
    let file = trace(folder.path());
    let refused = |options: &str, words: &[&str]| drop(replay(&file, options).expect(2).says(words));
    refused("--detail half", &["`half` is not a detail", "0.05 or 5%"]);
    refused("--precision 0", &["is not from 0.000001"]);
    refused("--machine sgrt-ti2 --detail 5% --precision 1%", &["--precision", "cannot be used with"]);
    refused("--detail 5%", &["--machine none has none"]);
    let timeline = format!("--machine sgrt-ti2 --detail 5% --timeline {}", folder.path().join("t.json").display());
    refused(&timeline, &["--timeline shows every cycle", "--detail full"]);
    rayreel!["paper", "--detail", "counts", "--cache", folder.path(), "--out", folder.path()]
        .expect(2)
        .says(&["gives no time"]);
}

#[test]
fn a_sweep_has_points_of_several_details() {
    let folder = tempfile::tempdir().unwrap();
    trace(folder.path());
    let plan = folder.path().join("plan.toml");
    let text = "traces = [\"many.rtrace\"]\npolicies = [\"full\", \"adaptive\"]\n";
    fs::write(&plan, text).unwrap();
    let sweep = folder.path().join("x.sweep");
    rayreel!["sweep", "--quiet", &plan, "--detail", "5%", "-o", &sweep].expect(0);
    let csv = fs::read_to_string(sweep.join("results.csv")).unwrap();
    let mut lines = csv.lines();
    let heads: Vec<&str> = lines.next().unwrap().split(',').collect();
    for column in
        ["detail", "detail_fraction", "cycles_interval_percent", "gpu_perf_per_watt_interval_percent", "replicates"]
    {
        assert!(heads.contains(&column), "{column}");
    }
    assert_eq!(lines.filter(|line| line.contains(",0.05,")).count(), 2);
    // A plan is what it is.
    rayreel!["sweep", "run", "--quiet", &sweep, "--detail", "10%"].expect(2).says(&["was made for 0.05"]);
    rayreel!["sweep", "run", "--quiet", &sweep, "--detail", "0.05"].expect(0);
    let page = folder.path().join("page.html");
    rayreel!["report", &sweep, "-o", &page].expect(0);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("2 of 2 points are estimates") && page.contains('±'));
    // Several, each a point; those that are there already are taken.
    fs::write(&plan, format!("detail = [\"full\", 0.05]\n{text}")).unwrap();
    let both = folder.path().join("both.sweep");
    rayreel!["sweep", "--quiet", &plan, "-o", &both, "--reuse", &sweep]
        .expect(0)
        .says(&["4 points, 0 skipped, 2 reused, 2 computed"]);
}
