//! Samples of which some hits are traced and some interpolated, as work for a machine: the rays that the second
//! implementation traces, each once, each started by the SRP or spawned by its parent; and machines that do this work.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::scene::Meta;
use rayreel_formats::tile::{RayKind, Tile};
use rayreel_formats::trace::Trace;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::srp::KernelId;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::{NO_RAY, NO_TRIANGLE, TileWork};
use rayreel_replay::policy::{Adaptive, Apron, Policy};
use rayreel_replay::simulate::simulate;
use rayreel_replay::{FrameReplay, NamedPolicy, Options, PathSource, Replayer};
use rayreel_testkit::reference::{self, Origin, Outcome};
use rayreel_testkit::{preset, switches};

fn golden(name: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&path, Limits::default()).unwrap()
}

fn run(trace: &Trace, policy: &Policy) -> (FrameReplay, Vec<TileWork>) {
    let mut works = Vec::new();
    let mut replayer = Replayer::new(trace, policy, Options::default()).unwrap();
    let keep = |work| {
        works.push(work);
        Ok(())
    };
    let (frame, _) = replayer.frame_with(trace.meta().first_frame, &trace.topology(), keep).unwrap();
    (frame, works)
}

/// A ray: sample, kind, bounces and triangle.
type Ray = (u32, u32, RayKind, u32, u32);

/// Rays, and those that the SRP starts with their rounds.
type Expected = (Vec<Ray>, Vec<(u8, Ray)>);

/// The rays of the traced hits of a tile, and those of them that no traced hit spawns, with the round of their sample.
fn expected(outcome: &Outcome, tile: &Tile) -> Expected {
    let (mut rays, mut starts) = (Vec::new(), Vec::new());
    let rect = tile.rect;
    for (sample, (x, y)) in
        (rect.y..rect.y + rect.height).flat_map(|y| (rect.x..rect.x + rect.width).map(move |x| (x, y))).enumerate()
    {
        let at = y as usize * outcome.width + x as usize;
        // Whether the last hit of each depth was traced.
        let mut line = [false; 17];
        for (node, traced) in tile.tree.sample(sample).zip(&outcome.traced[at]) {
            let hit = &tile.tree.nodes[node];
            let depth = hit.class.depth();
            line[depth as usize] = traced.hit;
            if !traced.hit {
                continue;
            }
            let triangle = if hit.hit { tile.hits[node].triangle } else { NO_TRIANGLE };
            let ray = (x, y, hit.class.kind(), depth, triangle);
            rays.push(ray);
            (0..hit.shadows.count()).for_each(|_| rays.push((x, y, RayKind::Shadow, depth, NO_TRIANGLE)));
            if depth == 0 || !line[depth as usize - 1] {
                starts.push((outcome.rounds[at], ray));
            }
        }
    }
    (rays, starts)
}

fn sorted<T: Ord>(mut list: Vec<T>) -> Vec<T> {
    list.sort();
    list
}

/// Kinds as numbers, so that lists can be sorted.
fn key(ray: &Ray) -> (u32, u32, u32, u32, u32) {
    (ray.1, ray.0, ray.2 as u32, ray.3, ray.4)
}

/// Rays and starts of tiles, by the tile that brings the R-samples behind each sample, for blocks of `block` samples.
fn by_closing_tile(meta: &Meta, block: u32, tiles: impl Iterator<Item = Expected>) -> Vec<Expected> {
    let (width, height) = meta.grid();
    let tile = |at: u32, end: u32| at.next_multiple_of(block).min(end - 1) / meta.tile;
    let of = |ray: &Ray| (tile(ray.1, height) * meta.tile_grid().0 + tile(ray.0, width)) as usize;
    let mut all = vec![Expected::default(); meta.tile_count() as usize];
    for (rays, starts) in tiles {
        rays.into_iter().for_each(|ray| all[of(&ray)].0.push(ray));
        starts.into_iter().for_each(|start| all[of(&start.1)].1.push(start));
    }
    all
}

