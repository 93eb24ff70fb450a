//! Where a trace is, as a user writes it.

use std::ffi::{OsStr, OsString};
use std::fmt;
use std::path::{Path, PathBuf};

/// A file or an object.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Location {
    /// A path on this machine.
    Local(PathBuf),
    /// A URL.
    Remote(String),
}

/// Whether text is a URL rather than a path: a scheme of letters, digits, `+`, `-` and `.`, then `://`.
pub fn is_remote(location: &str) -> bool {
    let Some((scheme, _)) = location.split_once("://") else { return false };
    scheme.starts_with(|c: char| c.is_ascii_alphabetic())
        && scheme.chars().all(|c| c.is_ascii_alphanumeric() || "+-.".contains(c))
}

impl Location {
    /// What messages call it: a URL without user, password, query and fragment, any of which may be a secret. Where a password seems to have
    /// a character in it that should be escaped, all that stands before the last `@` is left out. (`https://me:12/3@host` cannot be told from
    /// a host `me` with a port and a path.)
    fn shown(&self) -> String {
        match self {
            Self::Local(path) => path.display().to_string(),
            Self::Remote(url) => {
                let (scheme, rest) = url.split_once("://").unwrap_or(("", url));
                let rest = &rest[broken_password(rest)..];
                let rest = &rest[..rest.find(['?', '#']).unwrap_or(rest.len())];
                let (host, path) = rest.split_at(rest.find('/').unwrap_or(rest.len()));
                let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
                format!("{scheme}://{host}{path}")
            }
        }
    }

    /// The same where a path is asked for, as errors do. Nothing may be joined to it.
    pub(crate) fn as_name(&self) -> PathBuf {
        match self {
            Self::Local(path) => path.clone(),
            Self::Remote(_) => self.shown().into(),
        }
    }

    /// Whether it holds what is not shown: a user, a password or a query.
    pub fn has_secret(&self) -> bool {
        matches!(self, Self::Remote(url) if *url != self.shown())
    }

    /// The last part of path or URL: the same for a file and its copy in a bucket.
    pub fn file_name(&self) -> String {
        match self {
            Self::Local(path) => path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned(),
            Self::Remote(_) => {
                let shown = self.shown();
                shown.rsplit('/').next().unwrap_or_default().to_string()
            }
        }
    }
}

/// Where the host begins, if what stands in front of a slash, a query or a fragment seems to be the beginning of a user and a password that
/// has such a sign in it: an `@` follows, and it is no host with a port, or has an `@` itself and the other one is not in a query. Else 0.
fn broken_password(rest: &str) -> usize {
    let front = rest.split(['/', '?', '#']).next().unwrap_or_default();
    let (user, host) = front.rsplit_once('@').map_or((false, front), |(_, host)| (true, host));
    let end = match (is_host(host), user) {
        (true, false) => return 0,
        (true, true) => rest.find(['?', '#']).unwrap_or(rest.len()),
        (false, _) => rest.len(),
    };
    rest[front.len()..end].rfind('@').map_or(0, |at| front.len() + at + 1)
}

/// Whether text may be a host, with a port or without one.
fn is_host(text: &str) -> bool {
    let is_port = |port: &str| port.is_empty() || port.parse::<u16>().is_ok();
    match text.strip_prefix('[').and_then(|name| name.split_once(']')) {
        Some((_, behind)) => behind.strip_prefix(':').map_or(behind.is_empty(), is_port),
        None => !text.contains(['[', ']']) && text.split_once(':').is_none_or(|(_, port)| is_port(port)),
    }
}

/// The location of a file in a folder: the query of a URL stays behind its path.
pub fn in_folder(folder: &str, name: &str) -> String {
    let query = if is_remote(folder) { folder.find(['?', '#']) } else { None };
    let (path, query) = folder.split_at(query.unwrap_or(folder.len()));
    // The slashes of `s3://` are no slashes at the end of a folder.
    let kept = if is_remote(folder) { path.find("://").map_or(0, |at| at + 3) } else { 0 };
    let (scheme, path) = path.split_at(kept);
    format!("{scheme}{}/{name}{query}", path.trim_end_matches('/'))
}

impl fmt::Display for Location {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.shown())
    }
}

impl From<OsString> for Location {
    fn from(text: OsString) -> Self {
        match text.into_string() {
            Ok(url) if is_remote(&url) => Self::Remote(url),
            Ok(path) => Self::Local(path.into()),
            Err(path) => Self::Local(path.into()),
        }
    }
}

impl From<&OsStr> for Location {
    fn from(text: &OsStr) -> Self {
        text.to_os_string().into()
    }
}

impl From<&str> for Location {
    fn from(text: &str) -> Self {
        OsString::from(text).into()
    }
}

/// A path is a path, whatever it looks like.
impl From<&Path> for Location {
    fn from(path: &Path) -> Self {
        Self::Local(path.to_path_buf())
    }
}

impl From<&Self> for Location {
    fn from(location: &Self) -> Self {
        location.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn urls_are_told_from_paths() {
        for url in ["s3://b/k", "gs://b/k", "http://h:1/x?y", "https://h", "s3a+x://b"] {
            assert!(is_remote(url), "{url}");
        }
        for path in ["a.rtrace", "/a/b", "C:\\x", "./s3://b/k", "s3:/b/k", "://x", "3s://x", ""] {
            assert!(!is_remote(path), "{path}");
        }
    }

    #[test]
    fn no_secret_is_shown() {
        let location = Location::from("https://me:word@host:8/a/b.rtrace?X-Amz-Signature=abc#x");
        assert_eq!(location.to_string(), "https://host:8/a/b.rtrace");
        assert_eq!(location.file_name(), "b.rtrace");
        for (url, shown) in [
            ("https://me:wo/rd@host/x", "https://host/x"),
            ("https://me:wo#rd@host:8/x?y", "https://host:8/x"),
            ("https://alice@corp.com:pa/ss@host/x", "https://host/x"),
            ("https://me:p@s/word@host/x", "https://host/x"),
            ("https://me:a]b/c@host/x", "https://host/x"),
            ("https://me:word@[::1]:8/x", "https://[::1]:8/x"),
            ("https://me:word@host/x?sig=a@b", "https://host/x"),
            ("http://host:8/a@b/x", "http://host:8/a@b/x"),
            ("http://host/a@b/x", "http://host/a@b/x"),
            ("http://[::1]:8/a@b", "http://[::1]:8/a@b"),
        ] {
            assert_eq!(Location::from(url).to_string(), shown);
            assert_eq!(Location::from(shown).to_string(), shown, "what is shown is shown again");
        }
        assert!(location.has_secret() && !Location::from("https://host:8/a/b.rtrace").has_secret());
        assert_eq!(in_folder("https://h/a/?sig=x", "t"), "https://h/a/t?sig=x");
        assert_eq!((in_folder("s3://", "t"), in_folder("/", "t")), ("s3:///t".into(), "/t".into()));
        assert_eq!((in_folder("/a?b/", "t"), in_folder("s3://b", "t")), ("/a?b/t".into(), "s3://b/t".into()));
        assert_eq!(Location::from("s3://bucket/f/t.rtrace").to_string(), "s3://bucket/f/t.rtrace");
        assert_eq!(Location::from("f/t.rtrace").file_name(), "t.rtrace");
    }
}
