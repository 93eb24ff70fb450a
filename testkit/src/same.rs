//! A replayed frame beside what the second implementation says of it.

use rayreel_formats::scene::Meta;
use rayreel_replay::FrameReplay;
use rayreel_replay::counts::RayCounts;
use rayreel_replay::image::resolve::Resolver;

use crate::reference::{Origin, Outcome, Rays};

/// Demands the same states, rounds, colours to the bit, rays of tiles, and findings of audits: per tile the squared error and the
/// number of values.
///
/// # Panics
/// When something differs.
#[track_caller]
pub fn assert_same(meta: &Meta, frame: &FrameReplay, expected: &Outcome, audits: &[(u64, u64)], what: &str) {
    let found: Vec<_> = frame.stats.tiles.iter().map(|t| (t.audited.sum, t.audited.values)).collect();
    assert_eq!(found, audits, "{what}: audits");
    let (width, height) = meta.grid();
    let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
    for (i, (x, y)) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).enumerate() {
        let how = Origin::from(frame.states.state(x, y));
        assert_eq!((how, frame.states.round(x, y)), (expected.how[i], expected.rounds[i]), "{what}: ({x}, {y})");
        resolver.add(x, y, expected.colours[i].into());
    }
    let bits = |v: &[f32; 3]| v.map(f32::to_bits);
    let image = resolver.finish();
    let wrong = image.pixels.iter().zip(&frame.image.pixels).position(|(a, b)| bits(a) != bits(b));
    assert_eq!(wrong, None, "{what}: colour of a pixel");
    let tiles = frame.stats.tiles.iter().map(|t| (kinds(t.counts.rays_traced), kinds(t.counts.rays_apron)));
    assert!(tiles.eq(expected.tiles.iter().copied()), "{what}: rays of tiles");
}

fn kinds(rays: RayCounts) -> Rays {
    [rays.primary, rays.reflection, rays.refraction, rays.shadow]
}
