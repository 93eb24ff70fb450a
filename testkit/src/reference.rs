//! A second implementation of the adaptive policies: the whole frame at once, slow and obvious, written from POLICIES.md and
//! not from the code it checks. It shares the trace format's functions (rays, colours, normals) and nothing else.

use rayreel_formats::tile::RayKind;
use rayreel_replay::TileSource;
use rayreel_replay::policy::view::SampleState;
use rayreel_replay::policy::{Adaptive, Apron, Refine};

use crate::rules::{Hit, Judge, between, mix};
use crate::second_read::{Frame, read};

/// How a sample came to be known.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// An R-sample, traced first.
    R,
    /// Traced by the X or the Y step, or by correction.
    Traced,
    /// Some rays were traced and some hits interpolated.
    Partial,
    /// Interpolated.
    Interpolated,
}

impl From<SampleState> for Origin {
    fn from(state: SampleState) -> Self {
        match state {
            SampleState::Reference => Self::R,
            SampleState::Traced => Self::Traced,
            SampleState::Partial => Self::Partial,
            SampleState::Interpolated => Self::Interpolated,
        }
    }
}

/// Number of rays: primary, reflection, refraction, shadow.
pub type Rays = [u64; 4];

/// What the reference found out about a frame. Samples are row by row over the whole grid.
pub struct Outcome {
    pub width: usize,
    pub how: Vec<Origin>,
    pub waves: Vec<u8>,
    pub colours: Vec<[f32; 3]>,
    /// Per sample and recorded hit whether its rays were traced.
    pub traced: Vec<Vec<bool>>,
    /// Samples whose primary hit is interpolated and has traced hits below, with its tree.
    pub stand_ins: Vec<(usize, Hit)>,
    pub rays_full: Rays,
    pub rays_traced: Rays,
    pub rays_apron: Rays,
    pub samples_apron: u64,
    /// Rays of the traced and of the apron samples, per tile.
    pub tiles: Vec<(Rays, Rays)>,
}

impl Outcome {
    /// Number of samples of a kind.
    pub fn count(&self, how: Origin) -> u64 {
        self.how.iter().filter(|h| **h == how).count() as u64
    }
}

/// What is known of a sample.
#[derive(Clone)]
struct Known {
    tree: Hit,
    how: Origin,
    wave: u8,
}

/// A frame in the making.
struct Maker<'a> {
    policy: &'a Adaptive,
    frame: &'a Frame,
    known: Vec<Option<Known>>,
    traced: Vec<Vec<bool>>,
    stand_ins: Vec<(usize, Hit)>,
}

/// Replays one frame with one block for all tiles.
pub fn replay<S: TileSource>(source: &S, policy: &Adaptive, frame: u32) -> Outcome {
    let tiles = source.meta().tile_count() as usize;
    replay_tiles(source, policy, &vec![(policy.block, 1.0); tiles], frame)
}

/// Replays one frame with a block and a factor on the colour limit for each tile.
pub fn replay_tiles<S: TileSource>(source: &S, policy: &Adaptive, rates: &[(u32, f64)], frame: u32) -> Outcome {
    let recorded = read(source, frame, policy.sampling.secondary || policy.sampling.similarity.secondary);
    let (maker, tiles, before) = decide(source, policy, rates, &recorded);
    maker.account(&tiles, &before)
}

