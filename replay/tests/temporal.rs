//! `temporal` against the slow second implementation, frame after frame; closed forms; hits that were not traced as garbage; and what a
//! machine is charged.

mod common;

use std::collections::BTreeSet;

use common::work_of;
use rayreel_formats::math::vec3;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::{Hit, ShadowState, Shadows, Tile};
use rayreel_replay::policy::{
    Adaptive, Attributes, HistoryRules, Limit, Multirate, NamedPolicy, Policy, Target, Temporal,
};
use rayreel_replay::{FrameReplay, Options, TileSource, replay};
use rayreel_testkit::golden;
use rayreel_testkit::poison::Poisoned;
use rayreel_testkit::reference::retell;
use rayreel_testkit::same::assert_same;
use rayreel_testkit::synthetic::{Look, Synthetic};
use rayreel_testkit::{Random, switches};

/// Rules that are drawn by chance.
fn rules(random: &mut Random) -> HistoryRules {
    fn pick<T: Copy>(random: &mut Random, of: &[T]) -> T {
        of[random.remainder(of.len() as u32) as usize]
    }
    HistoryRules {
        step: pick(random, &[1, 2, 4]),
        depth: pick(random, &[0, 1, 1, 3]),
        refresh: pick(random, &[2, 5, 9]),
        trust: pick(random, &[0.0, 0.2, 0.5, 1.0, 1.0]),
        age: pick(random, &[1, 2, 5, 255]),
        cover: pick(random, &[0.0, 0.5, 0.9, 1.0]),
        plane: pick(random, &[0.02, 0.3, 1.0]),
        normal_deg: pick(random, &[10.0, 60.0, 180.0]),
        distance: pick(random, &[0.1, 100.0]),
    }
}

/// What `variant` does, with blocks and limits that move in every frame.
fn nervous(variant: &Adaptive, history: HistoryRules) -> Temporal {
    let target = Target {
        psnr_db: Limit::At(30.0),
        audit: 7,
        strictest: 0.2,
        loosest: 5.0,
        share: 0.9,
        first_detail: 0.3,
        first_correct: 0.5,
        first_growth: 0.5,
        decay: 0.6,
    };
    let rates = Multirate {
        start: 4,
        finest: 2,
        coarsest: 8,
        raise: 2.0,
        lower: 4.0,
        alternate: 0.0,
        hold: 1,
        cut_deg: 180.0,
        cut_change: 1.0,
        target,
        sampling: variant.sampling.clone(),
    };
    Temporal { multirate: rates, history }
}

fn run<S: TileSource>(source: &S, policy: &Temporal, frames: &[u32]) -> Vec<FrameReplay> {
    replay(source, &Policy::Temporal(policy.clone()), frames.iter().copied(), Options::default()).unwrap().frames
}

/// Frames 0 to 5.
fn made_up(look: Look, seed: u64) -> Synthetic {
    let mut source = Synthetic::new(look, [(61, 45), (48, 33), (53, 49)][seed as usize % 3], 1, 16, seed);
    (source.meta.first_frame, source.meta.frames) = (0, 6);
    source
}

