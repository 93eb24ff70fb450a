//! Paths, traversed again outside of the crate: a script made from FORMAT.md takes boxes, triangles and rays of a trace.
//!
//! Skipped, saying so, where there is no python3 with NumPy.

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use crate::common::{capture, repository};
use crate::rayreel;

/// Runs the script on tables of a trace; nothing where there is no python3 with NumPy.
fn walk(tables: &[PathBuf]) -> Option<Output> {
    let ran = Command::new("python3").arg("-B").arg(repository("tests/e2e/walk.py")).args(tables).output();
    let output = ran.inspect_err(|error| eprintln!("skipped: python3 does not start: {error}")).ok()?;
    if output.status.code() == Some(77) {
        eprintln!("skipped: {}", String::from_utf8_lossy(&output.stdout).trim());
        return None;
    }
    Some(output)
}

#[test]
fn a_script_takes_the_steps_that_a_trace_holds() {
    let folder = tempfile::tempdir().unwrap();
    for (scene, options) in [("teapot", "--size 24x12 --samples 1x1"), ("cornell", "--size 16x16 --samples 1x1")] {
        let trace = folder.path().join(format!("{scene}.rtrace"));
        capture(scene, options, &trace);
        let tables = ["nodes", "triangles", "rays", "steps"].map(|what| {
            let table = folder.path().join(format!("{scene}-{what}.jsonl"));
            rayreel!["export", "--quiet", &trace, "--what", what, "-o", &table].expect(0);
            table
        });
        let Some(output) = walk(&tables) else { return };
        let said = [output.stdout, output.stderr].concat();
        assert!(output.status.success(), "{scene}: {}", String::from_utf8_lossy(&said));
        // A step that is another is noticed.
        let text = fs::read_to_string(&tables[3]).unwrap();
        fs::write(&tables[3], text.replacen("left_first", "right_first", 1)).unwrap();
        let output = walk(&tables).unwrap();
        let said = String::from_utf8_lossy(&output.stderr);
        assert!(!output.status.success() && said.contains("right_first"), "{scene}: {said}");
    }
}
