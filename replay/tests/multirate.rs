//! Blocks of their own for each tile, against the slow second implementation: whatever neighbours have.

use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_replay::image::psnr::SquaredError;
use rayreel_replay::policy::{Adaptive, Foveated, Limit, Multirate, NamedPolicy, Policy, Target};
use rayreel_replay::{FrameReplay, Options, TileSource, replay};
use rayreel_testkit::Random;
use rayreel_testkit::reference;
use rayreel_testkit::same::assert_same;
use rayreel_testkit::synthetic::{Look, Synthetic};
use rayreel_testkit::{preset, switches};

/// Synthetic frames whose tiles are flat or noisy by chance, so that blocks go up and down everywhere.
struct Patchwork {
    flat: Synthetic,
    wild: Synthetic,
    seed: u64,
}

impl Patchwork {
    fn new(size: (u32, u32), seed: u64) -> Self {
        let of = |look| {
            let mut source = Synthetic::new(look, size, 1, 16, seed);
            (source.meta.first_frame, source.meta.frames) = (0, 6);
            source
        };
        Self { flat: of(Look::Trees), wild: of(Look::Noise), seed }
    }
}

impl TileSource for Patchwork {
    fn meta(&self) -> &Meta {
        self.flat.meta()
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.flat.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        self.flat.camera(frame)
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        let mut random = Random(self.seed << 20 ^ u64::from(index) << 8 ^ u64::from(frame));
        random.next();
        if random.remainder(2) == 0 { self.flat.tile(frame, index) } else { self.wild.tile(frame, index) }
    }
}

/// What `variant` does, with blocks that follow every balance and a colour limit that follows one pixel in five.
fn nervous(variant: &Adaptive, seed: u64) -> Multirate {
    Multirate {
        start: 4,
        finest: 2,
        coarsest: 16,
        raise: [6.0, 3.0][seed as usize % 2],
        lower: [6.0, 4.0][seed as usize % 2],
        alternate: [0.0, 0.4, 0.2][seed as usize % 3],
        hold: [1, 1, 1, 2][seed as usize % 4],
        cut_deg: 180.0,
        cut_change: [1.0, 1.0, 0.3][seed as usize % 3],
        target: Target {
            psnr_db: Limit::At(30.0),
            audit: 5,
            strictest: 0.2,
            loosest: 5.0,
            share: [0.9, 0.6][seed as usize / 2 % 2],
            first_detail: [0.3, 0.6, 0.0, 1.0][seed as usize % 4],
            first_correct: [0.5, 1.0, 0.0][seed as usize % 3],
            first_growth: [0.3, 0.0][seed as usize % 2],
            decay: [0.75, 0.5, 0.0][seed as usize % 3],
        },
        sampling: variant.sampling.clone(),
    }
}

fn compare<S: TileSource>(
    source: &S,
    variant: &Adaptive,
    rates: &[(u32, f64)],
    audit: Option<u64>,
    frame: &FrameReplay,
    what: &str,
) {
    let (expected, audits) = match audit {
        Some(every) => reference::replay_audited(source, variant, rates, (frame.frame, every)),
        None => (reference::replay_tiles(source, variant, rates, frame.frame), vec![(0, 0); rates.len()]),
    };
    assert_same(source.meta(), frame, &expected, &audits, what);
}

