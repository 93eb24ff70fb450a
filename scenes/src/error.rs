//! What can be wrong with a scene: who must act, where it is, and what would put it right.

use std::{fmt, io, path::Path, path::PathBuf};

/// Why a scene could not be loaded, by who must act.
///
/// Messages are fragments: a caller puts its words before them (`cannot load scene: {err}`).
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// The caller named something that is no scene: another name helps.
    #[error("{what}; {fix}")]
    Usage {
        /// What was named and why it is no scene.
        what: String,
        /// What to name instead.
        fix: String,
    },
    /// The system could not read a file that the caller named.
    #[error("{}: cannot read this {what}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What kind of file it is.
        what: &'static str,
        /// The system's reason.
        source: io::Error,
    },
    /// A file says something that makes no sense, or names a file that is not there: its author must change it.
    #[error("{at}: {what}{}", fix_clause(fix.as_deref()))]
    Input {
        /// The file, and as much of the place in it as is known.
        at: Location,
        /// What is wrong.
        what: String,
        /// What to write instead, where `what` does not say it.
        fix: Option<String>,
        /// The system's reason, where a named file cannot be read.
        source: Option<io::Error>,
    },
    /// More than a scene or a trace can hold.
    #[error("{at}: {what}; {fix}")]
    Limit {
        /// The file or scene.
        at: Location,
        /// What there is too much of, with the limit.
        what: String,
        /// What to do.
        fix: String,
    },
    /// The parts of a scene do not fit together: the code that made the scene is at fault.
    #[error("scene `{scene}` is not consistent: {what}")]
    Inconsistent {
        /// The scene's name.
        scene: String,
        /// What does not fit.
        what: String,
    },
}

fn fix_clause(fix: Option<&str>) -> String {
    fix.map_or_else(String::new, |fix| format!("; {fix}"))
}

impl SceneError {
    /// Something wrong in a file, and what to write instead.
    pub(crate) fn input(at: Location, what: impl Into<String>, fix: impl Into<String>) -> Self {
        Self::Input { at, what: what.into(), fix: Some(fix.into()), source: None }
    }

    /// A file that the file at `at` names cannot be read; `what` is its kind.
    pub(crate) fn missing(at: Location, what: &str, missing: &Path, source: io::Error) -> Self {
        let what = format!("the {what} `{}` cannot be read", missing.display());
        Self::Input { at, what, fix: Some("put it there, or correct its name".into()), source: Some(source) }
    }

    /// A folder stands where a file of the kind `expected` should be named.
    pub(crate) fn folder(path: &Path, expected: &str) -> Self {
        Self::Usage { what: format!("{}: is a folder", path.display()), fix: format!("name the {expected} inside it") }
    }
}

/// Where something is wrong.
#[derive(Clone, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Location {
    /// Somewhere in a file.
    File(PathBuf),
    /// A line of a file.
    Line {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column in characters, from 1, where it is known.
        column: Option<usize>,
    },
    /// A part of a file that has a name, such as `[camera]`.
    Part {
        /// The file.
        path: PathBuf,
        /// The part's name.
        part: String,
    },
    /// A scene in memory.
    Scene {
        /// The scene's name.
        name: String,
        /// The frame whose camera is meant, if one is.
        camera: Option<usize>,
    },
}

impl Location {
    pub(crate) fn line(path: &Path, line: usize) -> Self {
        Self::Line { path: path.to_owned(), line, column: None }
    }
}

impl fmt::Display for Location {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::File(path) => write!(out, "{}", path.display()),
            Self::Line { path, line, column: None } => write!(out, "{}:{line}", path.display()),
            Self::Line { path, line, column: Some(column) } => write!(out, "{}:{line}:{column}", path.display()),
            Self::Part { path, part } => write!(out, "{}: {part}", path.display()),
            Self::Scene { name, camera: None } => write!(out, "scene `{name}`"),
            Self::Scene { name, camera: Some(frame) } => write!(out, "scene `{name}`, camera {frame}"),
        }
    }
}
