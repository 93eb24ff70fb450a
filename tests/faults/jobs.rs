//! Commands that write, small enough to be run some thousand times.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};

use crate::common::{capture, run};
use crate::server::Server;
use crate::system::System;

/// A command, and what is left of it.
pub struct Job {
    pub name: &'static str,
    /// The folder that it begins with.
    pub template: PathBuf,
    pub command: Vec<OsString>,
    /// The next run, after a fault.
    pub again: Vec<OsString>,
    /// The files that it makes.
    pub results: &'static [&'static str],
    /// Whether what it prints is a result.
    pub prints: bool,
    /// Whether nothing is left to do once the first file is there.
    pub ends: bool,
    /// Whether it may leave points undone and say so: code 3.
    pub leaves: bool,
}

const SIZE: &str = "--size 24x16 --samples 1x1 --tile 8";
const PLAN: &str = "traces = [\"a.rtrace\"]\nmachines = [\"none\"]\npolicies = [\"full\", \"adaptive\"]\n";

fn args(line: &str, folder: &Path) -> Vec<OsString> {
    line.split(' ').map(|word| word.replace("{}", folder.to_str().unwrap()).into()).collect()
}

pub fn jobs(system: &System) -> Vec<Job> {
    let empty = system.template("empty");
    let traced = system.template("traced");
    capture("cornell", SIZE, &traced.join("a.rtrace"));
    fs::write(traced.join("p.toml"), PLAN).unwrap();
    // A sweep that is computed, and one that is merged too.
    let computed = system.template("computed");
    for name in ["a.rtrace", "p.toml"] {
        fs::copy(traced.join(name), computed.join(name)).unwrap();
    }
    run(&args("sweep {}/p.toml -o {}/s --quiet", &computed)).expect(0);
    let merged = system.template("merged");
    fs::create_dir_all(merged.join("s")).unwrap();
    for name in ["results.parquet", "results.csv"] {
        fs::rename(computed.join("s").join(name), merged.join("s").join(name)).unwrap();
    }
    let server = Server::start(fs::read(traced.join("a.rtrace")).unwrap());
    let job = |name, template: &Path, line: &str, again: &str, results| Job {
        name,
        template: template.into(),
        command: args(line, &system.folder),
        again: args(if again.is_empty() { line } else { again }, &system.folder),
        results,
        prints: false,
        ends: false,
        leaves: false,
    };
    let (capture, resume) = (
        format!("capture cornell {SIZE} -o {{}}/a.rtrace"),
        format!("capture cornell {SIZE} -o {{}}/a.rtrace --resume"),
    );
    let table: &[&str] = &["s/results.parquet", "s/results.csv"];
    let fetched = format!("digest {} --json --trace-cache {{}}/cache", server.url());
    vec![
        Job { ends: true, ..job("capture", &empty, &capture, &resume, &["a.rtrace"]) },
        Job { leaves: true, ..job("sweep", &traced, "sweep {}/p.toml -o {}/s", "", table) },
        job("merge", &computed, "sweep merge {}/s", "", table),
        job("report", &merged, "report {}/s -o {}/page.html", "", &["page.html"]),
        job("export", &traced, "export {}/a.rtrace --what rays -o {}/rays.parquet", "", &["rays.parquet"]),
        Job { prints: true, ..job("cache", &empty, &fetched, "", &[]) },
    ]
}
