//! `rayreel scenes`: what there is to capture.

use anyhow::Result;
use clap::Subcommand;
use rayreel_scenes::{Optics, Scene};
use serde_json::json;

use crate::common::{GridArgs, print, print_json, printable};
use crate::exit::Exit;
use crate::scene_args::SceneArgs;

/// List the built-in scenes, or show what a scene holds.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    action: Action,
}

#[derive(Debug, Subcommand)]
enum Action {
    /// List the built-in scenes.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
    /// Show a built-in scene, a scene file (.toml) or a model (.obj, .gltf, .glb).
    Show {
        #[command(flatten)]
        scene: SceneArgs,
        /// Print JSON.
        #[arg(long)]
        json: bool,
    },
}

pub fn run(args: &Args) -> Result<Exit> {
    match &args.action {
        Action::List { json } => list(*json)?,
        Action::Show { scene, json } => show(&scene.load((0, 1), GridArgs::SIZE)?, *json)?,
    }
    Ok(Exit::Done)
}

fn list(as_json: bool) -> Result<()> {
    let mut rows = Vec::new();
    for name in rayreel_scenes::builtin_names() {
        let scene = rayreel_scenes::builtin(name)?;
        rows.push((*name, scene.mesh.triangles.len(), scene.objects.len(), scene.cameras.len()));
    }
    if as_json {
        let row = |&(name, triangles, objects, frames): &(&str, usize, usize, usize)| json!({"name": name, "triangles": triangles, "objects": objects, "frames": frames});
        return print_json(&rows.iter().map(row).collect());
    }
    let mut text = format!("{:<12} {:>10} {:>8} {:>7}\n", "scene", "triangles", "objects", "frames");
    for (name, triangles, objects, frames) in rows {
        text += &format!("{name:<12} {triangles:>10} {objects:>8} {frames:>7}\n");
    }
    print(&text)
}

fn show(scene: &Scene, as_json: bool) -> Result<()> {
    let (min, max) = scene.bounds();
    let camera = &scene.cameras[0];
    if as_json {
        return print_json(&json!({
            "name": scene.name,
            "triangles": scene.mesh.triangles.len(),
            "vertices": scene.mesh.positions.len(),
            "objects": scene.objects,
            "materials": scene.materials.iter().map(|m| &m.name).collect::<Vec<_>>(),
            "optics": scene.materials.iter().map(|m| optics_name(m.optics)).collect::<Vec<_>>(),
            "textures": scene.textures.len(),
            "lights": scene.lights.len(),
            "frames": scene.cameras.len(),
            "camera": {
                "eye": camera.eye.to_array(),
                "target": camera.target.to_array(),
                "up": camera.up.to_array(),
                "vfov_deg": camera.vfov_deg,
            },
            "bounds": {"min": min.to_array(), "max": max.to_array()},
            "content_hash": hex(&scene.content_hash()),
        }));
    }
    let mut text = String::new();
    let mut line = |name: &str, value: String| text += &format!("{name:<12} {}\n", printable(&value));
    line("scene", scene.name.clone());
    line("triangles", scene.mesh.triangles.len().to_string());
    line("vertices", scene.mesh.positions.len().to_string());
    line("objects", scene.objects.len().to_string());
    line(
        "materials",
        scene
            .materials
            .iter()
            .map(|m| format!("{} ({})", m.name, optics_name(m.optics)))
            .collect::<Vec<_>>()
            .join(", "),
    );
    line("textures", scene.textures.len().to_string());
    line("lights", scene.lights.len().to_string());
    line("frames", scene.cameras.len().to_string());
    line("bounds", format!("{min} to {max}"));
    line("camera", format!("from {} to {}, {} degrees vertical", camera.eye, camera.target, camera.vfov_deg));
    line("content", hex(&scene.content_hash()));
    print(&text)
}

fn optics_name(optics: Optics) -> &'static str {
    match optics {
        Optics::Opaque => "opaque",
        Optics::Mirror => "mirror",
        Optics::FresnelMirror => "Fresnel mirror",
        Optics::Dielectric => "dielectric",
    }
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|b| format!("{b:02x}")).collect()
}
