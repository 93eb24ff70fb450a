//! Scenes for Rayreel: what stands before the camera, before any ray is traced.
//!
//! A [`Scene`] is a triangle mesh with objects and materials, textures, lights, a sky, and a camera for each frame.
//! [`load`] makes one from whatever a user may name: a built-in scene ([`builtin_names`]), an OBJ model
//! ([`obj::load_obj`]), a glTF model or a scene file in TOML. [`camera`] reads camera paths in CSV. [`modelling`] holds the
//! tools that make the built-in scenes; tests make theirs with them.
//!
//! Not here: rays, traces, hardware. This crate depends on no other crate of the project.
//!
//! ```
//! let scene = rayreel_scenes::load("cornell")?;
//! assert_eq!(scene.mesh.triangles.len(), 564);
//! assert_eq!(scene.cameras[0].vfov_deg, 33.2);
//! assert!(scene.objects.iter().any(|object| object == "glass sphere"));
//! # Ok::<(), rayreel_scenes::SceneError>(())
//! ```
//!
//! Invariants:
//! - A scene that a loader returns has passed [`Scene::validate`].
//! - The same input gives the same scene on every machine: no hash order, and every transcendental function is
//!   `libm`'s, in `f64`. [`Scene::content_hash`] tells scenes apart.
//! - No input makes a loader panic. [`SceneError`] says who must act, where, and what would put it right.

mod builtin;
pub mod camera;
mod defaults;
pub mod error;
mod file;
mod gltf_model;
mod load;
mod mesh;
pub mod modelling;
mod names;
pub mod obj;
mod options;
mod overrides;
mod pictures;
pub mod scene;
mod validate;
mod view;
pub mod warnings;

pub use builtin::{builtin, builtin_names};
pub use error::SceneError;
pub use file::BOX_PADDING;
pub use load::{load, load_with};
pub use options::{DEFAULT_ASPECT, DEFAULT_FPS, LoadOptions, MAX_FPS};
pub use overrides::Overrides;
pub use scene::{Camera, Light, Material, Mesh, Optics, Scene, Sky, Texture, Triangle, Wrap};
