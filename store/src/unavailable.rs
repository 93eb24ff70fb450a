//! A server that gives no sound answer.

/// What an [`std::io::Error`] holds if a server is at fault, and neither the name nor this machine: it cannot be reached, fails, or
/// sends something else than was asked for.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{detail}")]
pub struct Unavailable {
    /// What it did.
    pub detail: String,
}

impl Unavailable {
    /// The error of the system that says so.
    #[cfg(feature = "s3")]
    pub(crate) fn error(detail: impl Into<String>) -> std::io::Error {
        std::io::Error::other(Self { detail: detail.into() })
    }
}
