//! One primitive of a mesh: read, transformed, cut into triangles.

use glam::{DAffine3, DVec3, Vec2, Vec3};
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::validation::Checked;

use super::{document::Source, materials::Surface, skin::Binding};
use crate::{
    error::SceneError,
    mesh::{MeshJoin, normals},
    scene::{Mesh, Triangle},
    warnings::Warnings,
};

/// Vertices and triangles that may still be read: the same data a thousand times must not fill the memory.
pub(crate) struct Budget {
    pub vertices: u64,
    pub triangles: u64,
}

impl Default for Budget {
    fn default() -> Self {
        Self { vertices: 1 << 28, triangles: 1 << 25 }
    }
}

impl Budget {
    fn take(&mut self, source: &Source, place: &str, vertices: usize, triangles: usize) -> Result<(), SceneError> {
        let all = Self::default();
        let left = (self.vertices.checked_sub(vertices as u64), self.triangles.checked_sub(triangles as u64));
        let (Some(vertices), Some(triangles)) = left else {
            let what = format!(
                "the scene has more than {} triangles, or primitives with more than {} vertices",
                all.triangles, all.vertices
            );
            return Err(SceneError::Limit { at: source.at(place), what, fix: "split the model".into() });
        };
        (self.vertices, self.triangles) = (vertices, triangles);
        Ok(())
    }
}

/// Where a primitive goes.
pub(crate) struct Target<'a> {
    pub mesh: &'a mut Mesh,
    pub object: u32,
    pub material: u32,
    pub surface: &'a Surface,
    pub binding: &'a Binding,
}

/// The vertices of a primitive.
struct Vertices {
    /// They stand mirrored, the first of them at least.
    is_mirrored: bool,
    positions: Vec<Vec3>,
    /// Of any length.
    normals: Option<Vec<DVec3>>,
    uvs: Vec<Vec2>,
}

/// Adds a primitive's triangles to the mesh.
pub(crate) fn append(
    source: &Source,
    place: &str,
    primitive: &Primitive,
    target: Target<'_>,
    budget: &mut Budget,
    warnings: &mut Warnings,
) -> Result<(), SceneError> {
    let mode = if let Checked::Valid(mode) = primitive.mode { mode } else { Mode::Triangles };
    if matches!(mode, Mode::Points | Mode::Lines | Mode::LineLoop | Mode::LineStrip) {
        let file = source.path.display();
        warnings.add("points", || format!("{file}: {place}: points and lines have no surface and were ignored"));
        return Ok(());
    }
    let vertices = vertices(source, place, primitive, &target, warnings)?;
    let count = vertices.positions.len();
    let order = order(source, place, primitive, count)?;
    let mut triangles = cut(mode, &order);
    if !order.len().is_multiple_of(3) && mode == Mode::Triangles {
        let file = source.path.display();
        warnings.add("rest", || format!("{file}: {place}: the last indices are no whole triangle and were ignored"));
    }
    budget.take(source, place, count, triangles.len())?;
    // A mirrored copy would show its inside.
    if vertices.is_mirrored {
        triangles.iter_mut().for_each(|t| t.swap(1, 2));
    }
    join(source, &vertices, &triangles, target, warnings);
    Ok(())
}

fn accessor(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Checked::Valid(semantic)).map(|index| index.value())
}

fn vertices(
    source: &Source,
    place: &str,
    primitive: &Primitive,
    target: &Target<'_>,
    warnings: &mut Warnings,
) -> Result<Vertices, SceneError> {
    let file = source.path.display();
    let broken = |what: String| source.bad(place, what, "export the model again");
    let position = accessor(primitive, Semantic::Positions).ok_or_else(|| broken("it has no POSITION".into()))?;
    let positions = source.floats::<3>(position)?;
    let bound = target.binding.of_vertices(source, place, primitive, positions.len())?;
    let stand =
        |(v, p): (usize, [f32; 3])| bound.stand(v).transform_point3(DVec3::from_array(p.map(f64::from))).as_vec3();
    let positions: Vec<Vec3> = positions.into_iter().enumerate().map(stand).collect();
    if let Some(at) = positions.iter().position(|p| !p.is_finite()) {
        return Err(broken(format!("vertex {at} is not finite")));
    }
    let count = positions.len();
    let same = |what: &str, found: usize| match found == count {
        true => Ok(()),
        false => Err(broken(format!("it has {count} positions and {found} {what}"))),
    };
    let normals = accessor(primitive, Semantic::Normals).map(|at| source.floats::<3>(at)).transpose()?;
    if let Some(normals) = &normals {
        same("normals", normals.len())?;
    }
    let turn = |(v, n): (usize, [f32; 3])| turned(&bound.stand(v), DVec3::from_array(n.map(f64::from)));
    let normals = normals.map(|list| list.into_iter().enumerate().map(turn).collect());
    let uvs = match accessor(primitive, Semantic::TexCoords(target.surface.uv_set)) {
        Some(at) => source.floats::<2>(at)?,
        None => {
            if target.surface.material.diffuse_map.is_some() {
                let set = target.surface.uv_set;
                warnings.add("uv", || format!("{file}: {place}: without TEXCOORD_{set} its texture has one colour"));
            }
            vec![[0.0; 2]; count]
        }
    };
    same("texture coordinates", uvs.len())?;
    let uvs: Vec<Vec2> = uvs.into_iter().map(|uv| lookup(target.surface, Vec2::from(uv))).collect();
    if let Some(at) = uvs.iter().position(|uv| !uv.is_finite()) {
        return Err(broken(format!("the texture coordinate of vertex {at} is not finite")));
    }
    if accessor(primitive, Semantic::Colors(0)).is_some() {
        warnings.add("colours", || format!("{file}: {place}: colours of vertices are not read"));
    }
    if primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty()) {
        warnings.add("morph", || format!("{file}: {place}: morph targets are not read"));
    }
    let is_mirrored = count > 0 && bound.stand(0).matrix3.determinant() < 0.0;
    Ok(Vertices { is_mirrored, positions, normals, uvs })
}

