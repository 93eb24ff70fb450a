//! The policies of cells against a slow second implementation, against hits they must not see, and as work for a machine.

mod common;

use common::work_of;
use proptest::prelude::*;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::srp::KernelId;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::{Round, TileWork};
use rayreel_replay::counts::RayCounts;
use rayreel_replay::image::resolve::Resolver;
use rayreel_replay::policy::{Jin2009, Mitchell1987, Policy, Priorities, Thresholds, Whitted1980};
use rayreel_replay::simulate::simulate;
use rayreel_replay::{FrameReplay, NamedPolicy, Options, PathSource, ReplayError, Replayer, TileSource, replay};
use rayreel_testkit::Random;
use rayreel_testkit::cells::{self, Work};
use rayreel_testkit::golden::traces;
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::{Origin, Outcome};
use rayreel_testkit::synthetic::{Look, Synthetic};

const FRAME: u32 = 6;
const BLOCKS: [u32; 5] = [2, 3, 4, 8, 16];
const PRESETS: [&str; 3] = ["whitted1980", "mitchell1987", "jin2009"];

fn run<S: TileSource>(source: &S, policy: &Policy) -> FrameReplay {
    replay(source, policy, [FRAME], Options::default()).unwrap().frames.remove(0)
}

fn whitted(block: u32, colour: f64, least: u32) -> Policy {
    Policy::Whitted1980(Whitted1980 { block, colour, least })
}

fn mitchell(block: u32, limit: f64) -> Policy {
    Policy::Mitchell1987(Mitchell1987 { block, red: limit, green: limit * 0.75, blue: (limit * 1.5).min(1.0) })
}

/// `bits` holds two bits for each priority.
fn jin(block: u32, bits: u32, limit: f64) -> Policy {
    let of = |i: u32| (bits >> (2 * i) & 3).min(2);
    let priority = Priorities {
        colour: of(0),
        poid: of(1),
        psn: of(2),
        psc: of(3),
        pte: of(4),
        soid: of(5),
        ssn: of(6),
        ssc: of(7),
        ste: of(8),
    };
    let threshold = Thresholds { colour: limit, normal_deg: 5.0 + 20.0 * limit, texture: limit };
    Policy::Jin2009(Jin2009 { block, priority, threshold })
}

fn kinds(rays: RayCounts) -> [u64; 4] {
    [rays.primary, rays.reflection, rays.refraction, rays.shadow]
}

fn assert_same<S: TileSource>(source: &S, frame: &FrameReplay, expected: &Outcome, what: &str) {
    let meta = source.meta();
    let (width, height) = meta.grid();
    let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let i = y as usize * expected.width + x as usize;
        assert_eq!(Origin::from(frame.states.state(x, y)), expected.how[i], "{what}: sample ({x}, {y})");
        assert_eq!(frame.states.round(x, y), expected.rounds[i], "{what}: round of ({x}, {y})");
        resolver.add(x, y, expected.colours[i].into());
    }
    let (image, bits) = (resolver.finish(), |v: &[f32; 3]| v.map(f32::to_bits));
    assert!(image.pixels.iter().map(bits).eq(frame.image.pixels.iter().map(bits)), "{what}: colours");
    let (counts, number) = (&frame.stats.counts, |how| expected.count(how));
    assert_eq!(counts.samples_reference, number(Origin::R), "{what}");
    assert_eq!(counts.samples_traced, number(Origin::R) + number(Origin::Traced), "{what}");
    assert_eq!(counts.samples_interpolated, number(Origin::Interpolated), "{what}");
    assert_eq!((counts.samples_partial, counts.samples_apron), (0, 0), "{what}");
    assert_eq!(kinds(counts.rays_traced), expected.rays_traced, "{what}");
    assert_eq!(kinds(counts.rays_full), expected.rays_full, "{what}");
    let tiles: Vec<_> = frame.stats.tiles.iter().map(|t| kinds(t.counts.rays_traced)).collect();
    assert!(tiles.iter().eq(expected.tiles.iter().map(|(rays, _)| rays)), "{what}: tiles");
}

/// Sizes whose grids end in every way: on a block, past a block, on a tile, one sample past a tile, smaller than a block.
const SIZES: [(u32, u32); 7] = [(48, 24), (47, 35), (25, 49), (1, 1), (2, 50), (31, 1), (97, 17)];

