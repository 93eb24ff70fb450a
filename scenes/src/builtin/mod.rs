//! The built-in scenes, generated at run time.

mod car;
mod chess;
mod cornell;
mod lab;
mod provence;
mod teapot;

use crate::{error::SceneError, names::hint, scene::Scene};

/// The names that [`builtin()`] knows.
#[must_use]
pub fn builtin_names() -> &'static [&'static str] {
    &["cornell", "teapot", "chess", "car", "lab", "provence"]
}

/// Generates a built-in scene.
///
/// # Errors
/// An unknown name, with near ones.
pub fn builtin(name: &str) -> Result<Scene, SceneError> {
    match name {
        "car" => car::scene(),
        "cornell" => cornell::scene(),
        "chess" => chess::scene(),
        "lab" => lab::scene(),
        "provence" => provence::scene(),
        "teapot" => teapot::scene(),
        _ => Err(SceneError::Usage {
            what: format!("no scene is called `{name}`"),
            fix: hint(name, builtin_names(), "built-in scenes"),
        }),
    }
}
