//! `rayreel export`: the command, its files and its errors. That rows are right is tested in `columns/tests`.

use std::ffi::OsString;
use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::rays::RayEnd;
use rayreel_formats::tile::ShadowState;
use rayreel_formats::trace::Trace;
use serde_json::Value;

use crate::common::{Ran, capture, repository, run};
use crate::rayreel;

/// Exports to a file; `options` are split at blanks.
fn export(trace: &Path, options: &str, file: &Path) -> Ran {
    let mut args: Vec<OsString> = vec!["export".into(), "--quiet".into(), trace.into(), "-o".into(), file.into()];
    args.extend(options.split_whitespace().map(OsString::from));
    run(&args)
}

/// The rows that an export says it wrote.
fn rows(ran: &Ran) -> u64 {
    ran.out.split_whitespace().nth(1).and_then(|word| word.parse().ok()).unwrap_or_else(|| panic!("{ran:?}"))
}

/// What a pipe gets, line by line.
fn piped(trace: &Path, options: &str) -> Vec<Value> {
    let ran = export(trace, &format!("{options} --format jsonl"), Path::new("-")).expect(0);
    ran.out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

/// On a third trace, of glass and several frames; `columns/tests` compares every column of the two in the repository.
#[test]
fn rows_are_the_rays_that_a_program_gets() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("chess.rtrace");
    capture("chess", "--size 48x32 --samples 1x1 --frames 0..3", &file);
    let columns =
        "frame,tile,index,class,kind,outcome,t,origin_x,origin_y,origin_z,direction_x,direction_y,direction_z";
    let rows = piped(&file, &format!("--what rays --columns {columns}"));
    let trace = Trace::open(&file, Limits::default()).unwrap();
    let tiles =
        trace.meta().frame_numbers().flat_map(|frame| (0..trace.meta().tile_count()).map(move |tile| (frame, tile)));
    let mut rays = tiles.flat_map(|(frame, tile)| {
        let mut all = trace.rays(frame, tile).unwrap();
        std::iter::from_fn(move || all.next().map(|ray| (frame, tile, ray)))
    });
    for row in &rows {
        let (frame, tile, recorded) = rays.next().expect("as many rays as rows");
        let is = |name: &str| row[name].as_u64().unwrap();
        assert_eq!((is("frame"), is("tile"), is("index")), (frame.into(), tile.into(), recorded.index.into()));
        assert_eq!((is("class"), row["kind"].as_str().unwrap()), (recorded.class.0.into(), recorded.kind().name()));
        let (outcome, t) = match recorded.end {
            RayEnd::Sky => ("miss", None),
            RayEnd::Hit(hit) => ("hit", Some(hit.t)),
            RayEnd::Light { state: ShadowState::Lit, .. } => ("lit", None),
            RayEnd::Light { state: ShadowState::Blocked, .. } => ("blocked", None),
            RayEnd::Light { .. } => ("tinted", None),
        };
        assert_eq!(row["outcome"], outcome);
        let float = |name: &str| row[name].as_f64().unwrap() as f32;
        if let Some(t) = t {
            assert_eq!(float("t"), t, "every bit of it");
        }
        let [origin, direction] =
            ["origin", "direction"].map(|what| ["x", "y", "z"].map(|axis| float(&format!("{what}_{axis}"))));
        assert_eq!((origin, direction), (recorded.ray.origin.to_array(), recorded.ray.direction.to_array()));
    }
    assert!(rays.next().is_none() && rows.len() > 5000, "{} rows", rows.len());
}

