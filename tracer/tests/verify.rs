//! `verify` takes every honest capture and refuses every tampered one, naming tile and sample.

mod support;

use rayreel_formats::tile::{Hit, ShadowState, Tile, step};
use rayreel_formats::trace::Codec;
use rayreel_tracer::verify::verify;
use support::recorded::{Recorded, grid, record, rewrite, tiles};
use support::{Random, builtin, cutout};

#[track_caller]
fn assert_verifies(recorded: &Recorded, what: &str) {
    let rays: u64 = tiles(&recorded.trace).iter().map(|t| t.tree.ray_count()).sum();
    let verified = verify(&recorded.trace, |_| true).expect("it verifies");
    assert_eq!(verified.first, None, "{what}");
    assert_eq!((verified.rays, verified.tiles_wrong), (rays, 0), "{what}");
    assert_eq!(verified.tiles, u64::from(recorded.trace.meta().tile_count()), "{what}");
}

#[test]
fn honest_captures_of_the_built_in_scenes() {
    for (name, width, height) in [("cornell", 61, 31), ("teapot", 64, 32), ("chess", 47, 29)] {
        let scene = builtin(name);
        for (samples, tile, depth) in [(1, 32, 4), (2, 32, 3), (1, 7, 6), (2, 1024, 0)] {
            let recorded = record(&scene, grid(width, height, samples, tile), depth, Codec::Context);
            assert_verifies(&recorded, &format!("{name}, {samples}x{samples}, tiles of {tile}, depth {depth}"));
        }
    }
}

#[test]
fn honest_captures_with_cut_outs_and_many_lights() {
    for lights in [0, 1, 3, 16] {
        let scene = cutout::scene(lights);
        for depth in 0..=6 {
            let codec = if depth % 2 == 0 { Codec::Context } else { Codec::Plain(1) };
            let recorded = record(&scene, grid(33, 21, 1 + depth % 2, 16), depth, codec);
            assert_verifies(&recorded, &format!("{lights} lights, depth {depth}"));
        }
    }
}

/// The scene of the tests above shows what it should: each kind of step, ray and shadow state.
#[test]
fn the_cut_out_scene_has_everything() {
    let recorded = record(&cutout::scene(3), grid(64, 40, 1, 32), 5, Codec::Context);
    let tiles = tiles(&recorded.trace);
    for kind in 0..=step::PASS {
        assert!(tiles.iter().any(|t| t.paths.steps.contains(&kind)), "no step {kind}");
    }
    for state in [ShadowState::NotCast, ShadowState::Lit, ShadowState::Blocked, ShadowState::Tinted] {
        let has = |t: &Tile| t.tree.nodes.iter().any(|n| n.hit && n.shadows.get(1) == state);
        assert!(tiles.iter().any(has), "no shadow ray is {state:?}");
    }
    assert!(tiles.iter().flat_map(|t| &t.tree.nodes).any(|n| n.class.depth() == 5));
}

/// Takes out the nodes `from..to`, which belong to sample `sample`, with their rays.
fn remove(tile: &mut Tile, sample: usize, from: usize, to: usize) {
    let index = tile.tree.ray_index();
    tile.paths.spans.drain(index[from] as usize..index[to] as usize);
    tile.tree.nodes.drain(from..to);
    tile.hits.drain(from..to);
    tile.radiance.drain(from..to);
    tile.tree.first[sample + 1..].iter_mut().for_each(|first| *first -= (to - from) as u32);
}

/// Where the subtree of `node` ends.
fn subtree_end(tile: &Tile, sample: usize, node: usize) -> usize {
    let (nodes, depth) = (&tile.tree.nodes, tile.tree.nodes[node].class.depth());
    let range = tile.tree.sample(sample);
    (node + 1..range.end).find(|&n| nodes[n].class.depth() <= depth).unwrap_or(range.end)
}

/// A tampering of one node; false where it does not apply.
type Tamper = fn(&mut Tile, usize, usize, &mut Random) -> bool;

