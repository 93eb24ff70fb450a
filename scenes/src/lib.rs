//! Scenes for Rayreel: what is in front of the camera, before any ray is traced.
//!
//! A [`Scene`] is a triangle mesh with object ids and materials, textures, lights, a sky and a
//! camera path. It comes from a built-in generator, an OBJ/MTL file or a scene file (TOML);
//! [`load`] takes any of them. This crate knows nothing of rays, traces or hardware.
//!
//! Invariants: a scene that a loader returns has passed [`Scene::validate`]; the same input gives
//! the same bytes on every machine (no hash order, and every transcendental function from `libm` in
//! `f64`); no input makes a loader panic.

pub mod builtin;
pub mod camera;
pub mod defaults;
pub mod error;
pub mod file;
mod file_camera;
mod hash;
mod load;
mod mesh_join;
pub mod modelling;
mod mtl;
mod mtl_line;
mod normals;
mod obj;
mod obj_text;
mod polygon;
pub mod scene;
mod texture;
mod validate;
mod warnings;

pub use builtin::{builtin, builtin_names};
pub use error::SceneError;
pub use file::load_scene_file;
pub use load::load;
pub use obj::{ObjModel, load_obj};
pub use scene::*;
pub use validate::{MAX_LIGHTS, MAX_TEXTURE_SIDE};