/// Every sample is decided exactly once (the engine would panic), as the second implementation does, whatever the blocks of
/// the tiles around are; and blocks and limits follow what the tiles were like as they do there.
#[test]
fn neighbours_of_any_block_fit_together() {
    let (mut pairs, mut factors) = (std::collections::BTreeSet::new(), std::collections::BTreeSet::new());
    let (mut errors, mut finer) = (SquaredError::default(), 0);
    for (seed, variant) in (0u64..).zip(switches::draw(16, 3)) {
        let source = Patchwork::new([(93, 61), (80, 49), (65, 65)][seed as usize % 3], seed);
        let policy = nervous(&variant, seed);
        let frames = replay(&source, &Policy::Multirate(policy.clone()), 0..6, Options::default()).unwrap().frames;
        let plans = reference::plans(source.meta(), &policy, &frames);
        finer += frames[0].blocks.tiles().iter().filter(|&&block| block < policy.start).count();
        for (frame, plan) in frames.into_iter().zip(plans) {
            let blocks = frame.blocks.tiles();
            let rates: Vec<_> =
                blocks.iter().zip(&frame.stats.tiles).map(|(&block, tile)| (block, tile.factor)).collect();
            let is_near = |((a, f), (b, g)): (&(u32, f64), &(u32, f64))| a == b && (f / g - 1.0).abs() < 1.0e-9;
            let planned = &plan.tiles;
            assert!(
                rates.iter().zip(planned).all(is_near),
                "{seed}, frame {}: {rates:?}, not {planned:?}",
                frame.frame
            );
            factors.extend(rates.iter().map(|r| r.1.to_bits()));
            errors = errors + frame.stats.tiles.iter().map(|t| t.audited).sum();
            let mut variant = Adaptive { apron: rayreel_replay::policy::Apron::Share, ..variant.clone() };
            variant.sampling.correct = reference::stricter(&variant.sampling.correct, plan.correct);
            compare(&source, &variant, &rates, Some(5), &frame, &format!("{seed}, frame {}: {variant:?}", frame.frame));
            let columns = source.meta().tile_grid().0 as usize;
            pairs.extend(blocks.chunks(columns).flat_map(|row| row.windows(2)).map(|pair| (pair[0], pair[1])));
        }
    }
    assert!(pairs.len() >= 14, "of 16 pairs of neighbours: {pairs:?}");
    assert!(finer > 20, "tiles of first frames below much detail: {finer}");
    assert!(factors.len() > 30, "the colour limit moved: {}", factors.len());
    assert!(errors.sum > 0 && errors.values > 10_000, "{errors:?}");
}

#[test]
fn rings_equal_the_reference() {
    let Policy::Foveated(fixed) = NamedPolicy::load("foveated", &[]).unwrap().policy else { panic!("a preset") };
    for (seed, variant) in (0u64..).zip(switches::draw(8, 4)) {
        let source = Patchwork::new((111, 77), seed);
        let policy = Foveated { gaze_x: 0.4, sampling: variant.sampling.clone(), ..fixed.clone() };
        let frame =
            replay(&source, &Policy::Foveated(policy.clone()), [2], Options::default()).unwrap().frames.remove(0);
        let rates: Vec<_> = (0..source.meta().tile_count()).map(|tile| ring(&policy, source.meta(), tile)).collect();
        assert!(rates.iter().any(|r| r.0 == 2) && rates.iter().any(|r| r.0 == 16), "{rates:?}");
        assert_eq!(frame.blocks.tiles(), rates.iter().map(|r| r.0).collect::<Vec<_>>());
        let variant = Adaptive { apron: rayreel_replay::policy::Apron::Share, ..variant };
        compare(&source, &variant, &rates, None, &frame, &format!("{seed}: {variant:?}"));
    }
}

/// Block and factor of a tile as POLICIES.md has them: from the middle of its samples.
fn ring(policy: &Foveated, meta: &Meta, tile: u32) -> (u32, f64) {
    let (rect, (w, h)) = (meta.tile_rect(tile), meta.grid());
    let x = f64::from(rect.x) + f64::from(rect.width) / 2.0 - policy.gaze_x * f64::from(w);
    let y = f64::from(rect.y) + f64::from(rect.height) / 2.0 - policy.gaze_y * f64::from(h);
    let distance = (x / f64::from(h)).hypot(y / f64::from(h));
    let way = ((distance - policy.inner) / (policy.outer - policy.inner)).clamp(0.0, 1.0);
    let mut block = policy.finest;
    let rings = f64::from(policy.coarsest / policy.finest).log2();
    (0..(way * rings) as u32).for_each(|_| block *= 2);
    (block, 1.0 + (policy.relax - 1.0) * way)
}

/// With a single block to choose from, a sequence is that of `adaptive`.
#[test]
fn one_block_is_adaptive() {
    let mut source = Synthetic::new(Look::Discs, (70, 40), 2, 16, 7);
    source.meta.frames = 6;
    for block in [4, 8] {
        let set = [
            format!("start={block}"),
            format!("finest={block}"),
            format!("coarsest={block}"),
            "target.psnr_db=off".into(),
        ];
        let policy = NamedPolicy::load("multirate", &set).unwrap().policy;
        let frames = source.meta.frame_numbers();
        let rated = replay(&source, &policy, frames.clone(), Options::default()).unwrap();
        let fixed = replay(&source, &Policy::Adaptive(preset("multirate", block)), frames, Options::default()).unwrap();
        assert_eq!(rated, fixed);
    }
}
