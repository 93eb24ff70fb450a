//! What else a reader can count on: sizes of files and crates, one habit for modules, and words that say nothing.

use std::path::{Path, PathBuf};

use crate::tokens::tokens;

const FILE_LINES_MAX: usize = 400;
const FRONT_PAGE_LINES_MAX: usize = 60;

/// The folders of the workspace's crates, `.` for the binary's.
pub fn members(root: &Path) -> Vec<String> {
    let manifest: toml::Table = std::fs::read_to_string(root.join("Cargo.toml")).unwrap().parse().unwrap();
    let members = manifest["workspace"]["members"].as_array().unwrap();
    members.iter().map(|member| member.as_str().unwrap().to_string()).chain([".".to_string()]).collect()
}

/// A source file, its path from the root of the project.
pub struct Source {
    pub path: String,
    pub text: String,
}

impl Source {
    fn lines(&self) -> usize {
        self.text.lines().count()
    }
}

/// Every `.rs` file of the project, tests, benches and examples too.
fn sources(root: &Path) -> Vec<Source> {
    let mut todo: Vec<PathBuf> = members(root)
        .iter()
        .flat_map(|member| ["src", "tests", "benches", "examples"].map(|part| root.join(member).join(part)))
        .collect();
    let mut found = Vec::new();
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(path.read_dir().unwrap().map(|entry| entry.unwrap().path()));
        } else if path.extension().is_some_and(|extension| extension == "rs") {
            let text = std::fs::read_to_string(&path).unwrap();
            let path = path.strip_prefix(root).unwrap().components().collect::<PathBuf>();
            found.push(Source { path: path.display().to_string(), text });
        }
    }
    found.sort_by(|a, b| a.path.cmp(&b.path));
    found
}

fn project() -> Vec<Source> {
    sources(&crate::root())
}

fn none(found: Vec<String>) {
    assert!(found.is_empty(), "{}", found.join("\n"));
}

fn too_long(sources: &[Source]) -> Vec<String> {
    let limit = |path: &str| if path.ends_with("src/lib.rs") { FRONT_PAGE_LINES_MAX } else { FILE_LINES_MAX };
    let long = sources.iter().filter(|source| source.lines() > limit(&source.path));
    long.map(|source| format!("{}: {} lines, more than {}", source.path, source.lines(), limit(&source.path))).collect()
}

#[test]
fn no_file_is_long_and_a_front_page_fits_a_screen() {
    none(too_long(&project()));
    let lines = |path: &str, count| Source { path: path.into(), text: "x\n".repeat(count) };
    assert!(too_long(&[lines("a/src/lib.rs", 60), lines("a/src/b.rs", 400)]).is_empty());
    assert_eq!(too_long(&[lines("a/src/lib.rs", 61), lines("a/tests/b.rs", 401)]).len(), 2);
}

/// Lines of programs, without folders of tests, by crate.
fn lines_by_crate(sources: &[Source], members: &[String]) -> Vec<(String, usize)> {
    let folder = |member: &String| if member == "." { "src/".into() } else { format!("{member}/src/") };
    let lines = |member: &String| {
        let inside = sources.iter().filter(|source| source.path.starts_with(&folder(member)));
        (member.clone(), inside.map(Source::lines).sum())
    };
    members.iter().map(lines).collect()
}

fn too_large(crates: &[(String, usize)]) -> Vec<String> {
    let all: usize = crates.iter().map(|(_, lines)| lines).sum();
    let large = crates.iter().filter(|(_, lines)| lines * 3 > all);
    large.map(|(name, lines)| format!("{name} has {lines} of {all} lines, more than a third")).collect()
}

#[test]
fn no_crate_is_more_than_a_third() {
    none(too_large(&lines_by_crate(&project(), &members(&crate::root()))));
    let made_up = [("a".to_string(), 34), ("b".to_string(), 33), ("c".to_string(), 33)];
    assert_eq!(too_large(&made_up), ["a has 34 of 100 lines, more than a third"]);
}

/// A module with children is `name/mod.rs`; its tests are `name/tests.rs`, declared as `mod tests;`.
fn other_habits(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for Source { path, .. } in sources.iter().filter(|source| source.path.contains("src/")) {
        let stem = path.strip_suffix(".rs").unwrap();
        let folder = format!("{stem}/");
        if sources.iter().any(|other| other.path.starts_with(&folder)) && !only_tests(sources, &folder) {
            found.push(format!("{path}: stands beside its folder; it is {folder}mod.rs"));
        }
        if stem.ends_with("_tests") {
            found.push(format!("{path}: it is {}/tests.rs", stem.strip_suffix("_tests").unwrap()));
        }
    }
    found
}

/// `name/tests.rs` (and what is below `name/tests/`) may stand alone beside `name.rs`.
fn only_tests(sources: &[Source], folder: &str) -> bool {
    let mut inside = sources.iter().filter_map(|source| source.path.strip_prefix(folder));
    inside.all(|rest| rest == "tests.rs" || rest.starts_with("tests/"))
}

#[test]
fn modules_are_folders_with_a_mod_file() {
    none(other_habits(&project()));
    let made_up = |path: &str| Source { path: path.into(), text: String::new() };
    let good = ["src/a/mod.rs", "src/a/b.rs", "src/c.rs", "src/c/tests.rs"].map(made_up);
    assert!(other_habits(&good).is_empty());
    let bad = ["src/a.rs", "src/a/b.rs", "src/c_tests.rs"].map(made_up);
    assert_eq!(other_habits(&bad).len(), 2);
}

fn empty_words(sources: &[Source]) -> Vec<String> {
    let mut found = Vec::new();
    for Source { path, text } in sources {
        let doc = |line: &str| line.trim_start().starts_with("//") && line.contains(concat!("See the ", "module."));
        let says_nothing = text.lines().enumerate().filter(|(_, line)| doc(line));
        found.extend(says_nothing.map(|(at, _)| format!("{path}:{}: says nothing", at + 1)));
        let names = tokens(text).into_iter().filter(|token| token.text == "own");
        found.extend(names.map(|token| format!("{path}:{}: a thing called `own`: name what it is", token.line)));
    }
    found
}

#[test]
fn names_and_comments_say_something() {
    none(empty_words(&project()));
    let made_up = |text: &str| vec![Source { path: "a.rs".into(), text: text.into() }];
    assert!(empty_words(&made_up("// its own thing\nlet policy = \"own\";")).is_empty());
    assert_eq!(empty_words(&made_up(concat!("/// See the ", "module.\nfn a() {}"))).len(), 1);
    for code in ["let own = 1;", "let f = |own| 1;", "for own in 0..1 {}", "fn f(own: u8) {}"] {
        assert_eq!(empty_words(&made_up(code)), ["a.rs:1: a thing called `own`: name what it is"], "{code}");
    }
}
