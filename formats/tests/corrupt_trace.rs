//! A whole trace in the hands of an attacker: an error, or what was written; never a panic, a hang, or memory beyond
//! the limits.
//!
//! `container_corruption.rs` does this for the container with payloads that mean nothing; here metadata, BVH, cameras
//! and columns of both codecs are decoded too. `RAYREEL_LONG=1` tells fifty times as many lies.

mod trace_support;

use std::sync::Arc;
use std::time::{Duration, Instant};

use rayreel_formats::budget::Budget;
use rayreel_formats::bvh::Child;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Codec, LeafTests, PackedColumn, PathSink, Scratch, Trace};
use rayreel_formats::{Error, Limits};
use trace_support::Random;
use trace_support::forge::{Chunk, change, put_together, take_apart};
use trace_support::whole::{Content, read_bytes};

/// Longest that reading any forged trace may take. The machine may be busy; a hang is much longer.
const PATIENCE: Duration = Duration::from_secs(10);

/// Two frames of two tiles each, one of each codec.
fn sample() -> Content {
    Content::random(21, (7, 4), 4, 6, 3, 2)
}

fn mixed(tile: &rayreel_formats::tile::Tile) -> Codec {
    if tile.index == 0 { Codec::Context } else { Codec::Plain(9) }
}

/// What a small machine would allow: enough for the sample.
fn small() -> Limits {
    Limits {
        max_chunk_packed_bytes: 1 << 16,
        max_chunk_raw_bytes: 1 << 17,
        max_index_entries: 4096,
        max_columns_per_tile: 8,
        max_samples_per_tile: 4096,
        max_nodes_per_tile: 1 << 14,
        max_path_steps_per_tile: 1 << 17,
        max_bvh_nodes: 1 << 12,
        max_triangles: 1 << 12,
        max_metadata_bytes: 1 << 16,
        ..Limits::default()
    }
}

/// Reads everything, and complains of panics by the seed, and of slowness.
fn read_in_time(bytes: Vec<u8>, limits: &Limits, what: &str) -> Result<Content, Error> {
    let start = Instant::now();
    let read = std::panic::catch_unwind(|| read_bytes(bytes, limits));
    let took = start.elapsed();
    assert!(took < PATIENCE, "{what}: {took:?}");
    read.unwrap_or_else(|_| panic!("{what}: reading panicked"))
}

fn rounds(normally: u64) -> u64 {
    let normally = if cfg!(debug_assertions) { normally / 5 } else { normally };
    if std::env::var_os("RAYREEL_LONG").is_some() { normally * 50 } else { normally }
}

#[test]
fn every_flipped_byte_is_noticed() {
    let content = sample();
    let whole = content.bytes(mixed);
    assert_eq!(read_bytes(whole.clone(), &small()).expect("a good trace"), content);
    for at in 0..whole.len() {
        for flip in [0x01, 0x10, 0x80, 0xff] {
            let mut bytes = whole.clone();
            bytes[at] ^= flip;
            if let Ok(found) = read_in_time(bytes, &small(), &format!("byte {at} ^ {flip:#x}")) {
                assert_eq!(found, content, "byte {at} ^ {flip:#x}");
            }
        }
    }
}

#[test]
fn every_truncation_is_noticed() {
    let whole = sample().bytes(mixed);
    for len in 0..whole.len() {
        assert!(read_in_time(whole[..len].to_vec(), &small(), &format!("{len} bytes")).is_err(), "{len} bytes");
    }
}

