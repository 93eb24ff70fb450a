//! How energies are rounded to femtojoules.

/// Division rounded to the nearest, halves up.
pub(super) fn nearest(value: u128, by: u128) -> u128 {
    (value + by / 2) / by
}
