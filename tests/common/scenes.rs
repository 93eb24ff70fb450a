//! Scene files for the tests: one made up here, and those of the shared folder beside the repository.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::Value;

use super::repository;

/// A scene to capture: name, what to give to the command line, frame.
#[derive(Clone, Debug)]
pub struct SceneFile {
    /// Name.
    pub name: String,
    /// Scene file or built-in name.
    pub spec: String,
    /// Frame of the camera path.
    pub frame: u64,
}

/// The built-in scenes and all of `../shared/scenes`; scene files are written into `folder`.
pub fn all(folder: &Path) -> Vec<SceneFile> {
    let builtin = |name: &str| SceneFile { name: name.into(), spec: name.into(), frame: 0 };
    let mut scenes: Vec<_> = super::BUILTIN.into_iter().map(builtin).collect();
    scenes.extend(shared(folder));
    scenes
}

/// The scenes that `cameras.json` lists; none where the folder is not there.
pub fn shared(folder: &Path) -> Vec<SceneFile> {
    let root = repository("../shared/scenes");
    let Ok(text) = fs::read_to_string(root.join("cameras.json")) else {
        eprintln!("skipped: {} is not here, only built-in scenes are tested", root.display());
        return Vec::new();
    };
    let root = root.canonicalize().unwrap();
    let cameras: Value = serde_json::from_str(&text).unwrap();
    let scenes = cameras.as_object().unwrap().iter().filter(|(_, v)| v.is_object());
    scenes.map(|(name, view)| write(folder, &root, name, view)).collect()
}

fn write(folder: &Path, root: &Path, name: &str, view: &Value) -> SceneFile {
    let quoted = |key: &str| format!("{:?}", root.join(view[key].as_str().unwrap()));
    let mut text = format!("model = {}\nname = {name:?}\n[camera]\n", quoted("obj"));
    // Frame numbers of the files start at 1, ours at 0.
    let mut frame = 0;
    if view["path"].is_string() {
        text += &format!("path = {}\n", quoted("path"));
        frame = view["frame"].as_u64().unwrap() - 1;
    } else {
        for key in ["eye", "target", "up", "vfov_deg"] {
            text += &format!("{key} = {}\n", floats(&view[key]));
        }
    }
    for point in view["points"].as_array().into_iter().flatten() {
        text += &format!("[[lights]]\nkind = \"point\"\nposition = {}\n", floats(point));
    }
    if view["sun"].is_array() {
        text += &format!("[[lights]]\nkind = \"directional\"\nto_light = {}\n", floats(&view["sun"]));
    }
    let file = folder.join(format!("{name}.toml"));
    fs::write(&file, text).unwrap();
    SceneFile { name: name.into(), spec: text_of(&file), frame }
}

/// A number or a list of numbers, all as TOML floats.
fn floats(value: &Value) -> String {
    match value.as_array() {
        Some(list) => format!("[{}]", list.iter().map(floats).collect::<Vec<_>>().join(", ")),
        None => format!("{:?}", value.as_f64().unwrap()),
    }
}

/// A path as text.
pub fn text_of(path: &Path) -> String {
    path.to_str().unwrap().to_string()
}

/// A mirror floor, a glass wall and a coloured one, with a camera that moves for five frames.
pub fn moving(folder: &Path) -> String {
    let obj = "mtllib room.mtl\n\
        v -2 0 -2\nv 2 0 -2\nv 2 0 2\nv -2 0 2\n\
        v -1 0 0\nv 1 0 0\nv 1 1.5 0.2\nv -1 1.5 -0.2\n\
        v -2 0 -1.5\nv 2 0 -1.5\nv 2 2 -1.5\nv -2 2 -1.5\n\
        o floor\nusemtl mirror\nf 1 4 3 2\n\
        o pane\nusemtl glass\nf 5 6 7 8\n\
        v -2 0 1.5\nv -2 2 1.5\n\
        o wall\nusemtl red\nf 9 10 11 12\n\
        o side\nusemtl red\nf 13 9 12 14\n";
    let mtl = "newmtl mirror\nKd 0.3 0.3 0.4\nKs 0.5 0.5 0.5\nNs 100\nillum 3\n\
        newmtl glass\nKd 0 0 0\nKs 1 1 1\nNi 1.5\nd 0.1\nTf 0.9 0.9 0.9\nillum 7\n\
        newmtl red\nKd 0.8 0.2 0.1\nillum 1\n";
    let scene = "model = \"room.obj\"\n[camera]\nvfov_deg = 45.0\n\
        [[camera.keyframes]]\nframe = 0\neye = [0.5, 1.2, 4.0]\ntarget = [0.0, 0.6, 0.0]\n\
        [[camera.keyframes]]\nframe = 4\neye = [-0.9, 1.5, 3.6]\ntarget = [0.0, 0.6, 0.0]\n\
        [[lights]]\nkind = \"point\"\nposition = [1.0, 3.0, 2.0]\n\
        [[lights]]\nkind = \"directional\"\nto_light = [-0.5, 1.0, 0.3]\n";
    let files = [("room.obj", obj), ("room.mtl", mtl), ("room.toml", scene)];
    files.iter().for_each(|(name, text)| fs::write(folder.join(name), text).unwrap());
    let file: PathBuf = folder.join("room.toml");
    text_of(&file)
}