/// Overwrites, flips, cuts or lengthens.
fn damage(random: &mut Random, bytes: &mut Vec<u8>) {
    if bytes.is_empty() {
        bytes.push(random.next() as u8);
    }
    let at = random.below(bytes.len() as u32) as usize;
    match random.below(8) {
        0..3 => bytes[at] ^= 1 << random.below(8),
        3 => bytes[at] = [0, 1, 0x7f, 0x80, 0xff][random.below(5) as usize],
        4 => {
            let word = [0, u32::MAX, 1 << 31, 1 << 30, random.next()][random.below(5) as usize];
            bytes.iter_mut().skip(at).zip(word.to_le_bytes()).for_each(|(b, new)| *b = new);
        }
        5 => bytes.truncate(at),
        6 => bytes.extend((0..random.below(40)).map(|_| random.next() as u8)),
        _ => bytes[at..].iter_mut().for_each(|b| *b = random.next() as u8),
    }
}

/// Checksums, lengths and index are right, and zstd's frames are good: only the payloads lie.
#[test]
fn lies_under_good_checksums_never_panic() {
    let chunks = take_apart(&sample().bytes(mixed));
    let mut strings = 0;
    change(&mut chunks.clone(), |_, _, _| strings += 1);
    let (mut good, mut bad) = (0, 0);
    for seed in 0..rounds(6000) {
        let random = &mut Random(seed);
        let mut forged = chunks.clone();
        // Mostly one lie, so that what comes behind it is reached.
        let (target, all) = (random.below(strings), random.once_in(10));
        let mut number = 0;
        change(&mut forged, |_, _, bytes| {
            if number == target || all && random.once_in(3) {
                damage(random, bytes);
            }
            number += 1;
        });
        match read_in_time(put_together(&forged), &small(), &format!("seed {seed}")) {
            Ok(_) => good += 1,
            Err(error) => {
                bad += 1;
                assert!(!error.to_string().is_empty());
            }
        }
    }
    assert!(good > 100 && bad > 100, "{good} were read, {bad} refused: the test is one-sided");
}

/// Columns of nothing but noise, for scenes of many kinds.
#[test]
fn noise_for_columns_never_panics() {
    for seed in 0..rounds(300) {
        let random = &mut Random(seed);
        let triangles = [0, 1, 3, 60][random.below(4) as usize];
        let content = Content::random(seed, (9, 5), 8, triangles, random.below(15), random.below(17));
        let mut chunks = take_apart(&content.bytes(|_| Codec::Context));
        let first = random.below(4) as u8;
        change(&mut chunks, |_, column, bytes| {
            if column.is_some_and(|c| c >= first) {
                let length = random.below(400);
                *bytes = (0..length).map(|_| random.next() as u8).collect();
                if column == Some(Column::Paths as u8) && random.once_in(2) {
                    // No runs, so that the main stream is reached.
                    bytes.iter_mut().take(4 * random.below(7) as usize).for_each(|b| *b = 0);
                }
            }
        });
        let _ = read_in_time(put_together(&chunks), &small(), &format!("seed {seed}"));
    }
}

fn tile_of(chunks: &mut [Chunk], codec: u8, column: Column) -> &mut rayreel_formats::container::ColumnEntry {
    let columns = chunks.iter_mut().filter_map(|chunk| match chunk {
        Chunk::Tile(_, columns) => columns.iter_mut().find(|c| c.id == column as u8 && c.codec == codec),
        Chunk::Payload(..) => None,
    });
    columns.into_iter().next().expect("the sample has tiles of both codecs")
}

/// Lengths that no machine can give.
#[test]
fn absurd_lengths_are_refused() {
    let chunks = take_apart(&sample().bytes(mixed));
    for (codec, column) in [(0, Column::Tree), (0, Column::Paths), (1, Column::Tree), (1, Column::Paths)] {
        for length in [1 << 60, u64::MAX, 1 << 32] {
            let mut forged = chunks.clone();
            tile_of(&mut forged, codec, column).raw_len = length;
            let read = read_in_time(put_together(&forged), &Limits::default(), "a length");
            assert!(matches!(read, Err(Error::LimitExceeded { .. })), "{column:?} of {length}: {read:?}");
        }
    }
    for at in [0, 4, 8, 12] {
        let mut forged = chunks.clone();
        change(&mut forged, |id, _, bytes| {
            if id == rayreel_formats::container::ChunkId::BVH {
                bytes[at..at + 4].copy_from_slice(&u32::MAX.to_le_bytes());
            }
        });
        assert!(read_in_time(put_together(&forged), &Limits::default(), "a count").is_err(), "BVH count {at}");
    }
}

