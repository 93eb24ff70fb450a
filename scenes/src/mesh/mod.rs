//! Building meshes: shading normals from geometry, and vertices shared where they agree.

mod away;
mod join;
mod meet;
pub(crate) mod normals;

pub(crate) use away::{away, bounds};
pub(crate) use join::MeshJoin;
pub(crate) use meet::meet;
