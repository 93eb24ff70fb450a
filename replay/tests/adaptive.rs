//! The adaptive policy against a slow second implementation, and against hits it must not see.

use rayreel_replay::counts::RayCounts;
use rayreel_replay::image::resolve::Resolver;
use rayreel_replay::policy::view::SampleState;
use rayreel_replay::policy::{Adaptive, Apron, Limit, Policy, Refine};
use rayreel_replay::{FrameReplay, Options, TileSource, replay};
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::{self, Origin, Outcome};
use rayreel_testkit::synthetic::{Look, Synthetic};
use rayreel_testkit::{adaptive, policy, switches};

const FRAME: u32 = 6;

fn run<S: TileSource>(source: &S, policy: &Policy, threads: usize) -> FrameReplay {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let options = Options::default();
    pool.install(|| replay(source, policy, [FRAME], options)).unwrap().frames.remove(0)
}

fn kinds(rays: RayCounts) -> reference::Rays {
    [rays.primary, rays.reflection, rays.refraction, rays.shadow]
}

fn assert_same<S: TileSource>(source: &S, frame: &FrameReplay, expected: &Outcome, what: &str) {
    let meta = source.meta();
    let (width, height) = meta.grid();
    let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
    for y in 0..height {
        for x in 0..width {
            let i = y as usize * expected.width + x as usize;
            let how = match frame.states.state(x, y) {
                SampleState::Reference => Origin::R,
                SampleState::Traced => Origin::Traced,
                SampleState::Interpolated => Origin::Interpolated,
                SampleState::Partial => Origin::Partial,
            };
            assert_eq!(how, expected.how[i], "{what}: sample ({x}, {y})");
            assert_eq!(frame.states.round(x, y), expected.rounds[i], "{what}: round of ({x}, {y})");
            resolver.add(x, y, expected.colours[i].into());
        }
    }
    let (image, bits) = (resolver.finish(), |v: &[f32; 3]| v.map(f32::to_bits));
    assert!(image.pixels.iter().map(bits).eq(frame.image.pixels.iter().map(bits)), "{what}: colours");
    let counts = &frame.stats.counts;
    let number = |how| expected.count(how);
    assert_eq!(counts.samples_reference, number(Origin::R), "{what}");
    assert_eq!(counts.samples_traced, number(Origin::R) + number(Origin::Traced) + number(Origin::Partial), "{what}");
    assert_eq!(counts.samples_partial, number(Origin::Partial), "{what}");
    assert_eq!(counts.samples_interpolated, number(Origin::Interpolated), "{what}");
    assert_eq!(counts.samples_full, expected.how.len() as u64, "{what}");
    assert_eq!(counts.samples_apron, expected.samples_apron, "{what}");
    assert_eq!(kinds(counts.rays_full), expected.rays_full, "{what}");
    assert_eq!(kinds(counts.rays_traced), expected.rays_traced, "{what}");
    assert_eq!(kinds(counts.rays_apron), expected.rays_apron, "{what}");
    let tiles: Vec<_> =
        frame.stats.tiles.iter().map(|t| (kinds(t.counts.rays_traced), kinds(t.counts.rays_apron))).collect();
    assert_eq!(tiles, expected.tiles, "{what}: tiles");
}

/// Sizes whose grids end in every way: on a block, past a block, on a tile, one sample past a tile, smaller than a block.
const SIZES: [(u32, u32); 6] = [(48, 24), (47, 35), (25, 49), (1, 1), (2, 50), (31, 1)];

fn policies() -> Vec<Adaptive> {
    let mut list = Vec::new();
    for block in [2, 3, 4, 8] {
        for refine in [Refine::Direct, Refine::Hierarchical] {
            for apron in [Apron::Share, Apron::Retrace] {
                list.push(adaptive(block, refine, apron));
            }
        }
    }
    list
}

#[test]
fn equals_the_reference() {
    for (i, &size) in SIZES.iter().enumerate() {
        for look in [Look::Discs, Look::Noise] {
            // A tile of 24 samples is a multiple of every block.
            let source = Synthetic::new(look, size, 1 + i as u32 % 2, 24, i as u64);
            for variant in policies() {
                let what = format!("{look:?} {size:?} {variant:?}");
                let expected = reference::replay(&source, &variant, FRAME);
                let policy = Policy::Adaptive(variant);
                let frame = run(&source, &policy, 1);
                assert_same(&source, &frame, &expected, &what);
                assert_eq!(run(&source, &policy, 4), frame, "{what}: threads");
            }
        }
    }
}