#[test]
fn equals_the_reference_and_reads_nothing_that_is_not_traced() {
    let (mut random, mut spared, mut stood_for, mut mistaken, mut distrusted) = (Random(5), 0, 0, 0, 0);
    for (seed, variant) in (0u64..).zip(switches::draw(24, 8)) {
        let source = made_up([Look::Trees, Look::Trees, Look::Discs][seed as usize % 3], seed);
        let mut policy = nervous(&variant, rules(&mut random));
        if seed % 2 == 0 {
            policy.multirate.sampling.attributes = Attributes::Lazy;
        }
        // Frame 3 comes after a cut.
        let numbers = [0, 1, 3, 4, 5];
        let frames = run(&source, &policy, &numbers);
        let told = retell(&source, &policy, &frames);
        for (frame, written) in frames.iter().zip(&told) {
            let what = format!("{seed}, frame {}: {policy:?}", frame.frame);
            assert_same(&source.meta, frame, &written.outcome, &written.audited, &what);
            let hits = written.outcome.traced.iter().flatten();
            spared += hits.clone().map(|traced| traced.spared).sum::<u32>();
            stood_for += hits.filter(|traced| traced.stood_for).count();
            let checks = written.outcome.history.checked.values();
            mistaken += checks.clone().map(|sums| sums.1).sum::<u64>();
            distrusted += checks.filter(|sums| sums.1 as f64 > policy.history.trust * sums.0 as f64).count();
        }
        let outcomes = numbers.into_iter().zip(told.iter().map(|written| &written.outcome)).collect();
        let poisoned = Poisoned { source: &source, outcomes, seed: 3 };
        for (frame, clean) in run(&poisoned, &policy, &numbers).iter().zip(&frames) {
            assert_eq!(frame.states, clean.states, "{policy:?}");
            assert_eq!(frame.image, clean.image, "{policy:?}");
            let rays = |frame: &FrameReplay| frame.stats.counts.rays_traced;
            assert_eq!(rays(frame), rays(clean), "{policy:?}");
        }
    }
    // All cases were met, and often.
    let met = [u64::from(spared), stood_for as u64, mistaken, 10 * distrusted as u64];
    assert!(met.iter().all(|n| *n > 300), "{met:?}");
}

/// One frame again and again, seen from one place, until something changes.
struct Still {
    one: Synthetic,
    /// Until this frame all lights are lit, from then on none is.
    dark: u32,
    /// From this frame on all is another object.
    other: u32,
    /// From this frame on the camera looks to the side.
    turned: u32,
}

impl Still {
    fn new(look: Look, size: (u32, u32), tile: u32) -> Self {
        let mut one = Synthetic::new(look, size, 1, tile, 4);
        (one.meta.first_frame, one.meta.frames) = (0, 64);
        Self { one, dark: u32::MAX, other: u32::MAX, turned: u32::MAX }
    }
}

impl TileSource for Still {
    fn meta(&self) -> &Meta {
        &self.one.meta
    }

    fn object_of(&self, triangle: u32) -> u32 {
        self.one.object_of(triangle)
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        let camera = self.one.camera(0)?;
        let corner = if frame >= self.turned { camera.corner + vec3(0.6, 0.0, 0.0) } else { camera.corner };
        Ok(Camera { corner, ..camera })
    }

    fn tile(&self, frame: u32, index: u32) -> rayreel_formats::Result<Tile> {
        let mut tile = self.one.tile(0, index)?;
        tile.frame = frame;
        if frame >= self.other {
            // Four triangles an object.
            tile.hits.iter_mut().filter(|hit| **hit != Hit::MISS).for_each(|hit| hit.triangle += 4);
        }
        if frame >= self.dark {
            for node in tile.tree.nodes.iter_mut().filter(|node| node.hit) {
                let cast: Vec<usize> = node.shadows.cast().collect();
                node.shadows = Shadows::default();
                cast.iter().for_each(|&light| node.shadows.set(light, ShadowState::Blocked));
            }
        }
        Ok(tile)
    }
}

/// The preset with one block and one limit for all: nothing but the history moves.
fn steady(sets: &[&str]) -> Temporal {
    let mut all = vec!["target.psnr_db=off", "start=4", "finest=4", "coarsest=4", "correct.colour_alone=off"];
    all.extend(sets);
    let all: Vec<String> = all.iter().map(ToString::to_string).collect();
    match NamedPolicy::load("temporal", &all).unwrap().policy {
        Policy::Temporal(temporal) => temporal,
        other => panic!("{other:?}"),
    }
}

/// Of [`Look::Flat`], whose colours are noise, nothing but R-samples is traced then (and without `correct.colour_alone`).
const BLIND: &str = "similarity.colour=off";

fn shadow_rays(frames: &[FrameReplay]) -> Vec<u64> {
    frames.iter().map(|frame| frame.stats.counts.rays_traced.shadow).collect()
}

