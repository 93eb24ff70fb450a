//! How much of an object is read: little more than what is asked for.

use std::fs;
use std::ops::Range;
use std::path::Path;
use std::sync::Arc;

use rayreel_formats::Limits;
use rayreel_formats::container::ChunkId;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::Trace;
use rayreel_replay::{NamedPolicy, Options as ReplayOptions, replay};
use rayreel_store::Options;

use crate::moto::Moto;
use crate::server::Server;
use crate::{FRAMES, orbit};

/// Bytes of all tiles with their headers, and of those that `wanted` names.
fn tile_bytes(trace: &Trace, wanted: impl Fn(u32, u32) -> bool) -> (u64, u64) {
    let (mut all, mut some) = (0, 0);
    for frame in trace.meta().frame_numbers() {
        for tile in 0..trace.meta().tile_count() {
            let len = trace.reader().require(ChunkId::tile(frame, tile)).unwrap().total_len();
            all += len;
            some += if wanted(frame, tile) { len } else { 0 };
        }
    }
    (all, some)
}

/// Reads 5 % of the tiles of the object at `url` in several ways, and holds what that took against the bytes of all tiles.
fn read_a_twentieth(url: &str, file: &Path) {
    let local = Trace::open(file, Limits::default()).unwrap();
    let far = || {
        let options = Options::default();
        let trace = rayreel_store::open(url, &options).unwrap();
        let opened = options.traffic.fetched_bytes();
        (trace, Arc::clone(&options.traffic), opened)
    };
    let scattered = |frame: u32, tile: u32| (frame * 7 + tile) % 20 == 3;
    let one_frame = |frame: u32, _: u32| frame == 11;
    for (what, wanted) in
        [("scattered tiles", &scattered as &dyn Fn(u32, u32) -> bool), ("the tiles of a frame", &one_frame)]
    {
        let (trace, traffic, opened) = far();
        let before = traffic.requests();
        let mut tiles = 0;
        for frame in trace.meta().frame_numbers() {
            for tile in (0..trace.meta().tile_count()).filter(|&tile| wanted(frame, tile)) {
                assert_eq!(
                    trace.tile(frame, tile, &Column::ALL).unwrap(),
                    local.tile(frame, tile, &Column::ALL).unwrap()
                );
                tiles += 1;
            }
        }
        report(what, &local, wanted, tiles, traffic.fetched_bytes() - opened, traffic.requests() - before);
    }
    // A replay of one frame of twenty.
    let (trace, traffic, opened) = far();
    let before = traffic.requests();
    let policy = NamedPolicy::load("adaptive", &[]).unwrap();
    let frames: Range<u32> = 11..12;
    let there = replay(&trace, &policy.policy, frames.clone(), ReplayOptions::default()).unwrap().stats();
    let here = replay(&local, &policy.policy, frames, ReplayOptions::default()).unwrap().stats();
    assert_eq!(format!("{here:?}"), format!("{there:?}"));
    let tiles = trace.meta().tile_count();
    let read = traffic.fetched_bytes() - opened;
    report("a replay of a frame", &local, &one_frame, tiles, read, traffic.requests() - before);
}

fn report(what: &str, trace: &Trace, wanted: &dyn Fn(u32, u32) -> bool, tiles: u32, read: u64, requests: u64) {
    let (all, some) = tile_bytes(trace, wanted);
    let share = |bytes: u64| 100.0 * bytes as f64 / all as f64;
    println!(
        "{what}: {tiles} of {} tiles, {:.2} % of their bytes; read {read} of {all} bytes, {:.2} %, in {requests} requests",
        trace.meta().tile_count() * FRAMES,
        share(some),
        share(read)
    );
    assert!(share(some) > 3.0 && share(some) < 7.0, "{what} is about a twentieth");
    assert!(read as f64 <= 1.05 * some as f64 + 4096.0, "{what}: {read} bytes for {some}");
    assert!(requests <= u64::from(tiles * 2 + FRAMES), "{what}: {requests} requests");
}

#[test]
fn a_twentieth_of_the_tiles_is_a_twentieth_of_the_bytes_of_a_bucket() {
    let Some(moto) = Moto::start() else { return };
    let file = orbit();
    moto.put("/bucket", b"");
    moto.put("/bucket/orbit.rtrace", &fs::read(file).unwrap());
    read_a_twentieth(&format!("{}/bucket/orbit.rtrace", moto.endpoint()), file);
}

/// The server's own count.
#[test]
fn what_is_read_is_what_is_sent() {
    let file = orbit();
    let server = Server::start(fs::read(file).unwrap());
    read_a_twentieth(&server.url(), file);
    server.sent();
    let options = Options::default();
    let trace = rayreel_store::open(server.url().as_str(), &options).unwrap();
    let sent = server.sent();
    let bytes = |sent: &[Range<usize>]| sent.iter().map(|range| range.len() as u64).sum::<u64>();
    println!("opening: {} bytes in {} requests", bytes(&sent), sent.len());
    assert!(sent.len() <= 4, "{sent:?}");
    for frame in trace.meta().frame_numbers() {
        for tile in 0..trace.meta().tile_count() {
            trace.tile(frame, tile, &Column::ALL).unwrap();
        }
    }
    let rest = server.sent();
    println!("all tiles: {} bytes in {} requests", bytes(&rest), rest.len());
    assert_eq!(bytes(&sent) + bytes(&rest), options.traffic.fetched_bytes());
    assert_eq!((sent.len() + rest.len()) as u64, options.traffic.requests());
    assert!(bytes(&sent) + bytes(&rest) < trace.reader().len() + (128 << 10), "nothing much is read twice");
    assert!(rest.len() < (trace.meta().tile_count() * FRAMES / 2) as usize, "neighbours come together: {}", rest.len());
}