/// A texture coordinate of the file as one of the scene, whose `v` points up.
fn lookup(surface: &Surface, uv: Vec2) -> Vec2 {
    let moved = surface.uv_map.map_or(uv, |map| map.apply(uv));
    Vec2::new(moved.x, 1.0 - moved.y)
}

/// A normal turned as a transform turns the surface, mirrored and unevenly scaled ones too.
fn turned(world: &DAffine3, n: DVec3) -> DVec3 {
    let m = world.matrix3;
    let (x, y, z) = (m.y_axis.cross(m.z_axis), m.z_axis.cross(m.x_axis), m.x_axis.cross(m.y_axis));
    let side = if m.determinant() < 0.0 { -1.0 } else { 1.0 };
    (x * n.x + y * n.y + z * n.z) * side
}

/// The order of vertices: that of the indices, or of the file.
fn order(source: &Source, place: &str, primitive: &Primitive, count: usize) -> Result<Vec<u32>, SceneError> {
    let Some(indices) = primitive.indices else { return Ok((0..count as u32).collect()) };
    let order = source.indices(indices.value())?;
    if let Some(index) = order.iter().find(|index| **index as usize >= count) {
        let what = format!("vertex index {index} is out of range: it has {count} vertices");
        return Err(source.bad(place, what, "export the model again"));
    }
    Ok(order)
}

/// Triangles of a list, strip or fan, all counter-clockwise.
fn cut(mode: Mode, order: &[u32]) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => {
            let turn = |(i, v): (usize, &[u32])| if i % 2 == 0 { [v[0], v[1], v[2]] } else { [v[1], v[0], v[2]] };
            order.windows(3).enumerate().map(turn).collect()
        }
        Mode::TriangleFan => {
            let hub = order.first().copied().unwrap_or(0);
            order.get(1..).unwrap_or(&[]).windows(2).map(|v| [hub, v[0], v[1]]).collect()
        }
        _ => order.as_chunks::<3>().0.to_vec(),
    }
}

/// Adds the triangles that have an area, each corner with its normal: the file's, or that of the face.
fn join(source: &Source, vertices: &Vertices, triangles: &[[u32; 3]], target: Target<'_>, warnings: &mut Warnings) {
    let file = source.path.display();
    let mut out = MeshJoin::new(vertices.positions.len());
    for triangle in triangles {
        if normals::is_dropped(&vertices.positions, *triangle, &source.path, warnings) {
            continue;
        }
        let face = normals::area_vector(&vertices.positions, *triangle).normalize_or(DVec3::Y).as_vec3();
        let corners = triangle.map(|v| {
            let at = v as usize;
            let given = vertices.normals.as_ref().and_then(|normals| {
                let unit = normals[at].try_normalize();
                if unit.is_none() {
                    warnings.add("normal", || {
                        format!("{file}: a normal is zero or not finite; its corners get the face's normal")
                    });
                }
                unit
            });
            let normal = given.map_or(face, |normal| normal.as_vec3());
            out.vertex(v, vertices.positions[at], normal, vertices.uvs[at])
        });
        out.mesh.triangles.push(Triangle { vertices: corners, object: target.object, material: target.material });
    }
    let mesh = target.mesh;
    let base = mesh.positions.len() as u32;
    mesh.positions.append(&mut out.mesh.positions);
    mesh.normals.append(&mut out.mesh.normals);
    mesh.uvs.append(&mut out.mesh.uvs);
    let moved = |t: Triangle| Triangle { vertices: t.vertices.map(|v| v + base), ..t };
    mesh.triangles.extend(out.mesh.triangles.into_iter().map(moved));
}