/// All steps; the tiles, and what was traced before correction.
fn decide<'a, S: TileSource>(
    source: &S,
    policy: &'a Adaptive,
    rates: &[(u32, f64)],
    recorded: &'a Frame,
) -> (Maker<'a>, Vec<Area>, Vec<Vec<bool>>) {
    let meta = source.meta();
    let (width, height) = (recorded.width, recorded.height);
    let columns = meta.tile_grid().0;
    let tiles: Vec<_> = (0..meta.tile_count()).map(|i| Area::new(meta.tile_rect(i), rates[i as usize])).collect();
    let traced = recorded.rays.iter().map(|hits| vec![false; hits.len()]).collect();
    let mut maker = Maker { policy, frame: recorded, known: vec![None; width * height], traced, stand_ins: Vec::new() };
    let last = (width - 1, height - 1);
    for (i, area) in tiles.iter().enumerate() {
        let left = if (i as u32).is_multiple_of(columns) { area.n } else { tiles[i - 1].n };
        for (x, y) in area.samples() {
            let own = on(x, area.n, last.0) && on(y, area.n, last.1);
            if own || x == area.x0 && on(y, left, last.1) {
                maker.whole(y * width + x, Origin::R, 0);
            }
        }
    }
    for area in &tiles {
        let mut ends: Vec<usize> = (area.x0..area.x1).filter(|&x| on(x, area.n, last.0)).collect();
        ends.extend((area.x1 < width).then_some(area.x1));
        for y in (area.y0..area.y1).filter(|&y| on(y, area.n, last.1)) {
            for pair in ends.windows(2) {
                let line: Vec<usize> = (pair[0]..=pair[1]).map(|x| y * width + x).collect();
                maker.fill(area, &line, 1, f64::INFINITY);
            }
        }
    }
    let after_x: Vec<bool> = maker.known.iter().map(Option::is_some).collect();
    for area in &tiles {
        for x in area.x0..area.x1 {
            let mut ends: Vec<usize> = (area.y0..area.y1).filter(|&y| after_x[y * width + x]).collect();
            ends.extend((area.y1 < height).then_some(area.y1));
            for pair in ends.windows(2) {
                let line: Vec<usize> = (pair[0]..=pair[1]).map(|y| y * width + x).collect();
                maker.fill(area, &line, 1 + area.levels(policy.sampling.refine), f64::INFINITY);
            }
        }
    }
    let before = maker.traced.clone();
    tiles.iter().for_each(|area| maker.correct(area));
    (maker, tiles, before)
}

/// Replays one frame and audits pixels; what the audits found too: per tile the squared error and the number of values.
pub fn replay_audited<S: TileSource>(
    source: &S,
    policy: &Adaptive,
    rates: &[(u32, f64)],
    (frame, every): (u32, u64),
) -> (Outcome, Vec<(u64, u64)>) {
    let recorded = read(source, frame, policy.sampling.secondary || policy.sampling.similarity.secondary);
    let (mut maker, tiles, before) = decide(source, policy, rates, &recorded);
    let n = source.meta().samples as usize;
    let found = tiles.iter().map(|area| maker.audit(area, n, u64::from(frame), every)).collect();
    (maker.account(&tiles, &before), found)
}

/// A tile: its samples, its block and its factor on the colour limit.
struct Area {
    x0: usize,
    y0: usize,
    x1: usize,
    y1: usize,
    n: usize,
    relax: f64,
}

/// True for a multiple of the block and for the last one.
fn on(at: usize, n: usize, last: usize) -> bool {
    at.is_multiple_of(n) || at == last
}

impl Area {
    fn new(rect: rayreel_formats::scene::Rect, (block, relax): (u32, f64)) -> Self {
        let (x0, y0) = (rect.x as usize, rect.y as usize);
        Self { x0, y0, x1: x0 + rect.width as usize, y1: y0 + rect.height as usize, n: block as usize, relax }
    }

    fn samples(&self) -> impl Iterator<Item = (usize, usize)> + use<> {
        let (x0, x1) = (self.x0, self.x1);
        (self.y0..self.y1).flat_map(move |y| (x0..x1).map(move |x| (x, y)))
    }

    /// Waves of one step: one, or as often as the block can be halved.
    fn levels(&self, refine: Refine) -> u8 {
        let mut levels = 0;
        let mut gap = self.n;
        while gap > 1 {
            gap = gap.div_ceil(2);
            levels += 1;
        }
        if refine == Refine::Direct { 1 } else { levels }
    }
}

