use std::fs;

use serde_json::{Value, json};
use tempfile::TempDir;

use super::*;

/// The folder of a replay with one picture for each name: as long as a PNG file must be to be one here.
fn folder(stats: &Value, pictures: &[&str]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join(folder::STATS), stats.to_string()).unwrap();
    pictures.iter().for_each(|name| fs::write(folder.path().join(name), b"\x89PNG\r\n\x1a\n").unwrap());
    folder
}

fn stats() -> Value {
    json!({ "scene": "s", "policy": "p", "width": 8, "height": 4, "frames": [{ "frame": 0, "cycles": 10 }] })
}

fn page_of(stats: &Value) -> String {
    let folder = folder(stats, &["result.png"]);
    let file = folder.path().join("page.html");
    write(folder.path(), &file).unwrap();
    fs::read_to_string(file).unwrap()
}

#[test]
fn sizes_are_numbers_or_there_is_no_page() {
    assert!(page_of(&stats()).contains("<li>1 frame of 8 x 4 pixels</li>"));
    for key in ["width", "height"] {
        for odd in [json!("1\"><script>alert(1)</script>"), json!({ "x": "<b>" }), json!(-1), json!(1.5), Value::Null] {
            let mut stats = stats();
            stats[key] = odd;
            let folder = folder(&stats, &["result.png"]);
            let error = write(folder.path(), &folder.path().join("page.html")).unwrap_err();
            assert!(error.is_bad_data() && error.to_string().contains(key), "{error}");
            assert!(!folder.path().join("page.html").exists());
        }
    }
}

/// What stands below `gpu` and `ti_with_memory` in a report was left out.
#[test]
fn the_whole_gpu_has_its_figures() {
    let mut stats = stats();
    stats["gpu"] = json!({ "energy_mj": 12.5, "power_w": 0.75 });
    stats["ti_with_memory"] = json!({ "perf_per_watt": 321.0 });
    stats["frames"] = json!([{ "frame": 0, "gpu": { "energy_mj": 12.5 } }]);
    let page = page_of(&stats);
    for words in ["gpu_energy_mj", "12.5000", "gpu_power_w", "0.7500", "ti_with_memory_perf_per_watt", "321.0000"] {
        assert!(page.contains(words), "{words}");
    }
    assert!(page.contains("Energy of the GPU, mJ") && page.contains("12.500<"), "frame by frame");
}

/// They had fixed places of mJ and ms, and all read 0.000.
#[test]
fn small_frames_have_their_digits() {
    let mut stats = stats();
    let frame = |number: u64, time: f64| json!({ "frame": number, "time_ms": time, "energy_mj": 2e-9, "flip": 3e-6 });
    stats["frames"] = json!([frame(0, 0.0021), frame(1, 0.0042)]);
    (stats["time_ms"], stats["power_w"]) = (json!(0.0063), json!(1.25e-5));
    let page = page_of(&stats);
    for words in ["Time, µs</th>", ">2.100<", ">4.200<", "energy_mj", ">3.000e-6<", ">0.0063</td><td>ms<", ">1.250e-5<"]
    {
        assert!(page.contains(words), "{words}: {page}");
    }
    assert!(page.contains("Energy of the T&amp;I units, nJ") && page.contains(">0.002<"), "{page}");
    // The file keeps the unit that is stored.
    let folder = folder(&stats, &[]);
    let (_, charts) = page::page(&folder::Folder::read(folder.path()).unwrap());
    let time = charts.iter().find(|chart| chart.name == "frames-time_ms").unwrap();
    assert_eq!(time.csv, "frame,\"Time, ms\"\r\n0,0.0021\r\n1,0.0042\r\n");
}

/// A picture that equals the reference has no number, and read as one that nobody compared.
#[test]
fn identical_pictures_say_so() {
    let mut stats = stats();
    let frame = |number: u64, psnr: Value| json!({ "frame": number, "identical": psnr.is_null(), "psnr_db": psnr });
    stats["frames"] = json!([frame(0, Value::Null), frame(1, json!(40.5)), { "frame": 2, "psnr_db": null }]);
    let page = page_of(&stats);
    assert!(page.contains(">identical</td>") && page.contains(">40.50</td>") && page.contains(">–</td>"), "{page}");
    assert!(page.contains("A missing piece of a PSNR line is a frame that equals the reference."));
    assert!(page.contains("data-v=\"Infinity,40.5,\""), "{page}");
    stats["frames"] = json!([frame(0, Value::Null), frame(1, Value::Null)]);
    stats["identical"] = json!(true);
    let page = page_of(&stats);
    assert!(page.contains("<strong>PSNR, dB</strong>") && page.contains(">identical</text>"), "{page}");
    assert_eq!(page.matches(">identical</td>").count(), 5, "two frames, and three figures of all: {page}");
}

/// Two frames of which the second is an estimate.
fn estimated() -> Value {
    let mut stats = stats();
    let intervals = json!({ "interval_percent": { "cycles": 1.5 } });
    stats["frames"] = json!([{ "frame": 0, "cycles": 10 }, { "frame": 1, "cycles": 2e4 as u64, "detail": intervals }]);
    stats["cycles"] = json!(2e4 as u64 + 10);
    stats["descriptions"] = json!({ "cycles": { "unit": "cycles", "description": "d" } });
    let intervals = json!({ "cycles": 0.7, "rays_traced": null });
    stats["detail"] =
        json!({ "mode": "sampled", "fraction": 0.1, "windows": 5, "whole_frames": 1, "interval_percent": intervals });
    stats
}

#[test]
fn estimates_say_so() {
    let folder = folder(&estimated(), &[]);
    let replay = folder::Folder::read(folder.path()).unwrap();
    let (html, charts) = page::page(&replay);
    assert!(html.contains("20\u{202f}010 ±\u{202f}0.7\u{202f}%</td>"), "all frames: {html}");
    assert!(html.contains("20\u{202f}000 ±\u{202f}1.5\u{202f}%</td>") && html.contains("<td class=\"num\">10</td>"));
    assert!(
        html.contains("Estimates from 5 windows with 10.0 % of the tiles; 1 frame was simulated whole (too few tiles"),
        "{html}"
    );
    assert!(html.contains("95 % interval reaches from - to + what stands behind it; counts of work are exact.</p>"));
    assert!(html.contains("data-within=\",1.5\""), "the pointer tells them too");
    assert_eq!(charts[0].csv, "frame,Cycles,Cycles_interval_percent\r\n0,10,\r\n1,20000,1.5\r\n");
    // What is exact says nothing of it.
    let exact = page_of(&stats());
    assert!(!exact.split("<script").next().unwrap().contains('±') && !exact.contains("stimate"));
    for (mode, sentence) in
        [("counts", "No cycle was simulated: work and misses are counted"), ("all", "Nothing is estimated")]
    {
        let mut stats = stats();
        stats["detail"] = json!({ "mode": mode, "windows": 0, "whole_frames": 0 });
        assert!(page_of(&stats).contains(sentence), "{mode}");
    }
}