/// Of a picture that stands still everything is known. In as many frames as `refresh` says each sample looks for its lights once.
#[test]
fn a_still_picture_is_looked_at_once_in_refresh_frames() {
    let source = Still::new(Look::Flat, (65, 33), 32);
    let policy = steady(&["history.step=1", "history.age=255", BLIND]);
    let frames = run(&source, &policy, &(0..17).collect::<Vec<_>>());
    let rays = shadow_rays(&frames);
    // R-samples in 17 columns and 9 rows; of a flat object nothing else is traced.
    assert_eq!(rays[0], 17 * 9);
    assert_eq!(rays[1..9].iter().sum::<u64>(), 17 * 9);
    assert_eq!(rays[9..17], rays[1..9]);
    assert!(rays[1..].iter().all(|n| *n > 0 && *n < 17 * 9 / 3), "{rays:?}");
    frames.iter().for_each(|frame| {
        assert_eq!(frame.image, frames[0].image);
        assert_eq!(frame.stats.counts.rays_traced.primary, 17 * 9);
    });
}

/// A picture with all kinds of hits: known lights change no sample of what stands still.
#[test]
fn a_still_picture_stays_as_it_is() {
    for look in [Look::Trees, Look::Discs] {
        let source = Still::new(look, (64, 48), 16);
        let frames = run(&source, &steady(&["history.depth=3", "history.step=1"]), &[0, 1, 2, 3]);
        let rays = shadow_rays(&frames);
        assert!(rays[1..].iter().all(|n| *n * 2 < rays[0]), "{look:?}: {rays:?}");
        frames.iter().for_each(|frame| {
            assert_eq!(frame.image, frames[0].image, "{look:?}");
            let others = |frame: &FrameReplay| {
                let rays = frame.stats.counts.rays_traced;
                [rays.primary, rays.reflection, rays.refraction]
            };
            assert_eq!(others(frame), others(&frames[0]), "{look:?}");
        });
    }
}

/// An entry that was taken from entries is older than they, and at `age` nobody believes it.
#[test]
fn what_is_known_grows_old() {
    let source = Still::new(Look::Flat, (9, 5), 8);
    for age in [1, 2, 5] {
        let sets =
            [BLIND.to_owned(), "history.step=1".into(), "history.refresh=1024".into(), format!("history.age={age}")];
        let rays =
            shadow_rays(&run(&source, &steady(&sets.each_ref().map(String::as_str)), &(0..13).collect::<Vec<_>>()));
        // R-samples: 0, 4 and 8, by 0 and 4. Looked for in frame 0 and age + 1 frames later again.
        let expected: Vec<_> = (0..13).map(|frame| if frame % (age + 1) == 0 { 6 } else { 0 }).collect();
        assert_eq!(rays, expected, "age {age}");
    }
}

/// After a frame number that does not follow, a turn of the view, or where all is another object, all rays are cast.
#[test]
fn what_is_new_is_looked_for() {
    let of = |change: &dyn Fn(&mut Still), sets: &[&str], frames: &[u32]| {
        let mut source = Still::new(Look::Flat, (33, 17), 16);
        change(&mut source);
        shadow_rays(&run(&source, &steady(sets), frames))
    };
    let rays = of(&|_| (), &[BLIND], &[0, 1, 7, 8]);
    let all = rays[0];
    assert!(rays[1] < all && rays[2] == all && rays[3] < all, "frame 7 does not follow: {rays:?}");
    let rays = of(&|still| still.other = 2, &[BLIND], &[0, 1, 2, 3]);
    assert!(rays[1] < all && rays[2] == all && rays[3] < all, "another object: {rays:?}");
    // The hits are as far as before in other directions: off their planes, and partly outside of the picture before.
    let turn = |cut: &str| of(&|still| still.turned = 2, &[BLIND, "history.plane=1", cut], &[0, 1, 2, 3]);
    let (cut, followed) = (turn("cut_deg=15"), turn("cut_deg=180"));
    assert!(cut[1] < all && cut[2] == all && cut[3] < all, "the view turned: {cut:?}");
    assert!(followed[2] > followed[1] && followed[2] < all, "some is still in the picture: {followed:?}");
}

