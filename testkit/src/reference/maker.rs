//! The steps of the adaptive policies over a frame in the making.

use std::cell::Cell;
use std::collections::BTreeMap;

use rayreel_replay::policy::{Adaptive, Refine};

use super::area::Area;
use super::outcome::Origin;
use crate::recorded::Frame;
use crate::rules::{Hit, Judge, between, difference, mix};
use crate::shade::shade;

/// What is known of a sample.
#[derive(Clone)]
pub struct KnownSample {
    pub tree: Hit,
    pub how: Origin,
    pub round: u8,
}

/// A frame in the making.
pub struct Maker<'a> {
    pub policy: &'a Adaptive,
    pub frame: &'a Frame,
    pub known: Vec<Option<KnownSample>>,
    pub traced: Vec<Vec<bool>>,
    pub stand_ins: Vec<(usize, Hit)>,
    pub lazy: LazyAttributes,
}

/// Attributes of interpolated hits that are made when they are read.
#[derive(Default)]
pub struct LazyAttributes {
    /// By tile (its first sample) and sample: of how many hits there are attributes.
    there: BTreeMap<((usize, usize), usize), u32>,
    /// All that were made.
    pub made: u64,
}

impl Maker<'_> {
    /// Traces a sample whole.
    pub fn whole(&mut self, at: usize, how: Origin, round: u8) {
        self.traced[at].fill(true);
        self.known[at] = Some(KnownSample { tree: self.frame.recorded[at].clone(), how, round });
    }

    pub fn tree(&self, at: usize) -> &Hit {
        &self.known[at].as_ref().expect("known").tree
    }

    pub fn judge(&self, area: &Area, gap: usize) -> Judge<'_> {
        Judge {
            similarity: &self.policy.sampling.similarity,
            relax: area.relax,
            gap,
            stand_in: self.policy.sampling.stand_in,
            compared: Cell::new(0),
        }
    }

    /// Decides the inner samples of `line`, whose two ends are known.
    pub fn fill(&mut self, area: &Area, line: &[usize], round: u8, foreseen: f64) {
        let gap = line.len() - 1;
        if gap < 2 {
            return;
        }
        let (a, b) = (self.tree(line[0]).clone(), self.tree(line[gap]).clone());
        let (similar, compared) = {
            let judge = self.judge(area, gap);
            (judge.samples(&a, &b, foreseen), judge.compared.get())
        };
        [line[0], line[gap]].into_iter().for_each(|end| self.read(area, end, compared));
        if similar {
            for (i, &at) in line.iter().enumerate().take(gap).skip(1) {
                let (near, far, s) = nearer(&a, &b, i, gap);
                let mut tree = between(near, far, s);
                shade(&self.policy.sampling, self.frame, (near, far), s, &mut tree);
                self.known[at] = Some(KnownSample { tree, how: Origin::Interpolated, round });
            }
            return;
        }
        if self.policy.sampling.refine == Refine::Direct {
            (1..gap).for_each(|i| self.trace(area, (&a, &b), line, i, round));
            return;
        }
        let m = gap / 2;
        self.trace(area, (&a, &b), line, m, round);
        let mut foreseen = f64::INFINITY;
        let middle = self.known[line[m]].as_ref().unwrap();
        if self.policy.sampling.similarity.predict && middle.how == Origin::Traced {
            let (near, far, s) = nearer(&a, &b, m, gap);
            let guess = mix(near.colour, far.colour, s);
            foreseen = difference((guess, middle.tree.colour), (guess, middle.tree.colour));
        }
        self.fill(area, &line[..=m], round + 1, foreseen);
        self.fill(area, &line[m..], round + 1, foreseen);
    }

    /// Traces sample `i` of `line`, or what of it must be.
    pub fn trace(&mut self, area: &Area, (a, b): (&Hit, &Hit), line: &[usize], i: usize, round: u8) {
        if !self.policy.sampling.secondary {
            return self.whole(line[i], Origin::Traced, round);
        }
        [line[0], line[line.len() - 1]].into_iter().for_each(|end| self.read(area, end, u32::MAX));
        let (near, far, s) = nearer(a, b, i, line.len() - 1);
        let judge = self.judge(area, line.len() - 1);
        let mut traced = vec![false; self.traced[line[i]].len()];
        let tree = judge.rebuild((near, far), s, &self.frame.recorded[line[i]], &mut traced);
        let how = match (traced.iter().any(|t| *t), traced.iter().all(|t| *t)) {
            (false, _) => Origin::Interpolated,
            (true, true) => Origin::Traced,
            (true, false) => Origin::Partial,
        };
        if !traced[0] && how == Origin::Partial {
            self.stand_ins.push((line[i], tree.clone()));
        }
        let (hits, of_rays) = (tree.hits(), traced.iter().filter(|t| **t).count() as u32);
        self.lazy.there.insert(((area.x0, area.y0), line[i]), hits);
        self.lazy.made += u64::from(hits.saturating_sub(of_rays));
        self.traced[line[i]] = traced;
        self.known[line[i]] = Some(KnownSample { tree, how, round });
    }

    /// A tile reads the first hits of a sample: of one that is interpolated it makes what it did not make before.
    pub fn read(&mut self, area: &Area, at: usize, hits: u32) {
        let sample = self.known[at].as_ref().unwrap();
        if sample.how == Origin::Interpolated {
            let there = self.lazy.there.entry(((area.x0, area.y0), at)).or_default();
            let new = hits.min(sample.tree.hits()).saturating_sub(*there);
            *there += new;
            self.lazy.made += u64::from(new);
        }
    }

    /// Traces interpolated samples that a traced neighbour in the tile contradicts, pass by pass.
    pub fn correct(&mut self, area: &Area) {
        let correct = &self.policy.sampling.correct;
        let mut news: Vec<(usize, usize)> = area.samples().collect();
        for pass in 0..correct.passes as u8 {
            let mut found = Vec::new();
            for (x, y) in area.samples() {
                let at = y * self.frame.width + x;
                let is_witness = |&(u, v): &(usize, usize)| {
                    x.abs_diff(u).max(y.abs_diff(v)) == 1
                        && self.known[v * self.frame.width + u].as_ref().unwrap().how != Origin::Interpolated
                };
                if news.iter().any(is_witness) {
                    self.read(area, at, 1);
                }
                let sample = self.known[at].as_ref().unwrap();
                if sample.how == Origin::Interpolated && news.iter().any(|&at| self.contradicts(area, (x, y), at)) {
                    found.push((x, y));
                }
            }
            let round = 1 + 2 * area.levels(self.policy.sampling.refine) + pass;
            found.iter().for_each(|&(x, y)| self.whole(y * self.frame.width + x, Origin::Traced, round));
            news = found;
        }
    }

    pub fn contradicts(&self, area: &Area, (x, y): (usize, usize), (u, v): (usize, usize)) -> bool {
        if x.abs_diff(u).max(y.abs_diff(v)) != 1 {
            return false;
        }
        let (sample, witness) = (&self.known[y * self.frame.width + x], &self.known[v * self.frame.width + u]);
        let (sample, witness) = (sample.as_ref().unwrap(), witness.as_ref().unwrap());
        if witness.how == Origin::Interpolated || self.judge(area, 1).alike(&sample.tree, &witness.tree) {
            return false;
        }
        let colours = (sample.tree.colour, witness.tree.colour);
        let differ = difference(colours, colours);
        self.policy.sampling.correct.colour.value().is_none_or(|limit| differ.is_nan() || differ > limit)
    }
}

/// The nearer end for step `i` of `gap`, the other, and the other's share.
fn nearer<'h>(a: &'h Hit, b: &'h Hit, i: usize, gap: usize) -> (&'h Hit, &'h Hit, f32) {
    if i <= gap - i { (a, b, i as f32 / gap as f32) } else { (b, a, (gap - i) as f32 / gap as f32) }
}