#[test]
fn equals_the_reference_under_all_tests() {
    let source = Synthetic::new(Look::Discs, (40, 30), 2, 16, 3);
    let noise = Synthetic::new(Look::Noise, (40, 30), 2, 16, 4);
    for switches in 0u32..32 {
        let on = |bit: u32, value: f64| if switches >> bit & 1 == 1 { Limit::At(value) } else { Limit::Off };
        let mut variant = adaptive(4, Refine::Hierarchical, Apron::Retrace);
        variant.sampling.similarity.object_id = switches & 1 == 1;
        variant.sampling.similarity.shadow = switches & 2 == 2;
        variant.sampling.similarity.normal_deg = on(2, 7.5);
        variant.sampling.similarity.position = on(3, 0.05);
        variant.sampling.similarity.plane = on(4, 0.01);
        for source in [&source, &noise] {
            let expected = reference::replay(source, &variant, FRAME);
            assert_same(
                source,
                &run(source, &Policy::Adaptive(variant.clone()), 2),
                &expected,
                &format!("{variant:?}"),
            );
        }
    }
}

#[test]
fn tiles_do_not_change_the_picture() {
    let variant = policy(3, Refine::Hierarchical, Apron::Share);
    let whole = run(&Synthetic::new(Look::Discs, (45, 33), 2, 96, 1), &variant, 2);
    // 15 is odd: pixels of two samples straddle tiles.
    for tile in [3, 15, 24] {
        let frame = run(&Synthetic::new(Look::Discs, (45, 33), 2, tile, 1), &variant, 2);
        assert_eq!((&frame.image, &frame.states), (&whole.image, &whole.states), "tile {tile}");
        assert_eq!(frame.reference, whole.reference, "tile {tile}");
        assert_eq!(frame.stats.counts, whole.stats.counts, "tile {tile}");
    }
}

/// Ray trees, and every switch there is.
#[test]
fn equals_the_reference_with_ray_trees() {
    let mut seen = [0; 4];
    for (i, variant) in switches::draw(160, 1).into_iter().enumerate() {
        let look = if i % 4 == 3 { Look::Noise } else { Look::Trees };
        let source = Synthetic::new(look, SIZES[i % 3], 1 + i as u32 % 2, 24, i as u64);
        let expected = reference::replay(&source, &variant, FRAME);
        let what = format!("{i}: {look:?} {variant:?}");
        assert_same(&source, &run(&source, &Policy::Adaptive(variant), 2), &expected, &what);
        let kinds = [Origin::R, Origin::Traced, Origin::Partial, Origin::Interpolated];
        (0..4).for_each(|k| seen[k] += expected.count(kinds[k]));
    }
    // The comparison means something: each kind is there, and often.
    assert!(seen.iter().all(|n| *n > 3000), "{seen:?}");
}

/// Where hits were interpolated one by one, the untraced ones below traced ones are garbage too.
#[test]
fn untraced_hits_are_never_read() {
    let (mut partial, mut poisoned) = (0, 0);
    let simple = policies().into_iter().map(|variant| (Look::Discs, variant));
    let drawn = switches::draw(60, 2).into_iter().map(|variant| (Look::Trees, variant));
    for (i, (look, variant)) in simple.chain(drawn).enumerate() {
        let source = Synthetic::new(look, (37, 29), 2, 24, 9 + i as u64);
        let outcome = reference::replay(&source, &variant, FRAME);
        let policy = Policy::Adaptive(variant);
        let clean = run(&source, &policy, 2);
        if outcome.traced.iter().flatten().all(|traced| traced.hit) {
            continue;
        }
        poisoned += 1;
        partial += outcome.count(Origin::Partial);
        for seed in 0..2 {
            let frame = run(&Poisoned::new(&source, &outcome, seed), &policy, 2);
            assert_eq!(frame.image, clean.image, "{policy:?}");
            assert_eq!(frame.states, clean.states, "{policy:?}");
            let (a, b) = (&frame.stats.counts, &clean.stats.counts);
            assert_eq!((a.rays_traced, a.rays_apron), (b.rays_traced, b.rays_apron), "{policy:?}");
            assert_ne!(frame.reference, clean.reference, "the poison is real");
        }
    }
    assert!(poisoned > 60, "nothing to poison in most of the runs");
    assert!(partial > 1000, "{partial} samples with some hits untraced");
}

