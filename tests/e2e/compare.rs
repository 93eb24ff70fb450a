//! `rayreel compare`: a gate that is shut when anything changed.

use std::fs;

use crate::common::small_sweep::{POINTS, small_sweep};
use crate::common::{replay, repository};
use crate::rayreel;

#[test]
fn sweeps_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let a = small_sweep(dir, "a", "sgrt-ti2", "");
    let told = rayreel!["compare", &a, &a.join("results.parquet")].expect(0).out;
    assert!(told.starts_with(&format!("equal: {POINTS} points, ")), "{told}");
    // Another machine: no point is there any more, unless machines are not what points are known by.
    let b = small_sweep(dir, "b", "sgrt-ti1", "");
    let json = rayreel!["compare", "--json", &a, &b].expect(1).json();
    assert_eq!((json["counts"]["vanished"].as_u64(), json["counts"]["appeared"].as_u64()), (Some(8), Some(8)));
    let json = rayreel!["compare", "--json", &a, &b, "--across", "machine"].expect(1).json();
    assert_eq!((json["matched"].as_u64(), json["counts"]["vanished"].as_u64()), (Some(8), Some(0)));
    let changed = |name: &str| json["results"].as_array().unwrap().iter().any(|change| change["name"] == name);
    assert!(json["equal"] == false && json["results"].as_array().unwrap().len() == 20, "no more than --top");
    let json = rayreel!["compare", "--json", "--top", "0", &a, &b, "--across", "machine"].expect(1).json();
    let change = json["results"].as_array().unwrap().iter().find(|change| change["name"] == "cycles").unwrap();
    assert_eq!((change["changed"].as_u64(), change["unit"].as_str()), (Some(8), Some("cycles")));
    assert!(!changed("psnr_db"), "a machine changes no picture");
    assert_eq!(json["configuration"][0]["key"], "machine");
    // A constant of the machine in all points: the points are the same, their configuration and results are not.
    let c = small_sweep(dir, "c", "sgrt-ti2", "set = [\"dram.rl=40\"]");
    let told = rayreel!["compare", &a, &c].expect(1).out;
    assert!(told.contains("dram.rl  8 points  34 -> 40") && told.contains("  time_ms "), "{told}");
    assert!(told.contains("matched: 8 points, of 8 in A and 8 in B") && !told.contains("vanished"), "{told}");
    rayreel!["compare", &a, &c, "--ignore", "dram.rl"].expect(1);
    rayreel!["compare", &a, &c, "--only", "psnr_db"].expect(0);
}

#[test]
fn two_runs_are_compared() {
    let folder = tempfile::tempdir().unwrap();
    let [a, b, c] = ["a.json", "b.json", "c.json"].map(|name| folder.path().join(name));
    let trace = repository("traces/v1_0_cornell.rtrace");
    fs::write(&a, replay(&trace, "--machine sgrt-ti2").expect(0).out).unwrap();
    fs::write(&b, replay(&trace, "--machine sgrt-ti2").expect(0).out).unwrap();
    fs::write(&c, replay(&trace, "--machine sgrt-ti1 --policy full").expect(0).out).unwrap();
    let told = rayreel!["compare", &a, &b].expect(0).out;
    assert!(told.starts_with("equal: 1 point, "), "{told}");
    // Other programs write 15.0 as 15.
    let rewritten = folder.path().join("rewritten.json");
    fs::write(&rewritten, fs::read_to_string(&a).unwrap().replace(".0,", ",").replace(".0\n", "\n")).unwrap();
    assert_ne!(fs::read(&a).unwrap(), fs::read(&rewritten).unwrap());
    rayreel!["compare", &a, &rewritten].expect(0).prints(&["equal: 1 point, "]);
    let told = rayreel!["compare", &a, &c, "--top", "0"].expect(1).out;
    for words in ["machine", "sgrt-ti2 -> sgrt-ti1", "adaptive -> full", "rays_traced", "gpu_energy_mj"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    // The folder of a replay is its run, and the run in a folder is a page of it. What runs are of is said whatever is asked for.
    let (run, other) = (folder.path().join("run"), repository("traces/v1_0_teapot.rtrace"));
    rayreel!["replay", "--quiet", &trace, "--machine", "sgrt-ti2", "-o", &run].expect(0);
    rayreel!["compare", &run, &a].expect(0).prints(&["equal: 1 point, "]);
    rayreel!["report", &run.join("stats.json")].expect(0).prints(&["report.html: "]);
    let refused = rayreel!["report", &run, "--animate", "result", "-o", &run.join("x.gif")].expect(2);
    refused.says(&["x.gif: an animation is an animated PNG"]);
    assert!(run.join("report.html").exists() && !run.join("x.gif").exists());
    fs::write(&c, replay(&other, "--machine sgrt-ti2 --frames 30").expect(0).out).unwrap();
    let told = rayreel!["compare", &a, &c, "--only", "cycles", "--tolerance", "1%"].expect(1).out;
    let first = "A and B differ in: trace v1_0_cornell.rtrace -> v1_0_teapot.rtrace, first_frame 0 -> 30\n";
    assert!(told.starts_with(first) && told.contains("figures: 1 of 1 changed within 1.00 %"), "{told}");
}

#[test]
fn errors_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path();
    let [bad, json, run] = ["bad.parquet", "other.json", "run.json"].map(|name| dir.join(name));
    fs::write(&bad, "PAR1 no PAR1").unwrap();
    fs::write(&json, "{\"rows\": 3}").unwrap();
    fs::write(&run, replay(&repository("traces/v1_0_cornell.rtrace"), "").expect(0).out).unwrap();
    rayreel!["compare", &bad, &bad].expect(65).says(&["bad.parquet", "not a Parquet file"]);
    rayreel!["compare", &json, &json].expect(65).says(&["other.json", "rayreel replay"]);
    rayreel!["compare", &dir.join("none"), &run].expect(2).says(&["none"]);
    rayreel!["compare", dir, &run].expect(2).says(&["not the folder of a sweep"]);
    rayreel!["compare", &run, &run, "--tolerance", "-1"].expect(2).says(&["0 or more"]);
    rayreel!["compare", &run, &run, "--only", "***"].expect(2).says(&["***"]);
    rayreel!["compare", &run, &run, "--only", "rays_trace"].expect(2).says(&["--only \"rays_trace\"", "rays_traced"]);
    rayreel!["compare", &run, &run, "--ignore", "cycels*"].expect(2).says(&["--ignore \"cycels*\" matches no column"]);
    rayreel!["compare", &run, &run, "--across", "polcy"]
        .expect(2)
        .says(&["--across \"polcy\"", "did you mean policy?"]);
    rayreel!["compare", &run, &run, "--only", "rays_traced"].expect(0);
    fs::write(dir.join("plan.json"), "{}").unwrap();
    rayreel!["compare", dir, &run].expect(2).says(&["no results.parquet", "rayreel sweep merge"]);
    rayreel!["report", dir].expect(2).says(&["no results.parquet", "rayreel sweep merge"]);
    rayreel!["report", &bad].expect(65).says(&["bad.parquet"]);
    rayreel!["report", &run].expect(2).says(&["run.json: it is JSON", "give the folder"]);
}
