//! Lights of a glTF file as the lights that the tracer has: without fall-off and without cones.

use glam::{DAffine3, DVec3, Vec3};
use gltf::json::extensions::scene::khr_lights_punctual::Type;
use gltf::json::validation::Checked;

use super::{document::Source, nodes::label};
use crate::{
    error::SceneError,
    scene::{Light, MAX_LIGHTS},
    warnings::Warnings,
};

/// What all lights together give a surface that faces them: as much as the default lights do.
const TOGETHER: f64 = 1.13;

/// A light with how much it gives at the middle of the model, in the file's units.
struct Lamp {
    light: Light,
    colour: DVec3,
}

/// A light nearer to the middle of the model than this part of its radius counts as so far away: no surface is nearer to it on the whole.
const NEAREST: f64 = 0.5;

/// The lights at the nodes of the scene. Exposure is the viewer's in glTF: so only how strong lights are beside each other
/// counts, at the middle of the model, which has a radius, and together they are as strong as the default ones.
pub(crate) fn lights(
    source: &Source,
    stands: impl Iterator<Item = (usize, DAffine3)>,
    (middle, radius): (Vec3, f32),
    warnings: &mut Warnings,
) -> Result<Vec<Light>, SceneError> {
    let mut lamps = Vec::new();
    for (node, world) in stands {
        if let Some(light) = named(source, node)
            && let Some(lamp) = lamp(source, node, light, &world, (middle.as_dvec3(), f64::from(radius)), warnings)?
        {
            lamps.push(lamp);
        }
    }
    let strength = |lamp: &Lamp| lamp.colour.max_element();
    if lamps.len() > MAX_LIGHTS {
        for _ in MAX_LIGHTS..lamps.len() {
            warnings.add("lights", || {
                format!("{}: a trace has {MAX_LIGHTS} lights at most: the weakest were left out", source.path.display())
            });
        }
        // The sort is stable, so equal lamps keep the order of the file.
        lamps.sort_by(|a, b| strength(b).total_cmp(&strength(a)));
        lamps.truncate(MAX_LIGHTS);
    }
    let sum: f64 = lamps.iter().map(strength).sum();
    let scaled = |lamp: &Lamp| (lamp.colour * (TOGETHER / sum)).as_vec3();
    Ok(lamps.iter().map(|lamp| coloured(lamp.light, scaled(lamp))).collect())
}

/// The light that a node names.
pub(crate) fn named(source: &Source, node: usize) -> Option<usize> {
    let named = source.root().nodes[node].extensions.as_ref()?.khr_lights_punctual.as_ref()?;
    Some(named.light.value())
}

fn coloured(light: Light, colour: Vec3) -> Light {
    match light {
        Light::Point { position, .. } => Light::Point { position, colour },
        Light::Directional { to_light, .. } => Light::Directional { to_light, colour },
    }
}

/// One light; `None` for one that is dark.
fn lamp(
    source: &Source,
    node: usize,
    index: usize,
    world: &DAffine3,
    (middle, radius): (DVec3, f64),
    warnings: &mut Warnings,
) -> Result<Option<Lamp>, SceneError> {
    let all = source.root().extensions.as_ref().and_then(|all| all.khr_lights_punctual.as_ref());
    let broken =
        |what: &str| source.bad(label(source, node), format!("light {index} {what}"), "export the model again");
    let light = all.and_then(|all| all.lights.get(index)).ok_or_else(|| broken("is not in the file"))?;
    let colour = DVec3::from_array(light.color.map(f64::from)) * f64::from(light.intensity);
    if !colour.is_finite() || colour.min_element() < 0.0 {
        return Err(broken("has a colour or intensity that is negative or not finite"));
    }
    let position = world.translation;
    let kind = if let Checked::Valid(kind) = light.type_ { kind } else { Type::Point };
    if kind == Type::Spot {
        let file = source.path.display();
        warnings.add("spot", || {
            format!("{file}: {}: a spot light shines to all sides here: cones are not read", label(source, node))
        });
    }
    let (light, fall_off) = if kind == Type::Directional {
        let to_light = world.matrix3.z_axis.try_normalize().ok_or_else(|| broken("shines in no direction"))?;
        (Light::Directional { to_light: to_light.as_vec3(), colour: Vec3::ZERO }, 1.0)
    } else {
        let square = (position - middle).length_squared().max((NEAREST * radius).powi(2));
        (Light::Point { position: position.as_vec3(), colour: Vec3::ZERO }, 1.0 / square)
    };
    let colour = colour * fall_off;
    Ok((colour.max_element() > 0.0).then_some(Lamp { light, colour }))
}
