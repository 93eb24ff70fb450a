//! From the checked text to a mesh: tobj reads it, degenerate triangles go, corners get their normals.

use std::path::Path;

use glam::{Vec2, Vec3};

use crate::{
    error::{Location, SceneError},
    mesh::{MeshJoin, away, normals},
    obj::text::{ABSENT_NORMAL, CheckedObj, empty_mesh},
    scene::{Mesh, Triangle},
    warnings::Warnings,
};

/// Triangles straight from tobj.
#[derive(Default)]
pub(crate) struct RawMesh {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    uvs: Vec<Vec2>,
    pub triangles: Vec<Triangle>,
}

/// Runs tobj over the checked text and drops degenerate triangles.
pub(crate) fn triangles(
    path: &Path,
    checked: &CheckedObj,
    slots: &[u32],
    warnings: &mut Warnings,
) -> Result<RawMesh, SceneError> {
    let failed = |reason: String| {
        let what = format!("cannot be read as OBJ: {reason}");
        SceneError::input(Location::File(path.to_owned()), what, "please report this file")
    };
    // The libraries have been read; tobj only needs to know the names.
    let names: String = (0..slots.len()).map(|m| format!("newmtl m{m}\n")).collect();
    let library = |_: &Path| tobj::load_mtl_buf(&mut names.as_bytes());
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ignore_points: true, ignore_lines: true };
    let (models, _) =
        tobj::load_obj_buf(&mut checked.text.as_bytes(), &options, library).map_err(|e| failed(e.to_string()))?;
    let mut raw = RawMesh::default();
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
    let RawMesh { positions, triangles, .. } = &mut raw;
    triangles.retain(|t| !normals::is_dropped(positions, t.vertices, path, warnings));
    if triangles.is_empty() {
        let why = match away(positions) {
            Some(away) => {
                format!("all {before} triangles have no area in single precision: {away}; move it there")
            }
            None => format!("all {before} triangles have no area"),
        };
        return Err(empty_mesh(path, &why));
    }
    Ok(raw)
}

fn append(mesh: &tobj::Mesh, object: u32, material: u32, raw: &mut RawMesh) {
    let base = raw.positions.len() as u32;
    raw.positions.extend(mesh.positions.as_chunks().0.iter().map(|p: &[f32; 3]| Vec3::from(*p)));
    raw.normals.extend(mesh.normals.as_chunks().0.iter().map(|n: &[f32; 3]| Vec3::from(*n)));
    raw.uvs.extend(mesh.texcoords.as_chunks().0.iter().map(|t: &[f32; 2]| Vec2::from(*t)));
    let triangle = |v: &[u32; 3]| Triangle { vertices: v.map(|v| base + v), object, material };
    raw.triangles.extend(mesh.indices.as_chunks().0.iter().map(triangle));
}

/// Gives each corner its normal: the file's, the face's where the file's is broken, a smooth one
/// where there is none.
pub(crate) fn join(raw: RawMesh) -> Mesh {
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
