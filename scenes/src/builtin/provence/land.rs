//! The lie of the land: heights, the road's course, the pool's outline, the field's borders.
//!
//! Metres; x to the east, z to the south, the farmhouse at the origin.

use glam::{DVec2, DVec3};

use crate::modelling::{paint, part::sin_cos};

/// Centre of the pool.
pub const POOL: DVec2 = DVec2::new(8.5, 16.5);
/// Half axes of the pool, to the middle of its rim.
pub const POOL_AXES: DVec2 = DVec2::new(6.2, 3.9);
/// Field of lavender: west, north, east and south borders.
pub const FIELD: [f64; 4] = [-34.0, 24.0, 9.0, 74.0];
/// West and east end of the gravel court before the house.
pub const COURT: [f64; 2] = [-9.3, 17.6];
/// Half the width of the road.
pub const ROAD_HALF: f64 = 1.55;
/// The road's course from south to north.
const ROAD: [DVec2; 12] = [
    DVec2::new(34.0, 120.0),
    DVec2::new(22.0, 96.0),
    DVec2::new(14.5, 76.0),
    DVec2::new(13.5, 58.0),
    DVec2::new(18.0, 42.0),
    DVec2::new(21.5, 28.0),
    DVec2::new(18.5, 13.0),
    DVec2::new(14.5, 0.0),
    DVec2::new(16.5, -14.0),
    DVec2::new(8.0, -30.0),
    DVec2::new(-16.0, -46.0),
    DVec2::new(-36.0, -72.0),
];

/// From 0 below `low` to 1 above `high`, without a kink.
#[must_use]
pub fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Height of the ground.
#[must_use]
pub fn height(x: f64, z: f64) -> f64 {
    // A level yard round the house and the pool; rolling land beyond.
    let yard = smooth(12.0, 44.0, DVec2::new((x - 3.0) * 0.8, z - 6.0).length());
    let wave = |size: f64, seed: u32| paint::noise(x / size + 11.3, z / size - 4.7, seed) - 0.5;
    let rolling = 3.4 * wave(46.0, 21) + 1.0 * wave(19.0, 22);
    let rise = 2.6 * smooth(14.0, 62.0, z) + 2.2 * smooth(20.0, 70.0, x);
    let far = DVec2::new(x, z - 10.0).length();
    let hills = smooth(70.0, 260.0, far) * (26.0 * wave(150.0, 23) + 9.0 * wave(61.0, 24) + 6.0);
    let range = smooth(300.0, 820.0, far) * (70.0 + 150.0 * wave(330.0, 25) + 30.0 * wave(150.0, 26));
    yard * rolling + rise + hills + range
}

/// A point of the ground.
#[must_use]
pub fn ground(x: f64, z: f64) -> DVec3 {
    DVec3::new(x, height(x, z), z)
}

/// How far out a place is in the pool's ellipse: 1 on the middle of the rim.
#[must_use]
pub fn pool_radius(x: f64, z: f64) -> f64 {
    ((DVec2::new(x, z) - POOL) / POOL_AXES).length()
}

/// A point on an ellipse `offset` metres outside the middle of the pool's rim.
#[must_use]
pub fn pool_rim(turn: f64, offset: f64) -> DVec2 {
    let (sin, cos) = sin_cos(std::f64::consts::TAU * turn);
    POOL + DVec2::new(cos, -sin) * (POOL_AXES + DVec2::splat(offset))
}

/// The road's middle, `t` from 0 to 1, and its direction.
#[must_use]
pub fn road(t: f64) -> (DVec2, DVec2) {
    let last = ROAD.len() - 1;
    let s = (t * last as f64).clamp(0.0, last as f64 - 1e-9);
    let i = s as usize;
    let f = s - i as f64;
    let at = |k: usize| ROAD[k.min(last)];
    let [a, b, c, d] = [at(i.saturating_sub(1)), at(i), at(i + 1), at(i + 2)];
    let (m0, m1) = ((c - a) / 2.0, (d - b) / 2.0);
    let (f2, f3) = (f * f, f * f * f);
    let p = b * (2.0 * f3 - 3.0 * f2 + 1.0) + m0 * (f3 - 2.0 * f2 + f) + c * (3.0 * f2 - 2.0 * f3) + m1 * (f3 - f2);
    let v = b * (6.0 * f2 - 6.0 * f)
        + m0 * (3.0 * f2 - 4.0 * f + 1.0)
        + c * (6.0 * f - 6.0 * f2)
        + m1 * (3.0 * f2 - 2.0 * f);
    (p, v.normalize_or(DVec2::Y))
}

/// Distance from the middle of the road.
#[must_use]
pub fn road_distance(x: f64, z: f64) -> f64 {
    let p = DVec2::new(x, z);
    let nearest = (0..=220).map(|i| (road(f64::from(i) / 220.0).0 - p).length_squared()).fold(f64::MAX, f64::min);
    nearest.sqrt()
}

/// Whether a place lies in the field of lavender, `margin` metres inside its borders.
#[must_use]
pub fn in_field(x: f64, z: f64, margin: f64) -> bool {
    let [west, north, east, south] = FIELD;
    x > west + margin && x < east - margin && z > north + margin && z < south - margin
}

/// The court's winding southern edge.
#[must_use]
pub fn court_edge(x: f64) -> f64 {
    8.6 + 2.6 * smooth(-3.0, 6.0, x) + 0.9 * (paint::noise(x / 3.1, 2.5, 27) - 0.5)
}

/// Whether a place is built over: house, yard or pool.
#[must_use]
pub fn is_built(x: f64, z: f64) -> bool {
    let house = x > -17.5 && x < 11.5 && z > -9.0 && z < 9.5;
    let court = x > COURT[0] && x < COURT[1] && z > 0.0 && z < court_edge(x) - 0.15;
    house || court || pool_radius(x, z) < 1.45
}