const TAMPERS: [(&str, Tamper); 13] = [
    ("a step", |tile, _, node, random| {
        let rays = 1 + tile.tree.nodes[node].shadows.count() as usize;
        let ray = tile.tree.ray_index()[node] as usize + random.below(rays);
        // A copy, because rays may share their steps.
        let copy = tile.paths.ray(ray).to_vec();
        let at = random.below(copy.len());
        tile.paths.spans[ray].0 = tile.paths.steps.len() as u32;
        tile.paths.steps.extend_from_slice(&copy);
        let step = tile.paths.steps.len() - copy.len() + at;
        tile.paths.steps[step] = (tile.paths.steps[step] + 1 + random.below(9) as u8) % 10;
        true
    }),
    ("a step too few", |tile, _, node, _| {
        let ray = tile.tree.ray_index()[node] as usize;
        tile.paths.spans[ray].1 -= 1;
        true
    }),
    ("a triangle", |tile, _, node, _| {
        tile.hits[node].triangle ^= 1;
        tile.tree.nodes[node].hit
    }),
    ("an ulp of t up", |tile, _, node, _| {
        tile.hits[node].t = tile.hits[node].t.next_up();
        tile.tree.nodes[node].hit
    }),
    ("an ulp of t down", |tile, _, node, _| {
        tile.hits[node].t = tile.hits[node].t.next_down();
        tile.tree.nodes[node].hit
    }),
    ("a normal", |tile, _, node, random| {
        let normal = &mut tile.hits[node].normal;
        *(if random.below(2) == 0 { &mut normal.u } else { &mut normal.v }) ^= 1;
        tile.tree.nodes[node].hit
    }),
    ("a shadow state", |tile, _, node, random| {
        let shadows = &mut tile.tree.nodes[node].shadows;
        let Some(light) = shadows.cast().next() else { return false };
        let old = shadows.get(light);
        let states = [ShadowState::Lit, ShadowState::Blocked, ShadowState::Tinted];
        shadows.set(light, states[random.below(3)]);
        shadows.get(light) != old
    }),
    ("a shadow ray that was not recorded", |tile, _, node, _| {
        let shadows = tile.tree.nodes[node].shadows;
        let Some(light) = shadows.cast().next().filter(|_| shadows.count() > 1) else { return false };
        let ray = tile.tree.ray_index()[node] as usize + 1;
        tile.paths.spans.remove(ray);
        tile.tree.nodes[node].shadows.set(light, ShadowState::NotCast);
        true
    }),
    ("a reflection's weight", |tile, _, node, random| {
        tile.radiance[node].reflect.0[random.below(3)] ^= 1;
        tile.tree.nodes[node].reflect
    }),
    ("a refraction's weight", |tile, _, node, random| {
        tile.radiance[node].refract.0[random.below(3)] ^= 1;
        tile.tree.nodes[node].refract
    }),
    ("a hit that is recorded as a miss", |tile, sample, node, _| {
        if !tile.tree.nodes[node].hit {
            return false;
        }
        let end = subtree_end(tile, sample, node);
        remove(tile, sample, node + 1, end);
        let ray = tile.tree.ray_index()[node] as usize;
        let shadows = std::mem::take(&mut tile.tree.nodes[node].shadows).count() as usize;
        tile.paths.spans.drain(ray + 1..ray + 1 + shadows);
        let flags = &mut tile.tree.nodes[node];
        (flags.hit, flags.reflect, flags.refract) = (false, false, false);
        tile.hits[node] = Hit::MISS;
        true
    }),
    ("a miss that is recorded as a hit", |tile, _, node, _| {
        let miss = !tile.tree.nodes[node].hit;
        tile.tree.nodes[node].hit = true;
        tile.hits[node] = Hit { triangle: 0, t: 1.0, ..Hit::MISS };
        miss
    }),
    ("a child that was not recorded", |tile, sample, node, _| {
        if !tile.tree.nodes[node].reflect {
            return false;
        }
        let end = subtree_end(tile, sample, node + 1);
        remove(tile, sample, node + 1, end);
        tile.tree.nodes[node].reflect = false;
        true
    }),
];

/// Tampers with one node of a trace in one way, many times; each must be found, in that tile and sample, and no other.
fn assert_found(recorded: &Recorded, name: &str, tamper: Tamper, times: usize) {
    let honest = tiles(&recorded.trace);
    let (mut random, mut done) = (Random(name.len() as u64), 0);
    for _ in 0..4000 {
        let at = random.below(honest.len());
        let sample = random.below(honest[at].tree.samples());
        let range = honest[at].tree.sample(sample);
        let node = range.start + random.below(range.len());
        let mut changed = honest.clone();
        if !tamper(&mut changed[at], sample, node, &mut random) {
            continue;
        }
        let tile = &honest[at];
        let (x, y) = (tile.rect.x + sample as u32 % tile.rect.width, tile.rect.y + sample as u32 / tile.rect.width);
        let what = format!("{name}: tile {}, x {x}, y {y}, node {node}", tile.index);
        let verified = verify(&rewrite(&recorded.trace, &changed).trace, |_| true).expect("it can be read");
        let first = verified.first.unwrap_or_else(|| panic!("{what}: was not found"));
        assert_eq!((first.frame, first.tile, first.x, first.y), (0, tile.index, x, y), "{what}: {first:?}");
        assert_eq!(verified.tiles_wrong, 1, "{what}");
        done += 1;
        if done == times {
            return;
        }
    }
    panic!("{name}: applied only {done} times");
}

#[test]
fn every_tampering_is_found() {
    let recorded = record(&cutout::scene(3), grid(21, 13, 1, 8), 4, Codec::Context);
    for (name, tamper) in TAMPERS {
        assert_found(&recorded, name, tamper, 25);
    }
}
