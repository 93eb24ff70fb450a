//! Inputs that were trouble once, and the kept ones: nothing panics, and one that is read without end never lets the test end. The
//! runner limits the time of each; a test asserts none.

use std::fs;
use std::path::{Path, PathBuf};

use rayreel_fuzz::memory::{self, Counting};
use rayreel_fuzz::{all, runner};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).map(|entries| entries.map(|entry| entry.unwrap().path()).collect());
    let mut files: Vec<PathBuf> = entries.unwrap_or_default();
    files.sort();
    files
}

/// One test and not several: the count of memory is that of the process.
#[test]
fn every_kept_input_is_read_in_little_memory() {
    let home = Path::new(env!("CARGO_MANIFEST_DIR"));
    let targets = all();
    let mut read = 0;
    for target in &targets {
        let mut inputs = runner::seeds(target, &home.join("corpus"));
        let seeds = inputs.len();
        inputs.extend(files(&home.join("regressions").join(target.name)).iter().map(|file| fs::read(file).unwrap()));
        for (number, bytes) in inputs.iter().enumerate() {
            let held = memory::restart();
            runner::read(target, bytes).unwrap_or_else(|why| panic!("{} input {number}: {why}", target.name));
            assert!(
                memory::peak() - held < 200 << 20,
                "{} input {number}: {} bytes",
                target.name,
                memory::peak() - held
            );
            read += 1;
        }
        assert!(seeds > 0, "{} has no input", target.name);
    }
    assert!(read > 50, "{read}");
    for part in ["corpus", "regressions"] {
        for folder in files(&home.join(part)) {
            let name = folder.file_name().unwrap().to_str().unwrap();
            assert!(targets.iter().any(|target| target.name == name), "{part}/{name} is of no target");
        }
    }
}

/// The seeds of the targets that read what this program writes are read well; else only the door is tested.
#[test]
fn sound_inputs_are_read_well() {
    for target in all() {
        let said: Vec<String> = (target.seeds)().iter().map(|bytes| (target.read)(bytes)).collect();
        let well =
            said.iter().any(|said| ["well", "rows", "opened", "true", "false"].iter().any(|word| said.contains(word)));
        assert!(well, "{}: {said:?}", target.name);
    }
}