impl Maker<'_> {
    /// Traces a sample whole.
    fn whole(&mut self, at: usize, how: Origin, wave: u8) {
        self.traced[at].fill(true);
        self.known[at] = Some(Known { tree: self.frame.recorded[at].clone(), how, wave });
    }

    fn tree(&self, at: usize) -> &Hit {
        &self.known[at].as_ref().expect("known").tree
    }

    fn judge(&self, area: &Area, gap: usize) -> Judge<'_> {
        Judge {
            similarity: &self.policy.sampling.similarity,
            relax: area.relax,
            gap,
            stand_in: self.policy.sampling.stand_in,
        }
    }

    /// Decides the inner samples of `line`, whose two ends are known.
    fn fill(&mut self, area: &Area, line: &[usize], wave: u8, foreseen: f64) {
        let gap = line.len() - 1;
        if gap < 2 {
            return;
        }
        let (a, b) = (self.tree(line[0]).clone(), self.tree(line[gap]).clone());
        if self.judge(area, gap).samples(&a, &b, foreseen) {
            for (i, &at) in line.iter().enumerate().take(gap).skip(1) {
                let (near, far, s) = nearer(&a, &b, i, gap);
                let tree = between(near, far, s);
                self.known[at] = Some(Known { tree, how: Origin::Interpolated, wave });
            }
            return;
        }
        if self.policy.sampling.refine == Refine::Direct {
            (1..gap).for_each(|i| self.trace(area, (&a, &b), line, i, wave));
            return;
        }
        let m = gap / 2;
        self.trace(area, (&a, &b), line, m, wave);
        let mut foreseen = f64::INFINITY;
        let middle = self.known[line[m]].as_ref().unwrap();
        if self.policy.sampling.similarity.predict && middle.how == Origin::Traced {
            let (near, far, s) = nearer(&a, &b, m, gap);
            let guess = mix(near.colour, far.colour, s);
            foreseen = super::rules::difference((guess, middle.tree.colour), (guess, middle.tree.colour));
        }
        self.fill(area, &line[..=m], wave + 1, foreseen);
        self.fill(area, &line[m..], wave + 1, foreseen);
    }

    /// Traces sample `i` of `line`, or what of it must be.
    fn trace(&mut self, area: &Area, (a, b): (&Hit, &Hit), line: &[usize], i: usize, wave: u8) {
        if !self.policy.sampling.secondary {
            return self.whole(line[i], Origin::Traced, wave);
        }
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
        self.traced[line[i]] = traced;
        self.known[line[i]] = Some(Known { tree, how, wave });
    }

    /// Traces interpolated samples that a traced neighbour in the tile contradicts, pass by pass.
    fn correct(&mut self, area: &Area) {
        let correct = &self.policy.sampling.correct;
        let mut news: Vec<(usize, usize)> = area.samples().collect();
        for pass in 0..correct.passes as u8 {
            let mut found = Vec::new();
            for (x, y) in area.samples() {
                let own = self.known[y * self.frame.width + x].as_ref().unwrap();
                if own.how == Origin::Interpolated && news.iter().any(|&at| self.contradicts(area, (x, y), at)) {
                    found.push((x, y));
                }
            }
            let wave = 1 + 2 * area.levels(self.policy.sampling.refine) + pass;
            found.iter().for_each(|&(x, y)| self.whole(y * self.frame.width + x, Origin::Traced, wave));
            news = found;
        }
    }

    /// Traces what was interpolated in the pixels that are drawn, and compares the pixels as displayed.
    fn audit(&mut self, area: &Area, n: usize, frame: u64, every: u64) -> (u64, u64) {
        let width = self.frame.width;
        let (mut sum, mut values) = (0, 0);
        let whole = |(x, y): &(usize, usize)| x % n == 0 && y % n == 0 && x + n <= area.x1 && y + n <= area.y1;
        for (x, y) in area.samples().filter(whole) {
            let pixel = (y / n * (width / n) + x / n) as u64;
            if !draw(pixel ^ (frame << 40)).is_multiple_of(every) {
                continue;
            }
            let samples: Vec<usize> = (0..n * n).map(|i| (y + i / n) * width + x + i % n).collect();
            let before = self.display(&samples);
            for &at in &samples {
                let Known { how, wave, .. } = *self.known[at].as_ref().unwrap();
                if how == Origin::Interpolated {
                    self.whole(at, Origin::Traced, wave);
                }
            }
            let after = self.display(&samples);
            sum += (0..3).map(|c| (before[c] - after[c]).pow(2) as u64).sum::<u64>();
            values += 3;
        }
        (sum, values)
    }

    /// A pixel in 8 bits of sRGB, by the formula of the standard.
    fn display(&self, samples: &[usize]) -> [i64; 3] {
        std::array::from_fn(|channel| {
            let sum = samples.iter().fold(0.0f32, |sum, &at| sum + self.tree(at).colour[channel]);
            let linear = f64::from(sum / samples.len() as f32).clamp(0.0, 1.0);
            let coded = if linear > 0.0031308 { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 } else { 12.92 * linear };
            (coded * 255.0).round() as i64
        })
    }

    fn contradicts(&self, area: &Area, (x, y): (usize, usize), (u, v): (usize, usize)) -> bool {
        if x.abs_diff(u).max(y.abs_diff(v)) != 1 {
            return false;
        }
        let (own, witness) = (&self.known[y * self.frame.width + x], &self.known[v * self.frame.width + u]);
        let (own, witness) = (own.as_ref().unwrap(), witness.as_ref().unwrap());
        if witness.how == Origin::Interpolated || self.judge(area, 1).alike(&own.tree, &witness.tree) {
            return false;
        }
        let colours = (own.tree.colour, witness.tree.colour);
        let differ = super::rules::difference(colours, colours);
        self.policy.sampling.correct.colour.value().is_none_or(|limit| differ.is_nan() || differ > limit)
    }

    fn account(self, tiles: &[Area], before: &[Vec<bool>]) -> Outcome {
        let width = self.frame.width;
        let rays_of = |traced: &[Vec<bool>], at: usize| -> Option<Rays> {
            let hits = self.frame.rays[at].iter().zip(&traced[at]).filter(|(_, t)| **t).map(|(rays, _)| *rays);
            traced[at].iter().any(|t| *t).then(|| sum(hits))
        };
        let mut outcome = Outcome {
            width,
            how: self.known.iter().map(|k| k.as_ref().expect("every sample is decided").how).collect(),
            waves: self.known.iter().map(|k| k.as_ref().unwrap().wave).collect(),
            colours: self.known.iter().map(|k| k.as_ref().unwrap().tree.colour).collect(),
            traced: Vec::new(),
            stand_ins: Vec::new(),
            rays_full: sum(self.frame.rays.iter().flatten().copied()),
            rays_traced: [0; 4],
            rays_apron: [0; 4],
            samples_apron: 0,
            tiles: Vec::new(),
        };
        for area in tiles {
            let own = sum(area.samples().filter_map(|(x, y)| rays_of(&self.traced, y * width + x)));
            let mut again = Vec::new();
            if self.policy.apron == Apron::Retrace {
                let border = border(area, self.frame);
                // What a neighbour corrects later is not traced again.
                again.extend(border.into_iter().filter_map(|(x, y)| rays_of(before, y * width + x)));
            }
            outcome.samples_apron += again.len() as u64;
            let paid = (own, sum(again.into_iter()));
            outcome.rays_traced = sum([outcome.rays_traced, paid.0].into_iter());
            outcome.rays_apron = sum([outcome.rays_apron, paid.1].into_iter());
            outcome.tiles.push(paid);
        }
        Outcome { traced: self.traced, stand_ins: self.stand_ins, ..outcome }
    }
}

