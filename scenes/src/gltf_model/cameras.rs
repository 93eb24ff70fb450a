//! Cameras of a glTF file.

use glam::{DAffine3, Vec3};

use super::{
    document::Source,
    nodes::{Tree, label},
};
use crate::{error::SceneError, scene::Camera, validate::check_camera, warnings::Warnings};

/// A camera of the scene: its place in the tree, and its vertical field of view in degrees.
pub(crate) struct Lens {
    pub place: usize,
    node: usize,
    vfov_deg: f32,
}

/// The first camera with a perspective. Others, and those without, are told.
pub(crate) fn first(source: &Source, tree: &Tree, warnings: &mut Warnings) -> Option<Lens> {
    let file = source.path.display();
    let mut lens: Option<Lens> = None;
    for (place, node) in tree.nodes() {
        let Some(index) = source.root().nodes[node].camera else { continue };
        let camera = &source.root().cameras[index.value()];
        match (&camera.perspective, &lens) {
            (None, _) => warnings.add("orthographic", || {
                format!("{file}: {}: only cameras with a perspective are read", label(source, node))
            }),
            (Some(_), Some(first)) => warnings.add("cameras", || {
                let (used, other) = (label(source, first.node), label(source, node));
                format!("{file}: the camera of {used} is used; others, such as that of {other}, are not")
            }),
            (Some(perspective), None) => {
                lens = Some(Lens { place, node, vfov_deg: f64::from(perspective.yfov).to_degrees() as f32 });
            }
        }
    }
    lens
}

/// The camera where its node stands. It looks along its axis at the point beside `middle`.
pub(crate) fn camera(source: &Source, lens: &Lens, world: &DAffine3, middle: Vec3) -> Result<Camera, SceneError> {
    let at = || source.at(label(source, lens.node));
    let axis = |axis: glam::DVec3| {
        let what = "the camera's node has a scale of zero";
        axis.try_normalize().ok_or_else(|| SceneError::input(at(), what, "export the model again"))
    };
    let (forward, up) = (-axis(world.matrix3.z_axis)?, axis(world.matrix3.y_axis)?);
    let eye = world.translation;
    let beside = (middle.as_dvec3() - eye).dot(forward);
    // A target behind the camera, or within the rounding of its coordinates, would turn it.
    let distance = beside.max(1e-2 * (eye.length() + (middle.as_dvec3() - eye).length())).max(1e-3);
    let target = eye + forward * distance;
    let camera = Camera { eye: eye.as_vec3(), target: target.as_vec3(), up: up.as_vec3(), vfov_deg: lens.vfov_deg };
    check_camera(&camera, at)?;
    Ok(camera)
}
