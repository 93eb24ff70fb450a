//! The tree column: which rays there are and what shadow rays found.

use super::classes::{ClassRays, CodingOrder, Raster};
use super::coder::{Bit, Coder, Decoder, Encoder, Symbol};
use crate::limits::Limits;
use crate::scene::Rect;
use crate::tile::{MAX_DEPTH, RayClass, RayKind, RayNode, Shadows, Tree};

/// Contexts of whether a ray hits: four neighbours of three states (absent, miss, hit), per kind of ray.
const HIT_CONTEXTS: usize = 3 * 81;
/// Contexts of children and of shadow states: the neighbours W, N and NW of five states (absent, or one of four), per
/// kind of ray.
const STATE_CONTEXTS: usize = 3 * 125;

struct TreeModels {
    hit: Vec<Bit>,
    children: Vec<Symbol<4>>,
    /// Per light.
    shadows: Vec<Vec<Symbol<4>>>,
}

impl TreeModels {
    fn new(lights: usize) -> Self {
        Self {
            hit: vec![Bit::EVEN; HIT_CONTEXTS],
            children: vec![Symbol::default(); STATE_CONTEXTS],
            shadows: vec![vec![Symbol::default(); STATE_CONTEXTS]; lights],
        }
    }

    /// Codes one node, given the neighbouring nodes of its class.
    fn code<C: Coder>(&mut self, coder: &mut C, near: &[Option<RayNode>; 4], mut node: RayNode) -> RayNode {
        let kind = match node.class.kind() {
            RayKind::Primary => 0,
            RayKind::Reflection => 1,
            RayKind::Refraction | RayKind::Shadow => 2,
        };
        let mix = |states: usize, take: usize, f: &dyn Fn(&RayNode) -> usize| {
            near[..take].iter().fold(kind, |sum, n| sum * states + n.as_ref().map_or(0, |n| 1 + f(n)))
        };
        node.hit = coder.bit(&mut self.hit[mix(3, 4, &|n| usize::from(n.hit))], node.hit);
        if !node.hit {
            return node;
        }
        let children = |n: &RayNode| usize::from(n.reflect) | usize::from(n.refract) << 1;
        let coded = self.children[mix(5, 3, &children)].code(coder, children(&node));
        (node.reflect, node.refract) = (coded & 1 != 0, coded & 2 != 0);
        for (light, models) in self.shadows.iter_mut().enumerate() {
            let state = |n: &RayNode| (n.shadows.0 >> (2 * light) & 3) as usize;
            let coded = models[mix(5, 3, &state)].code(coder, state(&node));
            node.shadows.0 = node.shadows.0 & !(3 << (2 * light)) | (coded as u32) << (2 * light);
        }
        node
    }
}

fn nodes_near(raster: &Raster, sample: u32, nodes: impl Fn(u32) -> RayNode) -> [Option<RayNode>; 4] {
    let near = raster.neighbours(sample);
    [near.w, near.n, near.nw, near.ne].map(|n| n.map(&nodes))
}

/// Codes a tree of `lights` lights.
pub fn encode(order: &CodingOrder<'_>, lights: usize) -> Vec<u8> {
    let CodingOrder { tree, rect, classes } = order;
    let (mut coder, mut models, mut raster) = (Encoder::default(), TreeModels::new(lights), Raster::new(*rect));
    for ClassRays { rays, .. } in classes {
        raster.clear();
        for &(sample, node) in rays {
            let near = nodes_near(&raster, sample, |n| tree.nodes[n as usize]);
            models.code(&mut coder, &near, tree.nodes[node as usize]);
            raster.set(sample, node);
        }
    }
    coder.finish()
}

/// Decodes a tree.
///
/// # Errors
/// Says which limit a hostile stream would break.
pub fn decode(bytes: &[u8], rect: Rect, lights: usize, max_depth: u32, limits: &Limits) -> Result<Tree, String> {
    let (mut coder, mut models, mut raster) = (Decoder::new(bytes), TreeModels::new(lights), Raster::new(rect));
    let max_depth = max_depth.min(MAX_DEPTH);
    // Samples that have a ray of each class, filled by the parent class.
    let mut waiting: Vec<Vec<u32>> = vec![Vec::new(); 1 << (max_depth + 1)];
    waiting[1] = (0..rect.len() as u32).collect();
    let mut found: Vec<(u32, RayNode)> = Vec::new();
    for class in 1..waiting.len() {
        let samples = std::mem::take(&mut waiting[class]);
        raster.clear();
        for sample in samples {
            let class = RayClass(class as u16);
            let empty = RayNode { class, hit: false, reflect: false, refract: false, shadows: Shadows(0) };
            let near = nodes_near(&raster, sample, |n| found[n as usize].1);
            let node = models.code(&mut coder, &near, empty);
            if (node.reflect || node.refract) && class.depth() >= max_depth {
                return Err(format!("a ray of depth {} has children", class.depth()));
            }
            if node.reflect {
                waiting[class.reflection().0 as usize].push(sample);
            }
            if node.refract {
                waiting[class.refraction().0 as usize].push(sample);
            }
            raster.set(sample, found.len() as u32);
            found.push((sample, node));
            if found.len() as u64 > limits.max_nodes_per_tile {
                return Err(format!("more than {} ray-tree nodes", limits.max_nodes_per_tile));
            }
        }
    }
    Ok(depth_first(found, rect.len()))
}

/// Sorts nodes that were found class by class into samples, each depth first.
fn depth_first(mut found: Vec<(u32, RayNode)>, samples: usize) -> Tree {
    // Shifted to the left end, the bits of a class are its way from the root. So ways sort depth first, reflections
    // before refractions; of two equal ones the class with fewer bits is the ancestor.
    found.sort_by_key(|(sample, node)| (*sample, node.class.0 << node.class.0.leading_zeros(), node.class.0));
    let mut first = Vec::with_capacity(samples + 1);
    let mut at = 0;
    for sample in 0..samples as u32 {
        first.push(at as u32);
        while at < found.len() && found[at].0 == sample {
            at += 1;
        }
    }
    first.push(at as u32);
    Tree { first, nodes: found.into_iter().map(|(_, node)| node).collect() }
}
