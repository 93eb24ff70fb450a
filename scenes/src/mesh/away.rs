//! Models far from the origin.

use glam::Vec3;

/// More than so many times the model's size away from the origin, rays that leave a surface begin visibly off it: they begin a part
/// in 131,072 of the largest coordinate away.
const AWAY_MAX: f32 = 2000.0;

/// How far from the origin a model lies, if that is too far for its size.
pub(crate) fn away(positions: &[Vec3]) -> Option<String> {
    let (low, high) = bounds(positions);
    let (size, largest) = ((high - low).max_element(), low.abs().max(high.abs()).max_element());
    (largest > AWAY_MAX * size)
        .then(|| format!("the model, {size:e} units large, lies {largest:e} units from the origin"))
}

/// The smallest and the largest of the coordinates.
pub(crate) fn bounds(positions: &[Vec3]) -> (Vec3, Vec3) {
    positions.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)))
}
