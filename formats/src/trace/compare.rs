//! The first place where two traces say different things.

use super::codec::Scratch;
use super::reader::Trace;
use crate::error::Result;
use crate::math::Vec3;
use crate::scene::{Camera, Light, Meta};
use crate::tile::{Column, Tile};

/// A difference between two traces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Difference {
    /// Where: `meta`, `bvh`, `frame 3`, `frame 3, tile 5, column hits, sample 17 (x 40, y 8)`.
    pub place: String,
    /// What the first and the second trace say there.
    pub detail: String,
}

fn differ(place: impl Into<String>, detail: impl Into<String>) -> Option<Difference> {
    Some(Difference { place: place.into(), detail: detail.into() })
}

/// Finds the first difference in canonical order: metadata, BVH, then frames, tiles, columns, samples.
///
/// # Errors
/// When a tile of either is damaged.
pub fn compare(a: &Trace, b: &Trace) -> Result<Option<Difference>> {
    let bare = |meta: &Meta| Meta { tool: String::new(), ..meta.clone() };
    if bare(a.meta()) != bare(b.meta()) {
        return Ok(differ("meta", meta_difference(a.meta(), b.meta())));
    }
    if a.bvh() != b.bvh() {
        let count = |t: &Trace| format!("{} nodes, {} triangles", t.bvh().nodes.len(), t.bvh().triangles.len());
        return Ok(differ("bvh", format!("{} | {}", count(a), count(b))));
    }
    let (missing_a, missing_b) = (a.missing_tiles(), b.missing_tiles());
    let (mut scratch_a, mut scratch_b) = (Scratch::default(), Scratch::default());
    for frame in a.meta().frame_numbers() {
        if a.has_frame(frame) && b.has_frame(frame) {
            let (camera_a, camera_b) = (a.camera(frame)?, b.camera(frame)?);
            // By their bytes, in which zeros of either sign differ.
            if camera_a.to_payload()? != camera_b.to_payload()? {
                return Ok(differ(format!("frame {frame}"), format!("{} | {}", camera(&camera_a), camera(&camera_b))));
            }
        }
        for tile in 0..a.meta().tile_count() {
            let has = |missing: &[(u32, u32)]| missing.binary_search(&(frame, tile)).is_err();
            match (has(&missing_a), has(&missing_b)) {
                (false, false) => continue,
                (true, false) => return Ok(differ(format!("frame {frame}, tile {tile}"), "there | missing")),
                (false, true) => return Ok(differ(format!("frame {frame}, tile {tile}"), "missing | there")),
                (true, true) => {}
            }
            let (columns_a, columns_b) = (a.readable(frame, tile)?, b.readable(frame, tile)?);
            if let Some(column) = Column::ALL.iter().find(|c| columns_a.contains(c) != columns_b.contains(c)) {
                let place = format!("frame {frame}, tile {tile}, column {}", column.name());
                let words = if columns_a.contains(column) { "there | missing" } else { "missing | there" };
                return Ok(differ(place, words));
            }
            let tile_a = a.tile_with(frame, tile, &columns_a, &mut scratch_a)?;
            let tile_b = b.tile_with(frame, tile, &columns_b, &mut scratch_b)?;
            if let Some(difference) = tile_difference(&tile_a, &tile_b, &columns_a) {
                return Ok(Some(difference));
            }
        }
    }
    Ok(None)
}

fn triple(Vec3 { x, y, z }: Vec3) -> String {
    format!("({x}, {y}, {z})")
}

fn light(light: &Light) -> String {
    match *light {
        Light::Point { position, colour } => format!("a point at {} of {}", triple(position), triple(colour)),
        Light::Directional { to_light, colour } => format!("from {} of {}", triple(to_light), triple(colour)),
    }
}

fn camera(camera: &Camera) -> String {
    let Camera { eye, corner, right, down } = *camera;
    let [eye, corner, right, down] = [eye, corner, right, down].map(triple);
    format!("eye {eye}, corner {corner}, right {right}, down {down}")
}

fn meta_difference(a: &Meta, b: &Meta) -> String {
    let fields = |m: &Meta| {
        [
            ("scene", m.scene.clone()),
            ("scene hash", m.scene_hash.iter().map(|b| format!("{b:02x}")).collect()),
            ("size", format!("{}x{}", m.width, m.height)),
            ("samples", m.samples.to_string()),
            ("tile", m.tile.to_string()),
            ("frames", format!("{} from {}", m.frames, m.first_frame)),
            ("depth", m.max_depth.to_string()),
            ("weight", m.min_weight.to_string()),
            ("lights", m.lights.iter().map(light).collect::<Vec<_>>().join(", ")),
        ]
    };
    let pairs = fields(a).into_iter().zip(fields(b)).filter(|(a, b)| a.1 != b.1);
    pairs.map(|((name, a), (_, b))| format!("{name}: {a} | {b}")).collect::<Vec<_>>().join("; ")
}

/// The first sample in which two tiles differ, and how, in those `columns` that both have, column by column.
fn tile_difference(a: &Tile, b: &Tile, columns: &[Column]) -> Option<Difference> {
    let place = |column: Column, sample: usize| {
        let (x, y) = (sample as u32 % a.rect.width + a.rect.x, sample as u32 / a.rect.width + a.rect.y);
        let name = column.name();
        format!("frame {}, tile {}, column {name}, sample {sample} (x {x}, y {y})", a.frame, a.index)
    };
    if a.tree != b.tree {
        let nodes = |t: &Tile, s: usize| t.tree.nodes[t.tree.sample(s)].to_vec();
        let sample = (0..a.tree.samples()).find(|&s| nodes(a, s) != nodes(b, s))?;
        return differ(place(Column::Tree, sample), format!("{:?} | {:?}", nodes(a, sample), nodes(b, sample)));
    }
    let (index_a, samples) = (a.tree.ray_index(), a.tree.samples());
    let with = |column: Column| 0..if columns.contains(&column) { samples } else { 0 };
    let hits = with(Column::Hits).find(|&s| a.hits[a.tree.sample(s)] != b.hits[a.tree.sample(s)]);
    if let Some(sample) = hits {
        let of = |t: &Tile| format!("{:?}", &t.hits[t.tree.sample(sample)]);
        return differ(place(Column::Hits, sample), format!("{} | {}", of(a), of(b)));
    }
    let radiance = with(Column::Radiance).find(|&s| a.radiance[a.tree.sample(s)] != b.radiance[a.tree.sample(s)]);
    if let Some(sample) = radiance {
        let of = |t: &Tile| format!("{:?}", &t.radiance[t.tree.sample(sample)]);
        return differ(place(Column::Radiance, sample), format!("{} | {}", of(a), of(b)));
    }
    let rays = |sample: usize| {
        let nodes = a.tree.sample(sample);
        index_a[nodes.start] as usize..index_a[nodes.end] as usize
    };
    let (sample, ray) = with(Column::Paths)
        .find_map(|s| rays(s).find(|&ray| a.paths.ray(ray) != b.paths.ray(ray)).map(|ray| (s, ray - rays(s).start)))?;
    let at = rays(sample).start + ray;
    differ(place(Column::Paths, sample), format!("ray {ray}: {:?} | {:?}", a.paths.ray(at), b.paths.ray(at)))
}