/// A tree whose bytes are worth far less is refused for that, since more memory would not help; a sound one for the memory alone.
#[test]
fn trees_are_earned_and_fit_into_the_memory() {
    let mut chunks = take_apart(&sample().bytes(mixed));
    let refusal = |chunks: &[Chunk], memory| {
        let limits = Limits { memory: Arc::new(Budget::new(memory)), ..Limits::default() };
        read_in_time(put_together(chunks), &limits, "a tree").unwrap_err().to_string()
    };
    assert!(refusal(&chunks, 300).contains("memory for decoding"));
    change(&mut chunks, |id, _, bytes| {
        if id == rayreel_formats::container::ChunkId::BVH {
            *bytes = vec![0; 40 << 20];
        }
    });
    assert!(refusal(&chunks, 300).contains("raw length of a chunk"));
}

/// Each limit refuses the sample when it is a little too low for it, in both codecs.
#[test]
fn every_limit_binds() {
    let content = sample();
    let most = |f: &dyn Fn(&rayreel_formats::tile::Tile) -> u64| content.tiles.iter().map(f).max().unwrap_or(0);
    let nodes = most(&|t| t.tree.nodes.len() as u64);
    for codec in [Codec::Context, Codec::Plain(3)] {
        let bytes = content.bytes(|_| codec);
        let (bvh_nodes, triangles) = (content.bvh.nodes.len() as u64, content.bvh.triangles.len() as u64);
        let exact = Limits { max_nodes_per_tile: nodes, max_bvh_nodes: bvh_nodes, max_triangles: triangles, ..small() };
        assert!(read_bytes(bytes.clone(), &exact).is_ok(), "{codec:?}: what just fits is read");
        let pixels = u64::from(content.meta.width) * u64::from(content.meta.height);
        assert!(read_bytes(bytes.clone(), &Limits { max_pixels: pixels, ..small() }).is_ok());
        let cases: [(&str, Limits); 10] = [
            ("pixels", Limits { max_pixels: pixels - 1, ..small() }),
            ("nodes", Limits { max_nodes_per_tile: nodes - 1, ..small() }),
            ("steps", Limits { max_path_steps_per_tile: 10, ..small() }),
            ("samples", Limits { max_samples_per_tile: 15, ..small() }),
            ("bvh nodes", Limits { max_bvh_nodes: bvh_nodes - 1, ..small() }),
            ("triangles", Limits { max_triangles: triangles - 1, ..small() }),
            ("metadata", Limits { max_metadata_bytes: 50, ..small() }),
            ("index", Limits { max_index_entries: 7, ..small() }),
            ("columns", Limits { max_columns_per_tile: 3, ..small() }),
            ("raw bytes", Limits { max_chunk_raw_bytes: 300, ..small() }),
        ];
        for (name, limits) in cases {
            assert!(read_bytes(bytes.clone(), &limits).is_err(), "{codec:?}: the limit on {name} does not bind");
        }
    }
}

/// A raw length that is not the column's is a lie, even where the decoder could do without it.
#[test]
fn raw_lengths_are_checked() {
    let chunks = take_apart(&sample().bytes(mixed));
    for codec in [0, 1] {
        for column in Column::ALL {
            let mut forged = chunks.clone();
            tile_of(&mut forged, codec, column).raw_len += 1;
            let read = read_bytes(put_together(&forged), &small());
            assert!(read.is_err(), "codec {codec}, column {}: a wrong raw length was accepted", column.name());
        }
    }
}

