//! The tree that obvhs builds over triangles.
//!
//! Its builder sorts triangles along a Morton curve through the box around all of them, and merges those that the curve brings together. The
//! curve takes each axis as it is stretched to the box: over a ground of 8000 units and heights of 1 it goes up and down before it goes
//! on, and neighbours on the ground lie far apart on it. Rays above such a ground took ten times the steps (docs/model-changes.md).
//! So the box of the curve is less flat than that of the triangles may be.

use glam::Vec3A;
use obvhs::BvhBuildParams;
use obvhs::aabb::Aabb;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::node::Bvh2Node;
use obvhs::bvh2::{Bvh2, reinsertion::ReinsertionOptimizer};
use obvhs::ploc::PlocBuilder;
use obvhs::triangle::Triangle;
use rayreel_formats::bvh::MAX_LEAF_TRIANGLES;

/// The box of the curve has no side shorter than the longest one over this. The flattest of the built-in scenes, `car`, has 17: they keep
/// the curve of obvhs.
const FLAT_MAX: f32 = 32.0;

/// Triangles before and behind one on the curve that it may be merged with: [`PlocSearchDistance::Medium`](obvhs::ploc::PlocSearchDistance).
const SEARCH: usize = 14;

/// What obvhs' medium preset makes of triangles, but for the box of the curve, and with leaves as small as the trace wants them.
pub(crate) fn tree(triangles: &[Triangle]) -> Bvh2 {
    let params = BvhBuildParams { max_prims_per_leaf: MAX_LEAF_TRIANGLES, ..BvhBuildParams::medium_build() };
    let mut builder = PlocBuilder::with_capacity(triangles.len());
    let mut bvh = Bvh2::zeroed(triangles.len());
    bvh.reset_for_reuse(triangles.len(), Some((0..triangles.len() as u32).collect()));
    builder.current_nodes = (0..).zip(triangles).map(|(at, t)| Bvh2Node::new(t.aabb(), 1, at)).collect();
    let all = triangles.iter().fold(Aabb::empty(), |all, t| all.union(&t.aabb()));
    let (precision, depth) = (params.sort_precision, params.search_depth_threshold);
    builder.build_ploc_from_leaves::<SEARCH, false>(&mut bvh, less_flat(all), precision, depth);
    let mut optimizer = ReinsertionOptimizer::default();
    optimizer.run(&mut bvh, params.reinsertion_batch_ratio, None);
    collapse(&mut bvh, params.max_prims_per_leaf, params.collapse_traversal_cost);
    let again = params.reinsertion_batch_ratio * params.post_collapse_reinsertion_batch_ratio_multiplier;
    optimizer.run(&mut bvh, again, None);
    bvh
}

/// A box with its short sides lengthened, on both ends alike.
fn less_flat(all: Aabb) -> Aabb {
    let diagonal = all.diagonal();
    let short = Vec3A::splat(diagonal.max_element() / FLAT_MAX);
    let more = (short - diagonal).max(Vec3A::ZERO) * 0.5;
    Aabb { min: all.min - more, max: all.max + more }
}

#[cfg(test)]
mod tests {
    use obvhs::bvh2::builder::build_bvh2;

    use super::*;

    /// A sheet of small triangles, and a large one that reaches to `far` below it.
    fn sheet(far: f32) -> Vec<Triangle> {
        let at = |x: usize, z: usize| {
            Vec3A::new(x as f32 / 50.0, (x as f32).sin() * (z as f32).cos() / 50.0, z as f32 / 50.0)
        };
        let mut all = Vec::new();
        for (x, z) in (0..50).flat_map(|x| (0..50).map(move |z| (x, z))) {
            all.push(Triangle { v0: at(x, z), v1: at(x + 1, z), v2: at(x, z + 1) });
            all.push(Triangle { v0: at(x + 1, z), v1: at(x + 1, z + 1), v2: at(x, z + 1) });
        }
        let corner = |x, z| Vec3A::new(x, -1.0, z);
        all.push(Triangle { v0: corner(-far, -far), v1: corner(-far, 3.0 * far), v2: corner(3.0 * far, -far) });
        all
    }

    /// The areas of the boxes of the tree, but for those as large as the ground.
    fn areas(bvh: &Bvh2) -> f64 {
        bvh.nodes.iter().map(|node| f64::from(node.aabb().half_area())).filter(|&area| area < 10.0).sum()
    }

    #[test]
    fn a_large_ground_does_not_spoil_what_stands_on_it() {
        let near = areas(&tree(&sheet(4.0)));
        for far in [40.0, 400.0, 4000.0] {
            let ratio = areas(&tree(&sheet(far))) / near;
            assert!((0.8..1.25).contains(&ratio), "{far}: {ratio}");
        }
    }

    #[test]
    fn models_that_are_not_flat_have_the_tree_of_obvhs() {
        for far in [0.5, 4.0, 7.0] {
            let triangles = sheet(far);
            let params = BvhBuildParams { max_prims_per_leaf: MAX_LEAF_TRIANGLES, ..BvhBuildParams::medium_build() };
            let theirs = build_bvh2(&triangles, params, &mut std::time::Duration::default());
            let ours = tree(&triangles);
            let of = |bvh: &Bvh2| {
                let nodes = bvh.nodes.iter().map(|n| (n.aabb().min, n.aabb().max, n.prim_count, n.first_index));
                (nodes.collect::<Vec<_>>(), bvh.primitive_indices.clone())
            };
            assert!(of(&ours) == of(&theirs), "{far}");
        }
    }
}
