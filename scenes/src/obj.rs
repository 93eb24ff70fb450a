//! Wavefront OBJ models.

use std::{io::ErrorKind, path::Path};

use glam::{Vec2, Vec3};

use crate::{
    error::{SceneError, hint},
    mesh_join::MeshJoin,
    mtl, normals,
    obj_text::{self, ABSENT_NORMAL, Checked},
    scene::{Material, Mesh, Texture, Triangle, Warning},
    texture::TextureSet,
    warnings::Warnings,
};

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
}

/// Triangles straight from tobj.
#[derive(Default)]
struct Raw {
    positions: Vec<Vec3>,
    normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    triangles: Vec<Triangle>,
}

/// Loads an OBJ model with its material libraries and textures.
///
/// Polygons are triangulated (concave ones too), normals are the file's where it has them, else
/// smooth across edges of less than 40 degrees.
///
/// # Errors Whatever is wrong with the files, with the line it is in.
pub fn load_obj(path: impl AsRef<Path>) -> Result<ObjModel, SceneError> {
    let path = path.as_ref();
    let mut warnings = Warnings::default();
    let text = read_text(path, "OBJ file", &mut warnings)?;
    let checked = obj_text::check(path, &text, &mut warnings)?;
    drop(text);
    let mut textures = TextureSet::default();
    let mut materials = load_libraries(path, &checked, &mut textures, &mut warnings)?;
    let slots = material_slots(path, &checked, &mut materials, &mut warnings);
    let raw = triangles(path, &checked, &slots, &mut warnings)?;
    Ok(ObjModel {
        mesh: join(raw),
        objects: checked.objects,
        materials,
        textures: textures.into_list(),
        warnings: warnings.into_list(),
    })
}

/// Reads a text file. Old exporters write names in Latin-1: bytes that are no UTF-8 are replaced,
/// with a warning.
fn read_text(path: &Path, what: &'static str, warnings: &mut Warnings) -> Result<String, SceneError> {
    if path.is_dir() {
        return Err(SceneError::IsFolder { path: path.to_owned(), expected: what });
    }
    let bytes = std::fs::read(path).map_err(|source| SceneError::Io { path: path.to_owned(), what, source })?;
    Ok(String::from_utf8(bytes).unwrap_or_else(|error| {
        warnings.add("utf-8", || format!("{}: is not UTF-8; the odd bytes were replaced", path.display()));
        String::from_utf8_lossy(error.as_bytes()).into_owned()
    }))
}

fn load_libraries(
    path: &Path,
    checked: &Checked,
    textures: &mut TextureSet,
    warnings: &mut Warnings,
) -> Result<Vec<Material>, SceneError> {
    let folder = path.parent().unwrap_or(Path::new(""));
    let mut materials = Vec::new();
    let mut done: Vec<&str> = Vec::new();
    for (line, statement) in &checked.libraries {
        // A name may hold blanks, and a statement may hold several names: the whole is tried first.
        let whole = folder.join(statement.replace('\\', "/"));
        let names: Vec<&str> = if whole.is_file() { vec![statement] } else { statement.split_whitespace().collect() };
        if names.is_empty() {
            let what = "`mtllib` names no file".to_owned();
            return Err(SceneError::Syntax {
                path: path.to_owned(),
                line: *line,
                what,
                fix: "name a material library".into(),
            });
        }
        for name in names {
            if done.contains(&name) {
                continue;
            }
            done.push(name);
            let library = folder.join(name.replace('\\', "/"));
            let text = read_text(&library, "material library", warnings).map_err(|error| {
                let source = match error {
                    SceneError::Io { source, .. } => source,
                    _ => ErrorKind::IsADirectory.into(),
                };
                SceneError::MissingFile {
                    path: path.to_owned(),
                    line: *line,
                    what: "material library",
                    missing: library.clone(),
                    source,
                }
            })?;
            mtl::read(&library, &text, &mut materials, textures, warnings)?;
        }
    }
    Ok(materials)
}

