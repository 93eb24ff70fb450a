//! One row a hit of a closest-hit ray.

use rayreel_formats::rays::{Geometry, RayEnd, TileRays, surface};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::Trace;

use super::kinds::Kind;
use super::{TileRows, place};
use crate::error::Result;
use crate::schema::{Batch, Table, table};
use crate::value::WordsOf;

table! {
    /// The hits of a trace.
    pub struct HitRows = "hits", "a hit of a closest-hit ray, in the order of the rays" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        x: Vec<u32>, "samples", "sample: column of the frame's grid";
        y: Vec<u32>, "samples", "sample: row of the frame's grid";
        index: Vec<u32>, "", "number in its tile of the ray that hit, as in table rays";
        ray: Vec<u32>, "", "number in its sample of the ray that hit, as in table rays";
        class: Vec<u16>, "", "the path to the hit: 1 is the primary ray, 2c the reflection and 2c + 1 the refraction of class c";
        depth: Vec<u8>, "bounces", "bounces before the hit";
        kind: WordsOf<Kind>, "", "what the ray is that hit";
        triangle: Vec<u32>, "", "triangle, as table triangles numbers them";
        object: Vec<u32>, "", "number of its object; table triangles has the name";
        material: Vec<u32>, "", "number of its material; table triangles has the name";
        t: Vec<f32>, "lengths of the direction", "where on the ray";
        position_x: Vec<f32>, "scene units", "the hit point";
        position_y: Vec<f32>, "scene units", "the hit point";
        position_z: Vec<f32>, "scene units", "the hit point";
        normal_x: Vec<f32>, "", "shading normal of unit length, as recorded: not turned towards the ray";
        normal_y: Vec<f32>, "", "shading normal";
        normal_z: Vec<f32>, "", "shading normal";
        front: Vec<bool>, "", "the ray met the front of the triangle";
        shadows: Vec<u32>, "", "shadow rays of the hit, two bits a light from the lowest on: 0 not cast, 1 lit, 2 blocked, 3 tinted";
        local_r: Vec<f32>, "linear RGB", "local colour";
        local_g: Vec<f32>, "linear RGB", "local colour";
        local_b: Vec<f32>, "linear RGB", "local colour";
        reflect_r: Vec<f32>, "", "weight of the reflected ray's colour; 0 where there is none";
        reflect_g: Vec<f32>, "", "weight of the reflected ray's colour";
        reflect_b: Vec<f32>, "", "weight of the reflected ray's colour";
        refract_r: Vec<f32>, "", "weight of the refracted ray's colour; 0 where there is none";
        refract_g: Vec<f32>, "", "weight of the refracted ray's colour";
        refract_b: Vec<f32>, "", "weight of the refracted ray's colour";
    }
}

/// The columns that are made of recorded colours.
pub(crate) const COLOURS: [&str; 9] =
    ["local_r", "local_g", "local_b", "reflect_r", "reflect_g", "reflect_b", "refract_r", "refract_g", "refract_b"];

/// What is read of hits.
#[derive(Clone, Copy, Debug)]
pub struct Hits {
    /// Their colours; without, these columns are 0.
    pub colours: bool,
}

impl TileRows for HitRows {
    const TABLE: &'static Table = &Self::TABLE;
    const ROWS_A_SAMPLE: u32 = 4;
    type With = Hits;

    fn add(&mut self, trace: &Trace, with: &Hits, (frame, number): (u32, u32)) -> Result<()> {
        let columns: &[Column] = if with.colours { &[Column::Hits, Column::Radiance] } else { &[Column::Hits] };
        let tile = trace.tile(frame, number, columns)?;
        let (bvh, numbers) = (trace.bvh(), tile.tree.ray_index());
        let geometry = Geometry { bvh, camera: trace.camera(frame)? };
        let mut rays = TileRays::new(tile, geometry, &trace.meta().lights);
        while let Some(recorded) = rays.next() {
            let RayEnd::Hit(hit) = recorded.end else { continue };
            let (tile, node) = (rays.tile(), recorded.node as usize);
            let (x, y) = place(tile, recorded.sample);
            let first = numbers[tile.tree.sample(recorded.sample as usize).start];
            let triangle = bvh.triangles[hit.triangle as usize];
            let met = surface(&recorded.ray, hit.t, bvh.corners(hit.triangle as usize), hit.normal);
            let (normal, colours) = (hit.normal.decode(), tile.radiance.get(node).copied().unwrap_or_default());
            let [local, reflect, refract] =
                [colours.local, colours.reflect, colours.refract].map(|half| half.to_vec3());
            self.frame.push(frame);
            self.tile.push(number);
            self.x.push(x);
            self.y.push(y);
            self.index.push(recorded.index);
            self.ray.push(recorded.index - first);
            self.class.push(recorded.class.0);
            self.depth.push(recorded.class.depth() as u8);
            self.kind.push(recorded.kind().into());
            self.triangle.push(hit.triangle);
            self.object.push(triangle.object);
            self.material.push(triangle.material);
            self.t.push(hit.t);
            self.position_x.push(met.point.x);
            self.position_y.push(met.point.y);
            self.position_z.push(met.point.z);
            self.normal_x.push(normal.x);
            self.normal_y.push(normal.y);
            self.normal_z.push(normal.z);
            self.front.push(met.front);
            self.shadows.push(tile.tree.nodes[node].shadows.0);
            self.local_r.push(local.x);
            self.local_g.push(local.y);
            self.local_b.push(local.z);
            self.reflect_r.push(reflect.x);
            self.reflect_g.push(reflect.y);
            self.reflect_b.push(reflect.z);
            self.refract_r.push(refract.x);
            self.refract_g.push(refract.y);
            self.refract_b.push(refract.z);
        }
        Ok(())
    }

    fn into_batch(self) -> Batch {
        self.batch()
    }
}
