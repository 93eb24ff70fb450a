//! Building meshes: shading normals from geometry, and vertices shared where they agree.

mod join;
pub(crate) mod normals;

pub(crate) use join::MeshJoin;
