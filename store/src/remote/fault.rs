//! What an object store's error means to whoever gave the location.

use std::io;

use object_store::Error;

use crate::unavailable::Unavailable;

/// Longest answer of a server that is repeated, in characters.
const ANSWER_MAX: usize = 300;

/// The error in a line, without the URL that was asked for: its query may be a signature.
pub(super) fn explain(error: &Error) -> io::Error {
    let cause = root(error);
    match error {
        Error::NotFound { .. } if cause.contains("NoSuchBucket") => {
            io::Error::new(io::ErrorKind::NotFound, "there is no such bucket")
        }
        Error::NotFound { .. } => io::Error::new(io::ErrorKind::NotFound, "there is no such object"),
        Error::PermissionDenied { .. } | Error::Unauthenticated { .. } => {
            let detail = format!("access is denied; are the credentials in the environment? {cause}");
            io::Error::new(io::ErrorKind::PermissionDenied, detail)
        }
        _ if cause.contains("URL scheme is not allowed") => io::Error::new(
            io::ErrorKind::InvalidInput,
            "the endpoint is plain http://, which needs AWS_ALLOW_HTTP=true",
        ),
        // HTTP stores say so by kind, the others in words.
        _ if matches!(error, Error::NotSupported { .. }) || cause.contains("non-partial response") => {
            Unavailable::error("the server does not serve parts of files (range requests)")
        }
        _ => Unavailable::error(cause),
    }
}

/// The innermost cause: what lies around it is the library's way to it.
fn root(error: &Error) -> String {
    let mut cause: &dyn std::error::Error = error;
    while let Some(source) = cause.source() {
        cause = source;
    }
    let text = cause.to_string();
    let text = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if text.chars().count() <= ANSWER_MAX { text } else { text.chars().take(ANSWER_MAX).chain("...".chars()).collect() }
}