fn assert_work(work: &TileWork, (rays, starts): &Expected, what: &str) -> usize {
    let of = |ray: u32| {
        let ray = &work.rays[ray as usize];
        (ray.x, ray.y, ray.kind, u32::from(ray.depth), ray.triangle)
    };
    let found = (0..work.rays.len() as u32).map(|ray| key(&of(ray))).collect();
    assert_eq!(sorted(found), sorted(rays.iter().map(key).collect()), "{what}: rays of tile {}", work.tile);
    let begun =
        (0u8..).zip(&work.rounds).flat_map(|(number, round)| round.starts.iter().map(move |&ray| (number, ray)));
    let found = sorted(begun.clone().map(|(round, ray)| (round, key(&of(ray)))).collect());
    assert_eq!(found, sorted(starts.iter().map(|(round, ray)| (*round, key(ray))).collect()), "{what}: starts");
    // Each ray is begun or spawned, once.
    let mut named = vec![0; work.rays.len()];
    begun.for_each(|(_, ray)| named[ray as usize] += 1);
    for (i, ray) in work.rays.iter().enumerate() {
        [ray.reflect, ray.refract].iter().filter(|&&child| child != NO_RAY).for_each(|&child| {
            assert_eq!((of(child).0, of(child).1, of(child).3), (ray.x, ray.y, u32::from(ray.depth) + 1), "{what}");
            named[child as usize] += 1;
        });
        (i + 1..=i + usize::from(ray.shadows)).for_each(|shadow| named[shadow] += 1);
    }
    assert!(named.iter().all(|n| *n == 1), "{what}: {named:?}");
    starts.iter().filter(|(_, ray)| ray.3 > 0).count()
}

#[test]
fn work_is_what_the_reference_traces() {
    let mut secondary_starts = 0;
    for name in ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"] {
        let trace = golden(name);
        let frame = trace.meta().first_frame;
        let mut list: Vec<Adaptive> = vec![preset("multirate", 8), preset("aggressive", 4), preset("quality", 2)];
        list.extend(
            switches::draw(14, 6).into_iter().filter(|variant| trace.meta().tile.is_multiple_of(variant.block)),
        );
        for variant in list {
            let block = variant.block;
            let mut variant = Adaptive { apron: Apron::Share, ..variant };
            variant.sampling.stand_in = true;
            let outcome = reference::replay(&trace, &variant, frame);
            let what = format!("{name} {variant:?}");
            let (replayed, works) = run(&trace, &Policy::Adaptive(variant));
            assert!(works.iter().map(|work| work.tile).eq(0..trace.meta().tile_count()));
            let tiles = (0..trace.meta().tile_count()).map(|i| PathSource::tile_with_paths(&trace, frame, i).unwrap());
            let all = by_closing_tile(trace.meta(), block, tiles.map(|tile| expected(&outcome, &tile)));
            let mut rays = 0;
            for work in &works {
                secondary_starts += assert_work(work, &all[work.tile as usize], &what);
                rays += work.rays.len() as u64;
            }
            assert_eq!(rays, replayed.stats.counts.rays_traced.total(), "{what}");
            assert_eq!(replayed.stats.counts.samples_partial, outcome.count(Origin::Partial), "{what}");
        }
    }
    assert!(secondary_starts > 500, "{secondary_starts} rays leave interpolated hits");
}

/// Aprons that are traced again hold partial samples too.
#[test]
fn retraced_aprons_add_their_rays() {
    let trace = golden("v1_0_teapot.rtrace");
    let variant = Adaptive { apron: Apron::Retrace, ..preset("multirate", 8) };
    let (frame, works) = run(&trace, &Policy::Adaptive(variant));
    for (work, stats) in works.iter().zip(&frame.stats.tiles) {
        let counts = stats.counts;
        assert_eq!(work.rays.len() as u64, counts.rays_traced.total() + counts.rays_apron.total());
        assert_eq!(u64::from(work.apron_samples), counts.samples_apron);
    }
    assert!(frame.stats.counts.samples_partial > 0 && frame.stats.counts.rays_apron.total() > 0);
}

