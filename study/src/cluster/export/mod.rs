//! Templates for engines that this project does not run: files to be read, edited and submitted by people who have the engine.
//!
//! All of them call the same contract as the tested engine: any machine may run any shard of the folder, any number of times.

mod templates;

use std::path::Path;

use crate::cluster::shell::{filled, quote};

pub use templates::{ENGINES, Engine};

/// What stands in a template.
#[derive(Clone, Copy, Debug)]
pub struct Fill<'a> {
    /// The program, absolute.
    pub program: &'a Path,
    /// The folder of the sweep, absolute.
    pub sweep: &'a Path,
    /// Id of its plan.
    pub plan: &'a str,
    /// Into how many shards it is split.
    pub shards: usize,
}

/// The first words of every file.
pub const LABEL: &str = "NOT TESTED: a template to edit.";

impl Engine {
    /// Its files: names and contents.
    pub fn files(&self, fill: Fill<'_>) -> Vec<(&'static str, String)> {
        self.files.iter().map(|(name, text)| (*name, of_template(text, fill))).collect()
    }
}

/// Fills in a template. Paths stand in shell scripts alone: elsewhere other quotes would be needed.
fn of_template(text: &str, fill: Fill<'_>) -> String {
    let word = |path: &Path| quote(&path.display().to_string());
    let values = [
        ("LABEL", LABEL.to_owned()),
        ("NAME", super::slurm::sbatch::name(fill.plan)),
        ("SHARDS", fill.shards.to_string()),
        ("LAST", (fill.shards - 1).to_string()),
        ("PROGRAM", word(fill.program)),
        ("SWEEP", word(fill.sweep)),
    ];
    filled(text, &values.each_ref().map(|(name, value)| (*name, value.as_str())))
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    fn all() -> Vec<(&'static str, &'static str, String)> {
        let fill = Fill {
            program: Path::new("/opt/my tools/rayreel"),
            sweep: Path::new("/data/a b's.sweep"),
            plan: "8c62bfbd01234567",
            shards: 40,
        };
        let files =
            |engine: &'static Engine| engine.files(fill).into_iter().map(move |(name, text)| (engine.name, name, text));
        ENGINES.iter().flat_map(files).collect()
    }

    #[test]
    fn every_file_says_that_nobody_tested_it() {
        for (engine, name, text) in all() {
            // JSON has no comments: the script beside it says so.
            assert!(text.contains(LABEL) || name.ends_with(".json"), "{engine} {name}");
            let left = ["@LABEL@", "@NAME@", "@SHARDS@", "@LAST@", "@PROGRAM@", "@SWEEP@"];
            assert!(left.iter().all(|mark| !text.contains(mark)), "{engine} {name}: {text}");
        }
    }

    #[test]
    fn every_engine_calls_the_contract() {
        for engine in ENGINES {
            let text: String = all().into_iter().filter(|(name, ..)| *name == engine.name).map(|file| file.2).collect();
            for words in ["sweep run", "--shard", "/40", "--flush", "sweep merge"] {
                // Arguments of containers are lists of words.
                let text = text.replace("\", \"", " ");
                assert!(text.contains(words), "{} does not say {words}", engine.name);
            }
        }
    }

    #[test]
    fn scripts_are_shell_and_json_is_json() {
        for (engine, name, text) in all() {
            if name.ends_with(".sh") {
                let output = Command::new("bash").args(["-n", "-c", &text]).output().unwrap();
                let said = String::from_utf8_lossy(&output.stderr).into_owned();
                assert!(output.status.success(), "{engine} {name}: {said}");
                assert!(text.starts_with("#!/bin/"), "{engine} {name}");
            } else if name.ends_with(".json") {
                serde_json::from_str::<serde_json::Value>(&text).unwrap_or_else(|e| panic!("{engine} {name}: {e}"));
            }
        }
    }
}
