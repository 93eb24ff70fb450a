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
    let fails = |url: &str, word: &str, code: i32| {
        let ran = rayreel(&format!("info {url}")).expect(code).says(&["cannot open", &shown, word]);
        assert!(!ran.err.contains("secret"), "{}", ran.err);
    };
    fails(&shown, "no such object", 2);
    server.state.lock().unwrap().whole_only = true;
    fails(&server.url(), "parts of files", 69);
    // That a server fails is no fault of the plan that names it.
    let plan = folder.path().join("p.toml");
    fs::write(&plan, format!("traces = [\"{}\"]\nmachines = [\"none\"]\npolicies = [\"full\"]\n", server.url()))
        .unwrap();
    let sweep = format!("sweep plan {} -o {}", plan.display(), folder.path().join("s").display());
    let ran = rayreel(&sweep).expect(69).says(&["p.toml:1:", "parts of files"]);
    assert!(!ran.err.contains("secret"), "{}", ran.err);
    server.state.lock().unwrap().whole_only = false;
    server.state.lock().unwrap().failures = 2;
    rayreel(&format!("info {}", server.url())).expect(0);
    server.state.lock().unwrap().failures = 1000;
    fails(&server.url(), "503", 69);
}

/// With a tag the library asks for the rest; without one it gives up, and the part is asked for again.
#[test]
fn answers_that_are_cut_short_are_asked_for_again() {
    let server = Server::start(fs::read(few()).unwrap());
    for tag in ["\"one\"", ""] {
        server.state.lock().unwrap().tag = tag.into();
        server.state.lock().unwrap().cuts = 2;
        let trace = rayreel_store::open(server.url().as_str(), &Options::default()).unwrap();
        server.state.lock().unwrap().cuts = 2;
        trace.tile(7, 1, &Column::ALL).unwrap();
        assert_eq!(server.state.lock().unwrap().cuts, 0, "tag {tag:?}");
    }
    server.state.lock().unwrap().cuts = 1000;
    let error = rayreel_store::open(server.url().as_str(), &Options { retries: 1, ..Options::default() }).unwrap_err();
    assert!(anyhow::Error::new(error).chain().any(|cause| cause.to_string().contains("cannot")), "it ends");
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

/// The plan, the results and every message held the signature.
#[test]
fn no_secret_of_a_url_is_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let server = Server::start(fs::read(small(folder.path(), "cornell")).unwrap());
    let place = folder.path().display();
    fs::write(
        folder.path().join("p.toml"),
        format!("traces = [{:?}]\npolicies = [\"full\"]\nmachines = [\"none\"]\n", server.url()),
    )
    .unwrap();
    rayreel(&format!("sweep plan --no-estimate {place}/p.toml -o {place}/s")).expect(0);
    let ran =
        rayreel(&format!("sweep run {place}/s --quiet")).expect(3).says(&["RAYREEL_TRACE_URLS", "no such object"]);
    assert!(!ran.err.contains("secret"), "{}", ran.err);
    // In one process the URL is known; elsewhere it comes from the environment.
    rayreel(&format!("sweep {place}/p.toml --quiet -o {place}/t")).expect(0);
    let run: Vec<_> = ["sweep", "run", &format!("{place}/s"), "--quiet"].map(std::ffi::OsString::from).to_vec();
    let ran = crate::common::command(&run).env("RAYREEL_TRACE_URLS", format!("x {}", server.url())).output().unwrap();
    assert!(ran.status.success(), "{}", String::from_utf8_lossy(&ran.stderr));
    let mut todo = vec![folder.path().join("s"), folder.path().join("t")];
    while let Some(path) = todo.pop() {
        if path.is_dir() {
            todo.extend(fs::read_dir(path).unwrap().map(|entry| entry.unwrap().path()));
        } else {
            let bytes = fs::read(&path).unwrap();
            assert!(!bytes.windows(6).any(|text| text == b"secret"), "{}", path.display());
        }
    }
    let csv = fs::read_to_string(folder.path().join("t/results.csv")).unwrap();
    assert!(csv.contains(",orbit.rtrace,"), "{csv}");
}

/// A corrupted answer went into the cache before its checksum was looked at, and stayed there.
#[test]
fn a_corrupted_answer_is_fetched_once_more() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = fs::read(few()).unwrap();
    let server = Server::start(bytes.clone());
    let cache = rayreel_store::CacheFolder { path: folder.path().to_path_buf(), max_bytes: u64::MAX };
    let options = || Options { cache: Some(cache.clone()), ..Options::default() };
    let spoil = |wrong: bool| {
        let mut state = server.state.lock().unwrap();
        // The middle of the file: tiles, and neither end.
        let middle = bytes.len() / 2;
        state.bytes = bytes.clone();
        state.bytes[middle - 2000..middle + 2000].iter_mut().for_each(|byte| *byte ^= u8::from(wrong));
    };
    let read = |trace: &rayreel_formats::trace::Trace| {
        let tiles =
            trace.meta().frame_numbers().flat_map(|frame| (0..trace.meta().tile_count()).map(move |t| (frame, t)));
        tiles
            .map(|(frame, tile)| trace.tile(frame, tile, &Column::ALL).map(|_| ()))
            .collect::<Result<Vec<_>, _>>()
            .map(|_| ())
    };
    let trace = rayreel_store::open(server.url().as_str(), &options()).unwrap();
    spoil(true);
    let error = read(&trace).unwrap_err().to_string();
    let kept = format!("fetched twice from the server, and the cache {} does not keep it", folder.path().display());
    assert!(error.contains("checksum") && error.contains(&kept), "{error}");
    // The server is well again: nothing of the wrong bytes is left.
    spoil(false);
    read(&trace).unwrap();
    read(&rayreel_store::open(server.url().as_str(), &options()).unwrap()).unwrap();
}
