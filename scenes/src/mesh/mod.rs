//! Building meshes: shading normals from geometry, and vertices shared where they agree.

mod join;
mod meet;
pub(crate) mod normals;

pub(crate) use join::MeshJoin;
pub(crate) use meet::meet;
