//! The steps of the adaptive policies over a frame in the making.

use std::cell::Cell;
use std::collections::BTreeMap;

use rayreel_replay::policy::{Adaptive, First, HistoryRules, Refine};

use super::area::Area;
use super::draw::draw;
use super::outcome::{Origin, Sought};
use crate::past::{Glance, Past, Traced};
use crate::recorded::Frame;
use crate::rules::{Hit, Judge, Tracing, between, difference, mix};
use crate::shade::shade;

/// What is known of a sample.
#[derive(Clone)]
pub struct KnownSample {
    pub tree: Hit,
    pub how: Origin,
    pub round: u8,
    pub age: u32,
}

/// What a frame knows of the one before.
pub struct Memory<'a> {
    pub rules: &'a HistoryRules,
    /// The frame at work.
    pub frame: u32,
    /// Nothing in a first frame.
    pub past: Option<&'a Past>,
}

/// A frame in the making.
pub struct Maker<'a> {
    pub policy: &'a Adaptive,
    pub frame: &'a Frame,
    pub known: Vec<Option<KnownSample>>,
    pub traced: Vec<Vec<Traced>>,
    pub stand_ins: Vec<(usize, Hit)>,
    pub lazy: LazyAttributes,
    pub memory: Option<Memory<'a>>,
    pub history: Sought,
}

/// Attributes of interpolated hits that are made when they are read.
#[derive(Default)]
pub struct LazyAttributes {
    /// By tile (its first sample) and sample: of how many hits there are attributes.
    there: BTreeMap<((usize, usize), usize), u32>,
    /// All that were made.
    pub made: u64,
}

impl<'a> Maker<'a> {
    /// Of which nothing is known yet.
    pub fn new(policy: &'a Adaptive, frame: &'a Frame, memory: Option<Memory<'a>>) -> Self {
        let known = vec![None; frame.recorded.len()];
        let traced = frame.rays.iter().map(|hits| vec![Traced::default(); hits.len()]).collect();
        let (stand_ins, lazy, history) = (Vec::new(), LazyAttributes::default(), Sought::default());
        Self { policy, frame, known, traced, stand_ins, lazy, memory, history }
    }

    /// Traces a sample whole.
    pub fn whole(&mut self, at: usize, how: Origin, round: u8) {
        self.traced[at].fill(Traced::WHOLE);
        self.known[at] = Some(KnownSample { tree: self.frame.recorded[at].clone(), how, round, age: 0 });
    }

    /// Traces a sample whole but for rays at lights that it finds in the history.
    pub fn trace_whole(&mut self, area: &Area, at: usize, how: Origin, round: u8) {
        let mut glance = self.glance(area, at);
        if !glance.looks() {
            return self.whole(at, how, round);
        }
        let tree = glance.see_all(1, &self.frame.recorded[at]);
        let how = if how == Origin::R || glance.is_whole() { how } else { Origin::Partial };
        self.known[at] = Some(KnownSample { tree, how, round, age: glance.age });
        self.note(area, at, glance);
    }