#[test]
fn tables_count_what_the_trace_and_the_machine_count() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (folder.path().join("chess.rtrace"), folder.path().join("t.npy"));
    capture("chess", "--size 48x32 --samples 2x2 --frames 0..2", &trace);
    let info = rayreel!["info", "--json", &trace].expect(0).json();
    let count = |options: &str| rows(&export(&trace, options, &file).expect(0));
    assert_eq!(count("--what rays"), info["rays"].as_u64().unwrap());
    assert_eq!(count("--what nodes"), info["bvh_nodes"].as_u64().unwrap());
    assert_eq!(count("--what triangles"), info["triangles"].as_u64().unwrap());
    assert_eq!(count("--what samples"), 2 * 96 * 64);
    assert_eq!(count("--what rays --frames 0") + count("--what rays --frames 1"), count("--what rays"));
    assert_eq!(count("--what hits --tiles 0..3") + count("--what hits --tiles 3..6"), count("--what hits"));
    // A policy and a machine, against the report of a replay.
    let replay = rayreel!["replay", "--quiet", "--json", "--policy", "multirate", &trace].expect(0).json();
    let counter =
        |name: &str| replay["counters"][name]["value"].as_u64().unwrap_or_else(|| panic!("no counter {name}"));
    let lookups = counter("ti/trv/node_visits") + counter("ti/ist/triangle_tests");
    assert_eq!(count("--what lookups --policy multirate"), lookups);
    let misses = counter("ti/trv/l1/misses") + counter("ti/ist/l1/misses") + counter("srp/l1/misses");
    let requests = piped(&trace, "--what requests --policy multirate --columns route");
    assert_eq!(requests.iter().filter(|row| row["route"] == "cached").count() as u64, misses);
    let visits = |row: &&Value| row["counter"] == "node_visits";
    let intervals = piped(&trace, "--what counters --policy multirate --interval 2000");
    let sum: u64 = intervals.iter().filter(visits).map(|row| row["change"].as_u64().unwrap()).sum();
    assert_eq!(sum, counter("ti/trv/node_visits"));
    // States of samples, against the same report.
    let samples = piped(&trace, "--what samples --policy multirate --columns state");
    let interpolated = samples.iter().filter(|row| row["state"] == "interpolated").count() as u64;
    let traced = samples.len() as u64 - interpolated;
    let said = ["samples_traced", "samples_interpolated"].map(|name| replay[name].as_u64().unwrap());
    assert_eq!([traced, interpolated], said);
}

/// Parquet has a place for what made a table: it says as much as stats.json does.
#[test]
fn a_parquet_file_says_what_made_it() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (repository("traces/v1_0_cornell.rtrace"), folder.path().join("T.PARQUET"));
    let said = |options: &str| {
        let ran = export(&trace, options, &file).expect(0);
        // The metadata stand behind all pages, as they are.
        let bytes = std::fs::read(&file).unwrap();
        let end = String::from_utf8_lossy(&bytes[bytes.len().saturating_sub(20_000)..]).into_owned();
        let from = end.rfind(r#"{"table":"#).unwrap();
        let mut json = serde_json::Deserializer::from_str(&end[from..]).into_iter::<Value>();
        (ran.out, json.next().unwrap().unwrap())
    };
    let (out, json) = said("--what tiles --policy multirate --set ti.trv=2 --frames 0");
    let replay = rayreel!["replay", "--quiet", "--json", "--machine", "none", &trace].expect(0).json();
    let origin = &json["origin"];
    assert_eq!(json["table"], "tiles");
    assert_eq!(
        origin["command"],
        "rayreel export v1_0_cornell.rtrace --what tiles --frames 0..1 --policy multirate --set ti.trv=2"
    );
    for key in ["program", "model_version", "scene", "trace_fingerprint"] {
        assert!(origin[key] == replay[key] && !origin[key].is_null(), "{key}: {origin}");
    }
    assert_eq!((origin["policy"].as_str(), origin["machine"].as_str()), (Some("multirate"), Some("sgrt-ti2+ti.trv=2")));
    assert!(out.contains("of table tiles under multirate on sgrt-ti2+ti.trv=2, "), "{out}");
    let (_, rays) = said("--what rays");
    assert!(rays["origin"]["policy"].is_null() && rays["origin"]["model_version"].is_null());
}

