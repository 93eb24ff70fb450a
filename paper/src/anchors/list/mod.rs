//! The anchors, by what they are about. Bounds and sources only: nothing here is measured.

mod area;
mod energy;
mod mechanisms;
mod replays;
mod sampling;
mod speed;
mod systems;

use super::anchor::Anchor;

/// All anchors, in the order of the table.
pub fn all() -> impl Iterator<Item = &'static Anchor> {
    let lists =
        [speed::ANCHORS, systems::ANCHORS, energy::ANCHORS, mechanisms::ANCHORS, area::ANCHORS, sampling::ANCHORS];
    lists.into_iter().flatten()
}

#[cfg(test)]
mod tests;