/// Policies of one block: limits from the strictest on, and priorities by chance.
fn policies(block: u32, seed: u64) -> Vec<Policy> {
    let mut random = Random(seed);
    random.next();
    let mut list = vec![whitted(block, 0.0, 1), mitchell(block, 0.0), whitted(block, 2.0, 1), mitchell(block, 1.0)];
    for limit in [0.05, 0.2, 0.4] {
        list.extend([whitted(block, limit, 1 + random.remainder(3)), mitchell(block, limit)]);
        list.push(jin(block, random.next(), limit));
        // Without colours, which are mostly chance here, attributes decide; then those of one kind of hits alone.
        list.push(jin(block, random.next() & !0b11, limit));
        list.push(jin(block, random.next() & !0b11 & [0x3ff, 0x3fc00][random.remainder(2) as usize], limit));
    }
    list
}

#[test]
fn equals_the_reference() {
    let mut seen = [0; 3];
    for (i, &size) in SIZES.iter().enumerate() {
        for (j, look) in [Look::Discs, Look::Noise, Look::Trees, Look::Edge(13)].into_iter().enumerate() {
            for block in BLOCKS {
                let seed = (i * 100 + j * 10) as u64 + u64::from(block);
                let source = Synthetic::new(look, size, 1 + (i + j) as u32 % 3, 48, seed);
                for policy in policies(block, seed) {
                    let what = format!("{look:?} {size:?} {policy:?}");
                    let (expected, _) = cells::replay(&source, &policy, FRAME);
                    assert_same(&source, &run(&source, &policy), &expected, &what);
                    let kinds = [Origin::R, Origin::Traced, Origin::Interpolated];
                    (0..3).for_each(|k| seen[k] += expected.count(kinds[k]));
                }
            }
        }
    }
    // The comparison means something: each kind is there, and often.
    assert!(seen.iter().all(|n| *n > 100_000), "{seen:?}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(96))]

    #[test]
    fn equals_the_reference_whatever_it_is(
        size in (1u32..60, 1u32..60), samples in 1u32..4, (block, times) in (0usize..5, 1u32..4),
        (kind, bits, limit, least) in (0u32..3, any::<u32>(), 0.0f64..0.6, 1u32..4), look in 0usize..3, seed in any::<u64>()
    ) {
        let (block, look) = (BLOCKS[block], [Look::Discs, Look::Noise, Look::Trees][look]);
        let policy = match kind {
            0 => whitted(block, limit, least),
            1 => mitchell(block, limit),
            _ => jin(block, bits, limit),
        };
        let source = Synthetic::new(look, size, samples, block * times, seed);
        let (expected, _) = cells::replay(&source, &policy, FRAME);
        assert_same(&source, &run(&source, &policy), &expected, "proptest");
    }
}

/// The tiles of a frame, and the threads, do not show.
#[test]
fn tiles_do_not_change_the_picture() {
    for look in [Look::Discs, Look::Trees] {
        for policy in policies(3, 5) {
            let of = |tile| run(&Synthetic::new(look, (45, 33), 2, tile, 1), &policy);
            let whole = of(96);
            // 15 is odd: pixels of two samples straddle tiles. 3 is a tile of one block.
            for tile in [3, 15, 24] {
                let frame = of(tile);
                assert_eq!((&frame.image, &frame.states), (&whole.image, &whole.states), "tile {tile} {policy:?}");
                assert_eq!(frame.stats.counts, whole.stats.counts, "tile {tile} {policy:?}");
            }
            let alone = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
            assert_eq!(alone.install(|| of(96)), whole, "{policy:?}");
        }
    }
}

#[test]
fn untraced_hits_are_never_read() {
    let (mut poisoned, mut spared) = (0, 0);
    for (i, look) in [Look::Discs, Look::Trees].into_iter().enumerate() {
        for block in [2, 3, 8] {
            for policy in policies(block, 11 + u64::from(block)) {
                let source = Synthetic::new(look, (37, 29), 2, 24, 9 + i as u64);
                let (outcome, _) = cells::replay(&source, &policy, FRAME);
                let clean = run(&source, &policy);
                if outcome.traced.iter().flatten().all(|traced| traced.hit) {
                    continue;
                }
                poisoned += 1;
                spared += outcome.count(Origin::Interpolated);
                for seed in 0..2 {
                    let frame = run(&Poisoned::new(&source, &outcome, seed), &policy);
                    assert_eq!((&frame.image, &frame.states), (&clean.image, &clean.states), "{policy:?}");
                    let traced = |frame: &FrameReplay| frame.stats.counts.rays_traced;
                    assert_eq!(traced(&frame), traced(&clean), "{policy:?}");
                    assert_ne!(frame.reference, clean.reference, "the poison is real");
                }
            }
        }
    }
    assert!(poisoned > 60 && spared > 10_000, "{poisoned} runs, {spared} samples");
}

/// What the second implementation counts in each round, the machine is charged for; the tile that brings the far corners of a
/// cell does its work, and R-samples are their own tile's.
#[test]
fn machines_are_charged_for_what_is_done() {
    for trace in traces() {
        let meta = trace.meta();
        let ((width, height), (columns, _)) = (meta.grid(), meta.tile_grid());
        let blocks: Vec<u32> = BLOCKS.into_iter().filter(|n| meta.tile.is_multiple_of(*n)).collect();
        for policy in blocks.into_iter().flat_map(|n| policies(n, n.into())) {
            let (expected, rounds) = cells::replay(&trace, &policy, meta.first_frame);
            let (frame, works) = work_of(&trace, &policy, [trace.meta().first_frame]).remove(0);
            assert_same(&trace, &frame, &expected, &format!("{policy:?}"));
            let n = match &policy {
                Policy::Whitted1980(values) => values.block,
                Policy::Mitchell1987(values) => values.block,
                Policy::Jin2009(values) => values.block,
                _ => unreachable!(),
            };
            let of = |round: usize| {
                let all = works.iter().filter_map(|w| w.rounds.get(round));
                all.fold(Work::default(), |sum, w| Work {
                    tests: sum.tests + u64::from(w.tests),
                    colours: sum.colours + u64::from(w.colours),
                    interpolated: sum.interpolated + u64::from(w.interpolated),
                })
            };
            (0..8).for_each(|i| assert_eq!(of(i), rounds.get(i).copied().unwrap_or_default(), "{policy:?} {i}"));
            assert!(works.iter().flat_map(|w| &w.rounds).all(|round| round.attributes == 0));
            let is_line = |at: u32, size: u32| at.is_multiple_of(n) || at + 1 == size;
            // The tile of the far corner of the cell that a sample belongs to.
            let far = |at: u32, size: u32| {
                let start = if at + 1 == size { at } else { at / n * n };
                if start + 1 == size { start } else { (start + n).min(size - 1) }
            };
            for work in &works {
                for (round, start) in (0..).zip(&work.rounds).flat_map(|(i, r)| r.starts.iter().map(move |s| (i, *s))) {
                    let (x, y) = (work.rays[start as usize].x, work.rays[start as usize].y);
                    let reference = is_line(x, width) && is_line(y, height);
                    let (u, v) = if reference { (x, y) } else { (far(x, width), far(y, height)) };
                    assert_eq!(work.tile, v / meta.tile * columns + u / meta.tile, "({x}, {y}) {policy:?}");
                    assert_eq!(frame.states.round(x, y), round, "rounds stay: only R-samples are waited for");
                }
                let (left, above) = (work.tile % columns > 0, work.tile >= columns);
                let (from, rect) = ((work.rect.x, work.rect.y), work.rect);
                let count =
                    |from: u32, len: u32, size| (from..from + len).filter(|at| is_line(*at, size)).count() as u32;
                let (column, row) = (count(from.1, rect.height, height), count(from.0, rect.width, width));
                let read = u32::from(left) * column + u32::from(above) * row + u32::from(left && above);
                assert_eq!(work.border_samples, read, "tile {} {policy:?}", work.tile);
            }
            let sum = |of: fn(&TileWork) -> u32| works.iter().map(of).sum::<u32>();
            assert_eq!(sum(|w| w.border_samples), sum(|w| w.kept_samples), "what is kept is read");
        }
    }
}

/// Every kernel of a machine has as many items as the work says, and no machine changes a picture.
#[test]
fn machines_do_their_work() {
    let trace = &traces()[1];
    let frame = trace.meta().first_frame;
    for (preset, machine) in
        PRESETS.into_iter().flat_map(|preset| ["sgrt-ti2", "external-buffers"].map(|machine| (preset, machine)))
    {
        let policy = NamedPolicy::load(preset, &[]).unwrap().policy;
        let (replayed, works) = work_of(trace, &policy, [trace.meta().first_frame]).remove(0);
        let machine = NamedMachine::load(machine, &[]).unwrap();
        let mut replayer = Replayer::new(trace, &policy, Options::default()).unwrap();
        let named = (machine.name.as_str(), &machine.config);
        let ran = simulate(&mut replayer, frame, &trace.topology(), named, &mut NoProbe).unwrap();
        assert_eq!(ran.replay, replayed, "{preset}");
        assert_eq!(ran.stats.rays(), replayed.stats.counts.rays_traced.total(), "{preset}");
        let items = |kernel: KernelId| -> u64 {
            ran.stats.cores.iter().map(|core| core.srp.kernels[kernel as usize].items).sum()
        };
        let sum = |of: fn(&Round) -> u32| works.iter().flat_map(|w| &w.rounds).map(|r| u64::from(of(r))).sum::<u64>();
        assert_eq!(items(KernelId::Similarity), sum(|round| round.tests), "{preset}");
        assert_eq!(items(KernelId::Colour), sum(|round| round.colours), "{preset}");
        assert_eq!(items(KernelId::Interpolate), sum(|round| round.interpolated), "{preset}");
        assert_eq!(items(KernelId::Attributes), 0, "{preset}");
    }
}

/// One row of a flat object whose colours are chance, so any two differ.
#[test]
fn squares_are_halved_by_hand() {
    let source = Synthetic::new(Look::Flat, (9, 1), 1, 16, 0);
    let rounds = |policy: &Policy| {
        let frame = run(&source, policy);
        (0..9).map(|x| frame.states.round(x, 0)).collect::<Vec<_>>()
    };
    assert_eq!(rounds(&whitted(8, 0.0, 1)), [0, 3, 2, 3, 1, 3, 2, 3, 0]);
    assert_eq!(rounds(&whitted(8, 2.0, 1)), [0, 1, 1, 1, 1, 1, 1, 1, 0]);
    let frame = run(&source, &whitted(8, 0.0, 4));
    // 8 samples are longer than 4: they are halved once, and the rest is interpolated without a test.
    assert_eq!((frame.stats.counts.samples_traced, rounds(&whitted(8, 0.0, 4))), (3, vec![0, 2, 2, 2, 1, 2, 2, 2, 0]));
}

/// A cell that agrees shows one colour; half of the samples of one that differs a little are traced.
#[test]
fn priorities_say_how_much_is_traced() {
    let source = Synthetic::new(Look::Edge(4), (8, 4), 1, 4, 3);
    let traced = |priority: u32| {
        let policy = jin(4, priority << 2, 0.1);
        let frame = run(&source, &policy);
        let colour = |x: usize, y: usize| frame.image.pixels[y * 8 + x];
        if priority == 0 {
            assert!((0..3).all(|y| (0..4).all(|x| colour(x, y) == colour(0, 0))), "one colour a cell");
        }
        (0..3)
            .flat_map(|y| (0..4).map(move |x| (x, y)))
            .filter(|&(x, y)| frame.states.state(x, y) != rayreel_replay::policy::SampleState::Interpolated)
            .count()
    };
    assert_eq!([traced(0), traced(1), traced(2)], [1, 6, 12]);
}

#[test]
fn settings_are_checked() {
    let message = |preset: &str, set: &str| NamedPolicy::load(preset, &[set.into()]).unwrap_err().to_string();
    for (preset, set, part) in [
        ("whitted1980", "block=5", "block = 5 is not allowed; it must be 2 or 3 or 4 or 8"),
        ("whitted1980", "colour=2.5", "a number from 0 to 2"),
        ("whitted1980", "colour=off", "a number from 0 to 2"),
        ("whitted1980", "least=0", "an integer from 1 to 16"),
        ("mitchell1987", "red=1.5", "a number from 0 to 1"),
        ("mitchell1987", "blue=nan", "a number from 0 to 1"),
        ("mitchell1987", "grene=0.1", "did you mean green?"),
        ("jin2009", "priority.poid=3", "priority.poid = 3 is not allowed; it must be 0 or 1 or 2"),
        ("jin2009", "poid=1", "did you mean priority.poid?"),
        ("jin2009", "threshold.normal_deg=181", "a number from 0 to 180"),
        ("jin2009", "similarity.shadow=true", "policy of kind \"jin2009\""),
    ] {
        let text = message(preset, set);
        assert!(text.contains(part), "{text:?} does not say {part:?}");
    }
    let source = Synthetic::new(Look::Flat, (20, 20), 1, 10, 0);
    for preset in PRESETS {
        let policy = NamedPolicy::load(preset, &["block=4".into()]).unwrap();
        let error = Replayer::new(&source, &policy, Options::default()).err().unwrap();
        assert!(matches!(error, ReplayError::Request(_)), "{error}");
        assert!(error.to_string().contains("tile"), "{error}");
    }
    // Values made by code are checked too.
    assert!(Replayer::new(&source, &whitted(2, -1.0, 1), Options::default()).is_err());
}
