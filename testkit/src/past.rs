//! What a frame leaves for the next, and how its samples use it: written from POLICIES.md once more.

use rayreel_formats::math::Vec3;
use rayreel_formats::scene::Camera;
use rayreel_replay::policy::HistoryRules;

use crate::recorded::Frame;
use crate::rules::{Hit, Surface, Tracing};

/// What a frame leaves.
pub struct Past {
    rules: HistoryRules,
    camera: Camera,
    columns: usize,
    /// Row by row.
    entries: Vec<Entry>,
}

/// What is kept of a sample.
#[derive(Default)]
struct Entry {
    position: [f32; 3],
    age: u32,
    /// Path, surface and local colour of its hits.
    hits: Vec<(u32, Surface, [f32; 3])>,
}

/// The entries that count at a place, the nearest first.
struct Place<'a> {
    entries: Vec<&'a Entry>,
    age: u32,
}

/// The lights of a hit that are known.
struct KnownLights {
    /// The number of each, and its state.
    states: Vec<(u32, u32)>,
    /// Of the nearest entry's hit.
    local: [f32; 3],
}

impl Past {
    /// Nothing is known of any sample yet.
    pub fn new(rules: &HistoryRules, frame: &Frame) -> Self {
        let step = rules.step as usize;
        let (columns, rows) = (frame.width.div_ceil(step), frame.height.div_ceil(step));
        let entries = (0..columns * rows).map(|_| Entry::default()).collect();
        Self { rules: rules.clone(), camera: frame.camera, columns, entries }
    }

    /// The samples that have entries: the number of the entry, column and row.
    pub fn places(rules: &HistoryRules, frame: &Frame) -> Vec<(usize, usize, usize)> {
        let step = rules.step as usize;
        let rows = (0..frame.height).step_by(step);
        rows.flat_map(|y| (0..frame.width).step_by(step).map(move |x| (x, y)))
            .enumerate()
            .map(|(entry, (x, y))| (entry, x, y))
            .collect()
    }

    /// Keeps a sample.
    pub fn keep(&mut self, entry: usize, tree: &Hit, age: u32) {
        let position = tree.surface.map_or([0.0; 3], |surface| surface.position);
        let mut hits = Vec::new();
        keep(&mut hits, tree, 1, self.rules.depth);
        self.entries[entry] = Entry { position, age, hits };
    }

    /// Hits below the primary one of an entry.
    pub fn below(&self, entry: usize) -> usize {
        self.entries[entry].hits.len().saturating_sub(1)
    }

    /// Column and row of `point` in the picture, in samples, and its distance.
    fn project(&self, point: [f32; 3]) -> Option<(f64, f64, f64)> {
        let wide = |v: Vec3| v.to_array().map(f64::from);
        let Camera { eye, corner, right, down } = self.camera;
        let (e, c, r, d) = (wide(eye), wide(corner), wide(right), wide(down));
        let volume = dot(c, cross(r, d));
        let part = |axis: [f64; 3], o| dot(o, axis.map(|v| v / volume));
        let o = std::array::from_fn(|i| f64::from(point[i]) - e[i]);
        let w = part(cross(r, d), o);
        let at = |axis| part(axis, o) / w - 0.5;
        (w > 0.0).then(|| (at(cross(d, c)), at(cross(c, r)), dot(o, o).sqrt()))
    }

    /// The entries around the place of a primary hit, and what counts of them if it is found.
    fn look(&self, hit: &Surface) -> (Vec<usize>, Option<Place<'_>>) {
        let (columns, rows) = (self.columns as i64, (self.entries.len() / self.columns) as i64);
        let Some((u, v, distance)) = self.project(hit.position) else { return (Vec::new(), None) };
        let (x, y) = (u / f64::from(self.rules.step), v / f64::from(self.rules.step));
        // A cast keeps what is far outside there.
        let (x0, y0) = (x.floor() as i64, y.floor() as i64);
        if x.is_nan() || y.is_nan() || x0 < -1 || y0 < -1 || x0 >= columns || y0 >= rows {
            return (Vec::new(), None);
        }
        let square = |x: i64, y: i64| [(x, y), (x + 1, y), (x, y + 1), (x + 1, y + 1)];
        let entry =
            |(x, y): (i64, i64)| (x >= 0 && y >= 0 && x < columns && y < rows).then_some((y * columns + x) as usize);
        let read = square(x0.max(0), y0.max(0)).into_iter().filter_map(entry).collect();
        let (a, b) = (x - x0 as f64, y - y0 as f64);
        let weights = [(1.0 - a) * (1.0 - b), a * (1.0 - b), (1.0 - a) * b, a * b];
        let mut counted: Vec<(f64, &Entry)> = Vec::new();
        for (at, weight) in square(x0, y0).into_iter().zip(weights) {
            let Some(entry) = entry(at).map(|entry| &self.entries[entry]) else { continue };
            let q: [f64; 3] = std::array::from_fn(|i| f64::from(entry.position[i]) - f64::from(hit.position[i]));
            let off = dot(q, hit.normal.map(f64::from)).abs();
            let same = entry.hits.first().is_some_and(|(_, kept, _)| kept.object == hit.object);
            if same && entry.age < self.rules.age && off <= self.rules.plane * distance {
                counted.push((weight, entry));
            }
        }
        let cover = counted.iter().fold(0.0, |sum, (weight, _)| sum + weight);
        let most = counted.iter().fold(0.0, |most, (weight, _)| f64::max(most, *weight));
        let Some(nearest) = counted.iter().position(|(weight, _)| *weight == most) else { return (read, None) };
        counted.swap(0, nearest);
        let entries: Vec<_> = counted.into_iter().map(|(_, entry)| entry).collect();
        let age = 255.min(1 + entries.iter().map(|entry| entry.age).max().unwrap_or(0));
        (read, (cover >= self.rules.cover).then_some(Place { entries, age }))
    }

