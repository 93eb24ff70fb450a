//! The package as Python has it: the native part that was just built, under `pytest`. So the notebook and `docs/python.md` are run too.

use std::path::{Path, PathBuf};
use std::process::Command;

/// What the tests import; without one of these there is nothing to run them with.
const MODULES: &str = "numpy, polars, pyarrow, pytest, mypy, nbformat, nbclient, ipykernel";

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// The package: its Python, beside the library that cargo has put next to this test.
fn package(to: &Path) {
    let built = std::env::current_exe().unwrap();
    let native = built.with_file_name("lib_native.so");
    let sources = root().join("python/lib/rayreel");
    let package = to.join("rayreel");
    std::fs::create_dir(&package).unwrap();
    for entry in sources.read_dir().unwrap() {
        let path = entry.unwrap().path();
        if path.is_file() {
            std::fs::copy(&path, package.join(path.file_name().unwrap())).unwrap();
        }
    }
    std::fs::copy(&native, package.join("_native.abi3.so")).unwrap_or_else(|e| panic!("{}: {e}", native.display()));
}

#[test]
#[cfg(target_os = "linux")]
fn the_package_passes_its_tests() {
    let python = std::env::var("PYTHON").unwrap_or_else(|_| "python3".into());
    let found = Command::new(&python).args(["-c", &format!("import {MODULES}")]).output();
    if !found.is_ok_and(|output| output.status.success()) {
        assert!(
            std::env::var_os("RAYREEL_PYTHON").is_none(),
            "RAYREEL_PYTHON is set, and {python} lacks one of {MODULES}"
        );
        eprintln!("skipped: {python} does not have all of {MODULES}");
        return;
    }
    let dir = tempfile::tempdir().unwrap();
    package(dir.path());
    // The program may not be built, or not from these sources: then what compares with it is skipped.
    let program = std::env::current_exe().unwrap().ancestors().nth(2).unwrap().join("rayreel");
    let mut command = Command::new(&python);
    command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider", "tests"]).current_dir(root().join("python"));
    command.env("PYTHONPATH", dir.path()).env("PYTHONDONTWRITEBYTECODE", "1").env("RAYREEL", &program);
    let output = command.output().unwrap();
    let said = [output.stdout, output.stderr].concat();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&said));
    eprintln!("{}", String::from_utf8_lossy(&said));
}
