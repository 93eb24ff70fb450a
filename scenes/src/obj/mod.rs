//! Wavefront OBJ models.

mod mtl;
mod polygon;
mod text;
mod triangles;
mod winding;

use std::{
    io,
    path::{Path, PathBuf},
};

use rayreel_settings::files;

use self::{
    mtl::{MaterialList, TextureSet},
    text::CheckedObj,
};
use crate::{
    defaults::default_material,
    error::{Location, SceneError},
    names::hint,
    scene::{Material, Mesh, Texture},
    warnings::{Warning, Warnings},
};

/// Most bytes of an OBJ file or a material library.
const MODEL_MAX: u64 = 16 << 30;

/// What an OBJ file and its material libraries hold.
#[derive(Clone, Debug)]
pub struct ObjModel {
    /// The triangles, without the degenerate ones.
    pub mesh: Mesh,
    /// One name per `o` or `g` that has faces, in the order of first use.
    pub objects: Vec<String>,
    /// The libraries' materials, and default ones for names that no library knows.
    pub materials: Vec<Material>,
    /// Decoded textures.
    pub textures: Vec<Texture>,
    /// What was odd and how it was handled.
    pub warnings: Vec<Warning>,
    /// The files that were read: the model, its libraries and their textures.
    pub files: Vec<PathBuf>,
}

/// Loads an OBJ model with its material libraries and textures.
///
/// Polygons are triangulated (concave ones too), normals are the file's where it has them, else
/// smooth across edges of less than 40 degrees, but flat after `s off`.
///
/// # Errors
/// Whatever is wrong with the files, with the line it is in.
pub fn load_obj(path: impl AsRef<Path>) -> Result<ObjModel, SceneError> {
    let path = path.as_ref();
    let mut warnings = Warnings::default();
    if path.is_dir() {
        return Err(SceneError::folder(path, "OBJ file"));
    }
    let source = read_text(path, &mut warnings).map_err(|source| SceneError::Io {
        path: path.to_owned(),
        what: "OBJ file",
        source,
    })?;
    let checked = text::check(path, &source, &mut warnings)?;
    drop(source);
    let mut textures = TextureSet::default();
    let mut files = vec![path.to_owned()];
    let mut materials = load_libraries(path, &checked, (&mut textures, &mut files), &mut warnings)?;
    let slots = material_slots(path, &checked, &mut materials, &mut warnings);
    let mut raw = triangles::triangles(path, &checked, &slots, &mut warnings)?;
    winding::turn(&mut raw, (path, &checked.objects), &mut warnings);
    files.extend(textures.files());
    Ok(ObjModel {
        mesh: triangles::join(raw),
        objects: checked.objects,
        materials: materials.into_list(),
        textures: textures.into_list(),
        warnings: warnings.into_list(),
        files,
    })
}

/// Reads a text file. Old exporters write names in Latin-1: bytes that are no UTF-8 are replaced,
/// with a warning.
fn read_text(path: &Path, warnings: &mut Warnings) -> io::Result<String> {
    let bytes = files::read(path, MODEL_MAX)?;
    let text = from_utf16(&bytes).unwrap_or_else(|| {
        String::from_utf8(bytes).unwrap_or_else(|error| {
            warnings.add("utf-8", || format!("{}: is not UTF-8; the odd bytes were replaced", path.display()));
            String::from_utf8_lossy(error.as_bytes()).into_owned()
        })
    });
    // Old Macintosh programs end lines in a carriage return alone.
    Ok(if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text })
}

/// A text in UTF-16, as its byte order mark says.
fn from_utf16(bytes: &[u8]) -> Option<String> {
    let unit: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return None,
    };
    let units: Vec<u16> = bytes[2..].chunks_exact(2).map(|pair| unit([pair[0], pair[1]])).collect();
    Some(String::from_utf16_lossy(&units))
}

fn load_libraries(
    path: &Path,
    checked: &CheckedObj,
    (textures, files): (&mut TextureSet, &mut Vec<PathBuf>),
    warnings: &mut Warnings,
) -> Result<MaterialList, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials = MaterialList::default();
    let mut done: Vec<&str> = Vec::new();
    for (line, statement) in &checked.libraries {
        // A name may hold blanks, and a statement may hold several names: the whole is tried first.
        let bare = mtl::before_comment(statement);
        let whole = [statement, bare].into_iter().find(|name| folder.join(name.replace('\\', "/")).is_file());
        let names: Vec<&str> = whole.map_or_else(|| bare.split_whitespace().collect(), |name| vec![name]);
        let at = Location::line(path, *line);
        if names.is_empty() {
            return Err(SceneError::input(at, "`mtllib` names no file", "name a material library"));
        }
        for name in names {
            if done.contains(&name) {
                continue;
            }
            done.push(name);
            let library = folder.join(name.replace('\\', "/"));
            let text = read_text(&library, warnings)
                .map_err(|source| SceneError::missing(at.clone(), "material library", &library, source))?;
            mtl::read(&library, &text, &mut materials, textures, warnings)?;
            files.push(library);
        }
    }
    Ok(materials)
}

/// For each used material name its index; adds default materials for names that no library knows.
fn material_slots(
    path: &Path,
    checked: &CheckedObj,
    materials: &mut MaterialList,
    warnings: &mut Warnings,
) -> Vec<u32> {
    let mut slots = Vec::with_capacity(checked.uses.len());
    for (number, (name, line)) in checked.uses.iter().enumerate() {
        let known = materials.find_stated(name);
        let slot = known.unwrap_or_else(|| unknown_material((path, *line), name, materials, warnings));
        if let (Some(line), Some(material)) = (checked.without_uv.get(&number), materials.get(slot))
            && (material.diffuse_map.is_some() || material.alpha_map.is_some())
        {
            warnings.add("no vt", || {
                format!(
                    "{}:{line}: material `{}`: without `vt` its texture has one colour",
                    path.display(),
                    material.name
                )
            });
        }
        slots.push(slot as u32);
    }
    slots
}

/// The place of a default material for a name that no library knows.
fn unknown_material(
    (path, line): (&Path, usize),
    name: &str,
    materials: &mut MaterialList,
    warnings: &mut Warnings,
) -> usize {
    let place = format!("{}:{line}", path.display());
    let name = if name.is_empty() {
        warnings.add("no usemtl", || format!("{place}: faces without a material get a default grey"));
        "default"
    } else {
        warnings.add("usemtl", || {
            let hint = hint(name, &materials.names(), "materials");
            format!("{place}: material `{name}` is in no library and becomes a default grey; {hint}")
        });
        name
    };
    // A library may have a `default` of its own, which faces without a material have nothing to do with.
    materials.append(default_material(name))
}
