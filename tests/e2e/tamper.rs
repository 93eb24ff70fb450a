//! Traces with one wrong value and flawless checksums: `verify` finds what does not follow, `diff` what is not the same.

use std::path::{Path, PathBuf};

use rayreel_formats::bvh::Bvh;
use rayreel_formats::half::Half3;
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Light, Meta};
use rayreel_formats::tile::{ShadowState, Tile, step};
use rayreel_formats::trace::{Codec, Trace};

use crate::common::scenes::moving;
use crate::common::trace::{open, rewrite, rewrite_with};
use crate::common::{Ran, capture, digest};
use crate::rayreel;

/// A change of one sample of a tile; false if it does not apply to that sample.
type Change = fn(&mut Tile, usize) -> bool;

/// The changes that contradict the rest of the trace: name, the column that `diff` names, how.
const LIES: [(&str, &str, Change); 8] = [
    ("t by a bit", "hits", |tile, s| {
        on_hit(tile, s, |tile, i| tile.hits[i].t = f32::from_bits(tile.hits[i].t.to_bits() ^ 1))
    }),
    ("triangle", "hits", |tile, s| on_hit(tile, s, |tile, i| tile.hits[i].triangle ^= 1)),
    ("normal by a bit", "hits", |tile, s| {
        on_hit(tile, s, |tile, i| tile.hits[i].normal = Oct::from_bits(tile.hits[i].normal.to_bits() ^ 1))
    }),
    ("shadow state", "tree", shadow),
    ("weight of a child by a bit", "radiance", weight),
    ("step of a path", "paths", |tile, s| primary_path(tile, s, flip_first_test)),
    ("path of a shadow ray", "paths", shadow_path),
    ("t of a secondary ray", "hits", secondary_t),
];

fn on_hit(tile: &mut Tile, sample: usize, change: impl FnOnce(&mut Tile, usize)) -> bool {
    let node = tile.tree.sample(sample).start;
    let hit = tile.tree.nodes[node].hit;
    if hit {
        change(tile, node);
    }
    hit
}

fn shadow(tile: &mut Tile, sample: usize) -> bool {
    let node = &mut tile.tree.nodes[tile.tree.first[sample] as usize];
    let Some(light) = node.shadows.cast().next() else { return false };
    let other = if node.shadows.get(light) == ShadowState::Lit { ShadowState::Blocked } else { ShadowState::Lit };
    node.shadows.set(light, other);
    true
}

fn weight(tile: &mut Tile, sample: usize) -> bool {
    let node = tile.tree.sample(sample).start;
    let there = tile.tree.nodes[node].reflect;
    if there {
        tile.radiance[node].reflect.0[1] ^= 1;
    }
    there
}

fn secondary_t(tile: &mut Tile, sample: usize) -> bool {
    let node = tile.tree.sample(sample).skip(1).find(|&i| tile.tree.nodes[i].hit);
    if let Some(i) = node {
        tile.hits[i].t = f32::from_bits(tile.hits[i].t.to_bits() + 1);
    }
    node.is_some()
}

/// Changes the steps of ray `ray` of the tile: on a copy, since rays may share steps.
fn path_of(tile: &mut Tile, ray: usize, change: impl FnOnce(&mut [u8]) -> bool) -> bool {
    let mut path = tile.paths.ray(ray).to_vec();
    let changed = change(&mut path);
    if changed {
        tile.paths.spans[ray].0 = tile.paths.steps.len() as u32;
        tile.paths.steps.extend(path);
    }
    changed
}

fn primary_path(tile: &mut Tile, sample: usize, change: impl FnOnce(&mut [u8]) -> bool) -> bool {
    let ray = tile.tree.ray_index()[tile.tree.sample(sample).start] as usize;
    path_of(tile, ray, change)
}

fn shadow_path(tile: &mut Tile, sample: usize) -> bool {
    let node = tile.tree.sample(sample).start;
    let ray = tile.tree.ray_index()[node] as usize;
    tile.tree.nodes[node].shadows.count() > 0 && path_of(tile, ray + 1, flip_first_test)
}

