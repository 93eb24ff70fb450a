//! The bill of a frame: who was traced, and what each tile pays for its own samples and its apron.

use rayreel_replay::policy::Apron;

use super::area::{Area, border};
use super::maker::Maker;
use super::outcome::Outcome;
use crate::past::Traced;
use crate::recorded::Rays;

impl Maker<'_> {
    pub fn account(self, tiles: &[Area], before: &[Vec<Traced>]) -> Outcome {
        let width = self.frame.width;
        let rays_of = |traced: &[Vec<Traced>], at: usize| -> Option<Rays> {
            let hits = self.frame.rays[at].iter().zip(&traced[at]).filter(|(_, traced)| traced.hit);
            let cast = |(&[p, a, b, shadow], traced): (&Rays, &Traced)| [p, a, b, shadow - u64::from(traced.spared)];
            traced[at].iter().any(|traced| traced.hit).then(|| sum(hits.map(cast)))
        };
        let mut outcome = Outcome {
            width,
            how: self.known.iter().map(|k| k.as_ref().expect("every sample is decided").how).collect(),
            rounds: self.known.iter().map(|k| k.as_ref().unwrap().round).collect(),
            colours: self.known.iter().map(|k| k.as_ref().unwrap().tree.colour).collect(),
            traced: Vec::new(),
            stand_ins: Vec::new(),
            rays_full: sum(self.frame.rays.iter().flatten().copied()),
            rays_traced: [0; 4],
            rays_apron: [0; 4],
            samples_apron: 0,
            attributes: self.lazy.made,
            history: self.history,
            tiles: Vec::new(),
        };
        for area in tiles {
            let paid_for_itself = sum(area.samples().filter_map(|(x, y)| rays_of(&self.traced, y * width + x)));
            let mut again = Vec::new();
            if self.policy.apron == Apron::Retrace {
                let border = border(area, self.frame);
                // What a neighbour corrects later is not traced again.
                again.extend(border.into_iter().filter_map(|(x, y)| rays_of(before, y * width + x)));
            }
            outcome.samples_apron += again.len() as u64;
            let paid = (paid_for_itself, sum(again.into_iter()));
            outcome.rays_traced = sum([outcome.rays_traced, paid.0].into_iter());
            outcome.rays_apron = sum([outcome.rays_apron, paid.1].into_iter());
            outcome.tiles.push(paid);
        }
        Outcome { traced: self.traced, stand_ins: self.stand_ins, ..outcome }
    }
}

fn sum(list: impl Iterator<Item = Rays>) -> Rays {
    list.fold([0; 4], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
}