/// Counts the steps that it is given.
#[derive(Default)]
struct Counted(u64);

impl PathSink for Counted {
    fn visit(&mut self, _: u32, _: u8) {
        self.0 += 1;
    }
    fn leaf(&mut self, _: Child, tests: LeafTests) {
        self.0 += u64::from(tests.count());
    }
    fn pop(&mut self, _: u32, _: bool) {
        self.0 += 1;
    }
    fn end(&mut self, _: bool, _: u32) {}
}

/// The share of the memory is taken by what the directory promises, so no more than that is decoded.
#[test]
fn paths_have_no_more_steps_than_their_directory_promises() {
    let content = Content::random(21, (16, 16), 16, 40, 3, 2);
    let trace = Trace::from_bytes(content.bytes(|_| Codec::Context), Limits::default()).expect("it opens");
    let (tile, packed) = trace.packed_tile(3, 0).expect("it is there");
    let (rays, scratch) = (tile.tree.ray_count(), &mut Scratch::default());
    assert!(trace.paths(&tile, &packed, scratch).expect("they are sound") == content.tiles[0].paths);
    let mut all = Counted::default();
    trace.paths_to(&tile, &packed, scratch, &mut all).expect("they are sound");
    let cases = [
        (0, "too few for"),
        (4 * rays - 1, "too few for"),
        (4 * rays, "more steps than the directory promises"),
        (4 * rays + all.0 / 2, "more steps than the directory promises"),
        (4 * rays + all.0 - 1, "more steps than the directory promises"),
    ];
    for (raw_len, why) in cases {
        let lie = PackedColumn { raw_len, ..packed.clone() };
        let mut seen = Counted::default();
        let errors = [
            trace.paths(&tile, &lie, scratch).map(drop).expect_err("a lie").to_string(),
            trace.paths_to(&tile, &lie, scratch, &mut seen).map(drop).expect_err("a lie").to_string(),
        ];
        for error in errors {
            assert!(error.contains("column paths") && error.contains(why), "{raw_len}: {error}");
        }
        // The end of one path, its pops and the tests of a leaf, may be out before it is noticed.
        assert!(seen.0 <= raw_len.saturating_sub(4 * rays) + 150, "{raw_len}: {} steps came", seen.0);
    }
}

/// A tree of misses has no canonical bytes of hits, and a list of them all the same.
#[test]
fn misses_take_their_share_of_the_memory() {
    let content = Content::random(4, (32, 32), 32, 0, 1, 1);
    let bytes = content.bytes(|_| Codec::Context);
    let open = |memory| {
        let limits = Limits { memory: Arc::new(Budget::new(memory)), ..Limits::default() };
        Trace::from_bytes(bytes.clone(), limits).expect("it opens")
    };
    let hits = |memory| open(memory).tile(3, 0, &[Column::Hits]);
    assert!(open(20_000).tile(3, 0, &[Column::Tree]).is_ok());
    assert!(hits(20_000).expect_err("1024 nodes take more").to_string().contains("memory for decoding"));
    assert_eq!(hits(30_000).expect("they fit").hits, content.tiles[0].hits);
}

/// A small file that claims many frames costs no more than what it holds.
#[test]
fn frames_that_are_not_there_cost_little() {
    let mut content = sample();
    content.meta.frames = 1 << 25;
    let start = Instant::now();
    let refused = Trace::from_bytes(content.bytes(mixed), Limits::default());
    assert!(matches!(refused, Err(rayreel_formats::Error::LimitExceeded { what: "number of tiles", .. })));
    content.meta.frames = 1 << 20;
    let bytes = content.bytes(mixed);
    let trace = Trace::from_bytes(bytes, Limits::default()).expect("an incomplete trace can be opened");
    assert!(trace.tile(3, 0, &Column::ALL).is_ok() && trace.camera(5).is_err());
    assert!(start.elapsed() < PATIENCE, "{:?}", start.elapsed());
}
