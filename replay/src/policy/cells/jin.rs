//! Jin et al. 2009: attributes of image and object space decide, each with a priority that the user sets.
//!
//! A pixel has one sample, and gets half or all of the rest where an attribute with that priority differs from a neighbour's.

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::Shadows;

use super::cell::Cell;
use super::rule::CellRule;
use crate::policy::kinds::Jin2009;
use crate::policy::similarity::{Compared, difference, within_angle};
use crate::policy::tree::Node;
use rayreel_machine::work::PolicyReads;

/// The rule.
#[derive(Clone, Debug)]
pub struct Jin {
    values: Jin2009,
    /// Smallest cosine between normals.
    cosine: f64,
}

/// The priorities of the attributes of a hit.
#[derive(Clone, Copy)]
struct Priorities {
    object: u32,
    normal: u32,
    shadow: u32,
    texture: u32,
}

/// The highest priority that asks for half of the samples; any above asks for all.
const HALF: u32 = 1;

impl Jin {
    /// The rule with these values.
    pub fn new(values: &Jin2009) -> Self {
        Self { values: values.clone(), cosine: libm::cos(values.threshold.normal_deg.to_radians()) }
    }

    fn primary(&self) -> Priorities {
        let p = &self.values.priority;
        Priorities { object: p.poid, normal: p.psn, shadow: p.psc, texture: p.pte }
    }

    fn secondary(&self) -> Priorities {
        let p = &self.values.priority;
        Priorities { object: p.soid, normal: p.ssn, shadow: p.ssc, texture: p.ste }
    }
}

impl Priorities {
    fn highest(self) -> u32 {
        self.object.max(self.normal).max(self.shadow).max(self.texture)
    }
}

impl CellRule for Jin {
    fn deep(&self) -> bool {
        self.secondary().highest() > 0
    }

    fn reads(&self) -> PolicyReads {
        let (p, s) = (self.primary(), self.secondary());
        // Textures count where all else agrees, so all else is looked at.
        let local = p.texture.max(s.texture) > 0;
        PolicyReads {
            object: local || p.object.max(s.object) > 0,
            normal: local || p.normal.max(s.normal) > 0,
            shadow: local || p.shadow.max(s.shadow) > 0,
            local,
            ..PolicyReads::PAPER
        }
    }

    fn decide(&self, cell: &mut Cell<'_>) {
        if cell.samples().next().is_none() {
            return;
        }
        let mut search = Search { rule: self, found: 0, compared: Compared::default() };
        let (has_right, has_below) = (cell.x.0 != cell.x.1, cell.y.0 != cell.y.1);
        if has_right {
            search.pair(cell.first(), cell.right());
        }
        if has_below {
            search.pair(cell.first(), cell.below());
        }
        if has_right && has_below {
            search.pair(cell.first(), cell.across());
        }
        let (found, compared) = (search.found, search.compared);
        cell.compared(1, compared);
        let (left, top) = (cell.x.0, cell.y.0);
        let is_traced = |(x, y): (u32, u32)| found > HALF || found == HALF && (x - left + y - top).is_multiple_of(2);
        cell.samples().filter(|at| is_traced(*at)).for_each(|at| cell.trace(at, 1));
        // The R-sample is the first of them, row by row.
        let known = std::iter::once((left, top)).chain(cell.samples().filter(|at| is_traced(*at)));
        let (sum, count) = known.fold((Vec3::ZERO, 0u32), |(sum, count), at| (sum + cell.colour(at), count + 1));
        let [x, y, z] = sum.to_array().map(|v| v / count as f32);
        let mean = Vec3::new(x, y, z);
        cell.samples().filter(|at| !is_traced(*at)).for_each(|at| cell.interpolate(at, mean, 1));
    }
}

/// The highest priority of what differs in a cell. It looks only at what could raise it.
struct Search<'a> {
    rule: &'a Jin,
    found: u32,
    compared: Compared,
}

impl Search<'_> {
    /// Compares two samples.
    fn pair(&mut self, a: &[Node], b: &[Node]) {
        let (colour, primary, secondary) =
            (self.rule.values.priority.colour, self.rule.primary(), self.rule.secondary());
        if !self.wants(colour.max(primary.highest()).max(secondary.highest())) {
            return;
        }
        self.compared.pairs += 1;
        if self.wants(colour) {
            self.colours((a[0].colour, b[0].colour), self.rule.values.threshold.colour, colour);
        }
        self.hits(&a[0], &b[0], primary);
        self.below(a, b, secondary);
    }

    /// Compares the attributes of two hits.
    fn hits(&mut self, a: &Node, b: &Node, priorities: Priorities) {
        let (x, y) = match (&a.surface, &b.surface) {
            (None, None) => return,
            (Some(x), Some(y)) => (x, y),
            _ => return self.differs(priorities.object),
        };
        let object = x.object == y.object;
        let normal = within_angle(x.normal, y.normal, self.rule.cosine);
        let shadow = blocked(x.shadows) == blocked(y.shadows);
        let unlike = [(object, priorities.object), (normal, priorities.normal), (shadow, priorities.shadow)];
        unlike.into_iter().filter(|(alike, _)| !alike).for_each(|(_, priority)| self.differs(priority));
        if object && normal && shadow && self.wants(priorities.texture) {
            self.colours((a.local, b.local), self.rule.values.threshold.texture, priorities.texture);
        }
    }

    /// Compares what hangs below two hits, branch by branch.
    fn below(&mut self, a: &[Node], b: &[Node], priorities: Priorities) {
        if !self.wants(priorities.highest()) {
            return;
        }
        if !a[0].branches_as(&b[0]) {
            self.differs(priorities.object);
        }
        for (a, b) in branches(a).into_iter().zip(branches(b)).filter_map(|(a, b)| a.zip(b)) {
            if !self.wants(priorities.highest()) {
                return;
            }
            self.compared.pairs += 1;
            self.hits(&a[0], &b[0], priorities);
            self.below(a, b, priorities);
        }
    }

    fn colours(&mut self, both: (Vec3, Vec3), limit: f64, priority: u32) {
        self.compared.colours += 1;
        let found = difference(both, both);
        // A NaN is like nothing.
        if found > limit || found.is_nan() {
            self.differs(priority);
        }
    }

    fn differs(&mut self, priority: u32) {
        self.found = self.found.max(priority);
    }

    fn wants(&self, priority: u32) -> bool {
        priority > self.found
    }
}

/// The subtrees of the reflection and of the refraction of a hit.
fn branches(tree: &[Node]) -> [Option<&[Node]>; 2] {
    let mut children = crate::policy::tree::children(tree).map(|(_, child)| child);
    let reflect = tree[0].reflect.and_then(|_| children.next());
    [reflect, tree[0].refract.and_then(|_| children.next())]
}

/// Lights that something blocks.
fn blocked(shadows: Shadows) -> u32 {
    (shadows.0 >> 1 & !shadows.0 & 0x5555_5555).count_ones()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rayreel_formats::tile::ShadowState;

    #[test]
    fn blocked_lights_are_counted() {
        let mut shadows = Shadows::default();
        assert_eq!(blocked(shadows), 0);
        let states = [ShadowState::Blocked, ShadowState::Lit, ShadowState::Tinted, ShadowState::NotCast];
        states.into_iter().chain([ShadowState::Blocked]).enumerate().for_each(|(i, state)| shadows.set(i, state));
        assert_eq!(blocked(shadows), 2);
    }
}
