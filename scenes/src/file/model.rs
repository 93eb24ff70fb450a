//! Models by the ending of their name, as scenes with what the model does not say.

use std::path::Path;

use glam::Vec3;

use crate::{
    defaults,
    error::{Location, SceneError},
    gltf_model::{Film, load_gltf},
    mesh::{away, bounds},
    obj::load_obj,
    options::LoadOptions,
    scene::{Camera, Light, Mesh, Scene, Triangle},
    view::View,
    warnings::Warning,
};

/// A model as a scene, and what a scene file must know of it.
pub(crate) struct Model {
    pub scene: Scene,
    /// Where a camera stands that neither the scene file nor the model places, and the light.
    pub view: View,
    /// The model has cameras of its own.
    pub has_cameras: bool,
    /// The model has lights of its own: not lamps, which are surfaces that emit.
    pub has_lights: bool,
    /// Frames of its animation, for a still camera before it.
    pub frames: u64,
}

/// Whether the name ends as that of a model that is read.
pub(crate) fn is_model(path: &Path) -> bool {
    ["obj", "gltf", "glb"].contains(&extension(path).as_str())
}

fn extension(path: &Path) -> String {
    path.extension().map_or_else(String::new, |e| e.to_string_lossy().to_lowercase())
}

/// What to do about a file whose ending says that it is neither a model nor a scene file that is read.
pub(crate) fn unknown_format(path: &Path) -> SceneError {
    let known = [
        "fbx", "ply", "stl", "usd", "usda", "usdc", "usdz", "blend", "3ds", "dae", "x", "x3d", "wrl", "abc", "lwo",
        "max", "ma", "mb", "c4d", "step", "stp", "iges", "off", "vrm", "ase", "dxf", "3mf", "pbrt", "xml", "mitsuba",
    ];
    let extension = extension(path);
    let is_known = known.contains(&extension.as_str()) || extension == "rtrace";
    let kind = if is_known { "files are" } else { "(whatever it is) is" };
    let what =
        format!("{}: .{extension} {kind} not read: models are .obj, .gltf or .glb, scene files .toml", path.display());
    let out = path.with_extension("obj");
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let convert =
        || format!("convert it: Blender exports glTF 2.0 and OBJ, or `assimp export {} {}`", name(path), name(&out));
    let fix = match extension.as_str() {
        "rtrace" => format!(
            "it is a trace already: `rayreel replay {} --machine none --out FOLDER` makes its pictures",
            name(path)
        ),
        known_kind if known.contains(&known_kind) => convert(),
        _ => "name a model, a scene file or a scene".into(),
    };
    SceneError::Usage { what, fix }
}

/// A scene of a model alone: what it does not say of camera, lights and sky is the default.
pub(crate) fn from_model(path: &Path, options: &LoadOptions) -> Result<Scene, SceneError> {
    read(path, options).map(|model| model.scene)
}

/// Reads a model that [`is_model`] knows.
pub(crate) fn read(path: &Path, options: &LoadOptions) -> Result<Model, SceneError> {
    if extension(path) == "obj" {
        options.check_still(&path.display().to_string())?;
        let model = load_obj(path)?;
        let mut scene = bare(path);
        (scene.mesh, scene.objects) = (model.mesh, model.objects);
        (scene.materials, scene.textures) = (model.materials, model.textures);
        (scene.warnings, scene.files) = (model.warnings, model.files);
        return finish(path, scene, (None, options.aspect), (Vec::new(), Vec::new(), 1));
    }
    let model = load_gltf(path, options)?;
    let mut scene = bare(path);
    (scene.mesh, scene.objects) = (model.mesh, model.objects);
    (scene.materials, scene.textures) = (model.materials, model.textures);
    (scene.warnings, scene.files) = (model.warnings, model.files);
    finish(path, scene, (model.film.as_ref(), options.aspect), (model.lights, model.cameras, model.frames))
}

/// A scene of this name with nothing in it.
fn bare(path: &Path) -> Scene {
    Scene {
        name: path.file_stem().map_or_else(|| "model".into(), |stem| stem.to_string_lossy().into_owned()),
        mesh: crate::scene::Mesh::default(),
        objects: Vec::new(),
        materials: Vec::new(),
        textures: Vec::new(),
        lights: Vec::new(),
        sky: defaults::soft_sky(),
        cameras: Vec::new(),
        warnings: Vec::new(),
        files: Vec::new(),
    }
}

