//! The triangle tests of a leaf as one label: two bits a triangle, 0 where there was no test.

use crate::tile::step;

pub(super) const MISS: u8 = 1;
pub(super) const HIT: u8 = 2;
pub(super) const PASS: u8 = 3;

/// Packs up to `count` steps; a hit ends a shadow ray. Fails where a step is no triangle test or there is none.
#[inline(always)]
pub(super) fn take(steps: &mut std::slice::Iter<'_, u8>, count: usize, any_hit: bool) -> Result<u8, &'static str> {
    let mut label = 0;
    for i in 0..count {
        let &test @ step::MISS..=step::PASS = steps.next().ok_or("it ends in a leaf")? else {
            return Err("a step in a leaf is no triangle test");
        };
        let outcome = test - step::MISS + MISS;
        label |= outcome << (2 * i);
        if any_hit && outcome == HIT {
            break;
        }
    }
    Ok(label)
}

/// Appends the steps of a label.
#[inline(always)]
pub(super) fn put(mut label: u8, out: &mut Vec<u8>) {
    while label != 0 {
        out.push((label & 3) - MISS + step::MISS);
        label >>= 2;
    }
}

/// The upper bit of each test that is a hit.
#[inline(always)]
pub(super) fn hits(label: u8) -> u8 {
    label & !(label << 1) & 0xaa
}