fn flip_first_test(path: &mut [u8]) -> bool {
    let found = path.iter_mut().find(|s| **s == step::MISS);
    let changed = found.is_some();
    found.into_iter().for_each(|s| *s = step::HIT);
    changed
}

/// Where a change was made.
struct Place {
    frame: u32,
    tile: u32,
    sample: usize,
    x: u32,
    y: u32,
}

/// Rewrites `trace` with `change` made once: in the second half of the tiles of the last frame, not in the first samples.
fn lie(trace: &Trace, file: &Path, change: Change) -> Place {
    let meta = trace.meta();
    let (frame, first) = (meta.frame_numbers().end - 1, meta.tile_count() / 2);
    let mut place = None;
    rewrite(trace, file, Codec::Plain(1), |tile| {
        if tile.frame != frame || tile.index < first || place.is_some() {
            return;
        }
        let sample = (5..tile.tree.samples()).find(|&s| change(tile, s));
        place = sample.map(|sample| {
            let (column, row) = (sample as u32 % tile.rect.width, sample as u32 / tile.rect.width);
            Place { frame, tile: tile.index, sample, x: tile.rect.x + column, y: tile.rect.y + row }
        });
    });
    place.expect("the change applies somewhere")
}

fn traces(folder: &Path) -> Vec<PathBuf> {
    let (still, sequence) = (folder.join("still.rtrace"), folder.join("sequence.rtrace"));
    capture("cornell", "--size 48x40 --samples 1x1 --tile 16", &still);
    capture(&moving(folder), "--size 30x20 --samples 2x2 --tile 16 --frames 1..3", &sequence);
    vec![still, sequence]
}

#[test]
fn an_honest_copy_is_accepted() {
    let folder = tempfile::tempdir().unwrap();
    for file in traces(folder.path()) {
        for (i, codec) in [Codec::Plain(1), Codec::Context].into_iter().enumerate() {
            let copy = folder.path().join(format!("copy{i}.rtrace"));
            rewrite(&open(&file), &copy, codec, |_| {});
            rayreel!["verify", "--quiet", &copy].expect(0);
            assert_eq!(digest(&copy), digest(&file));
            let equal = rayreel!["diff", "--json", &file, &copy].expect(0).json();
            assert_eq!(equal["equal"], true);
        }
    }
}

#[test]
fn verify_names_a_lie() {
    let folder = tempfile::tempdir().unwrap();
    for file in traces(folder.path()) {
        let trace = open(&file);
        for (name, _, change) in LIES {
            let wrong = folder.path().join("wrong.rtrace");
            let at = lie(&trace, &wrong, change);
            let found = rayreel!["verify", "--quiet", "--json", &wrong].expect(1).json();
            assert_eq!(found["tiles_wrong"], 1, "{name}");
            let first = &found["first_mismatch"];
            let place = [("frame", at.frame), ("tile", at.tile), ("x", at.x), ("y", at.y)];
            place.iter().for_each(|(key, value)| assert_eq!(first[*key], *value, "{name}: {key} in {first}"));
            let text = rayreel!["verify", "--quiet", &wrong].expect(1).out;
            let words = format!("frame {}, tile {}, sample ({}, {})", at.frame, at.tile, at.x, at.y);
            assert!(text.contains(&words), "{name}: {text}");
        }
    }
}

#[test]
fn diff_names_the_first_difference() {
    let folder = tempfile::tempdir().unwrap();
    for file in traces(folder.path()) {
        let trace = open(&file);
        for (name, column, change) in LIES {
            let wrong = folder.path().join("wrong.rtrace");
            let at = lie(&trace, &wrong, change);
            let words = format!(
                "frame {}, tile {}, column {column}, sample {} (x {}, y {})",
                at.frame, at.tile, at.sample, at.x, at.y
            );
            let check = |ran: Ran| assert!(ran.out.contains(&words), "{name}: {} instead of {words}", ran.out);
            check(rayreel!["diff", &file, &wrong].expect(1));
            check(rayreel!["diff", "--json", &wrong, &file].expect(1));
            let (a, b) = (digest(&file), digest(&wrong));
            for other in ["meta", "bvh", "cameras", "tree", "hits", "radiance", "paths"] {
                assert_eq!(a[other] == b[other], other != column, "{name}: digest of {other}");
            }
            assert_ne!(a["total"], b["total"]);
        }
    }
}

