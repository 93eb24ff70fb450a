//! The scenes that benches run on: the built-in ones, and those of `../shared/scenes` where that folder is there.

use std::path::{Path, PathBuf};

use rayreel_scenes::{Camera, Light, Scene, SceneError, builtin_names, load};
use serde_json::Value;

type Load = Box<dyn Fn() -> Result<Scene, SceneError>>;

/// Name, frame of the camera path, loader.
pub fn all() -> Vec<(String, usize, Load)> {
    let mut found: Vec<(String, usize, Load)> = Vec::new();
    for name in builtin_names() {
        found.push(((*name).to_string(), 0, Box::new(move || load(name))));
    }
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/scenes");
    let Ok(text) = std::fs::read_to_string(folder.join("cameras.json")) else {
        println!("(../shared/scenes is not there: built-in scenes only)\n");
        return found;
    };
    let cameras: Value = serde_json::from_str(&text).expect("cameras.json is JSON");
    for (name, entry) in cameras.as_object().expect("cameras.json is an object") {
        if entry.is_object() {
            let (folder, entry) = (folder.clone(), entry.clone());
            let frame = entry["frame"].as_u64().map_or(0, |f| f as usize - 1);
            let title = if name.starts_with("cornell") { format!("{name}_obj") } else { name.clone() };
            let title = if builtin_names().contains(&name.as_str()) { format!("{name}_obj") } else { title };
            found.push((title, frame, Box::new(move || shared(&folder, &entry))));
        }
    }
    found
}

fn vector(value: &Value) -> glam::Vec3 {
    let number = |i: usize| value[i].as_f64().expect("a vector of numbers") as f32;
    glam::vec3(number(0), number(1), number(2))
}

fn shared(folder: &Path, entry: &Value) -> Result<Scene, SceneError> {
    let file = |key: &str| -> PathBuf { folder.join(entry[key].as_str().expect("a file name")) };
    let mut scene = load(&file("obj").to_string_lossy())?;
    scene.cameras = if entry["path"].is_string() {
        rayreel_scenes::camera::read_path(&file("path"))?
    } else {
        let vfov_deg = entry["vfov_deg"].as_f64().expect("an angle") as f32;
        let (eye, target, up) = (vector(&entry["eye"]), vector(&entry["target"]), vector(&entry["up"]));
        vec![Camera { eye, target, up, vfov_deg }]
    };
    let white = |intensity: f32| glam::Vec3::splat(intensity);
    let points = entry["points"].as_array().cloned().unwrap_or_default();
    let point = |p: &Value| Light::Point { position: vector(p), colour: white(1.2 / points.len() as f32) };
    scene.lights = points.iter().map(point).collect();
    if entry["sun"].is_array() {
        scene.lights.push(Light::Directional { to_light: vector(&entry["sun"]), colour: white(1.0) });
    }
    Ok(scene)
}