/// All lights go out at once. What is taken for known is wrong for a frame; then checks have said so, and tiles look for themselves until
/// the checks outweigh it.
#[test]
fn tiles_that_were_wrong_look_for_themselves() {
    let mut source = Still::new(Look::Flat, (64, 32), 32);
    source.dark = 3;
    let policy =
        steady(&[BLIND, "similarity.shadow=false", "history.refresh=4", "history.trust=0.1", "history.step=2"]);
    let frames = run(&source, &policy, &(0..12).collect::<Vec<_>>());
    let told = retell(&source, &policy, &frames);
    let rays = shadow_rays(&frames);
    let all = rays[0];
    // Frame 3 is taken in, frame 4 is not.
    assert!(rays[3] * 2 < all, "{rays:?}");
    assert_eq!(rays[4], all, "{rays:?}");
    let checks =
        |frame: usize| told[frame].outcome.history.checked.values().fold((0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
    assert_eq!(checks(2).1, 0);
    assert_eq!(checks(3).0, checks(3).1, "all lights went out");
    // Entries that stood on the old lights are looked up once more, and are wrong.
    assert!((5..12).all(|frame| checks(frame).1 == 0), "the new lights are known");
    let again = (5..12).find(|&frame| rays[frame] < all);
    assert!(again.is_some_and(|frame| frame > 5), "trusted again in time, and not at once: {rays:?}");
}

/// On a recorded flight a machine is charged for what the second implementation sought, read and kept.
#[test]
fn a_machine_is_charged_for_what_is_read_and_kept() {
    let trace = golden::trace("v1_0_teapot.rtrace");
    for (step, depth) in [(1, 3), (4, 1), (2, 0)] {
        let sets = [format!("history.step={step}"), format!("history.depth={depth}"), "history.cover=0.5".into()];
        let policy = steady(&sets.each_ref().map(String::as_str));
        let numbers = trace.meta().frame_numbers();
        let (frames, works): (Vec<_>, Vec<_>) =
            work_of(&trace, &Policy::Temporal(policy.clone()), numbers).into_iter().unzip();
        let told = retell(&trace, &policy, &frames);
        let columns = trace.meta().grid().0.div_ceil(step);
        let edge = trace.meta().tile / step;
        for (i, (written, works)) in told.iter().zip(&works).enumerate() {
            assert_same(trace.meta(), &frames[i], &written.outcome, &written.audited, "teapot");
            let sought: u64 =
                works.iter().flat_map(|work| &work.rounds).map(|round| u64::from(round.looked_back)).sum();
            assert_eq!(sought, written.outcome.history.hits);
            assert_eq!(sought > 0, i > 0);
            let spared: u32 = works.iter().flat_map(|work| &work.rays).map(|ray| u32::from(ray.known_lights)).sum();
            let expected = written.outcome.traced.iter().flatten().map(|traced| traced.spared);
            assert_eq!(spared, expected.sum::<u32>());
            let made: u64 = works.iter().flat_map(|work| &work.rounds).map(|round| u64::from(round.attributes)).sum();
            assert_eq!(made, written.outcome.attributes);
            let mut read = BTreeSet::new();
            for work in works {
                let kept = (work.history.kept as usize, work.history.kept_below as usize);
                assert_eq!(kept, written.kept[work.tile as usize], "tile {}", work.tile);
                let mut entries = BTreeSet::new();
                for span in work.history.reads.iter().filter(|span| !span.below) {
                    let (tx, ty) = (span.tile % trace.meta().tile_grid().0, span.tile / trace.meta().tile_grid().0);
                    let in_row = edge.min(columns - tx * edge);
                    for entry in span.first..span.first + span.count {
                        let (x, y) = (tx * edge + entry % in_row, ty * edge + entry / in_row);
                        assert!(entries.insert((y * columns + x) as usize), "tile {} reads an entry twice", work.tile);
                    }
                }
                // The hits below these entries and no others, each once.
                let mut below = BTreeSet::new();
                for span in work.history.reads.iter().filter(|span| span.below) {
                    let hits = span.first..span.first + span.count;
                    assert!(hits.end as usize <= told[i - 1].kept[span.tile as usize].1, "tile {}", work.tile);
                    hits.for_each(|hit| {
                        assert!(below.insert((span.tile, hit)), "tile {} reads a hit twice", work.tile)
                    });
                }
                let of_entries = entries.iter().map(|&entry| told[i - 1].below[entry]);
                assert_eq!(below.len(), of_entries.sum::<usize>(), "tile {}", work.tile);
                read.extend(entries);
            }
            assert_eq!(read, written.outcome.history.read);
        }
    }
}
