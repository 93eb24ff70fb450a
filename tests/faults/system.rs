//! The program on a system that fails when it is told to.

use std::ffi::OsString;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use crate::common;
use crate::disk;
use crate::jobs::Job;

/// What becomes of a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// It fails: a broken or a full disk.
    Fail,
    /// Half of it is done.
    Short,
    /// It is interrupted.
    Again,
    /// Half of it is done and the process dies.
    Torn,
    /// The process dies before it.
    Killed,
    /// The power goes: what was not synced is gone, names too.
    Cut,
    /// The power goes: names are there, bytes that were not synced are gone.
    CutOfBytes,
    /// There is no memory for something large.
    NoMemory,
}

impl Kind {
    pub const ALL: [Self; 8] =
        [Self::Fail, Self::Short, Self::Again, Self::Torn, Self::Killed, Self::Cut, Self::CutOfBytes, Self::NoMemory];

    pub fn is_cut(self) -> bool {
        matches!(self, Self::Cut | Self::CutOfBytes)
    }

    /// Whether the process dies of it.
    pub fn kills(self) -> bool {
        self.is_cut() || matches!(self, Self::Torn | Self::Killed | Self::NoMemory)
    }

    fn word(self) -> &'static str {
        match self {
            Self::Fail => "fail",
            Self::Short => "short",
            Self::Again => "again",
            Self::Torn => "torn",
            Self::NoMemory => "memory",
            Self::Killed | Self::Cut | Self::CutOfBytes => "kill",
        }
    }
}

/// How a run ended.
pub struct Ran {
    /// Exit code; -1 for a signal.
    pub code: i32,
    pub out: String,
    pub err: String,
}

/// A folder in which commands run, and what is preloaded into them.
pub struct System {
    home: tempfile::TempDir,
    /// Where the commands read and write.
    pub folder: PathBuf,
    shim: PathBuf,
}

impl System {
    pub fn new() -> Self {
        let memory = Path::new("/dev/shm");
        let home = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() }.unwrap();
        let shim = home.path().join("shim.so");
        let mut compiler = Command::new("cc");
        compiler.args(["-O1", "-shared", "-fPIC", "-o"]).arg(&shim);
        compiler.arg(common::repository("tests/faults/shim.c")).arg("-ldl");
        assert!(compiler.status().is_ok_and(|status| status.success()), "a C compiler builds what fails");
        Self { folder: home.path().join("work"), home, shim }
    }

    /// A folder in which what jobs begin with is made.
    pub fn template(&self, name: &str) -> PathBuf {
        let folder = self.home.path().join("templates").join(name);
        fs::create_dir_all(&folder).unwrap();
        folder
    }

    /// Puts what the job begins with into the folder, and all of it on the disk.
    pub fn fresh(&self, job: &Job) {
        fs::remove_dir_all(&self.folder).ok();
        copy(&job.template, &self.folder);
        fs::remove_file(self.log()).ok();
        disk::write(&self.disk(), &self.folder);
    }

    /// Runs the program; the n-th request is spoilt if that is asked for.
    pub fn run(&self, args: &[OsString], fault: Option<(Kind, usize)>) -> Ran {
        self.call(args, fault.map(|(kind, at)| (kind.word(), at, kind.is_cut())))
    }

    /// How many requests a command makes, of files or of memory.
    pub fn count(&self, args: &[OsString], of: &str) -> usize {
        assert_eq!(self.call(args, Some((of, 0, false))).code, 0);
        let log = fs::read_to_string(self.log()).unwrap();
        log.split(' ').next().unwrap().parse().unwrap()
    }

    fn call(&self, args: &[OsString], fault: Option<(&str, usize, bool)>) -> Ran {
        let mut command = Command::new(env!("CARGO_BIN_EXE_rayreel"));
        command.args(args).args(["--quiet", "--threads", "1"]).stdin(Stdio::null()).env("RAYREEL_TRACE_CACHE_GB", "1");
        command.env("RUST_BACKTRACE", "0");
        if let Some((kind, at, cut)) = fault {
            command.env("LD_PRELOAD", &self.shim).env("FAULT_UNDER", &self.folder).env("FAULT_LOG", self.log());
            command.env("FAULT_KIND", kind).env("FAULT_AT", at.to_string());
            if cut {
                command.env("FAULT_DISK", self.disk());
            }
        }
        let output = command.output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
        Ran { code: output.status.code().unwrap_or(-1), out: text(&output.stdout), err: text(&output.stderr) }
    }

    /// The request that was spoilt: its number, what it was, and of which file.
    pub fn spoilt(&self) -> Option<String> {
        let log = fs::read_to_string(self.log()).ok()?;
        Some(log.trim().replace(&self.folder.display().to_string(), ""))
    }

    /// Leaves in the folder what a power cut would.
    pub fn cut(&self, kind: Kind) {
        disk::read(&self.disk(), &self.folder, kind == Kind::Cut);
    }

    /// What later runs and readers go by: the results by name, and what was printed.
    pub fn state(&self, job: &Job, printed: &str) -> Vec<(&'static str, Option<Vec<u8>>)> {
        let read = |name: &&'static str| (*name, fs::read(self.folder.join(name)).ok());
        let printed = job.prints.then(|| ("what is printed", Some(printed.as_bytes().to_vec())));
        job.results.iter().map(read).chain(printed).collect()
    }

    fn log(&self) -> PathBuf {
        self.home.path().join("log")
    }

    fn disk(&self) -> PathBuf {
        self.home.path().join("disk")
    }
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let to = to.join(entry.file_name());
        if entry.path().is_dir() {
            copy(&entry.path(), &to);
        } else {
            fs::copy(entry.path(), to).unwrap();
        }
    }
}
