//! One row a ray.

use rayreel_formats::rays::{Geometry, RayEnd, TileRays};
use rayreel_formats::tile::Column;
use rayreel_formats::trace::Trace;

use super::kinds::{Kind, Outcome};
use super::{TileRows, place};
use crate::error::Result;
use crate::schema::{Batch, Table, table};
use crate::value::WordsOf;

table! {
    /// The rays of a trace.
    pub struct RayRows = "rays", "a ray, in the order in which a tile holds them: sample by sample, each closest-hit ray followed by the shadow rays of its hit" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        x: Vec<u32>, "samples", "sample: column of the frame's grid";
        y: Vec<u32>, "samples", "sample: row of the frame's grid";
        index: Vec<u32>, "", "number of the ray in its tile";
        ray: Vec<u32>, "", "number of the ray in its sample; 0 is the primary ray";
        parent: Vec<i32>, "", "number in the sample of the ray from whose hit it starts; -1 for the primary ray";
        class: Vec<u16>, "", "place in the ray tree: 1 is the primary ray, 2c the reflection and 2c + 1 the refraction of class c; of a shadow ray that of its parent";
        depth: Vec<u8>, "bounces", "bounces before the ray; of a shadow ray those before its parent";
        kind: WordsOf<Kind>, "", "what the ray is";
        light: Vec<i8>, "", "light of a shadow ray; -1 for others";
        origin_x: Vec<f32>, "scene units", "origin";
        origin_y: Vec<f32>, "scene units", "origin";
        origin_z: Vec<f32>, "scene units", "origin";
        direction_x: Vec<f32>, "", "direction; of unit length but for shadow rays to point lights, which reach their light at t = 1";
        direction_y: Vec<f32>, "", "direction";
        direction_z: Vec<f32>, "", "direction";
        t_max: Vec<f32>, "lengths of the direction", "where the ray ends at the latest; infinite if nowhere";
        outcome: WordsOf<Outcome>, "", "how it ended";
        triangle: Vec<i32>, "", "triangle that it met, as table triangles numbers them; -1 for a miss and for shadow rays";
        t: Vec<f32>, "lengths of the direction", "where it met the triangle; infinite for a miss, not a number for shadow rays";
    }
}

impl TileRows for RayRows {
    const TABLE: &'static Table = &Self::TABLE;
    const ROWS_A_SAMPLE: u32 = 8;
    type With = ();

    fn add(&mut self, trace: &Trace, _: &(), (frame, index): (u32, u32)) -> Result<()> {
        let tile = trace.tile(frame, index, &[Column::Hits])?;
        let (numbers, parents) = (tile.tree.ray_index(), tile.tree.parents());
        let geometry = Geometry { bvh: trace.bvh(), camera: trace.camera(frame)? };
        let mut rays = TileRays::new(tile, geometry, &trace.meta().lights);
        while let Some(recorded) = rays.next() {
            let node = recorded.node as usize;
            let tile = rays.tile();
            let (x, y) = place(tile, recorded.sample);
            let first = numbers[tile.tree.sample(recorded.sample as usize).start];
            let parent = match recorded.end {
                RayEnd::Light { .. } => (numbers[node] - first) as i32,
                _ if recorded.class.parent().is_none() => -1,
                _ => (numbers[parents[node] as usize] - first) as i32,
            };
            let (light, outcome, triangle, t) = match recorded.end {
                RayEnd::Sky => (-1, Outcome::Miss, -1, f32::INFINITY),
                RayEnd::Hit(hit) => (-1, Outcome::Hit, hit.triangle as i32, hit.t),
                RayEnd::Light { light, state } => (light as i8, state.into(), -1, f32::NAN),
            };
            let ray = recorded.ray;
            self.frame.push(frame);
            self.tile.push(index);
            self.x.push(x);
            self.y.push(y);
            self.index.push(recorded.index);
            self.ray.push(recorded.index - first);
            self.parent.push(parent);
            self.class.push(recorded.class.0);
            self.depth.push(recorded.class.depth() as u8);
            self.kind.push(recorded.kind().into());
            self.light.push(light);
            self.origin_x.push(ray.origin.x);
            self.origin_y.push(ray.origin.y);
            self.origin_z.push(ray.origin.z);
            self.direction_x.push(ray.direction.x);
            self.direction_y.push(ray.direction.y);
            self.direction_z.push(ray.direction.z);
            self.t_max.push(if ray.t_max < f32::MAX { ray.t_max } else { f32::INFINITY });
            self.outcome.push(outcome);
            self.triangle.push(triangle);
            self.t.push(t);
        }
        Ok(())
    }

    fn into_batch(self) -> Batch {
        self.batch()
    }
}
