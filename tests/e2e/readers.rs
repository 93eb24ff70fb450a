//! Other programs read the results of a sweep: DuckDB and polars, through Python.
//!
//! Skipped, saying so, where there is no python3, or neither module.

use std::process::Command;

use serde_json::Value;

use crate::common::small_sweep::{POINTS, small_sweep};
use crate::common::{replay, repository};

#[test]
fn duckdb_and_polars_read_results() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    let script = repository("tests/e2e/readers.py");
    let ran = Command::new("python3").arg("-B").arg(script).arg(sweep.join("results.parquet")).output();
    let output = match ran {
        Ok(output) => output,
        Err(error) => return eprintln!("skipped: python3 does not start: {error}"),
    };
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    if output.status.code() == Some(77) {
        return eprintln!("skipped: {}", said.trim());
    }
    assert!(output.status.success(), "{said}");
    if !said.is_empty() {
        eprintln!("skipped a part: {}", said.trim());
    }
    let run =
        replay(&repository("traces/v1_0_cornell.rtrace"), "--machine sgrt-ti2 --policy full --set ti.trv_l1.size=4KiB");
    let run = run.expect(0).json();
    let read: Value = serde_json::from_slice(&output.stdout).unwrap();
    let readers = read.as_object().unwrap();
    assert!(!readers.is_empty());
    for (reader, told) in readers {
        assert_eq!(told["rows"].as_u64(), Some(POINTS as u64), "{reader}");
        // Whole numbers, numbers, flags, words; an axis that some points lack.
        assert_eq!(told["types"], serde_json::json!(["integer", "float", "flag", "text", "integer"]), "{reader}");
        assert_eq!(told["first"]["cycles"], run["cycles"], "{reader}");
        assert_eq!(told["first"]["time_ms"], run["time_ms"], "{reader}: every bit of it");
        assert_eq!(told["first"]["identical"], true, "{reader}: full is the reference");
        assert_eq!((&told["first"]["l1"], &told["first"]["block"]), (&Value::from(4096), &Value::Null), "{reader}");
    }
}
