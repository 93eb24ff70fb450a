//! Metallic-roughness materials as the materials that the tracer has. `docs/scenes.md` states the rules for users.
//!
//! - F0 is `((ior - 1) / (ior + 1))^2` of a non-metal (0.04 at the index 1.5), the base colour of a metal, and between
//!   them what `metallic` says. The specular colour is F0 times `1 - roughness`.
//! - What is reflected and what is let through have one colour each: of a base colour that is a picture, its mean.
//! - Below [`GLOSSY`] a surface reflects rays, with Schlick's Fresnel from its specular colour on; a rougher one has only
//!   the highlight.
//! - The diffuse colour is the base colour times `1 - metallic (1 - roughness)`: a rough metal would be black without
//!   something to reflect, so it keeps its colour.
//! - Transmission makes a dielectric with the file's index, of metal as far as it is none; its tint for each surface crossed is base colour
//!   times transmission.
//! - `MASK` is a cut-out at its cutoff. `BLEND` is a cut-out at one half of the texture's alpha; a constant alpha is plain
//!   transparency, as `d` of an MTL file is, but of mirrors and glass it is not read.

use gltf::material::AlphaMode;

use glam::{Vec2, Vec3};

use super::{
    document::Source,
    textures::{Image, Named, Pictures},
};
use crate::{
    defaults::default_material,
    error::SceneError,
    scene::{Material, Optics},
    warnings::Warnings,
};

/// Roughness below which a surface reflects rays.
pub(crate) const GLOSSY: f32 = 0.4;
/// Phong exponent of the smoothest surface.
const SHININESS_MAX: f64 = 10_000.0;

/// A material, and what its texture needs of the mesh.
pub(crate) struct Surface {
    pub material: Material,
    /// Which texture coordinates.
    pub uv_set: u32,
    /// Where the texture is moved to.
    pub uv_map: Option<UvMap>,
    /// A cut-out that nothing is left of.
    pub invisible: bool,
}

/// KHR_texture_transform: scaled, turned, moved.
#[derive(Clone, Copy)]
pub(crate) struct UvMap {
    offset: Vec2,
    sin: f64,
    cos: f64,
    scale: Vec2,
}

impl UvMap {
    /// The coordinate where the texture is looked up.
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        let (u, v) = (f64::from(uv.x * self.scale.x), f64::from(uv.y * self.scale.y));
        let turned = Vec2::new((u * self.cos + v * self.sin) as f32, (v * self.cos - u * self.sin) as f32);
        turned + self.offset
    }
}

/// Reads a material.
pub(crate) fn surface(
    source: &Source,
    material: &gltf::Material<'_>,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Result<Surface, SceneError> {
    let name = name(material);
    let place = format!("{}: material `{name}`", source.path.display());
    tell_ignored(material, &place, warnings);
    let pbr = material.pbr_metallic_roughness();
    let [r, g, b, alpha] = pbr.base_color_factor();
    let base = colour(source, &name, "baseColorFactor", [r, g, b])?;
    if base.max_element() > 1.001 {
        warnings.add("bright", || format!("{place}: a base colour above 1 would create light and was lowered to 1"));
    }
    let base = base.min(Vec3::ONE);
    let alpha = number(source, &name, "base alpha", alpha, 0.0, 1.0)?;
    let (metallic, roughness) = metal(source, &name, &pbr, pictures, warnings)?;
    let ior = material.ior().unwrap_or(1.5);
    // The extension uses 0 for "reflects everything".
    let ior = if ior == 0.0 { 1.5 } else { number(source, &name, "ior", ior, 1.0, 1000.0)? };
    // What passes light is the part that is no metal.
    let transmission = transmission(source, material, &name, pictures, warnings)?;
    if transmission > 0.0 && metallic > 0.0 {
        warnings.add("metal glass", || {
            format!("{place}: transmission is of what is no metal: it is taken times 1 - metallic ({metallic:.2} here)")
        });
    }
    let transmission = transmission * (1.0 - metallic);
    let share = (ior - 1.0) / (ior + 1.0);
    let image = base_image(source, &pbr, warnings);
    let tint = match image {
        Some(image) if metallic > 0.0 && roughness < 1.0 || transmission > 0.0 => {
            warnings.add("tint map", || {
                format!("{place}: what metal reflects and glass lets through has one colour: the mean of the texture")
            });
            base * pictures.mean_colour(source, image)?
        }
        _ => base,
    };
    let specular = Vec3::splat(share * share).lerp(tint, metallic) * (1.0 - roughness);
    let mut out = Material {
        diffuse: base * (1.0 - metallic * (1.0 - roughness)) * (1.0 - transmission),
        specular,
        shininess: shininess(roughness),
        emission: emission(source, material, &name, warnings)?,
        optics: if roughness < GLOSSY { Optics::FresnelMirror } else { Optics::Opaque },
        ior: 1.0,
        transmission: Vec3::ONE,
        diffuse_map: None,
        alpha_map: None,
        name: name.clone(),
    };
    if transmission > 0.0 {
        (out.optics, out.ior, out.specular) = (Optics::Dielectric, ior, Vec3::ONE);
        out.transmission = (tint * transmission).min(Vec3::ONE);
        // Clear glass has the highlight of smooth glass.
        out.shininess = shininess(0.0);
        if roughness >= GLOSSY {
            warnings.add("frosted", || format!("{place}: rough glass is drawn clear"));
        }
    }
    let mut surface = Surface { material: out, uv_set: 0, uv_map: None, invisible: false };
    if let (Some(image), Some(info)) = (image, pbr.base_color_texture()) {
        base_texture(source, (image, &info), &mut surface, pictures)?;
    }
    alpha_mode(source, material, (image, alpha), &mut surface, pictures, warnings)?;
    Ok(surface)
}

