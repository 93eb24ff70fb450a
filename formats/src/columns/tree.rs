//! The tree column: which rays there are and what shadow rays found.

use super::classes::{ClassRays, CodingOrder};
use super::coder::{Bit, Coder, Decoder, Encoder};
use super::numbers::Symbol;
use super::rows::{Around, Rows};
use crate::limits::Limits;
use crate::scene::Rect;
use crate::tile::{MAX_DEPTH, RayClass, RayKind, RayNode, Shadows, Tree};

/// Contexts of whether a ray hits: four neighbours of three states (absent, miss, hit), per kind of ray.
const HIT_CONTEXTS: usize = 3 * 81;
/// Contexts of children and of shadow states: the neighbours W, N and NW of five states (absent, or one of four), per
/// kind of ray.
const STATE_CONTEXTS: usize = 3 * 125;

/// What a neighbour's node was.
#[derive(Clone, Copy, Default)]
struct Near {
    /// 1 if there is one.
    there: u8,
    /// 0 where there is none, 1 for a miss, 2 for a hit.
    hit: u8,
    /// 0 where there is none, else 1 + the children, one bit each.
    children: u8,
    shadows: u32,
}

impl Near {
    fn new(node: &RayNode) -> Self {
        let children = 1 + children(node) as u8;
        Self { there: 1, hit: 1 + u8::from(node.hit), children, shadows: node.shadows.0 }
    }

    /// 0 where there is none, else 1 + the state of a light.
    #[inline(always)]
    fn light(self, light: usize) -> usize {
        usize::from(self.there) + (self.shadows >> (2 * light) & 3) as usize
    }
}

fn children(node: &RayNode) -> usize {
    usize::from(node.reflect) | usize::from(node.refract) << 1
}

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
    #[inline(always)]
    fn code<C: Coder>(&mut self, coder: &mut C, around: Around<Near>, mut node: RayNode) -> RayNode {
        let kind = match node.class.kind() {
            RayKind::Primary => 0,
            RayKind::Reflection => 1,
            RayKind::Refraction | RayKind::Shadow => 2,
        };
        let Around { w, n, nw, ne } = around;
        let hits = [w, n, nw, ne].map(|near| usize::from(near.hit));
        node.hit = coder.bit(&mut self.hit[mix(kind, 3, hits)], node.hit);
        if !node.hit {
            return node;
        }
        let around = [w, n, nw];
        let context = mix(kind, 5, around.map(|near| usize::from(near.children)));
        let coded = self.children[context].code(coder, children(&node));
        (node.reflect, node.refract) = (coded & 1 != 0, coded & 2 != 0);
        for (light, models) in self.shadows.iter_mut().enumerate() {
            let given = (node.shadows.0 >> (2 * light) & 3) as usize;
            let coded = models[mix(kind, 5, around.map(|near| near.light(light)))].code(coder, given);
            node.shadows.0 = node.shadows.0 & !(3 << (2 * light)) | (coded as u32) << (2 * light);
        }
        node
    }
}

/// The context of a kind of ray whose neighbours have these of so many states.
#[inline(always)]
fn mix<const N: usize>(kind: usize, states: usize, near: [usize; N]) -> usize {
    near.into_iter().fold(kind, |sum, state| sum * states + state)
}

/// Codes a tree of `lights` lights.
pub fn encode(order: &CodingOrder<'_>, lights: usize) -> Vec<u8> {
    let CodingOrder { tree, rect, classes } = order;
    let (mut coder, mut models, mut rows) = (Encoder::default(), TreeModels::new(lights), Rows::new(*rect));
    for ClassRays { rays, .. } in classes {
        rows.restart(*rect);
        for &(sample, node) in rays {
            let (x, node) = (rows.go_to(sample), &tree.nodes[node as usize]);
            models.code(&mut coder, rows.around(x), *node);
            rows.set(x, Near::new(node));
        }
    }
    coder.finish()
}

/// Decodes a tree.
///
/// # Errors
/// Says which limit a hostile stream would break.
pub fn decode(bytes: &[u8], rect: Rect, lights: usize, max_depth: u32, limits: &Limits) -> Result<Tree, String> {
    let (mut coder, mut models, mut rows) = (Decoder::new(bytes), TreeModels::new(lights), Rows::new(rect));
    let (max_depth, most) = (max_depth.min(MAX_DEPTH), limits.nodes_max(bytes.len()));
    // Samples that have a ray of each class, filled by the parent class.
    let mut waiting: Vec<Vec<u32>> = vec![Vec::new(); 1 << (max_depth + 1)];
    waiting[1] = (0..rect.len() as u32).collect();
    let mut found: Vec<(u32, RayNode)> = Vec::new();
    for class in 1..waiting.len() {
        let samples = std::mem::take(&mut waiting[class]);
        if samples.is_empty() {
            continue;
        }
        rows.restart(rect);
        let class = RayClass(class as u16);
        for sample in samples {
            let empty = RayNode { class, hit: false, reflect: false, refract: false, shadows: Shadows(0) };
            let x = rows.go_to(sample);
            let node = models.code(&mut coder, rows.around(x), empty);
            if (node.reflect || node.refract) && class.depth() >= max_depth {
                return Err(format!("a ray of depth {} has children", class.depth()));
            }
            if node.reflect {
                waiting[class.reflection().0 as usize].push(sample);
            }
            if node.refract {
                waiting[class.refraction().0 as usize].push(sample);
            }
            rows.set(x, Near::new(&node));
            found.push((sample, node));
            if found.len() as u64 > most {
                return Err(format!("more than {most} ray-tree nodes in {} bytes", bytes.len()));
            }
        }
    }
    Ok(depth_first(&found, rect.len()))
}

/// Sorts nodes that were found class by class into samples, each depth first.
fn depth_first(found: &[(u32, RayNode)], samples: usize) -> Tree {
    let mut first = vec![0u32; samples + 1];
    found.iter().for_each(|&(sample, _)| first[sample as usize + 1] += 1);
    for sample in 0..samples {
        first[sample + 1] += first[sample];
    }
    let Some(&(_, any)) = found.first() else { return Tree { first, nodes: Vec::new() } };
    let (mut nodes, mut next) = (vec![any; found.len()], first.clone());
    for &(sample, node) in found {
        let place = &mut next[sample as usize];
        nodes[*place as usize] = node;
        *place += 1;
    }
    for range in first.windows(2) {
        let sample = &mut nodes[range[0] as usize..range[1] as usize];
        // Now by class, so two are in order: a child stands behind its parent.
        if sample.len() > 2 {
            // Shifted to the left end, the bits of a class are its way from the root. So ways sort depth first, reflections
            // before refractions; of two equal ones the class with fewer bits is the ancestor.
            sample.sort_unstable_by_key(|node| (node.class.0 << node.class.0.leading_zeros(), node.class.0));
        }
    }
    Tree { first, nodes }
}
