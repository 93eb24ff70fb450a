//! Material libraries (MTL).
//!
//! They are read here and not by tobj. tobj panics on a legal `Kd 0.5`, loses a whole library at a `Kd spectral` line,
//! and leaves the options of a `map_Kd` in the file name. Here every error has a line number.
//! How the statements are understood:
//!
//! - `illum` 0 to 2 (or none) is [`Optics::Opaque`], 3 and 8 [`Optics::Mirror`], 5
//!   [`Optics::FresnelMirror`], 4, 6, 7 and 9 [`Optics::Dielectric`]; 10 (shadow matte) is opaque
//!   with a warning.
//! - `illum` 0 and 1 have no highlight: their `Ks` is not read.
//! - Colours are linear. Without `Kd` a surface is 0.8 grey, or white under a `map_Kd`; glass without either has
//!   no colour of its own.
//! - `Tf` is the tint of a refracted ray per surface crossed, 1 = clear; none = clear. In the wild
//!   `Tf .1 .1 .1` without any `d` or `Tr` also means "filters a tenth" (the McGuire Cornell
//!   boxes): a dielectric whose `Tf` is below one half in all channels and that states no `d`/`Tr`
//!   gets `1 - Tf`.
//! - `d` below 1 on an opaque surface is plain transparency: a dielectric of index 1 (no
//!   reflection, no bending) that lets `1 - d` through. `d 0` there is what broken exporters write
//!   for "opaque" and is read so, with a warning.
//! - `map_d` with the picture of `map_Kd` means its alpha; with another picture, or with `-imfchan l`, the alpha if a texel is
//!   not opaque, else the luminance.
//! - `Ni` of a dielectric without one is 1.5, `Ks` of a dielectric without one is 1 (the full
//!   Fresnel reflection).

mod line;
mod textures;

pub(crate) use line::before_comment;

use std::{collections::BTreeMap, path::Path};

use glam::Vec3;

use self::line::{Map, MtlLine};
use crate::{
    error::SceneError,
    scene::{Material, Optics},
    warnings::Warnings,
};

pub(crate) use textures::TextureSet;

/// The materials of a model, found by their names.
#[derive(Debug, Default)]
pub(crate) struct MaterialList {
    list: Vec<Material>,
    by_name: BTreeMap<String, usize>,
    /// Those of libraries by what stands before a `#` in their names, which begins a comment where nobody knows the whole; none
    /// where several have the same before it.
    by_bare_name: BTreeMap<String, Option<usize>>,
}

impl MaterialList {
    /// The material of a name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.by_name.get(name).copied()
    }

    /// The material that a statement names. A name may hold a `#`: the whole counts before what is left without a comment.
    pub fn find_stated(&self, name: &str) -> Option<usize> {
        let bare = before_comment(name);
        self.find(name).or_else(|| self.find(bare)).or_else(|| self.by_bare_name.get(bare).copied().flatten())
    }

    /// A material by its place.
    pub fn get(&self, at: usize) -> Option<&Material> {
        self.list.get(at)
    }

    /// All names, in the order of the materials.
    pub fn names(&self) -> Vec<&str> {
        self.list.iter().map(|material| material.name.as_str()).collect()
    }

    /// Appends a material; its name finds it unless another has that name.
    pub fn append(&mut self, material: Material) -> usize {
        let at = self.list.len();
        self.by_name.entry(material.name.clone()).or_insert(at);
        self.list.push(material);
        at
    }

    /// Appends a material, or puts it in the place of the earlier one of its name; says whether there was one.
    pub fn define(&mut self, material: Material) -> bool {
        match self.find(&material.name) {
            Some(earlier) => {
                self.list[earlier] = material;
                true
            }
            None => {
                let bare = before_comment(&material.name).to_owned();
                let at = self.append(material);
                self.by_bare_name.entry(bare).and_modify(|one| *one = None).or_insert(Some(at));
                false
            }
        }
    }

    /// The materials.
    pub fn into_list(self) -> Vec<Material> {
        self.list
    }
}

/// What the statements of one material say, one by one.
#[derive(Debug, Default)]
struct Statements {
    name: String,
    line: usize,
    diffuse: Option<Vec3>,
    specular: Option<Vec3>,
    emission: Option<Vec3>,
    filter: Option<Vec3>,
    shininess: Option<f32>,
    ior: Option<f32>,
    dissolve: Option<f32>,
    transparency: Option<f32>,
    illum: Option<i64>,
    diffuse_map: Option<Map>,
    alpha_map: Option<Map>,
}

