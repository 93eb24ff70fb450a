//! Rays: how each follows from camera, `t`, normal and material, and how those of a tile are rebuilt.
//!
//! A trace stores no ray. A primary ray follows from the camera; a secondary or shadow ray follows from the hit that it
//! leaves. [`RayRebuilder`] gives the closest-hit rays of a tile as their parents' hits become known; [`TileRays`]
//! walks all rays of a tile, shadow rays included. The functions ([`primary`], [`surface`], [`reflection`], ..) are
//! those that the tracer calls.
//!
//! All of it is scalar arithmetic in a written order (see [`crate::math`]). So a ray rebuilt from a trace equals the
//! traced one to the last bit on any machine. FORMAT.md states the same formulas.

mod formulas;
mod rebuild;
mod walk;

pub use formulas::{Children, Ray, Surface, children, primary, reflection, refraction, shadow, surface, to_light};
pub use rebuild::{Geometry, KnownHit, RayRebuilder};
pub use walk::{RayEnd, RecordedRay, TileRays};
