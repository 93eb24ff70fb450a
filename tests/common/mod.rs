//! What the end-to-end tests share: running the binary, reading what it says, scenes to run it on.

pub mod scenes;
pub mod small_sweep;
pub mod trace;

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use serde_json::Value;

/// The built-in scenes.
pub const BUILTIN: [&str; 3] = ["cornell", "teapot", "chess"];

/// Runs the binary: `rayreel!["info", "--json", &path]`.
#[macro_export]
macro_rules! rayreel {
    ($($arg:expr),* $(,)?) => { $crate::common::run(&[$(::std::ffi::OsStr::new($arg).to_owned()),*]) };
}

/// How a run ended, and what it printed.
#[derive(Debug)]
pub struct Ran {
    /// The arguments, for messages.
    pub what: String,
    /// Exit code; -1 for a signal.
    pub code: i32,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Ran {
    /// Demands an exit code.
    #[track_caller]
    pub fn expect(self, code: i32) -> Self {
        let Self { what, code: found, out, err } = &self;
        assert_eq!(*found, code, "exit code of `rayreel {what}`\n--- stdout\n{out}\n--- stderr\n{err}");
        self
    }

    /// Demands words on standard error.
    #[track_caller]
    pub fn says(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.err.contains(word), "`rayreel {}` does not say {word:?}:\n{}", self.what, self.err);
        }
        self
    }

    /// Demands words on standard output.
    #[track_caller]
    pub fn prints(self, words: &[&str]) -> Self {
        for word in words {
            assert!(self.out.contains(word), "`rayreel {}` does not print {word:?}:\n{}", self.what, self.out);
        }
        self
    }

    /// Standard output as JSON.
    #[track_caller]
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("`rayreel {}`: {e}\n{}", self.what, self.out))
    }

    /// The same without the command that it names: two commands may ask for one result in other words.
    #[track_caller]
    pub fn result(&self) -> Value {
        let mut json = self.json();
        json.as_object_mut().unwrap().remove("command").expect("results name their command");
        json
    }
}

/// The binary with these arguments, detached from any terminal.
pub fn command(args: &[OsString]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_rayreel"));
    command.args(args).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).env_remove("COLUMNS");
    command
}

/// Runs the binary to its end.
pub fn run(args: &[OsString]) -> Ran {
    let what = args.iter().map(|a| a.to_string_lossy().into_owned()).collect::<Vec<_>>().join(" ");
    let output = command(args).output().unwrap();
    let text = |bytes: &[u8]| String::from_utf8(bytes.to_vec()).unwrap();
    let code = output.status.code().unwrap_or(-1);
    Ran { what, code, out: text(&output.stdout), err: text(&output.stderr) }
}

/// The arguments of a capture; `options` are split at blanks.
pub fn capture_args(scene: &str, options: &str, file: &Path) -> Vec<OsString> {
    let mut args: Vec<OsString> = ["capture", scene, "--quiet", "-o"].map(OsString::from).to_vec();
    args.push(file.into());
    args.extend(options.split_whitespace().map(OsString::from));
    args
}

/// Captures a scene, and gives the JSON summary.
#[track_caller]
pub fn capture(scene: &str, options: &str, file: &Path) -> Value {
    let mut args = capture_args(scene, options, file);
    args.push("--json".into());
    run(&args).expect(0).json()
}

/// The hashes of a trace, by column.
#[track_caller]
pub fn digest(file: &Path) -> Value {
    rayreel!["digest", "--json", file].expect(0).json()
}

/// Replays a trace, without a machine unless one is named; `options` are split at blanks.
pub fn replay(file: &Path, options: &str) -> Ran {
    let mut args: Vec<OsString> = ["replay", "--quiet", "--json"].map(OsString::from).to_vec();
    args.push(file.into());
    if !options.contains("--machine") {
        args.extend(["--machine", "none"].map(OsString::from));
    }
    args.extend(options.split_whitespace().map(OsString::from));
    run(&args)
}

/// A file of the repository.
pub fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// Whether committed files are to be rewritten instead of compared.
pub fn blessing() -> bool {
    std::env::var_os("RAYREEL_BLESS").is_some_and(|v| v == "1")
}

/// What to do when a committed file does not match.
pub const BLESS: &str = "if the change is meant: RAYREEL_BLESS=1 cargo test --release --test e2e, and review the diff";
