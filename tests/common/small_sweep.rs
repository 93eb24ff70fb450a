//! A sweep of a few points over a committed trace.

use std::fs;
use std::path::{Path, PathBuf};

use super::{repository, run};

/// Points of [`small_sweep`]: `full`, and `adaptive` with three blocks, on machines with two caches.
pub const POINTS: usize = 8;

/// Runs it on a machine; `extra` are more lines of its plan. Its folder.
#[track_caller]
pub fn small_sweep(folder: &Path, name: &str, machine: &str, extra: &str) -> PathBuf {
    let (plan, sweep) = (folder.join(format!("{name}.toml")), folder.join(format!("{name}.sweep")));
    let trace = repository("traces/v1_0_cornell.rtrace");
    let text = format!(
        "name = \"small & <quick>\"\ntraces = [{trace:?}]\nmachines = [{machine:?}]\npolicies = [\"full\", \"adaptive\"]\n{extra}\n\
         [[axis]]\nname = \"l1\"\nkey = \"ti.trv_l1.size\"\nvalues = [\"4KiB\", \"32KiB\"]\n\
         [[axis]]\nname = \"block\"\nkey = \"block\"\nvalues = [2, 4, 8]\nonly = [\"adaptive\"]\n"
    );
    fs::write(&plan, text).unwrap();
    let args = ["sweep".into(), plan.into(), "-o".into(), sweep.clone().into(), "--quiet".into()];
    run(&args).expect(0);
    sweep
}
