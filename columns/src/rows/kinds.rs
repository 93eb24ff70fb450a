//! Words that several tables use.

use rayreel_formats::tile::{RayKind, ShadowState};

use crate::value::word;

word! {
    /// What a ray is.
    pub enum Kind {
        /// From the eye.
        Primary = "primary",
        /// Mirrored at a surface.
        Reflection = "reflection",
        /// Bent through a surface.
        Refraction = "refraction",
        /// From a hit to a light.
        Shadow = "shadow",
    }
}

impl From<RayKind> for Kind {
    fn from(kind: RayKind) -> Self {
        match kind {
            RayKind::Primary => Self::Primary,
            RayKind::Reflection => Self::Reflection,
            RayKind::Refraction => Self::Refraction,
            RayKind::Shadow => Self::Shadow,
        }
    }
}

word! {
    /// How a ray ended.
    pub enum Outcome {
        /// It met nothing: it sees the sky.
        Miss = "miss",
        /// It met a triangle.
        Hit = "hit",
        /// A shadow ray that reached its light.
        Lit = "lit",
        /// A shadow ray that something opaque stopped.
        Blocked = "blocked",
        /// A shadow ray that reached its light through glass.
        Tinted = "tinted",
    }
}

impl From<ShadowState> for Outcome {
    fn from(state: ShadowState) -> Self {
        match state {
            ShadowState::Blocked => Self::Blocked,
            ShadowState::Tinted => Self::Tinted,
            // A ray that was not cast has no row.
            ShadowState::Lit | ShadowState::NotCast => Self::Lit,
        }
    }
}

word! {
    /// What a ray asks memory for.
    pub enum Asked {
        /// A node of two children.
        Node = "node",
        /// A triangle.
        Triangle = "triangle",
    }
}