/// For each used material name its index; adds default materials for names that no library knows.
fn material_slots(path: &Path, checked: &Checked, materials: &mut Vec<Material>, warnings: &mut Warnings) -> Vec<u32> {
    let mut slots = Vec::with_capacity(checked.uses.len());
    for (name, line) in &checked.uses {
        let known = materials.iter().position(|m| m.name == *name);
        slots.push(known.unwrap_or_else(|| {
            if name.is_empty() {
                warnings.add("no usemtl", || {
                    format!("{}:{line}: faces without a material get a default grey", path.display())
                });
                materials.push(mtl::default_material("default"));
            } else {
                let names: Vec<&str> = materials.iter().map(|m| m.name.as_str()).collect();
                let hint = hint(name, &names, "materials");
                warnings.add("usemtl", || {
                    format!(
                        "{}:{line}: material `{name}` is in no library and becomes a default grey; {hint}",
                        path.display()
                    )
                });
                materials.push(mtl::default_material(name));
            }
            materials.len() - 1
        }) as u32);
    }
    slots
}

/// Runs tobj over the checked text and drops degenerate triangles.
fn triangles(path: &Path, checked: &Checked, slots: &[u32], warnings: &mut Warnings) -> Result<Raw, SceneError> {
    let failed = |reason: String| SceneError::Obj { path: path.to_owned(), reason };
    // The libraries have been read; tobj only needs to know the names.
    let names: String = (0..slots.len()).map(|m| format!("newmtl m{m}\n")).collect();
    let library = |_: &Path| tobj::load_mtl_buf(&mut names.as_bytes());
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let (models, _) =
        tobj::load_obj_buf(&mut checked.text.as_bytes(), &options, library).map_err(|e| failed(e.to_string()))?;
    let mut raw = Raw::default();
    for model in &models {
        let object = model
            .name
            .strip_prefix('g')
            .and_then(|n| n.parse().ok())
            .ok_or_else(|| failed(format!("odd group `{}`", model.name)))?;
        let material =
            model.mesh.material_id.and_then(|m| slots.get(m)).ok_or_else(|| failed("a material got lost".into()))?;
        append(&model.mesh, object, *material, &mut raw);
    }
    let before = raw.triangles.len();
    let Raw { positions, triangles, .. } = &mut raw;
    triangles.retain(|t| !normals::is_degenerate(positions, t.vertices));
    for _ in triangles.len()..before {
        warnings.add("degenerate", || format!("{}: triangles without area were dropped", path.display()));
    }
    if triangles.is_empty() {
        return Err(SceneError::EmptyMesh {
            path: path.to_owned(),
            why: format!("all {before} triangles have no area"),
        });
    }
    Ok(raw)
}

fn append(mesh: &tobj::Mesh, object: u32, material: u32, raw: &mut Raw) {
    let base = raw.positions.len() as u32;
    raw.positions.extend(mesh.positions.as_chunks().0.iter().map(|p: &[f32; 3]| Vec3::from(*p)));
    raw.normals.extend(mesh.normals.as_chunks().0.iter().map(|n: &[f32; 3]| Vec3::from(*n)));
    raw.uvs.extend(mesh.texcoords.as_chunks().0.iter().map(|t: &[f32; 2]| Vec2::from(*t)));
    let triangle = |v: &[u32; 3]| Triangle { vertices: v.map(|v| base + v), object, material };
    raw.triangles.extend(mesh.indices.as_chunks().0.iter().map(triangle));
}

/// Gives each corner its normal: the file's, the face's where the file's is broken, a smooth one
/// where there is none.
fn join(raw: Raw) -> Mesh {
    let indices: Vec<[u32; 3]> = raw.triangles.iter().map(|t| t.vertices).collect();
    let groups: Vec<u32> = raw.triangles.iter().map(|t| t.object).collect();
    let absent = |v: u32| raw.normals[v as usize].to_array() == ABSENT_NORMAL;
    let smooth = if indices.iter().flatten().any(|v| absent(*v)) {
        normals::corner_normals(&raw.positions, &indices, &groups, normals::CREASE_COS)
    } else {
        Vec::new()
    };
    let mut out = MeshJoin::new(raw.positions.len());
    for (at, triangle) in raw.triangles.iter().enumerate() {
        let mut corner = 0;
        let vertices = triangle.vertices.map(|v| {
            let face =
                || normals::area_vector(&raw.positions, triangle.vertices).normalize_or(glam::DVec3::Y).as_vec3();
            let given = raw.normals[v as usize];
            let normal = if absent(v) {
                smooth[at][corner]
            } else if given.is_nan() {
                face()
            } else {
                normals::unit(given, Vec3::Y)
            };
            corner += 1;
            out.vertex(v, raw.positions[v as usize], normal, raw.uvs[v as usize])
        });
        out.mesh.triangles.push(Triangle { vertices, ..*triangle });
    }
    out.mesh
}
