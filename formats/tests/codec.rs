//! Whole tiles through both codecs: nothing is lost, whatever the tile holds.

mod trace_support;

use rayreel_formats::Limits;
use rayreel_formats::tile::{Column, Tile};
use rayreel_formats::trace::{Codec, Scratch, Trace, compare, digest};
use trace_support::Random;
use trace_support::whole::{Content, read};

#[track_caller]
fn assert_same(a: &Tile, b: &Tile, what: &str) {
    for column in Column::ALL {
        assert!(a.canonical_bytes(column) == b.canonical_bytes(column), "{what}: column {}", column.name());
    }
    assert!(a == b, "{what}: equal bytes, but not equal");
}

/// A random trace through a file; the tile edge, the triangles, the depth and the lights are given. `scratch` has seen
/// other scenes before.
fn round_trip(seed: u64, edge: u32, triangles: u32, depth: u32, lights: u32, scratch: &mut Scratch) {
    let what = format!("seed {seed}, edge {edge}, {triangles} triangles, depth {depth}, {lights} lights");
    let content = Content::random(seed, (edge + edge / 2, edge), edge, triangles, depth, lights);
    for codec in [Codec::Plain(1), Codec::Context] {
        content.each(&Limits::default(), |coder, tile| {
            let encode = |scratch: &mut Scratch| coder.encode(tile, codec, scratch).expect("it encodes");
            assert_eq!(encode(scratch), encode(&mut Scratch::default()), "{what}: used memory against fresh");
        });
        let (_folder, path) = content.write(|_| codec);
        let trace = Trace::open(&path, Limits::default()).unwrap_or_else(|e| panic!("{what}: {e}"));
        for tile in &content.tiles {
            let used = trace.tile_with(tile.frame, tile.index, &Column::ALL, scratch);
            let fresh = trace.tile(tile.frame, tile.index, &Column::ALL);
            assert_same(tile, &used.unwrap_or_else(|e| panic!("{what}: {e}")), &what);
            assert_same(tile, &fresh.unwrap_or_else(|e| panic!("{what}: {e}")), &what);
        }
    }
}

#[test]
fn tiny_scenes_and_tiles() {
    let mut scratch = Scratch::default();
    for seed in 0..500 {
        let random = &mut Random(seed ^ 0xabcd);
        let edge = [1, 2, 3, 7][random.below(4) as usize];
        let triangles = [0, 1, 2, 3, 5, 40][random.below(6) as usize];
        round_trip(seed, edge, triangles, random.below(15), random.below(17), &mut scratch);
    }
}

#[test]
fn whole_tiles() {
    let mut scratch = Scratch::default();
    for (seed, edge) in [32, 64, 100, 32, 64].into_iter().enumerate() {
        let random = &mut Random(seed as u64);
        let triangles = [1, 3, 500, 20_000][random.below(4) as usize];
        round_trip(seed as u64, edge, triangles, [14, 4, 2, 0][seed % 4], random.below(5), &mut scratch);
    }
}

/// A chain of reflections down to the deepest class, and one of refractions.
#[test]
fn the_deepest_trees() {
    let mut scratch = Scratch::default();
    for seed in 0..40 {
        round_trip(seed, 8, 30, 14, 2, &mut scratch);
    }
    let content = Content::random(5, (9, 9), 9, 30, 14, 2);
    let deepest = content.tiles.iter().flat_map(|t| &t.tree.nodes).map(|n| n.class.depth()).max();
    assert_eq!(deepest, Some(14), "the test's trees should go to the end");
}

/// A NaN is no value that a tracer writes, but what is stored must come back.
#[test]
fn nan_and_infinite_t_come_back_bit_for_bit() {
    let mut content = Content::random(11, (6, 5), 8, 20, 3, 1);
    let specials = [f32::NAN, f32::INFINITY, -0.0, f32::from_bits(1), f32::from_bits(0xffc0_1234)];
    for tile in &mut content.tiles {
        tile.hits.iter_mut().zip(specials.iter().cycle()).filter(|(h, _)| h.t.is_finite()).for_each(|(h, &t)| h.t = t);
    }
    for codec in [Codec::Plain(1), Codec::Context] {
        let (_folder, path) = content.write(|_| codec);
        let trace = Trace::open(&path, Limits::default()).expect("it opens");
        for tile in &content.tiles {
            let back = trace.tile(tile.frame, tile.index, &Column::ALL).expect("it decodes");
            assert!(tile.canonical_bytes(Column::Hits) == back.canonical_bytes(Column::Hits), "{codec:?}");
        }
    }
}