/// Reads one library and appends its materials; a material defined twice keeps its place and the
/// later definition.
pub(crate) fn read(
    path: &Path,
    text: &str,
    materials: &mut MaterialList,
    textures: &mut TextureSet,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let mut current: Option<Statements> = None;
    for (index, raw) in text.lines().enumerate() {
        let Some(line) = MtlLine::new(path, index + 1, raw) else {
            continue;
        };
        if line.keyword == "newmtl" {
            if let Some(done) = current.take() {
                finish(path, done, materials, textures, warnings)?;
            }
            if line.rest.is_empty() {
                return Err(line.bad("`newmtl` without a name".into(), "give the material a name"));
            }
            current = Some(Statements { name: line.rest.to_owned(), line: line.number, ..Statements::default() });
        } else if let Some(statements) = &mut current {
            statement(&line, statements, warnings)?;
        } else {
            warnings.add(&format!("early {}", path.display()), || {
                format!("{}:{}: a statement before the first `newmtl` was ignored", path.display(), line.number)
            });
        }
    }
    match current {
        Some(done) => finish(path, done, materials, textures, warnings),
        None => Ok(()),
    }
}

/// Adds one statement to the others of its material.
fn statement(line: &MtlLine<'_>, into: &mut Statements, warnings: &mut Warnings) -> Result<(), SceneError> {
    match line.keyword {
        "Kd" => into.diffuse = line.colour(warnings)?.or(into.diffuse),
        "Ks" => into.specular = line.colour(warnings)?.or(into.specular),
        "Ke" => into.emission = line.colour(warnings)?.or(into.emission),
        "Tf" => into.filter = line.colour(warnings)?.or(into.filter),
        "Ns" => into.shininess = Some(line.number_in(0.0, f32::MAX)?),
        "Ni" => into.ior = Some(line.number_in(0.0, 1000.0)?),
        "d" => into.dissolve = Some(line.dissolve(warnings)?),
        "Tr" => into.transparency = Some(line.number_in(0.0, 1.0)?),
        "illum" => into.illum = Some(line.illum()?),
        "map_Kd" => into.diffuse_map = Some(line::map(line, warnings)?),
        "map_d" => into.alpha_map = Some(line::map(line, warnings)?),
        // Ambient light comes from the sky here, and there are no reflection maps to be sharp.
        "Ka" | "map_Ka" | "sharpness" | "map_aat" => {}
        other => {
            let (file, number) = (line.path.display(), line.number);
            warnings.add(&format!("mtl {other}"), || format!("{file}:{number}: `{other}` is not used and was ignored"));
        }
    }
    Ok(())
}

/// Turns the statements of one material into a [`Material`].
fn finish(
    path: &Path,
    s: Statements,
    materials: &mut MaterialList,
    textures: &mut TextureSet,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let place = format!("{}:{}: material `{}`", path.display(), s.line, s.name);
    let mut optics = optics(s.illum, &place, warnings);
    let dielectric = optics == Optics::Dielectric;
    let mut transmission = transmission(&s, dielectric, &place, warnings);
    let grey = match (s.diffuse_map.is_some(), dielectric) {
        (true, _) => 1.0,
        (false, true) => 0.0,
        (false, false) => 0.8,
    };
    let mut diffuse = s.diffuse.unwrap_or(Vec3::splat(grey));
    let mut ior = s.ior.unwrap_or(if dielectric { 1.5 } else { 1.0 });
    if ior < 1.0 {
        warnings.add("ni", || format!("{place}: an index of refraction of {ior} was raised to 1"));
        ior = 1.0;
    }
    let opacity = opacity(&s, &place, warnings);
    tell_unread(&s, &optics, opacity, &place, warnings);
    if optics == Optics::Opaque && opacity < 1.0 {
        (optics, ior) = (Optics::Dielectric, 1.0);
        transmission = Vec3::splat(1.0 - opacity);
        diffuse *= opacity;
    }
    let (diffuse_map, alpha_map) = maps(path, &s, &place, textures, warnings)?;
    let material = Material {
        diffuse,
        specular: if matches!(s.illum, Some(0 | 1)) {
            Vec3::ZERO
        } else {
            s.specular.unwrap_or(Vec3::splat(f32::from(u8::from(dielectric))))
        },
        shininess: s.shininess.unwrap_or(10.0).round().clamp(1.0, 1e6) as u32,
        emission: s.emission.unwrap_or(Vec3::ZERO),
        optics,
        ior,
        transmission,
        diffuse_map,
        alpha_map,
        name: s.name,
    };
    if materials.define(material) {
        warnings.add("newmtl twice", || format!("{place} is defined twice; the later definition counts"));
    }
    Ok(())
}

