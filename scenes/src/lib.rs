//! Scenes for Rayreel: what is in front of the camera, before any ray is traced.
//!
//! A [`Scene`] is a triangle mesh with object ids and materials, textures, lights, a sky and a camera path. It comes from a
//! built-in generator, an OBJ/MTL file or a scene file (TOML). This crate knows nothing of rays, traces or hardware.

pub mod scene;

pub use scene::*;
