//! The rule that looks at attributes: Jin et al. 2009.

use rayreel_replay::policy::Jin2009;

use super::making::{Cell, Making};
use crate::rules::{Hit, difference};

/// Priorities of object, normal, shadow count and texture.
type Four = [u32; 4];

struct Judge<'a> {
    values: &'a Jin2009,
    /// The highest priority of what differs.
    p: u32,
    tests: u64,
    colours: u64,
}

pub fn jin(making: &mut Making<'_>, values: &Jin2009, cell: Cell) {
    if cell.others().is_empty() {
        return;
    }
    let Cell { xa, xb, ya, yb } = cell;
    let mut judge = Judge { values, p: 0, tests: 0, colours: 0 };
    let first = making.hit(xa, ya);
    let mut seen = vec![(xa, ya)];
    for at in [(xb, ya), (xa, yb), (xb, yb)] {
        // In the last column and row corners are the same samples.
        if !seen.contains(&at) {
            seen.push(at);
            judge.samples(first, making.hit(at.0, at.1));
        }
    }
    let Judge { p, tests, colours, .. } = judge;
    making.work(1).tests += tests;
    making.work(1).colours += colours;
    let (mut sum, mut number, mut rest) = ([0.0f32; 3], 0.0f32, Vec::new());
    for (x, y) in cell.owned() {
        if (x, y) != (xa, ya) {
            if p == 0 || p == 1 && (x - xa + y - ya) % 2 == 1 {
                rest.push((x, y));
                continue;
            }
            making.trace((x, y), 1);
        }
        let colour = making.colour(x, y);
        (0..3).for_each(|i| sum[i] += colour[i]);
        number += 1.0;
    }
    rest.into_iter().for_each(|at| making.interpolate(at, sum.map(|v| v / number), 1));
}

impl Judge<'_> {
    fn samples(&mut self, a: &Hit, b: &Hit) {
        let p = &self.values.priority;
        let (primary, secondary) = ([p.poid, p.psn, p.psc, p.pte], [p.soid, p.ssn, p.ssc, p.ste]);
        if p.colour <= self.p && max(primary) <= self.p && max(secondary) <= self.p {
            return;
        }
        self.tests += 1;
        if p.colour > self.p {
            self.colours += 1;
            self.raise(!near(a.colour, b.colour, self.values.threshold.colour), p.colour);
        }
        self.hits(a, b, primary);
        self.children(a, b, secondary);
    }

    fn hits(&mut self, a: &Hit, b: &Hit, [object, normal, shadow, texture]: Four) {
        let (Some(x), Some(y)) = (&a.surface, &b.surface) else {
            return self.raise(a.surface.is_some() != b.surface.is_some(), object);
        };
        let dot = |a: [f32; 3], b: [f32; 3]| (0..3).map(|i| f64::from(a[i]) * f64::from(b[i])).fold(0.0, |s, v| s + v);
        let cosine = libm::cos(self.values.threshold.normal_deg.to_radians());
        let turned = dot(x.normal, y.normal) < cosine * (dot(x.normal, x.normal) * dot(y.normal, y.normal)).sqrt();
        // Two bits a light: 2 is blocked.
        let count = |word: u32| (0..16).filter(|light| word >> (2 * light) & 3 == 2).count();
        let differ = [x.object != y.object, turned, count(x.shadows) != count(y.shadows)];
        self.raise(differ[0], object);
        self.raise(differ[1], normal);
        self.raise(differ[2], shadow);
        if differ == [false; 3] && texture > self.p {
            self.colours += 1;
            self.raise(!near(a.local, b.local, self.values.threshold.texture), texture);
        }
    }

    fn children(&mut self, a: &Hit, b: &Hit, four: Four) {
        if max(four) <= self.p {
            return;
        }
        let unlike = (0..2).any(|i| a.below[i].is_some() != b.below[i].is_some());
        self.raise(unlike, four[0]);
        for i in 0..2 {
            if let (Some((_, a)), Some((_, b))) = (&a.below[i], &b.below[i])
                && max(four) > self.p
            {
                self.tests += 1;
                self.hits(a, b, four);
                self.children(a, b, four);
            }
        }
    }

    fn raise(&mut self, differs: bool, priority: u32) {
        if differs && priority > self.p {
            self.p = priority;
        }
    }
}

fn near(a: [f32; 3], b: [f32; 3], limit: f64) -> bool {
    let found = difference((a, b), (a, b));
    !found.is_nan() && found <= limit
}

fn max(four: Four) -> u32 {
    four.into_iter().max().unwrap_or(0)
}