/// The surface of a primitive without a material: white and rough.
pub(crate) fn plain() -> Surface {
    let material = Material { diffuse: Vec3::ONE, ..default_material("default") };
    Surface { material, uv_set: 0, uv_map: None, invisible: false }
}

/// The name that messages and scene files use.
fn name(material: &gltf::Material<'_>) -> String {
    let index = || material.index().map_or_else(|| "default".into(), |index| format!("material {index}"));
    material.name().map_or_else(index, str::to_owned)
}

fn number(source: &Source, name: &str, what: &str, value: f32, low: f32, high: f32) -> Result<f32, SceneError> {
    // Exporters round.
    let near = value.clamp(low, high);
    if (value - near).abs() <= 1e-3 {
        return Ok(near);
    }
    let fix = format!("it must be between {low} and {high}");
    Err(source.bad(format!("material `{name}`"), format!("{what} is {value}"), &fix))
}

fn colour(source: &Source, name: &str, what: &str, colour: [f32; 3]) -> Result<Vec3, SceneError> {
    for value in colour {
        number(source, name, what, value, 0.0, 1e6)?;
    }
    Ok(colour.into())
}

/// Metallic and roughness: the factors, times the mean of their texture.
fn metal(
    source: &Source,
    name: &str,
    pbr: &gltf::material::PbrMetallicRoughness<'_>,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Result<(f32, f32), SceneError> {
    let metallic = number(source, name, "metallicFactor", pbr.metallic_factor(), 0.0, 1.0)?;
    let roughness = number(source, name, "roughnessFactor", pbr.roughness_factor(), 0.0, 1.0)?;
    let Some(info) = pbr.metallic_roughness_texture() else { return Ok((metallic, roughness)) };
    let Named::Picture(image) = Pictures::named(source, &info.texture(), warnings) else {
        return Ok((metallic, roughness));
    };
    let [_, rough, metal, _] = pictures.mean(source, image)?;
    warnings.add("metal map", || {
        format!(
            "{}: material `{name}`: textures of metal and roughness are read as their mean (here metallic {:.2}, roughness {:.2})",
            source.path.display(),
            f64::from(metallic) * metal,
            f64::from(roughness) * rough
        )
    });
    Ok(((f64::from(metallic) * metal) as f32, (f64::from(roughness) * rough) as f32))
}

/// The exponent whose highlight is as wide as that of a microfacet surface: `2 / roughness^4 - 2`.
fn shininess(roughness: f32) -> u32 {
    let alpha = f64::from(roughness) * f64::from(roughness);
    let exponent = if alpha > 0.0 { 2.0 / (alpha * alpha) - 2.0 } else { SHININESS_MAX };
    exponent.clamp(1.0, SHININESS_MAX).round() as u32
}

