//! Energy, recomputed outside of the crate: a script made from MODEL.md takes the counters and constants of a replay.
//!
//! Skipped, saying so, where there is no python3.

use std::fs;
use std::process::{Command, Output};

use crate::common::{replay, repository};

const MACHINES: [&str; 5] = ["sgrt-ti2", "sgrt-ti1", "sgrt-ti2-rob", "no-direct-interface", "raycore"];
/// Other sizes of records, stacks and requests: what leaks and travels by them is in no counter.
const SIZES: &str = "--set ti.ray_record_bytes=48 --set ti.stack_entries=0 --set ti.full_stack_entries=24 --set \
                     ti.stack_entry_bytes=8 --set l2.request_bytes=12";

/// Stacks and local memories below the sizes of their table, and beyond them.
const RAMS: [&str; 2] = [
    "--set ti.stack_entries=2 --set ti.rays_per_trv=24 --set srp.local_memory=24KiB",
    "--set ti.stack_entries=24 --set ti.rays_per_trv=100 --set srp.local_memory=512KiB --set energy.local_priced_size=8KiB \
     --set energy.stack_priced_size=512KiB",
];

/// Rows and bursts of another size than the prices are of.
const DRAM: &str = "--set dram.row_bytes=1024 --set dram.burst_bytes=64 --set dram.tccd=16 --set energy.dram_read_pj=0.777 \
                    --set energy.dram_priced_burst_bytes=48";

/// Traversal units and words of other widths than the prices are of.
const WIDTHS: &str = "--set ti.aabbs_per_cycle=1 --set energy.trv_priced_triangles=2 --set srp.local_word_bytes=8 --set energy.local_priced_word_bytes=3";

/// Caches of other sizes than those that the prices are of, above, below and beyond the table, and other lines.
const CACHES: &str = "--set ti.trv_l1.size=64KiB --set ti.ist_l1.size=4KiB --set srp.l1.size=24KiB --set srp.l1.ways=3 --set l2.size=1MiB \
                      --set energy.l1_priced_size=32KiB --set energy.l2_priced_size=512KiB";
const LINES: &str = "--set l2.line_bytes=128 --set energy.priced_line_bytes=32 --set energy.l1_fill_pj=0.011";

/// Runs the script; nothing where there is no python3.
fn recompute(files: &[std::path::PathBuf]) -> Option<Output> {
    let ran = Command::new("python3").arg("-B").arg(repository("tests/e2e/energy.py")).args(files).output();
    ran.inspect_err(|error| eprintln!("skipped: python3 does not start: {error}")).ok()
}

#[test]
fn a_script_finds_the_same_energy_in_the_counters() {
    let folder = tempfile::tempdir().unwrap();
    let mut files = Vec::new();
    for (machine, options) in MACHINES
        .map(|machine| (machine, ""))
        .into_iter()
        .chain([SIZES, CACHES, LINES, RAMS[0], RAMS[1], DRAM, WIDTHS].map(|sizes| ("sgrt-ti2", sizes)))
    {
        let policy = if machine == "raycore" { "full" } else { "multirate" };
        let trace = repository("traces/v1_0_teapot.rtrace");
        let file = folder.path().join(format!("{}-{machine}", files.len()));
        fs::write(&file, replay(&trace, &format!("--machine {machine} --policy {policy} {options}")).expect(0).out)
            .unwrap();
        files.push(file);
    }
    let Some(output) = recompute(&files) else { return };
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && said.contains("12 runs"), "{said}");
    // A counter that is off by a thousandth is noticed.
    let text = fs::read_to_string(&files[0]).unwrap();
    let mut run: serde_json::Value = serde_json::from_str(&text).unwrap();
    let tests = &mut run["counters"]["ti/trv/box_tests"]["value"];
    *tests = (tests.as_u64().unwrap() * 1001 / 1000).into();
    fs::write(&files[0], run.to_string()).unwrap();
    let output = recompute(&files[..1]).unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(!output.status.success() && said.contains("trv dynamic"), "{said}");
}