/// Through files: raw lengths, digests, and comparison.
#[test]
fn traces_of_either_codec_say_the_same() {
    let content = Content::random(7, (50, 33), 16, 200, 5, 3);
    let (_a, plain) = content.write(|_| Codec::Plain(3));
    let (_b, context) = content.write(|_| Codec::Context);
    let open = |path| Trace::open(path, Limits::default()).expect("it opens");
    let (plain, context) = (open(&plain), open(&context));
    assert_eq!(read(&plain).expect("it reads"), content);
    assert_eq!(read(&context).expect("it reads"), content);
    for (column, (a, b)) in Column::ALL.iter().zip(plain.column_totals().iter().zip(context.column_totals())) {
        let canonical: usize = content.tiles.iter().map(|tile| tile.canonical_bytes(*column).len()).sum();
        assert_eq!((a.id, a.raw_bytes, b.raw_bytes), (*column as u8, canonical as u64, canonical as u64));
    }
    let digests = [&plain, &context].map(|t| digest(t).expect("it digests"));
    assert_eq!(digests[0], digests[1]);
    assert_eq!(compare(&plain, &context).expect("it compares"), None);
}

/// Every change of one value changes its own column's digest, and only that one, and `compare` finds its sample.
#[test]
fn one_changed_value_is_found() {
    let content = Content::random(8, (20, 12), 8, 50, 3, 2);
    let (_a, path) = content.write(|_| Codec::Context);
    let original = Trace::open(&path, Limits::default()).expect("it opens");
    let before = digest(&original).expect("it digests");
    type Change = fn(&mut Tile, usize);
    let changes: [(Column, Change); 4] = [
        (Column::Tree, |t, n| t.tree.nodes[n].shadows.0 ^= 1 << 1 | 1),
        (Column::Hits, |t, n| t.hits[n].t = f32::from_bits(t.hits[n].t.to_bits() ^ 1)),
        (Column::Radiance, |t, n| t.radiance[n].local.0[2] ^= 1),
        (Column::Paths, |t, n| t.paths.spans.swap(t.tree.ray_index()[n] as usize, 0)),
    ];
    for (column, change) in changes {
        let mut changed = Content::random(8, (20, 12), 8, 50, 3, 2);
        let tile = &mut changed.tiles[4];
        // A hit of one shadow ray whose state is blocked or lit: it can change to the other, and no ray comes or goes.
        let fits = |n: &usize| tile.tree.nodes[*n].hit && matches!(tile.tree.nodes[*n].shadows.0, 1 | 2) && *n > 0;
        let node = (0..tile.tree.nodes.len()).find(fits).expect("there is one");
        let ray = tile.tree.ray_index()[node] as usize;
        assert!(column != Column::Paths || tile.paths.ray(ray) != tile.paths.ray(0), "choose another seed");
        change(tile, node);
        let sample = (0..tile.tree.samples()).find(|&s| tile.tree.sample(s).contains(&node)).expect("it is in one");
        let first = if column == Column::Paths { 0 } else { sample };
        let (_b, path) = changed.write(|_| Codec::Context);
        let trace = Trace::open(&path, Limits::default()).expect("it opens");
        let after = digest(&trace).expect("it digests");
        for other in Column::ALL {
            let same = before.columns[other as usize] == after.columns[other as usize];
            assert_eq!(same, other != column, "digest of {} after a change of {}", other.name(), column.name());
        }
        let found = compare(&original, &trace).expect("it compares").expect("they differ").place;
        let place = format!("frame 3, tile 4, column {}, sample {first} (", column.name());
        assert!(found.starts_with(&place), "{found}, not {place}");
    }
}
