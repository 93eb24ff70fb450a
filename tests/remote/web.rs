//! `http://`: what web servers do and do not do.

use std::fs;

use rayreel_formats::tile::Column;
use rayreel_store::Options;

use crate::common::replay;
use crate::moto;
use crate::server::Server;
use crate::{few, small};

fn rayreel(line: &str) -> crate::common::Ran {
    moto::run(line, "http://127.0.0.1:9", "none")
}

#[test]
fn a_replay_of_a_web_address_is_that_of_the_file() {
    let folder = tempfile::tempdir().unwrap();
    let file = small(folder.path(), "cornell");
    let server = Server::start(fs::read(&file).unwrap());
    let far = rayreel(&format!("replay {} --quiet --json --machine none", server.url())).expect(0).out;
    assert_eq!(far.replace("orbit.rtrace", "cornell.rtrace"), replay(&file, "").expect(0).out);
    assert!(!far.contains("secret"));
}

#[test]
fn faults_of_a_server_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(fs::read(small(folder.path(), "cornell")).unwrap());
    let shown = server.url().replace("?key=secret", "");
    let fails = |url: &str, word: &str| {
        let ran = rayreel(&format!("info {url}")).expect(2).says(&["cannot open", &shown, word]);
        assert!(!ran.err.contains("secret"), "{}", ran.err);
    };
    fails(&shown, "no such object");
    server.state.lock().unwrap().whole_only = true;
    fails(&server.url(), "parts of files");
    server.state.lock().unwrap().whole_only = false;
    server.state.lock().unwrap().failures = 2;
    rayreel(&format!("info {}", server.url())).expect(0);
    server.state.lock().unwrap().failures = 1000;
    fails(&server.url(), "503");
}

#[test]
fn two_versions_are_not_mixed() {
    let bytes = fs::read(few()).unwrap();
    let server = Server::start(bytes);
    let trace = rayreel_store::open(server.url().as_str(), &Options::default()).unwrap();
    trace.tile(0, 1, &Column::ALL).unwrap();
    server.state.lock().unwrap().tag = "\"two\"".into();
    let error = trace.tile(7, 1, &Column::ALL).unwrap_err();
    let text = anyhow::Error::new(error).chain().map(ToString::to_string).collect::<Vec<_>>().join(": ");
    assert!(text.contains("folder/orbit.rtrace") && text.contains("was replaced"), "{text}");
}

/// Many threads at once, as a replay reads.
#[test]
fn threads_share_what_is_fetched() {
    let bytes = fs::read(few()).unwrap();
    let len = bytes.len() as u64;
    let server = Server::start(bytes);
    let options = Options::default();
    let trace = rayreel_store::open(server.url().as_str(), &options).unwrap();
    std::thread::scope(|scope| {
        for _ in 0..4 {
            scope.spawn(|| {
                for frame in trace.meta().frame_numbers() {
                    for tile in 0..trace.meta().tile_count() {
                        trace.tile(frame, tile, &Column::ALL).unwrap();
                    }
                }
            });
        }
    });
    let read = options.traffic.fetched_bytes();
    assert!(read < len + len / 4 + (128 << 10), "4 threads that read all of {len} bytes fetched {read}");
}
