//! The built-in scenes, generated at run time.

mod car;
mod car_body;
mod car_cabin;
mod car_details;
mod car_interior;
mod car_plaza;
mod car_shell;
mod car_wheel;
mod chess;
mod chessmen;
mod cornell;
mod knight;
mod lab;
mod lab_apparatus;
mod lab_furniture;
mod lab_glassware;
mod lab_metal;
mod lab_room;
mod lab_stock;
mod lab_things;
mod newell;
mod provence;
mod teapot;

use crate::{
    error::{SceneError, hint},
    scene::Scene,
};

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
        _ => Err(SceneError::UnknownScene {
            name: name.to_owned(),
            hint: hint(name, builtin_names(), "built-in scenes"),
        }),
    }
}
