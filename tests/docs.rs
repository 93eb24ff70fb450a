//! The documents say what the program prints: commands that are cheap are run as they stand there, and their output is compared.
//!
//! A block is run if `<!-- run -->` stands on the line before it; before one whose commands end with another code than 0 stands
//! `<!-- run 2 -->`, and what they print as errors is compared too. What is no command of rayreel is one of the shell. Blocks of one document
//! share a folder, where `releases` of the repository is, and are run in order. A line `...` stands for any lines; a figure that depends on
//! the clock stands for any other. A table below a line `<!-- table: COMMAND -->` is part of what that command prints, an example of this
//! repository with a file that is in it. Links between documents are followed too, and lines of prose fit a screen.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

/// README, ARCHITECTURE, and every page under `docs`.
fn documents() -> Vec<PathBuf> {
    let pages = fs::read_dir(root().join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<PathBuf> = pages.filter(|path| path.extension().is_some_and(|ending| ending == "md")).collect();
    all.extend(["README.md", "ARCHITECTURE.md", "CHANGELOG.md"].map(|name| root().join(name)));
    all.sort();
    all
}

/// The rules that stand beside the code that follows them.
fn rules() -> [PathBuf; 3] {
    ["formats/FORMAT.md", "machine/MODEL.md", "replay/POLICIES.md"].map(|name| root().join(name))
}

/// A command of a document and what it prints there.
#[derive(Debug, PartialEq)]
struct Example {
    line: usize,
    command: String,
    code: i32,
    expected: Vec<String>,
}

/// The code that commands end with below this line, if they are run.
fn code(line: &str) -> Option<i32> {
    let inside = line.strip_prefix("<!-- run")?.strip_suffix("-->")?.trim();
    if inside.is_empty() { Some(0) } else { inside.parse().ok() }
}

/// The examples of a document that are to be run.
fn examples(text: &str) -> Vec<Example> {
    let mut found: Vec<Example> = Vec::new();
    let (mut marked, mut inside) = (None, false);
    for (number, line) in (1..).zip(text.lines()) {
        if inside {
            if line == "```" {
                (inside, marked) = (false, None);
            } else if let Some(command) = line.strip_prefix("$ ") {
                let command = command.split(" #").next().unwrap_or_default().trim().to_owned();
                found.push(Example { line: number, command, code: marked.unwrap_or(0), expected: Vec::new() });
            } else {
                found.last_mut().expect("output stands below a command").expected.push(line.trim_end().to_owned());
            }
        } else {
            inside = marked.is_some() && line == "```console";
            if !inside {
                marked = code(line);
            }
        }
    }
    found
}

/// Words that depend on the clock become one word: `1.9 Mrays/s`, `12.5 s`.
fn masked(line: &str) -> String {
    let words: Vec<&str> = line.trim_end().split(' ').collect();
    let clock = |i: usize| {
        let unit = words.get(i + 1).map(|word| word.trim_end_matches([',', '.']));
        words[i].parse::<f64>().is_ok() && unit.is_some_and(|u| ["Mrays/s", "krays/s", "points/s", "s"].contains(&u))
    };
    // A rate of the simulated machine is exact; only `capture` tells one of this computer.
    if !line.contains("bytes/ray") && !line.contains("points/s") {
        return line.trim_end().to_owned();
    }
    let mask = |i: usize| if clock(i) { "N" } else { words[i] };
    (0..words.len()).map(mask).collect::<Vec<_>>().join(" ").replace("krays/s", "Mrays/s")
}

/// Where `expected` and `actual` part, if they do; `...` stands for any number of lines.
fn difference(expected: &[String], actual: &[String]) -> Option<String> {
    let Some((first, rest)) = expected.split_first() else {
        return actual.first().map(|line| format!("it prints more: {line}"));
    };
    if first == "..." {
        // The nearest continuation that fits to the end.
        let found = (0..=actual.len()).map(|skip| difference(rest, &actual[skip..])).find(Option::is_none);
        return found.unwrap_or_else(|| Some(format!("nothing printed continues with {:?}", rest.first())));
    }
    match actual.split_first() {
        None => Some(format!("it does not print: {first}")),
        Some((line, after)) if masked(line) == masked(first) => difference(rest, after),
        Some((line, _)) => Some(format!("\n  documented: {first}\n  printed:    {line}")),
    }
}

/// Runs the examples of a document.
fn check(document: &Path) -> usize {
    let folder = tempfile::tempdir().unwrap();
    std::os::unix::fs::symlink(root().join("releases"), folder.path().join("releases")).unwrap();
    let all = examples(&fs::read_to_string(document).unwrap());
    for Example { line, command, code, expected } in &all {
        let place = format!("{}:{line}: {command}", document.display());
        let mut run = match command.strip_prefix("rayreel ") {
            Some(arguments) => {
                let mut run = Command::new(env!("CARGO_BIN_EXE_rayreel"));
                run.args(arguments.split_whitespace()).arg("--quiet");
                run
            }
            None => {
                let mut run = Command::new("sh");
                run.args(["-c", command]);
                run
            }
        };
        let output = run.current_dir(folder.path()).output().unwrap();
        assert_eq!(output.status.code(), Some(*code), "{place}: {}", String::from_utf8_lossy(&output.stderr));
        let said = if *code == 0 { output.stdout } else { [output.stdout, output.stderr].concat() };
        let printed: Vec<String> =
            String::from_utf8(said).unwrap().lines().map(|line| line.trim_end().to_owned()).collect();
        if let Some(difference) = difference(expected, &printed) {
            panic!("{place}: {difference}");
        }
    }
    all.len()
}

/// The tables of a document that an example prints: the line of the mark, the command, and the rows.
fn tables(text: &str) -> Vec<(usize, &str, Vec<&str>)> {
    let lines: Vec<&str> = text.lines().collect();
    let marked = lines.iter().enumerate().filter_map(|(at, &line)| {
        let command = line.strip_prefix("<!-- table: ")?.strip_suffix(" -->")?;
        Some((at, command))
    });
    let rows = |at: usize| {
        let below = lines[at + 1..].iter().copied().skip_while(|line| line.is_empty());
        below.take_while(|line| line.starts_with('|')).collect()
    };
    marked.map(|(at, command)| (at + 1, command, rows(at))).collect()
}

/// What an example prints that `cargo test` has built beside the program.
fn printed_by_example(command: &str, place: &str) -> String {
    let words: Vec<&str> = command.split_whitespace().collect();
    let ["cargo", "run", "--release", "--example", name, "--", arguments @ ..] = &words[..] else {
        panic!("{place}: an example is run by `cargo run --release --example NAME -- ..`");
    };
    let built = Path::new(env!("CARGO_BIN_EXE_rayreel")).with_file_name("examples").join(name);
    let output = Command::new(&built).args(arguments).current_dir(root()).output();
    let output = output.unwrap_or_else(|error| panic!("{place}: {}: {error}; build the examples", built.display()));
    assert!(output.status.success(), "{place}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

#[test]
fn tables_are_what_their_commands_print() {
    let mut checked = 0;
    for document in documents() {
        for (line, command, rows) in tables(&fs::read_to_string(&document).unwrap()) {
            let place = format!("{}:{line}", document.display());
            let printed = printed_by_example(command, &place);
            assert!(rows.len() > 2, "{place}: a table stands below its command");
            let table = rows.join("\n") + "\n";
            assert!(printed.contains(&table), "{place}: {command} prints\n{printed}\nand the document has\n{table}");
            checked += 1;
        }
    }
    assert!(checked >= 3, "only {checked} tables are checked");
}

#[test]
fn commands_print_what_the_documents_say() {
    let run: usize = documents().iter().map(|document| check(document)).sum();
    assert!(run >= 5, "only {run} commands of the documents are run");
}

/// Anchors as the usual renderers make them of headings.
fn anchors(text: &str) -> Vec<String> {
    let plain = |heading: &str| {
        let kept: String = heading.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect();
        kept.trim().to_lowercase().replace(' ', "-")
    };
    text.lines().filter(|line| line.starts_with('#')).map(|line| plain(line.trim_start_matches('#'))).collect()
}

/// Targets of the links of a text, without those in code.
fn links(text: &str) -> Vec<String> {
    let mut prose = String::new();
    let mut fenced = false;
    for line in text.lines() {
        fenced ^= line.starts_with("```");
        if !fenced {
            prose += line;
            prose.push('\n');
        }
    }
    let targets = prose.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned()));
    targets.filter(|target| !target.starts_with("http")).collect()
}

#[test]
fn links_lead_somewhere() {
    for document in documents().into_iter().chain(rules()) {
        let text = fs::read_to_string(&document).unwrap();
        for link in links(&text) {
            let (path, anchor) = link.split_once('#').unwrap_or((&link, ""));
            let target = if path.is_empty() { document.clone() } else { document.parent().unwrap().join(path) };
            assert!(target.exists(), "{}: a link to {link}, which is not there", document.display());
            if !anchor.is_empty() {
                let known = anchors(&fs::read_to_string(&target).unwrap());
                assert!(known.iter().any(|a| a == anchor), "{}: no heading for {link}: {known:?}", document.display());
            }
        }
    }
}

/// Lines of prose that are wider than [`WIDEST`] columns; tables, code and what tests write stay as they are.
fn wide(text: &str) -> Vec<usize> {
    let (mut fenced, mut written) = (false, false);
    let is_wide = |(_, line): &(usize, &str)| {
        let line = line.trim_start();
        fenced ^= line.starts_with("```");
        written = (written || line.ends_with("begin -->")) && !line.ends_with("end -->");
        !(fenced || written || line.starts_with('|') || line.starts_with("<!--")) && line.chars().count() > WIDEST
    };
    (1..).zip(text.lines()).filter(is_wide).map(|(number, _)| number).collect()
}

/// Columns of a line of prose, at most.
const WIDEST: usize = 150;

#[test]
fn prose_is_wrapped() {
    for document in documents().into_iter().chain(rules()) {
        let lines = wide(&fs::read_to_string(&document).unwrap());
        assert!(lines.is_empty(), "{}: lines {lines:?} are wider than {WIDEST} columns", document.display());
    }
    let (long, row) = ("x ".repeat(80), "| ".repeat(80));
    assert_eq!(wide(&format!("{long}\n{row}\n```\n{long}\n```\n- {long}")), [1, 6]);
    assert_eq!(wide(&format!("<!-- a: begin -->\n{long}\n<!-- a: end -->\n{long}")), [4]);
}

#[test]
fn a_wrong_document_is_noticed() {
    let lines = |text: &str| text.lines().map(str::to_owned).collect::<Vec<_>>();
    let printed = lines("a: 1\nb: 2\nc: 3");
    assert_eq!(difference(&lines("a: 1\n...\nc: 3"), &printed), None);
    assert_eq!(difference(&lines("..."), &printed), None);
    for wrong in ["a: 1\n...\nc: 4", "a: 1\nb: 2", "a: 1\nb: 2\nc: 3\nd: 4", "a: 2\n..."] {
        assert!(difference(&lines(wrong), &printed).is_some(), "{wrong}");
    }
    let rate = |rate: &str| lines(&format!("x.rtrace: 5 bytes, 1.260 bytes/ray (paths 0.534), {rate}"));
    assert_eq!(difference(&rate("2.1 Mrays/s"), &rate("350.61 krays/s")), None);
    assert!(difference(&lines("rays 5, 2.1 Mrays/s"), &lines("rays 5, 2.2 Mrays/s")).is_some(), "a simulated rate");
    let text = "<!-- run -->\n```console\n$ rayreel a   # why\nb\n$ rayreel c\n```\n```console\n$ rayreel d\n```\n";
    let found = examples(text);
    assert_eq!(found.len(), 2, "blocks without a mark are not run");
    assert_eq!((found[0].line, found[0].command.as_str(), found[0].expected.len()), (3, "rayreel a", 1));
    let text = "a\n<!-- table: cargo x -->\n\n| 1 |\n|---|\n| 2 |\n\n| 3 |\n";
    assert_eq!(tables(text), [(2, "cargo x", vec!["| 1 |", "|---|", "| 2 |"])]);
}