/// Adds what the model does not say. A view of an animation is that of its whole film, whatever frame the scene holds.
fn finish(
    path: &Path,
    mut scene: Scene,
    (film, aspect): (Option<&Film>, f64),
    (lights, cameras, frames): (Vec<Light>, Vec<Camera>, u64),
) -> Result<Model, SceneError> {
    scene.warnings.extend(check_size(path, &scene.mesh.positions)?);
    scene.warnings.extend(check_span(path, &scene.mesh));
    let view =
        film.map_or_else(|| View::of(&scene.mesh, aspect), |film| View::of(&film.first, aspect).within(film.bounds));
    let (has_cameras, has_lights) = (!cameras.is_empty(), !lights.is_empty());
    scene.lights = if has_lights { lights } else { view.lights(&scene) };
    scene.cameras = if has_cameras { cameras } else { vec![view.camera(None); frames as usize] };
    scene.validate()?;
    Ok(Model { scene, view, has_cameras, has_lights, frames })
}

/// Models of other sizes have normals whose squares leave the numbers of single precision: a cube on a floor of 8 units is drawn the same at
/// 2^-38 to 2^28 times its size, and partly unlit at 2^-40 and 2^29 times.
const SIZES: (f32, f32) = (2e-11, 2e9);
/// At other sizes not even a camera can be placed.
const SIZES_AT_ALL: (f32, f32) = (1e-14, 1e14);
/// The boxes that a tracer puts around triangles grow by this part of the distance from the ray's origin to the middle of the scene, and by
/// this part of their own distance from there (FORMAT.md, the box test).
pub const BOX_PADDING: f32 = 1.0 / 1_048_576.0;
/// Where a ray that starts nearby makes them grow by more than this part of the triangle, rays visit visibly more of them than
/// they would have to.
const PADDING_MAX: f32 = 1.0 / 32.0;

/// Tells where half of a model's triangles lie so far from its middle that rays take too many steps.
fn check_span(path: &Path, mesh: &Mesh) -> Option<Warning> {
    let axis = |axis: usize| median(mesh.positions.iter().map(|p| p[axis]).collect()).unwrap_or_default();
    let middle = Vec3::new(axis(0), axis(1), axis(2));
    let part = |t: &Triangle| {
        let corners = t.vertices.map(|v| mesh.positions[v as usize]);
        let padding =
            2.0 * BOX_PADDING * corners.map(|c| (c - middle).abs().max_element()).into_iter().fold(0.0, f32::max);
        let size = extent(corners.into_iter());
        if size > 0.0 { padding / size } else { 0.0 }
    };
    let typical = median(mesh.triangles.iter().map(part).collect())?;
    (typical > PADDING_MAX).then(|| {
        let part = 2.0 * BOX_PADDING / typical;
        let message = format!(
            "{}: half of the triangles are smaller than {part:.0e} of their distance from the middle of the model: the boxes around them are \
             padded for the distance, so rays take more steps than they need; move the parts of the model together",
            path.display()
        );
        Warning { message, count: 1 }
    })
}

/// The middle one, of an even number the upper one.
fn median(mut values: Vec<f32>) -> Option<f32> {
    let middle = values.len() / 2;
    (!values.is_empty()).then(|| *values.select_nth_unstable_by(middle, f32::total_cmp).1)
}

/// The longest edge of the box around some points.
fn extent(mut points: impl Iterator<Item = Vec3>) -> f32 {
    let first = points.next().unwrap_or_default();
    let (low, high) = points.fold((first, first), |(low, high), p| (low.min(p), high.max(p)));
    (high - low).max_element()
}

/// Refuses models whose size single precision cannot hold, and tells where it holds them badly.
fn check_size(path: &Path, positions: &[Vec3]) -> Result<Option<Warning>, SceneError> {
    let (low, high) = bounds(positions);
    let size = (high - low).max_element();
    let within = |(smallest, largest): (f32, f32)| (smallest..=largest).contains(&size);
    if !within(SIZES_AT_ALL) {
        let what = format!("the model is {size:e} units large");
        return Err(SceneError::input(Location::File(path.to_owned()), what, "scale it nearer to 1"));
    }
    let (what, fix) = if !within(SIZES) {
        (format!("the model is {size:e} units large"), "scale it nearer to 1")
    } else {
        let Some(what) = away(positions) else { return Ok(None) };
        (what, "move it there")
    };
    let message = format!("{}: {what}: surfaces may be lit wrongly; {fix}", path.display());
    Ok(Some(Warning { message, count: 1 }))
}
