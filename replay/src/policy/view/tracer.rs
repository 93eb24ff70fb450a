//! One sample in the hands of a policy: its hits are traced one by one.

use rayreel_formats::math::Vec3;
use rayreel_formats::tile::Shadows;

use crate::policy::history::KnownLights;
use crate::policy::tree::{Node, SurfacePoint};

/// The recorded ray tree of one sample, of which hits may be traced one by one.
pub struct HitTracer<'a> {
    pub(super) nodes: &'a [Node],
    pub(super) traced: &'a mut [Traced],
}

/// Which rays of a recorded hit were traced.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Traced {
    /// None.
    #[default]
    No,
    /// The ray that met it, and the shadow rays to all lights but these: the low bit of each light is set.
    But(u32),
}

impl Traced {
    /// All rays.
    pub const WHOLE: Self = Self::But(0);
}

impl HitTracer<'_> {
    /// Traces hit `node` and its shadow rays.
    pub fn hit(&mut self, node: usize) -> Node {
        self.traced[node] = Traced::WHOLE;
        self.nodes[node]
    }

    /// Traces the ray that meets hit `node`, and no shadow ray yet: no colour is known then, and of the lights whether rays would be
    /// cast at them, in the low bit of each.
    pub fn look(&mut self, node: usize) -> Node {
        let seen = self.nodes[node];
        // Whether a light is behind a surface the hit itself says.
        let surface = seen.surface.map(|surface| SurfacePoint { shadows: surface.shadows.places(), ..surface });
        if self.traced[node] == Traced::No {
            self.traced[node] = Traced::But(surface.map_or(0, |surface| surface.shadows.0));
        }
        Node { surface, local: Vec3::ZERO, colour: Vec3::ZERO, hit_rays: 1, rays: 1, ..seen }
    }

    /// Traces the shadow rays of hit `node`, which was looked at, but for those to lights that are known, and shades it. A trace holds
    /// no shader: it has the colour for the states that were recorded; for any others that of `known` stands.
    pub fn shade(&mut self, node: usize, known: KnownLights) -> Node {
        self.traced[node] = Traced::But(known.lights);
        let recorded = self.nodes[node];
        let Some(surface) = recorded.surface else { return recorded };
        let both = known.lights | known.lights << 1;
        let shadows = Shadows(surface.shadows.0 & !both | known.shadows.0 & both);
        let local = if shadows == surface.shadows { recorded.local } else { known.local };
        Node { surface: Some(SurfacePoint { shadows, ..surface }), local, ..recorded }
    }

    /// Traces hit `node` and everything below it.
    pub fn subtree(&mut self, node: usize) -> &[Node] {
        let range = node..node + self.nodes[node].len as usize;
        self.traced[range.clone()].fill(Traced::WHOLE);
        &self.nodes[range]
    }

    /// Whether recorded rays stand for the children of `like` below hit `node`: the recorded sample branches in the same
    /// way. This looks at the shape of the record only: without a stand-in a policy has to trace more.
    pub fn stands_in(&self, node: usize, like: &Node) -> bool {
        self.nodes[node].branches_as(like)
    }

    /// Hits of the subtree at `node`.
    pub fn len(&self, node: usize) -> usize {
        self.nodes[node].len as usize
    }
}
