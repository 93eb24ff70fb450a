//! Exit codes: what a script may rely on.

use std::io;
use std::process::ExitCode;

use rayreel_columns::ColumnsError;
use rayreel_formats::Error as TraceError;
use rayreel_paper::PaperError;
use rayreel_replay::ReplayError;
use rayreel_scenes::SceneError;
use rayreel_store::Unavailable;
use rayreel_study::StudyError;
use rayreel_study::html::ReportError;

/// How a command ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Done.
    Done = 0,
    /// The result says no: verify, diff or compare found a difference.
    No = 1,
    /// Wrong usage.
    Usage = 2,
    /// Tiles or frames are missing.
    Incomplete = 3,
    /// Bad input data.
    BadData = 65,
    /// A server cannot be reached, or gives no sound answer.
    Unavailable = 69,
    /// The system cannot read or write: a full disk, a broken one.
    Io = 74,
    /// Interrupted, with everything flushed.
    Interrupted = 75,
}

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> Self {
        Self::from(exit as u8)
    }
}

/// An error whose causes are told as text: they decide its code.
#[derive(Debug)]
struct Blamed(Exit, StudyError);

impl std::fmt::Display for Blamed {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.1.fmt(f)
    }
}

impl std::error::Error for Blamed {}

/// The same error with a code that its causes have decided.
pub fn blaming(exit: Exit, error: StudyError) -> anyhow::Error {
    Blamed(exit, error).into()
}

/// Whether nothing is wrong, and somebody only wanted the command to end.
pub fn is_interruption(error: &anyhow::Error) -> bool {
    error.chain().any(|cause| matches!(cause.downcast_ref(), Some(ReplayError::Interrupted)))
}

/// The exit code of an error.
pub fn of(error: &anyhow::Error) -> Exit {
    if let Some(Blamed(exit, _)) = error.downcast_ref() {
        return *exit;
    }
    // A replay's error may stand on a trace's: the innermost one that says who must act decides.
    if let Some(error) = error.chain().find_map(trace_error) {
        return of_trace(error);
    }
    let bad_data = |cause: &(dyn std::error::Error + 'static)| {
        // A scene that is not there is a wrong name; a scene that cannot be used is bad data.
        let scene =
            cause.downcast_ref().is_some_and(|e| !matches!(e, SceneError::Usage { .. } | SceneError::Io { .. }));
        let report = cause.downcast_ref().is_some_and(ReportError::is_bad_data);
        let study = study_error(cause).is_some_and(StudyError::is_bad_data);
        let columns = cause.downcast_ref().is_some_and(ColumnsError::is_bad_data);
        scene || report || study || columns || matches!(cause.downcast_ref(), Some(ReplayError::Corrupt { .. }))
    };
    if error.chain().any(bad_data) {
        return Exit::BadData;
    }
    error.chain().find_map(|cause| cause.downcast_ref::<io::Error>()).map_or(Exit::Usage, of_io)
}

/// The trace's error in a cause. An error that is transparent stands in the chain in place of the one it holds.
fn trace_error<'a>(cause: &'a (dyn std::error::Error + 'static)) -> Option<&'a TraceError> {
    let boxed = || cause.downcast_ref::<Box<TraceError>>().map(|error| &**error);
    let of_paper = || match cause.downcast_ref() {
        Some(PaperError::Trace(error)) => Some(error),
        _ => None,
    };
    cause.downcast_ref().or_else(boxed).or_else(of_paper)
}

fn study_error<'a>(cause: &'a (dyn std::error::Error + 'static)) -> Option<&'a StudyError> {
    let of_paper = || match cause.downcast_ref() {
        Some(PaperError::Study(error)) => Some(error),
        _ => None,
    };
    cause.downcast_ref().or_else(of_paper)
}

/// What the system or a server refused. A name that leads nowhere is a wrong name; what is left is no fault of whoever gave it.
fn of_io(error: &io::Error) -> Exit {
    use io::ErrorKind as Kind;
    if error.get_ref().is_some_and(|inner| inner.is::<Unavailable>()) {
        return Exit::Unavailable;
    }
    match error.kind() {
        Kind::InvalidData => Exit::BadData,
        Kind::NotFound
        | Kind::PermissionDenied
        | Kind::AlreadyExists
        | Kind::IsADirectory
        | Kind::NotADirectory
        | Kind::DirectoryNotEmpty
        | Kind::InvalidInput
        | Kind::InvalidFilename
        | Kind::Unsupported
        | Kind::WouldBlock => Exit::Usage,
        _ => Exit::Io,
    }
}

fn of_trace(error: &TraceError) -> Exit {
    match error {
        TraceError::Incomplete { .. } => Exit::Incomplete,
        TraceError::Io { source, .. } => of_io(source),
        TraceError::Occupied { .. } | TraceError::Usage { .. } => Exit::Usage,
        _ => Exit::BadData,
    }
}

/// True when standard output was closed by its reader.
pub fn is_broken_pipe(error: &anyhow::Error) -> bool {
    let broken = |e: &std::io::Error| e.kind() == std::io::ErrorKind::BrokenPipe;
    error.chain().any(|cause| cause.downcast_ref::<std::io::Error>().is_some_and(broken))
}