/// A trace of paths alone is enough for what follows from paths.
#[test]
fn tables_of_paths_need_no_other_column() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let whole = repository("traces/v1_0_cornell.rtrace");
    rayreel!["trim", "--quiet", "--columns", "paths", &whole, "-o", &at("paths")].expect(0);
    for what in ["steps", "addresses", "samples --columns x,y,node_visits,triangle_tests,pops,rays"] {
        let table = |trace: &Path, name: &str| {
            export(trace, &format!("--what {what} --format csv"), &at(name)).expect(0);
            std::fs::read(at(name)).unwrap()
        };
        assert!(table(&at("paths"), "a.csv") == table(&whole, "b.csv"), "{what}");
    }
    export(&at("paths"), "--what samples", &at("c.csv")).expect(3).says(&["holds no hits"]);
}

#[test]
fn what_cannot_be_exported_is_said_and_leaves_no_file() {
    let (trace, folder) = (repository("traces/v1_0_cornell.rtrace"), tempfile::tempdir().unwrap());
    let refused = |options: &str, name: &str, words: &[&str]| {
        export(&trace, options, &folder.path().join(name)).expect(2).says(words);
    };
    refused("--what colours", "a.npy", &["no such table", "rays, hits"]);
    refused("--what rays --format xml", "a.npy", &["no such format", "parquet, npy"]);
    refused("--what rays", "a.txt", &["says no format", ".parquet"]);
    refused("--what rays --frames 7", "a.npy", &["frame 7 is not in the trace, which holds frames 0 to 0"]);
    refused("--what rays --tiles 900", "a.npy", &["tile 900 is not in the trace"]);
    refused("--what rays --tiles 5..2", "a.npy", &["give tiles as numbers and ranges"]);
    refused("--what rays --columns x,hue", "a.npy", &["no column \"hue\"", "frame, tile, x, y"]);
    refused("--what rays --policy full", "a.npy", &["whatever a policy makes of it"]);
    refused("--what steps --machine sgrt-ti2", "a.npy", &["the same for every machine"]);
    refused("--what rays --set block=4", "a.npy", &["--set block=4 is for a policy"]);
    refused("--what rays --set ti.trv=4", "a.npy", &["--set ti.trv=4 is for a machine"]);
    refused("--what nodes --frames 0", "a.npy", &["the same for all frames; leave --frames out"]);
    refused("--what lookups --tiles 0", "a.npy", &["takes no --tiles: a machine works on whole frames"]);
    refused("--what lookups --machine mimd-trax", "a.npy", &["take requests"]);
    refused("--what rays --interval 5", "a.npy", &["--interval is for table counters"]);
    refused("--what counters --interval 0", "a.npy", &["--interval <CYCLES>", "a whole number of cycles of 1 or more"]);
    refused(
        "--what counters --interval -1",
        "a.npy",
        &["--interval <CYCLES>", "a whole number of cycles of 1 or more"],
    );
    refused("--what rays", "no/folder/a.npy", &["cannot write", "no/folder/a.npy"]);
    export(&trace, "--what rays", Path::new("-")).expect(2).says(&["--format csv"]);
    export(&trace, "--what rays --format npy", Path::new("-")).expect(2).says(&["cannot be piped"]);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}

/// Damage is found when the export comes to it: what was written until then goes away.
#[test]
fn a_damaged_trace_is_bad_data_and_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let (trace, file) = (folder.path().join("damaged.rtrace"), folder.path().join("t.parquet"));
    let mut bytes = std::fs::read(repository("traces/v1_0_teapot.rtrace")).unwrap();
    let at = bytes.len() * 3 / 4;
    bytes[at] ^= 0xff;
    std::fs::write(&trace, bytes).unwrap();
    for what in ["rays", "steps", "addresses", "samples", "samples --policy full", "lookups"] {
        let options = format!("--what {what}");
        let ran = export(&trace, &options, &file);
        // The byte may lie in a column that the table does not need.
        assert!(ran.code == 65 || what == "rays" && ran.code == 0, "{what}: {ran:?}");
        assert!(ran.code == 0 || !file.exists(), "{what}");
        std::fs::remove_file(&file).ok();
    }
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file");
}