    /// The lights of a hit that are known, if it has its like in all entries.
    fn lights(&self, place: &Place<'_>, path: u32, hit: &Surface) -> Option<KnownLights> {
        let cosine = libm::cos(self.rules.normal_deg.to_radians());
        let is_like = |(p, kept, _): &&(u32, Surface, [f32; 3])| {
            let (n, m) = (hit.normal.map(f64::from), kept.normal.map(f64::from));
            let off = (f64::from(kept.t) - f64::from(hit.t)).abs();
            *p == path
                && kept.object == hit.object
                && dot(n, m) >= cosine * (dot(n, n) * dot(m, m)).sqrt()
                && (path == 1 || off <= self.rules.distance * f64::from(hit.t))
        };
        let likes: Option<Vec<_>> = place.entries.iter().map(|entry| entry.hits.iter().find(is_like)).collect();
        let likes = likes?;
        let state = |word: u32, light: u32| word >> (2 * light) & 3;
        let known = (0..16).filter_map(|light| {
            let past = state(likes[0].1.shadows, light);
            let same = likes.iter().all(|(_, kept, _)| state(kept.shadows, light) == past);
            (state(hit.shadows, light) != 0 && (past == LIT || past == BLOCKED) && same).then_some((light, past))
        });
        Some(KnownLights { states: known.collect(), local: likes[0].2 })
    }
}

const LIT: u32 = 1;
const BLOCKED: u32 = 2;

fn keep(hits: &mut Vec<(u32, Surface, [f32; 3])>, hit: &Hit, path: u32, depth: u32) {
    let Some(surface) = hit.surface else { return };
    hits.push((path, surface, hit.local));
    for (i, child) in hit.below.iter().enumerate().filter(|_| depth > 0) {
        child.iter().for_each(|(_, child)| keep(hits, child, 2 * path + i as u32, depth - 1));
    }
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// One sample that is traced, with an eye on the frame before or without.
pub struct Glance<'a> {
    past: Option<&'a Past>,
    checks: bool,
    place: Option<Place<'a>>,
    /// What became of its recorded hits.
    pub hits: Vec<Traced>,
    /// Of the place, once a light was taken from there.
    pub age: u32,
    /// Hits whose lights were sought.
    pub sought: u64,
    /// Checks, and those that were mistaken.
    pub checked: (u64, u64),
    /// Entries that it reads.
    pub read: Vec<usize>,
    /// Where the history was right: the local colour that would have stood for another one, and the true one.
    pub twins: Vec<[[f32; 3]; 2]>,
}

/// Which rays of a recorded hit were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traced {
    /// The ray that met it.
    pub hit: bool,
    /// So many shadow rays were not.
    pub spared: u32,
    /// The colour of another hit stands for its own.
    pub stood_for: bool,
}

impl Traced {
    /// All rays.
    pub const WHOLE: Self = Self { hit: true, spared: 0, stood_for: false };
}

impl<'a> Glance<'a> {
    /// A sample of so many recorded hits that looks back, or checks, or neither.
    pub fn new(past: Option<&'a Past>, checks: bool, hits: usize) -> Self {
        let hits = vec![Traced::default(); hits];
        Self {
            past,
            checks,
            place: None,
            hits,
            age: 0,
            sought: 0,
            checked: (0, 0),
            read: Vec::new(),
            twins: Vec::new(),
        }
    }

    /// It looks back, or checks.
    pub fn looks(&self) -> bool {
        self.past.is_some()
    }

    /// All rays were traced.
    pub fn is_whole(&self) -> bool {
        self.hits.iter().all(|traced| *traced == Traced::WHOLE)
    }
}

impl Tracing for Glance<'_> {
    fn see(&mut self, path: u32, hit: &Hit) -> (Option<Surface>, [f32; 3]) {
        self.hits[hit.number] = Traced::WHOLE;
        let (Some(past), Some(surface)) = (self.past, hit.surface) else { return (hit.surface, hit.local) };
        if path == 1 {
            (self.read, self.place) = past.look(&surface);
        }
        self.sought += u64::from(path == 1 || self.place.is_some());
        let known = self.place.as_ref().and_then(|place| Some((place.age, past.lights(place, path, &surface)?)));
        let Some((age, KnownLights { states, local })) = known.filter(|(_, known)| !known.states.is_empty()) else {
            return (hit.surface, hit.local);
        };
        if self.checks {
            let mistaken = states.iter().filter(|(light, state)| surface.shadows >> (2 * light) & 3 != *state);
            self.checked.0 += states.len() as u64;
            self.checked.1 += mistaken.count() as u64;
            return (hit.surface, hit.local);
        }
        let put = |word: u32, (light, state): &(u32, u32)| word & !(3 << (2 * light)) | state << (2 * light);
        let word = states.iter().fold(surface.shadows, put);
        self.age = age;
        let stood_for = word != surface.shadows;
        self.twins.extend((!stood_for).then_some([local, hit.local]));
        self.hits[hit.number] = Traced { hit: true, spared: states.len() as u32, stood_for };
        (Some(Surface { shadows: word, ..surface }), if stood_for { local } else { hit.local })
    }
}
