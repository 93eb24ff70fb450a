//! The cache folder: what it saves, and that it is never trusted.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rayreel_formats::trace::{Trace, digest};
use rayreel_store::{CacheFolder, Options, Traffic};

use crate::server::Server;
use crate::{few, moto, small};

fn options(folder: &Path, max_bytes: u64) -> Options {
    Options { cache: Some(CacheFolder { path: folder.to_path_buf(), max_bytes }), ..Options::default() }
}

/// Reads all of the trace; gives its digest and what that took.
fn read(server: &Server, folder: &Path) -> (String, Arc<Traffic>) {
    let options = options(folder, u64::MAX);
    let trace = rayreel_store::open(server.url().as_str(), &options).unwrap();
    (digest(&trace).unwrap().total().to_string(), options.traffic)
}

fn digest_of(file: &Path) -> String {
    digest(&Trace::open(file, Default::default()).unwrap()).unwrap().total().to_string()
}

/// The blocks in a cache, by name.
fn blocks(folder: &Path) -> Vec<PathBuf> {
    let list = |folder: &Path| fs::read_dir(folder).unwrap().map(|e| e.unwrap().path()).collect::<Vec<_>>();
    let objects = list(folder).into_iter().filter(|path| path.is_dir());
    let mut blocks: Vec<_> = objects.flat_map(|object| list(&object)).collect();
    blocks.retain(|path| !path.ends_with("object"));
    blocks.sort();
    blocks
}

#[test]
fn what_was_fetched_is_not_fetched_again() {
    let folder = tempfile::tempdir().unwrap();
    let (file, cache) = (few(), folder.path().join("cache"));
    let server = Server::start(fs::read(file).unwrap());
    let (first, _) = read(&server, &cache);
    assert_eq!(first, digest_of(file));
    assert!(server.sent().len() > 10);
    let (second, traffic) = read(&server, &cache);
    assert_eq!(first, second);
    assert_eq!(server.sent().len(), 1, "only its end, which says that it is the same");
    assert!(traffic.cached_bytes() > fs::metadata(file).unwrap().len() - (128 << 10), "{traffic}");
    assert!(blocks(&cache).iter().all(|path| !path.file_name().unwrap().to_str().unwrap().starts_with('.')));
    let label = fs::read_to_string(blocks(&cache)[0].with_file_name("object")).unwrap();
    assert!(label.contains("orbit.rtrace") && label.contains("one") && !label.contains("secret"), "{label}");
}

#[test]
fn damaged_blocks_are_fetched_again() {
    let folder = tempfile::tempdir().unwrap();
    let (file, cache) = (few(), folder.path().join("cache"));
    let server = Server::start(fs::read(file).unwrap());
    let (first, _) = read(&server, &cache);
    let blocks = blocks(&cache);
    let damage = |at: usize, how: &dyn Fn(&mut Vec<u8>)| {
        let mut bytes = fs::read(&blocks[at]).unwrap();
        how(&mut bytes);
        fs::write(&blocks[at], bytes).unwrap();
    };
    damage(1, &|bytes| bytes.truncate(bytes.len() / 2));
    damage(2, &|bytes| bytes.clear());
    damage(3, &|bytes| bytes[7] ^= 1);
    // The bytes of another place.
    fs::copy(&blocks[5], &blocks[4]).unwrap();
    fs::remove_file(&blocks[6]).unwrap();
    server.sent();
    let (second, _) = read(&server, &cache);
    assert_eq!(first, second);
    let sent = server.sent().len();
    assert!((6..=10).contains(&sent), "five blocks and the end: {sent}");
    read(&server, &cache);
    assert_eq!(server.sent().len(), 1, "all is whole again");
}

#[test]
fn another_version_is_another_object() {
    let folder = tempfile::tempdir().unwrap();
    let cache = folder.path().join("cache");
    let (one, two) = (small(folder.path(), "cornell"), small(folder.path(), "teapot"));
    let server = Server::start(fs::read(&one).unwrap());
    assert_eq!(read(&server, &cache).0, digest_of(&one));
    {
        let mut state = server.state.lock().unwrap();
        state.bytes = fs::read(&two).unwrap();
        state.tag = "\"two\"".into();
    }
    assert_eq!(read(&server, &cache).0, digest_of(&two));
    // A server that names no version: nothing is kept, since nothing would say whether it still holds.
    server.state.lock().unwrap().tag.clear();
    let kept = blocks(&cache).len();
    assert_eq!(read(&server, &cache).0, digest_of(&two));
    assert_eq!(blocks(&cache).len(), kept);
}

#[test]
fn the_cache_is_bounded() {
    let folder = tempfile::tempdir().unwrap();
    let (file, cache) = (few(), folder.path().join("cache"));
    let bytes = fs::read(file).unwrap();
    let size = |cache: &Path| blocks(cache).iter().map(|path| fs::metadata(path).unwrap().len() - 32).sum::<u64>();
    let max = bytes.len() as u64 / 2;
    let (one, two) = (Server::start(bytes.clone()), Server::start(bytes));
    for server in [&one, &two] {
        let trace = rayreel_store::open(server.url().as_str(), &options(&cache, max)).unwrap();
        digest(&trace).unwrap();
        assert!(size(&cache) > max / 2 && size(&cache) <= max, "{} of {max}", size(&cache));
    }
    // What is no object of ours stays.
    fs::write(cache.join("mine"), "x").unwrap();
    fs::create_dir(cache.join("folder")).unwrap();
    let trace = rayreel_store::open(one.url().as_str(), &options(&cache, 0)).unwrap();
    assert_eq!(digest(&trace).unwrap().total().to_string(), digest_of(file));
    assert!(cache.join("mine").exists() && cache.join("folder").exists());
    assert!(size(&cache) <= max);
}

/// Processes that share a folder, some of them killed, and the folder deleted under them.
#[cfg(unix)]
#[test]
fn processes_share_the_folder() {
    let folder = tempfile::tempdir().unwrap();
    let (file, cache) = (few(), folder.path().join("cache"));
    let server = Server::start(fs::read(file).unwrap());
    let start = || {
        let args = ["digest", &server.url(), "--trace-cache", cache.to_str().unwrap()].map(Into::into);
        crate::common::command(&args).spawn().unwrap()
    };
    for millis in [5, 15, 30, 60] {
        let mut child = start();
        std::thread::sleep(std::time::Duration::from_millis(millis));
        child.kill().unwrap();
        child.wait().unwrap();
    }
    let wanted = digest_of(file);
    let children: Vec<_> = (0..3).map(|_| start()).collect();
    fs::remove_dir_all(&cache).ok();
    for child in children {
        let output = child.wait_with_output().unwrap();
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        assert!(output.status.success() && text.contains(&wanted), "{text}{}", String::from_utf8_lossy(&output.stderr));
    }
    assert_eq!(read(&server, &cache).0, wanted);
}

#[test]
fn the_flag_goes_before_the_variable() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a"), folder.path().join("b"));
    let server = Server::start(fs::read(small(folder.path(), "cornell")).unwrap());
    let run = |options: &str| {
        let line = format!("digest {} {options}", server.url());
        moto::run(&line, "http://127.0.0.1:9", a.to_str().unwrap()).expect(0);
        (a.exists(), b.exists())
    };
    assert_eq!(run("--trace-cache none"), (false, false));
    assert_eq!(run(&format!("--trace-cache {}", b.display())), (false, true));
    assert_eq!(run(""), (true, true));
}