#[test]
fn full_traces_everything_once() {
    let source = Synthetic::new(Look::Noise, (19, 23), 2, 7, 2);
    let frame = run(&source, &Policy::Full, 2);
    let counts = &frame.stats.counts;
    assert_eq!(counts.samples_traced, 19 * 23 * 4);
    assert_eq!((counts.samples_traced, counts.samples_interpolated), (counts.samples_full, 0));
    assert_eq!(counts.rays_traced, counts.rays_full);
    assert_eq!((counts.samples_apron, counts.rays_apron, counts.rays_saved()), (0, RayCounts::default(), 0));
    assert_eq!(counts.similarity_ratio(), None);
    assert_eq!(frame.reference.as_ref(), Some(&frame.image));
    let quality = frame.stats.quality.unwrap();
    assert_eq!((quality.squared_error, quality.ssim), (0, Some(1.0)));
    let rays: u64 = (0..source.meta.tile_count()).map(|i| source.tile(FRAME, i).unwrap().tree.ray_count()).sum();
    assert_eq!(counts.rays_full.total(), rays);
}

/// One flat object on a 9 x 5 grid, tiles of 4, blocks of 4: R-columns 0 4 8, R-rows 0 4.
#[test]
fn a_flat_frame_by_hand() {
    let source = Synthetic::new(Look::Flat, (9, 5), 1, 4, 0);
    let frame = run(&source, &policy(4, Refine::Direct, Apron::Retrace), 2);
    let counts = &frame.stats.counts;
    assert_eq!((counts.samples_reference, counts.samples_traced, counts.samples_interpolated), (6, 6, 39));
    assert_eq!(counts.similarity_ratio(), Some(1.0));
    // One primary and one shadow ray a sample.
    assert_eq!((counts.rays_full.total(), counts.rays_traced.total()), (90, 12));
    // Tiles 0 and 1 each see two R-samples to the right (closing column and corner) and one below; tile 2, the single
    // column 8, one below; tiles 3 and 4, the single row 4, one to the right; tile 5 none.
    let apron: Vec<_> = frame.stats.tiles.iter().map(|t| t.counts.samples_apron).collect();
    assert_eq!(apron, [3, 3, 1, 1, 1, 0]);
    assert_eq!(counts.rays_saved(), 90 - 12 - 18);
    // A tile of one R-sample and nothing else has no ratio.
    assert_eq!(frame.stats.tiles[5].counts.similarity_ratio(), None);
    assert_eq!(frame.stats.tiles[0].counts.similarity_ratio(), Some(1.0));
    assert_eq!((frame.states.round(0, 0), frame.states.round(1, 0), frame.states.round(1, 1)), (0, 1, 2));
}

/// One row of nine samples, the second object from column 3 on, one block of 8.
#[test]
fn an_edge_by_hand() {
    let source = Synthetic::new(Look::Edge(3), (9, 1), 1, 16, 0);
    let row = |refine| {
        let frame = run(&source, &policy(8, refine, Apron::Share), 1);
        (0..9).map(|x| (frame.states.state(x, 0), frame.states.round(x, 0))).collect::<Vec<_>>()
    };
    let (r, t, i) = (SampleState::Reference, SampleState::Traced, SampleState::Interpolated);
    // 0 and 8 differ: 4 is traced. 0 and 4 differ: 2 is traced. 0 and 2 agree, 2 and 4 differ, 4 and 8 agree.
    let expected = [(r, 0), (i, 3), (t, 2), (t, 3), (t, 1), (i, 2), (i, 2), (i, 2), (r, 0)];
    assert_eq!(row(Refine::Hierarchical), expected);
    let expected = [(r, 0), (t, 1), (t, 1), (t, 1), (t, 1), (t, 1), (t, 1), (t, 1), (r, 0)];
    assert_eq!(row(Refine::Direct), expected);
}

#[test]
fn rounds_stay_in_their_step() {
    let source = Synthetic::new(Look::Noise, (41, 37), 1, 24, 8);
    for (variant, levels) in policies().into_iter().zip([1, 1, 1, 1, 1, 1, 2, 2, 1, 1, 2, 2, 1, 1, 3, 3]) {
        let n = variant.block;
        let frame = run(&source, &Policy::Adaptive(variant), 1);
        for (x, y) in (0..37).flat_map(|y| (0..41).map(move |x| (x, y))) {
            let on_row = y % n == 0 || y == 36;
            let allowed = match (frame.states.state(x, y), on_row) {
                (SampleState::Reference, _) => 0..=0,
                (_, true) => 1..=levels,
                (_, false) => levels + 1..=2 * levels,
            };
            assert!(allowed.contains(&frame.states.round(x, y)), "block {n}: ({x}, {y}) {allowed:?}");
        }
    }
}
