//! Tells the program which commit it was built from, for `--version`, and whether its sources had changes beside it: figures of such
//! a build cannot be had again from the commit. A build without Git, from an archive, has none.

use std::path::Path;
use std::process::Command;

/// What the program is made of, as Git's patterns.
const SOURCES: &[&str] =
    &["Cargo.*", "build.rs", "src", ":(glob)*/Cargo.toml", ":(glob)*/src/**", ":(glob)*/presets/**"];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    // The log grows with each commit and checkout; HEAD alone names a branch and stays.
    for name in ["HEAD", "logs/HEAD"] {
        if let Some(path) = git(&["rev-parse", "--git-path", name]).filter(|path| Path::new(path).exists()) {
            println!("cargo:rerun-if-changed={path}");
        }
    }
    if let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]) {
        let changes = git(&[&["--no-optional-locks", "status", "--porcelain", "--"], SOURCES].concat());
        let note = if changes.is_some() { ", with changes that were not committed" } else { "" };
        println!("cargo:rustc-env=RAYREEL_COMMIT={commit}{note}");
        for path in git(&[&["ls-files", "--"], SOURCES].concat()).unwrap_or_default().lines() {
            println!("cargo:rerun-if-changed={path}");
        }
    }
}

fn git(args: &[&str]) -> Option<String> {
    // Of this project only: a package that was unpacked inside of another repository is not that repository's commit.
    let run = |args: &[&str]| Command::new("git").args(args).output().ok().filter(|output| output.status.success());
    let text = |output: std::process::Output| String::from_utf8(output.stdout).ok().map(|text| text.trim().to_owned());
    let root = run(&["rev-parse", "--show-toplevel"]).and_then(text)?;
    let here = std::env::var("CARGO_MANIFEST_DIR").ok()?;
    let is_ours = Path::new(&root).canonicalize().ok()? == Path::new(&here).canonicalize().ok()?;
    if is_ours { run(args).and_then(text).filter(|text| !text.is_empty()) } else { None }
}