    /// What a sample does with the history.
    fn glance(&self, area: &Area, at: usize) -> Glance<'a> {
        let hits = self.traced[at].len();
        let Some(Memory { rules, frame, past: Some(past) }) = self.memory else {
            return Glance::new(None, false, hits);
        };
        let checks = draw(at as u64).wrapping_add(frame.into()).is_multiple_of(rules.refresh.into());
        Glance::new((checks || area.is_trusted).then_some(past), checks, hits)
    }

    fn note(&mut self, area: &Area, at: usize, glance: Glance<'a>) {
        self.history.hits += glance.sought;
        self.history.read.extend(glance.read);
        self.history.twins.extend(glance.twins);
        let (checks, mistaken) = self.history.checked.entry((area.x0, area.y0)).or_default();
        (*checks, *mistaken) = (*checks + glance.checked.0, *mistaken + glance.checked.1);
        self.traced[at] = glance.hits;
    }

    /// How many hits of a sample the history keeps.
    fn kept(&self, at: usize) -> u32 {
        let Some(Memory { rules, .. }) = &self.memory else { return 0 };
        let (x, y, step) = (at % self.frame.width, at / self.frame.width, rules.step as usize);
        match (x.is_multiple_of(step) && y.is_multiple_of(step), rules.depth) {
            (false, _) => 0,
            (true, 0) => 1,
            (true, _) => u32::MAX,
        }
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
                let kept = self.kept(at);
                [line[0], line[gap]].into_iter().for_each(|end| self.read(area, end, kept));
                let age = self.age(line);
                self.known[at] = Some(KnownSample { tree, how: Origin::Interpolated, round, age });
                self.read(area, at, kept);
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
        if self.policy.sampling.similarity.predict && self.traced[line[m]].iter().all(|traced| traced.hit) {
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
            return self.trace_whole(area, line[i], Origin::Traced, round);
        }
        [line[0], line[line.len() - 1]].into_iter().for_each(|end| self.read(area, end, u32::MAX));
        let (near, far, s) = nearer(a, b, i, line.len() - 1);
        let judge = self.judge(area, line.len() - 1);
        let mut glance = self.glance(area, line[i]);
        let tree = judge.rebuild((near, far), s, &self.frame.recorded[line[i]], &mut glance);
        let of_rays = glance.hits.iter().filter(|traced| traced.hit).count() as u32;
        let how = match (of_rays, glance.is_whole()) {
            (0, _) => Origin::Interpolated,
            (_, true) => Origin::Traced,
            (_, false) => Origin::Partial,
        };
        if !glance.hits[0].hit && how == Origin::Partial {
            self.stand_ins.push((line[i], tree.clone()));
        }
        let (hits, is_mixed) = (tree.hits(), glance.hits.iter().any(|traced| !traced.hit));
        self.lazy.there.insert(((area.x0, area.y0), line[i]), hits);
        self.lazy.made += u64::from(hits.saturating_sub(of_rays));
        let age = glance.age.max(if is_mixed { self.age(line) } else { 0 });
        self.known[line[i]] = Some(KnownSample { tree, how, round, age });
        self.note(area, line[i], glance);
    }

    /// The larger age of both ends.
    fn age(&self, line: &[usize]) -> u32 {
        [line[0], line[line.len() - 1]].map(|end| self.known[end].as_ref().unwrap().age).into_iter().max().unwrap()
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
                let beside: Vec<_> = news.iter().filter(|&&other| self.is_witness((x, y), other)).collect();
                // With colours first hits are looked at where the first witness of which colours say anything leaves it open.
                let says =
                    |other: &&&(usize, usize)| self.shows((x, y), ***other) || self.shows_alone((x, y), ***other);
                let looks_at_hits = match self.policy.sampling.similarity.first {
                    First::Hits => !beside.is_empty(),
                    First::Colours => beside.iter().find(says).is_some_and(|&&other| !self.shows_alone((x, y), other)),
                };
                if looks_at_hits {
                    self.read(area, at, 1);
                }
                let is_contradicted = beside.iter().any(|&&other| self.contradicts(area, (x, y), other));
                if self.known[at].as_ref().unwrap().how == Origin::Interpolated && is_contradicted {
                    found.push((x, y));
                }
            }
            let round = 1 + 2 * area.levels(self.policy.sampling.refine) + pass;
            found.iter().for_each(|&(x, y)| self.whole(y * self.frame.width + x, Origin::Traced, round));
            news = found;
        }
    }

    /// A neighbour of which rays were traced.
    fn is_witness(&self, (x, y): (usize, usize), (u, v): (usize, usize)) -> bool {
        let known = self.known[v * self.frame.width + u].as_ref().unwrap();
        x.abs_diff(u).max(y.abs_diff(v)) == 1 && known.how != Origin::Interpolated
    }

    pub fn contradicts(&self, area: &Area, sample: (usize, usize), witness: (usize, usize)) -> bool {
        let [doubted, other] = [sample, witness].map(|(x, y)| self.tree(y * self.frame.width + x));
        let is_unlike = || !self.judge(area, 1).alike(doubted, other) && self.shows(sample, witness);
        self.is_witness(sample, witness) && (self.shows_alone(sample, witness) || is_unlike())
    }

    /// A viewer would see the difference of two samples.
    fn shows(&self, sample: (usize, usize), witness: (usize, usize)) -> bool {
        self.policy.sampling.correct.colour.value().is_none_or(|limit| self.exceeds(sample, witness, limit))
    }

    /// A viewer would see it so well that their hits do not matter.
    fn shows_alone(&self, sample: (usize, usize), witness: (usize, usize)) -> bool {
        self.policy.sampling.correct.colour_alone.value().is_some_and(|limit| self.exceeds(sample, witness, limit))
    }

    fn exceeds(&self, sample: (usize, usize), witness: (usize, usize), limit: f64) -> bool {
        let [a, b] = [sample, witness].map(|(x, y)| self.tree(y * self.frame.width + x));
        let is_weighed = self.policy.sampling.correct.weighed;
        let weight = if is_weighed { (f64::from((a.rays + b.rays) / 2) / 3.0).sqrt() } else { 1.0 };
        let differ = difference((a.colour, b.colour), (a.colour, b.colour));
        differ.is_nan() || differ > limit * weight
    }
}

/// The nearer end for step `i` of `gap`, the other, and the other's share.
fn nearer<'h>(a: &'h Hit, b: &'h Hit, i: usize, gap: usize) -> (&'h Hit, &'h Hit, f32) {
    if i <= gap - i { (a, b, i as f32 / gap as f32) } else { (b, a, (gap - i) as f32 / gap as f32) }
}
