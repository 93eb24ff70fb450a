//! Addresses of traces.

use rayreel_store::{Location, in_folder, is_remote};

use crate::target::{Target, text};

pub fn target() -> Target {
    Target { name: "url", seeds: urls, read: read_url, change: None, mend: None }
}

fn urls() -> Vec<Vec<u8>> {
    let all = [
        "https://me:word@host:8/a/b.rtrace?X-Amz-Signature=abc#x",
        "s3://bucket/f/t.rtrace",
        "gs://bucket/folder/",
        "../captures/a.rtrace",
        "http://[::1]:80/%2e%2e/a?b@c/d",
    ];
    all.map(|url| url.as_bytes().to_vec()).to_vec()
}

/// What is shown of a URL holds no part that may be a secret.
fn read_url(bytes: &[u8]) -> String {
    let url = text(bytes);
    let location = Location::from(&*url);
    let shown = location.to_string();
    if is_remote(&url) {
        let rest = shown.split_once("://").map_or("", |(_, rest)| rest);
        assert!(!shown.contains(['?', '#']), "{shown}");
        assert!(!rest.split('/').next().unwrap_or_default().contains('@'), "{shown}");
        assert_eq!(Location::from(&*shown).to_string(), shown, "what is shown is shown again");
    } else {
        assert_eq!(shown, url, "a path is shown as it is");
    }
    let joined = in_folder(&url, "t.rtrace");
    assert!(joined.contains("/t.rtrace") && is_remote(&joined) == is_remote(&url), "{joined}");
    format!("{} {}", is_remote(&url), location.has_secret())
}
