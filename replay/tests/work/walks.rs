//! Paths that are checked against the tree, by a walk written a second time.

use rayreel_formats::bvh::Child;
use rayreel_formats::tile::step;
use rayreel_machine::work::check::{PathCounts, walk};
use rayreel_machine::work::ops::Op;
use rayreel_machine::work::synthetic::{Random, balanced_topology, random_path};
use rayreel_machine::work::topology::Topology;

/// A walk written from the grammar alone: recursion down, a list of what is open. `None` for a path that breaks it.
pub fn independent(tree: &Topology, steps: &[u8], shadow: bool) -> Option<(PathCounts, Vec<Op>)> {
    let mut walk = Walk { tree, rest: steps, shadow, open: Vec::new(), counts: PathCounts::default(), ops: Vec::new() };
    walk.counts.rays = 1;
    let mut ended = walk.descend(Child::inner(0))?;
    while let (false, Some((child, parent))) = (ended, walk.open.pop()) {
        match walk.next()? {
            step::CULLED if !shadow => {
                walk.counts.culled += 1;
                walk.ops.push(Op::pop(parent, true));
            }
            step::POP => {
                walk.counts.pops += 1;
                walk.ops.push(Op::pop(parent, false));
                ended = walk.descend(child)?;
            }
            _ => return None,
        }
    }
    if !ended {
        walk.ops.push(Op::END);
    }
    walk.rest.is_empty().then_some((walk.counts, walk.ops))
}

struct Walk<'a> {
    tree: &'a Topology,
    rest: &'a [u8],
    shadow: bool,
    /// Children that are put aside, with the node that did it.
    open: Vec<(Child, u32)>,
    counts: PathCounts,
    ops: Vec<Op>,
}

impl Walk<'_> {
    fn next(&mut self) -> Option<u8> {
        let (&first, rest) = self.rest.split_first()?;
        self.rest = rest;
        Some(first)
    }

    /// From `child` down to where a pop is due; true if a shadow ray ends.
    fn descend(&mut self, child: Child) -> Option<bool> {
        if child.is_leaf() {
            for tested in 1..=child.count() as u32 {
                self.counts.triangle_tests += 1;
                match self.next()? {
                    step::HIT => {
                        self.counts.hits += 1;
                        if self.shadow {
                            self.ops.push(Op::leaf(child.first() as u32, tested));
                            return Some(true);
                        }
                    }
                    step::MISS | step::PASS => {}
                    _ => return None,
                }
            }
            self.ops.push(Op::leaf(child.first() as u32, child.count() as u32));
            return Some(false);
        }
        self.counts.node_visits += 1;
        let node = child.node() as u32;
        let [left, right] = self.tree.children[child.node()];
        let (near, far) = match self.next()? {
            step::NONE => (None, None),
            step::LEFT => (Some(left), None),
            step::RIGHT => (Some(right), None),
            step::LEFT_FIRST => (Some(left), Some(right)),
            step::RIGHT_FIRST => (Some(right), Some(left)),
            _ => return None,
        };
        self.ops.push(Op::visit(node, far.is_some()));
        self.counts.pushes += u64::from(far.is_some());
        self.open.extend(far.map(|far| (far, node)));
        near.map_or(Some(false), |near| self.descend(near))
    }
}

#[test]
fn walks_agree_on_good_and_bad_paths() {
    let mut random = Random(11);
    let (mut good, mut bad) = (0, 0);
    for round in 0..4000u32 {
        let tree = balanced_topology(1 + round % 9, round % 5);
        let shadow = round % 3 == 0;
        let mut path = random_path(&tree, shadow, &mut random);
        let (mut counts, mut ops) = (PathCounts::default(), Vec::new());
        assert_eq!(walk(&tree, &path.steps, shadow, &mut ops, &mut counts).unwrap().hit, path.hit);
        assert_eq!(ops, path.ops);
        assert_eq!(Some((counts, ops)), independent(&tree, &path.steps, shadow));
        let at = random.below(path.steps.len() as u32) as usize;
        match random.below(4) {
            0 => path.steps.truncate(at),
            1 => path.steps.insert(at, random.below(11) as u8),
            2 => _ = path.steps.remove(at),
            _ => path.steps[at] = random.below(11) as u8,
        }
        let (mut counts, mut ops) = (PathCounts::default(), Vec::new());
        match walk(&tree, &path.steps, shadow, &mut ops, &mut counts) {
            Ok(_) => {
                good += 1;
                assert_eq!(Some((counts, ops)), independent(&tree, &path.steps, shadow));
            }
            Err(fault) => {
                bad += 1;
                assert!(fault.step as usize <= path.steps.len());
                assert_eq!(None, independent(&tree, &path.steps, shadow), "{fault:?}");
            }
        }
    }
    assert!(good > 100 && bad > 1000, "{good} good, {bad} bad");
}

/// By hand: a root over two leaves of two triangles.
#[test]
fn faults_name_the_step() {
    let tree = balanced_topology(1, 2);
    let fault = |steps: &[u8], shadow| {
        walk(&tree, steps, shadow, &mut Vec::new(), &mut PathCounts::default()).map_err(|fault| fault.step)
    };
    use step::*;
    let ended = fault(&[LEFT_FIRST, MISS, HIT, POP, MISS, HIT], false).unwrap();
    assert_eq!((ended.hit, ended.max_stack), (3, 1));
    assert_eq!(fault(&[LEFT_FIRST, MISS, HIT, CULLED], false).unwrap().hit, 1);
    assert_eq!(fault(&[LEFT_FIRST, HIT], true).unwrap().hit, 0);
    assert_eq!(fault(&[LEFT_FIRST, HIT, MISS], true), Err(2), "goes on after a shadow ray's end");
    assert_eq!(fault(&[LEFT_FIRST, MISS, MISS, CULLED], true), Err(3), "shadow rays cull nothing");
    assert_eq!(fault(&[LEFT_FIRST, MISS, MISS], false), Err(3), "too short");
    assert_eq!(fault(&[LEFT, MISS, MISS, POP], false), Err(3), "nothing to pop");
    assert_eq!(fault(&[POP], false), Err(0));
    assert_eq!(fault(&[LEFT, LEFT], false), Err(1));
    assert_eq!(fault(&[], false), Err(0));
}