/// The textures of colour and of cut-out. A `map_d` that is the picture of the `map_Kd` means its alpha: the luminance of a
/// picture that is opaque would cut its dark parts out. That counts there only if `-imfchan l` asks for it.
fn maps(
    path: &Path,
    s: &Statements,
    place: &str,
    textures: &mut TextureSet,
    warnings: &mut Warnings,
) -> Result<(Option<usize>, Option<usize>), SceneError> {
    let mut load = |map: Option<&Map>, mask: bool| match map {
        Some(map) => textures.load(path, map, mask, warnings),
        None => Ok(None),
    };
    let of_colour = |mask: &&Map| {
        !mask.luminance && s.diffuse_map.as_ref().is_some_and(|colour| is_same_file(&colour.file, &mask.file))
    };
    let shared = s.alpha_map.as_ref().filter(of_colour).is_some();
    let (diffuse_map, mask) = (load(s.diffuse_map.as_ref(), false)?, s.alpha_map.as_ref().filter(|_| !shared));
    let other_map = load(mask, true)?;
    let alpha_map = if shared { diffuse_map.filter(|map| textures.has_alpha(*map)) } else { other_map };
    if s.alpha_map.is_none() && diffuse_map.is_some_and(|map| textures.has_alpha(map)) {
        warnings.add("alpha of map_Kd", || {
            format!("{place}: the alpha of its texture is not read: name the file as `map_d` too to cut it out")
        });
    }
    if alpha_map.is_some_and(|map| textures.is_cut_away(map)) {
        warnings.add("cut away", || format!("{place}: its texture is below the cutoff everywhere, and cuts all away"));
    }
    Ok((diffuse_map, alpha_map))
}

/// Whether two names are those of one file.
fn is_same_file(one: &Path, other: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().ok();
    one == other || real(one).is_some_and(|one| real(other) == Some(one))
}

/// Counts what the material says of light that passes, where none does or where it cannot be said.
fn tell_unread(s: &Statements, optics: &Optics, opacity: f32, place: &str, warnings: &mut Warnings) {
    if matches!(optics, Optics::Mirror | Optics::FresnelMirror) && opacity < 1.0 {
        warnings.add("clear mirror", || format!("{place}: `d` and `Tr` of a mirror are not read: nothing passes it"));
    }
    if *optics != Optics::Dielectric && s.filter.is_some_and(|filter| filter != Vec3::ONE) {
        warnings.add("tf of no glass", || format!("{place}: `Tf` is read of glass alone (illum 4, 6, 7 and 9)"));
    }
}

/// The kind of secondary rays that an illumination model asks for.
fn optics(illum: Option<i64>, place: &str, warnings: &mut Warnings) -> Optics {
    match illum {
        Some(3 | 8) => Optics::Mirror,
        Some(5) => Optics::FresnelMirror,
        Some(4 | 6 | 7 | 9) => Optics::Dielectric,
        Some(10) => {
            warnings
                .add("illum 10", || format!("{place}: illum 10 (shadow matte) is drawn as an ordinary opaque surface"));
            Optics::Opaque
        }
        _ => Optics::Opaque,
    }
}

/// The tint per surface. A small `Tf` without `d` or `Tr` is the strength of the filter, so the tint is `1 - Tf`.
fn transmission(s: &Statements, dielectric: bool, place: &str, warnings: &mut Warnings) -> Vec3 {
    let Some(filter) = s.filter.filter(|_| dielectric) else {
        return Vec3::ONE;
    };
    if filter.max_element() < 0.5 && s.dissolve.is_none() && s.transparency.is_none() {
        warnings.add("tf", || {
            format!(
                "{place}: `Tf` {filter} without `d` is read as the strength of the filter, so the tint is {}; \
                 add `d` to have it as written",
                Vec3::ONE - filter
            )
        });
        return Vec3::ONE - filter;
    }
    if filter.max_element() > 1.0 {
        warnings.add("tf above 1", || format!("{place}: `Tf` above 1 would create light and was lowered to 1"));
    }
    filter.min(Vec3::ONE)
}

/// `d`, or `1 - Tr`.
fn opacity(s: &Statements, place: &str, warnings: &mut Warnings) -> f32 {
    let from_transparency = s.transparency.map(|t| 1.0 - t);
    if let (Some(d), Some(t)) = (s.dissolve, from_transparency)
        && (d - t).abs() > 1e-3
    {
        warnings.add("d and Tr", || format!("{place}: `d` and `Tr` contradict each other; `d` counts"));
    }
    let opacity = s.dissolve.or(from_transparency).unwrap_or(1.0);
    let opaque_kind = matches!(s.illum.unwrap_or(2), 0..=2 | 10);
    if opacity <= 0.0 && opaque_kind {
        warnings.add("d 0", || {
            format!("{place}: `d 0` (or `Tr 1`) would make the surface invisible; it is read as opaque")
        });
        return 1.0;
    }
    opacity
}
