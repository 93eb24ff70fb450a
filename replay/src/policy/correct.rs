//! Post-correction: interpolated samples that a traced neighbour contradicts are traced after all.
//!
//! An object thinner than a block slips between R-samples, but rarely everywhere: where one of its samples is traced, its
//! interpolated neighbours show something else. They are traced, which brings the object one sample further, and so on along
//! it, pass by pass, until nothing contradicts or the passes are used up (after Kim et al. 2016, whose filters are not
//! published). It looks at all eight neighbours, since a thin wire may run on diagonally, from corner to corner of its
//! samples; only at those inside the tile, so that no tile waits for another.
//!
//! A highlight, and what is seen in a mirror or through glass, is an edge that primary hits do not show. So a large difference of colours
//! counts whatever the hits say (`correct.colour_alone`).

use super::similarity::{Compared, Tests, costs, difference};
use super::tree::Node;
use super::view::{SampleState, TileView};
use super::{Attributes, Sampling, Shade};

/// Corrects a tile whose samples are all known, with both limits multiplied by `factor`. The first pass is round `round`, and each pass a round.
pub fn correct(view: &mut TileView, sampling: &Sampling, (tests, factor): (&Tests, f64), round: u8) {
    let rules = &sampling.correct;
    let is_lazy = sampling.attributes == Attributes::Lazy;
    let [colour, alone] = [rules.colour, rules.colour_alone].map(|limit| limit.value().map(|limit| limit * factor));
    let limits = Limits { colour, alone, is_weighed: rules.weighed };
    // The samples that may contradict: in the first pass all.
    let mut witnesses = vec![true; view.rect().len()];
    // The interpolated samples whose attributes were looked at: they have to be interpolated too, once.
    let mut read = vec![sampling.shade == Shade::Attributes; view.rect().len()];
    for pass in 0..rules.passes {
        let round = round + pass as u8;
        let found = contradicted(view, (tests, limits), round, &witnesses, (is_lazy, &mut read));
        if found.is_empty() {
            return;
        }
        // Later only those that were traced just now: the others had their say.
        witnesses.fill(false);
        for (x, y) in found {
            view.correct(x, y, round);
            witnesses[offset(view, x, y)] = true;
        }
    }
}

/// The interpolated samples that a traced neighbour among `witnesses` contradicts.
fn contradicted(
    view: &mut TileView,
    (tests, limits): (&Tests, Limits),
    round: u8,
    witnesses: &[bool],
    (is_lazy, read): (bool, &mut [bool]),
) -> Vec<(u32, u32)> {
    let rect = view.rect();
    let (right, bottom) = (rect.x + rect.width, rect.y + rect.height);
    let mut found = Vec::new();
    for y in rect.y..bottom {
        for x in rect.x..right {
            if !matches!(view.state(x, y), Some((SampleState::Interpolated, _))) {
                continue;
            }
            let (columns, rows) = (x.max(rect.x + 1) - 1..right.min(x + 2), y.max(rect.y + 1) - 1..bottom.min(y + 2));
            let (doubted, mut made) = (&view.tree(x, y)[0], Compared::default());
            let around = rows.flat_map(|v| columns.clone().map(move |u| (u, v)));
            // The sample itself is interpolated, so it is no witness.
            let mut nearby = around.filter(|&(u, v)| {
                witnesses[offset(view, u, v)] && !matches!(view.state(u, v), Some((SampleState::Interpolated, _)))
            });
            if nearby.any(|(u, v)| contradicts(doubted, &view.tree(u, v)[0], (tests, limits), &mut made)) {
                found.push((x, y));
            }
            if made == Compared::default() {
                continue;
            }
            view.compared((x, y), round, made);
            if made.pairs == 0 {
                continue;
            }
            if is_lazy {
                view.read_hits((x, y), round, (x, y), 1);
                continue;
            }
            let is_new = !std::mem::replace(&mut read[offset(view, x, y)], true);
            view.read_attributes((x, y), round, is_new.into());
        }
    }
    found
}

/// How far colours must differ for a contradiction to count.
#[derive(Clone, Copy)]
struct Limits {
    /// Of samples whose hits are unlike; None: they count in any case.
    colour: Option<f64>,
    /// Of samples whose hits are alike; None: they never count.
    alone: Option<f64>,
    is_weighed: bool,
}

/// Whether a viewer could see the difference of a sample and a witness, and either their hits differ too or the difference is large.
fn contradicts(doubted: &Node, witness: &Node, (tests, limits): (&Tests, Limits), compared: &mut Compared) -> bool {
    let weight = if limits.is_weighed { costs(doubted.rays.midpoint(witness.rays)) } else { 1.0 };
    let colours = (doubted.colour, witness.colour);
    let exceeds = |limit: f64| {
        let shown = difference(colours, colours);
        shown > limit * weight || shown.is_nan()
    };
    let differs = |compared: &mut Compared| {
        compared.pairs += 1;
        !tests.alike_hits(doubted, witness, compared)
    };
    // What is looked at second is spared where the first decides.
    if tests.colours_first() {
        compared.colours += u32::from(limits.colour.is_some() || limits.alone.is_some());
        return limits.alone.is_some_and(exceeds) || (limits.colour.is_none_or(exceeds) && differs(compared));
    }
    let unlike = differs(compared);
    // Unlike or not, a difference beyond `alone` is enough.
    let either = |colour: f64| limits.alone.map_or(colour, |alone| alone.min(colour));
    match if unlike { limits.colour.map(either) } else { limits.alone } {
        Some(limit) => {
            compared.colours += 1;
            exceeds(limit)
        }
        None => unlike,
    }
}

fn offset(view: &TileView, x: u32, y: u32) -> usize {
    let rect = view.rect();
    (y - rect.y) as usize * rect.width as usize + (x - rect.x) as usize
}