/// Every kernel of the machine runs as often as the policy's work has items for it.
#[test]
fn machines_conserve_rays() {
    let trace = golden("v1_0_teapot.rtrace");
    let frame = trace.meta().first_frame;
    for policy in ["multirate", "foveated"] {
        let set: Vec<String> = if policy == "multirate" { vec!["coarsest=8".into()] } else { vec![] };
        let policy = NamedPolicy::load(policy, &set).unwrap();
        let (replayed, works) = run(&trace, &policy.policy);
        assert!(replayed.stats.counts.samples_partial > 0);
        let closest = || works.iter().flat_map(|w| &w.rays).filter(|ray| ray.kind != RayKind::Shadow);
        let number = |kind| works.iter().flat_map(|w| &w.rays).filter(|ray| ray.kind == kind).count() as u64;
        let rounds = || works.iter().flat_map(|work| &work.rounds);
        for machine in ["sgrt-ti2", "hybrid-raster", "external-buffers", "no-direct-interface"] {
            let machine = NamedMachine::load(machine, &[]).unwrap();
            let mut replayer = Replayer::new(&trace, &policy.policy, Options::default()).unwrap();
            let named = (machine.name.as_str(), &machine.config);
            let ran = simulate(&mut replayer, frame, &trace.topology(), named, &mut NoProbe).unwrap();
            let what = format!("{} on {}", policy.name, machine.name);
            assert_eq!(ran.replay, replayed, "{what}");
            let rays = replayed.stats.counts.rays_traced;
            let rastered = if machine.name == "hybrid-raster" { rays.primary } else { 0 };
            assert_eq!(ran.stats.rays(), rays.total() - rastered, "{what}");
            let items = |kernel: KernelId| -> u64 {
                ran.stats.cores.iter().map(|core| core.srp.kernels[kernel as usize].items).sum()
            };
            let starts: u64 = rounds().map(|round| round.starts.len() as u64).sum();
            assert_eq!(items(KernelId::Raygen), starts - rastered, "{what}: rays begun");
            assert_eq!(items(KernelId::ShadowResult), number(RayKind::Shadow), "{what}: shadow rays");
            let hits = closest().filter(|ray| ray.triangle != NO_TRIANGLE).count() as u64;
            assert_eq!(items(KernelId::Shade), hits, "{what}: hits");
            assert_eq!(items(KernelId::Miss), closest().count() as u64 - hits, "{what}: misses");
            assert_eq!(rays.shadow, number(RayKind::Shadow), "{what}");
            assert_eq!(rays.reflection, number(RayKind::Reflection), "{what}");
            assert_eq!(rays.refraction, number(RayKind::Refraction), "{what}");
            let tests: u64 = rounds().map(|round| u64::from(round.tests)).sum();
            let made: u64 = rounds().map(|round| u64::from(round.interpolated)).sum();
            assert_eq!((items(KernelId::Similarity), items(KernelId::Interpolate)), (tests, made), "{what}");
        }
    }
}

/// What a tile reads of the tile to its left are samples on that tile's R-rows, whatever its own block.
#[test]
fn borders_follow_the_neighbours_blocks() {
    let trace = golden("v1_0_cornell.rtrace");
    let policy = NamedPolicy::load("foveated", &["inner=0".into(), "outer=0.7".into()]).unwrap();
    let (frame, works) = run(&trace, &policy.policy);
    let ((columns, _), (_, height)) = (trace.meta().tile_grid(), trace.meta().grid());
    let mut differ = 0;
    for work in &works {
        let (left, above, rect) = (work.tile % columns > 0, work.tile >= columns, work.rect);
        let mut expected = if above { rect.width } else { 0 };
        if left {
            let blocks = frame.blocks.tiles();
            let block = blocks[work.tile as usize - 1];
            differ += u32::from(block != blocks[work.tile as usize]);
            let rows = (rect.y..rect.y + rect.height).filter(|y| y.is_multiple_of(block) || y + 1 == height);
            expected += rows.count() as u32;
        }
        assert_eq!(work.border_samples, expected, "tile {}", work.tile);
    }
    assert!(differ > 3, "{differ} tiles have another block than their neighbour");
}