/// A local colour cannot be checked without the scene; that it was changed can be seen all the same.
#[test]
fn a_repainted_sample_shows_in_diff_only() {
    let folder = tempfile::tempdir().unwrap();
    let file = traces(folder.path()).remove(0);
    let wrong = folder.path().join("wrong.rtrace");
    lie(&open(&file), &wrong, |tile, sample| {
        tile.radiance[tile.tree.first[sample] as usize].local = Half3([0x3c00, 0, 0]);
        true
    });
    rayreel!["verify", "--quiet", &wrong].expect(0);
    assert!(rayreel!["diff", &file, &wrong].expect(1).out.contains("column radiance"));
}

#[test]
fn diff_of_other_captures_names_the_setting() {
    let folder = tempfile::tempdir().unwrap();
    let (a, b) = (folder.path().join("a.rtrace"), folder.path().join("b.rtrace"));
    capture("cornell", "--size 32x20 --samples 1x1", &a);
    capture("cornell", "--size 32x24 --samples 1x1 --depth 2", &b);
    let said = rayreel!["diff", &a, &b].expect(1).out;
    assert!(said.starts_with("meta: ") && said.contains("32x20 | 32x24") && said.contains("depth: 4 | 2"), "{said}");
}

/// Changes of what only the scene knows: name, how, and what `verify --scene` says.
type TableLie = (&'static str, fn(&mut Meta, &mut Bvh), &'static str);

const TABLE_LIES: [TableLie; 4] = [
    ("all objects are one", |_, bvh| bvh.triangles.iter_mut().for_each(|t| t.object = 0), "triangles, first number "),
    ("an object's name", |_, bvh| bvh.objects[1].push('x'), "the names of objects"),
    (
        "the colour of a light",
        |meta, _| match &mut meta.lights[0] {
            Light::Point { colour, .. } | Light::Directional { colour, .. } => colour.x *= 0.5,
        },
        "the lights",
    ),
    ("the scene's hash", |meta, _| meta.scene_hash[0] ^= 1, "the hash of the scene's content"),
];

/// A trace agrees with itself whatever its tables call things: without the scene `verify` says that it believes them.
#[test]
fn tables_are_bound_by_the_scene() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, lie) = (folder.path().join("whole.rtrace"), folder.path().join("lie.rtrace"));
    capture("cornell", "--size 32x24", &whole);
    let told = rayreel!["verify", &whole].expect(0).out;
    assert!(told.contains("not bound to a scene: objects, colours"), "{told}");
    let told = rayreel!["verify", &whole, "--scene", "cornell"].expect(0).out;
    assert!(told.contains("as the scene: all tables, and 4 tiles traced again"), "{told}");
    let trace = open(&whole);
    for (name, change, words) in TABLE_LIES {
        let (mut meta, mut bvh) = (trace.meta().clone(), trace.bvh().clone());
        change(&mut meta, &mut bvh);
        rewrite_with(&trace, &lie, Codec::Context, (&meta, &bvh), |_| {});
        rayreel!["verify", &lie].expect(0);
        let told = rayreel!["verify", &lie, "--scene", "cornell"].expect(1).out;
        assert!(told.contains("differs from the scene: ") && told.contains(words), "{name}: {told}");
        std::fs::remove_file(&lie).unwrap();
    }
    // A colour follows from the scene alone.
    rewrite(&trace, &lie, Codec::Context, |tile| tile.radiance[0].local.0[0] ^= 1);
    rayreel!["verify", &lie].expect(0);
    let json = rayreel!["verify", "--json", &lie, "--scene", "cornell"].expect(1).json();
    assert_eq!((&json["scene"]["tiles_wrong"], &json["scene"]["tables_wrong"]), (&4.into(), &serde_json::json!([])));
    assert_eq!(json["scene"]["first_mismatch"], "the radiance of frame 0, tile 0");
    rayreel!["verify", &whole, "--scene", "teapot"].expect(1);
}