fn transmission(
    source: &Source,
    material: &gltf::Material<'_>,
    name: &str,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Result<f32, SceneError> {
    let Some(transmission) = material.transmission() else { return Ok(0.0) };
    let factor = number(source, name, "transmissionFactor", transmission.transmission_factor(), 0.0, 1.0)?;
    let Some(info) = transmission.transmission_texture() else { return Ok(factor) };
    let Named::Picture(image) = Pictures::named(source, &info.texture(), warnings) else { return Ok(factor) };
    let [mean, ..] = pictures.mean(source, image)?;
    let place = source.path.display();
    warnings.add("glass map", || {
        format!("{place}: material `{name}`: textures of transmission are read as their mean (here {mean:.2})")
    });
    Ok((f64::from(factor) * mean) as f32)
}

/// Emission has one colour here: a surface whose glow is a picture does not glow.
fn emission(
    source: &Source,
    material: &gltf::Material<'_>,
    name: &str,
    warnings: &mut Warnings,
) -> Result<Vec3, SceneError> {
    let strength = number(source, name, "emissiveStrength", material.emissive_strength().unwrap_or(1.0), 0.0, 1e6)?;
    let colour = colour(source, name, "emissiveFactor", material.emissive_factor())? * strength;
    if material.emissive_texture().is_none() || colour == Vec3::ZERO {
        return Ok(colour);
    }
    let place = source.path.display();
    warnings.add("glow map", || {
        format!("{place}: material `{name}`: textures of emission are not read, and the surface does not glow")
    });
    Ok(Vec3::ZERO)
}

/// The picture of the base colour, if it can be read.
fn base_image(
    source: &Source,
    pbr: &gltf::material::PbrMetallicRoughness<'_>,
    warnings: &mut Warnings,
) -> Option<Image> {
    match Pictures::named(source, &pbr.base_color_texture()?.texture(), warnings) {
        Named::Picture(image) => Some(image),
        Named::NotRead => None,
    }
}

/// Sets the diffuse map and how it lies.
fn base_texture(
    source: &Source,
    (image, info): (Image, &gltf::texture::Info<'_>),
    surface: &mut Surface,
    pictures: &mut Pictures,
) -> Result<(), SceneError> {
    surface.material.diffuse_map = Some(pictures.plain(source, image)?);
    surface.uv_set = info.tex_coord();
    if let Some(map) = info.texture_transform() {
        surface.uv_set = map.tex_coord().unwrap_or(surface.uv_set);
        let turn = f64::from(map.rotation());
        let (offset, scale) = (Vec2::from(map.offset()), Vec2::from(map.scale()));
        if !(turn.is_finite() && offset.is_finite() && scale.is_finite()) {
            let part = format!("material `{}`", surface.material.name);
            return Err(source.bad(part, "its texture transform is not finite", "export the model again"));
        }
        surface.uv_map = Some(UvMap { offset, sin: libm::sin(turn), cos: libm::cos(turn), scale });
    }
    Ok(())
}

/// Cut-outs and plain transparency, of a base texture with this picture and a constant alpha.
fn alpha_mode(
    source: &Source,
    material: &gltf::Material<'_>,
    (image, alpha): (Option<Image>, f32),
    surface: &mut Surface,
    pictures: &mut Pictures,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let out = &mut surface.material;
    match (material.alpha_mode(), image) {
        (AlphaMode::Opaque, _) => {}
        (AlphaMode::Mask, image) => {
            let cutoff = number(source, &out.name, "alphaCutoff", material.alpha_cutoff().unwrap_or(0.5), 0.0, 1e6)?;
            match image {
                Some(image) => out.alpha_map = pictures.cut_out(source, image, alpha, cutoff)?,
                None => surface.invisible = alpha < cutoff,
            }
            tell_cut_away(source, out, pictures, warnings);
        }
        (AlphaMode::Blend, image) => {
            if let Some(image) = image {
                out.alpha_map = pictures.cut_out(source, image, 1.0, 0.5)?;
            }
            tell_cut_away(source, out, pictures, warnings);
            if out.alpha_map.is_some() {
                let place = source.path.display();
                warnings.add("blend", || {
                    format!(
                        "{place}: material `{}`: the blended texture is cut out where its alpha is below one half",
                        out.name
                    )
                });
            }
            if alpha < 1.0 {
                see_through(source, out, alpha, warnings);
            }
        }
    }
    Ok(())
}

/// Above this weight of reflection a surface is one of metal: diamond has 0.17.
const METAL: f32 = 0.2;

/// Lets light pass straight through a surface, unless it is a mirror or glass.
fn see_through(source: &Source, out: &mut Material, alpha: f32, warnings: &mut Warnings) {
    let told = |what: &str| format!("{}: material `{}`: {what}", source.path.display(), out.name);
    let reflects = out.optics == Optics::FresnelMirror;
    if out.optics == Optics::Dielectric {
        return warnings.add("alpha of glass", || told("alpha is not read of glass: transmission says what passes"));
    }
    if reflects && out.specular.max_element() > METAL {
        return warnings.add("alpha of a mirror", || told("alpha is not read of a mirror: nothing passes it"));
    }
    if reflects {
        warnings.add("blended gloss", || told("what is blended lets light pass straight, and reflects nothing"));
    }
    (out.optics, out.ior, out.specular) = (Optics::Dielectric, 1.0, Vec3::ZERO);
    out.transmission = Vec3::splat(1.0 - alpha);
    out.diffuse *= alpha;
}

/// Counts cut-outs that nothing is left of, wherever the texture lies.
fn tell_cut_away(source: &Source, material: &Material, pictures: &Pictures, warnings: &mut Warnings) {
    if material.alpha_map.is_some_and(|map| pictures.is_cut_away(map)) {
        let place = source.path.display();
        warnings.add("cut away", || {
            format!(
                "{place}: material `{}`: its texture is below the cutoff everywhere, and cuts all away",
                material.name
            )
        });
    }
}

/// Counts what the material says and the scene cannot.
fn tell_ignored(material: &gltf::Material<'_>, place: &str, warnings: &mut Warnings) {
    if material.normal_texture().is_some() {
        warnings.add("normal map", || format!("{place}: normal maps are not read"));
    }
    if material.occlusion_texture().is_some() {
        warnings.add("occlusion map", || format!("{place}: occlusion maps are not read: shadows are traced"));
    }
    for name in material.extensions().into_iter().flat_map(|map| map.keys()) {
        warnings.add(&format!("extension {name}"), || format!("{place}: the extension {name} is not read"));
    }
}
