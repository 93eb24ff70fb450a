//! The anchors, by what they are about. Bounds and sources only: nothing here is measured.

mod area;
mod energy;
mod mechanisms;
mod replays;
mod sampling;
mod speed;

use super::anchor::Anchor;

/// All anchors, in the order of the table.
pub fn all() -> impl Iterator<Item = &'static Anchor> {
    [speed::ANCHORS, energy::ANCHORS, mechanisms::ANCHORS, area::ANCHORS, sampling::ANCHORS].into_iter().flatten()
}

#[cfg(test)]
mod tests;
