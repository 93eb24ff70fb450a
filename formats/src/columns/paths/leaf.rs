//! The triangle tests of a leaf as one label: two bits a triangle, 0 where there was no test.

use crate::tile::step;

pub(super) const MISS: u8 = 1;
pub(super) const HIT: u8 = 2;
pub(super) const PASS: u8 = 3;

/// Packs up to `count` steps; a hit ends a shadow ray.
#[inline(always)]
pub(super) fn take(steps: &mut std::slice::Iter<'_, u8>, count: usize, any: bool) -> u8 {
    let mut label = 0;
    for i in 0..count {
        let step = steps.next().map_or(0, |s| s - step::MISS + MISS);
        label |= step << (2 * i);
        if any && step == HIT {
            break;
        }
    }
    label
}

/// Appends the steps of a label.
#[inline(always)]
pub(super) fn put(mut label: u8, out: &mut Vec<u8>) {
    while label != 0 {
        out.push((label & 3) - MISS + step::MISS);
        label >>= 2;
    }
}

/// True when one of the tests is a hit.
#[inline(always)]
pub(super) fn has_hit(label: u8) -> bool {
    label & !(label << 1) & 0xaa != 0
}