/// The nearer end for step `i` of `gap`, the other, and the other's share.
fn nearer<'h>(a: &'h Hit, b: &'h Hit, i: usize, gap: usize) -> (&'h Hit, &'h Hit, f32) {
    if i <= gap - i { (a, b, i as f32 / gap as f32) } else { (b, a, (gap - i) as f32 / gap as f32) }
}

/// The samples outside a tile that its steps look at: on the closing column those in R-rows of the tile and of the corner, on
/// the closing row all.
fn border(area: &Area, frame: &Frame) -> Vec<(usize, usize)> {
    let mut list = Vec::new();
    if area.x1 < frame.width {
        for y in area.y0..=area.y1 {
            if y < frame.height && on(y, area.n, frame.height - 1) {
                list.push((area.x1, y));
            }
        }
    }
    if area.y1 < frame.height {
        list.extend((area.x0..area.x1).map(|x| (x, area.y1)));
    }
    list
}

/// The rays of a recorded hit.
pub fn rays_of(node: &rayreel_formats::tile::RayNode) -> Rays {
    let mut rays = [0; 4];
    rays[node.class.kind() as usize] += 1;
    rays[RayKind::Shadow as usize] += node.shadows.cast().count() as u64;
    rays
}

/// SplitMix64 at state `seed`.
fn draw(seed: u64) -> u64 {
    let mut z = seed.wrapping_add(0x9e3779b97f4a7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58476d1ce4e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d049bb133111eb);
    z ^ z >> 31
}

fn sum(list: impl Iterator<Item = Rays>) -> Rays {
    list.fold([0; 4], |a, b| [a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]])
}
