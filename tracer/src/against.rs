//! A trace against the scene that it was captured from: what it cannot say of itself.
//!
//! [`verify`](crate::verify::verify) asks whether a trace follows from its tables. Whether the tables are those of the scene, only
//! the scene can say: names of objects and which triangle belongs to which, colours of lights, which materials are cut-outs, triangles
//! that no ray met; and of what was recorded the local colours, black surfaces and texels of cut-outs.

use rayon::prelude::*;
use rayreel_formats::bvh::{Bvh, Triangle};
use rayreel_formats::error::first_error;
use rayreel_formats::scene::Meta;
use rayreel_formats::tile::Column;
use rayreel_formats::trace::{Scratch, Trace};
use rayreel_formats::{Error, Result};
use rayreel_scenes::Scene;

use crate::accel::Built;
use crate::grid::{SampleGrid, TraceSettings, frame_camera};
use crate::trace::Tracer;

/// How a trace differs from what a scene gives.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Against {
    /// What differs in the tables: one text each.
    pub tables: Vec<String>,
    /// Tiles that were traced again; none where the tables differ.
    pub tiles: u64,
    /// Those that differ.
    pub tiles_wrong: u64,
    /// The first of them.
    pub first: Option<String>,
}

impl Against {
    /// Whether everything is as the scene gives it.
    pub fn agrees(&self) -> bool {
        self.tables.is_empty() && self.tiles_wrong == 0
    }
}

/// Compares the tables of a trace with those of a scene, and if they are the same traces all its tiles again. After each batch
/// `progress` is told the number of tiles done, and stops by returning false.
///
/// # Errors
/// When the scene has not the frames of the trace; when a tile is damaged.
pub fn against(trace: &Trace, scene: &Scene, built: &Built, mut progress: impl FnMut(u64) -> bool) -> Result<Against> {
    let meta = trace.meta();
    if meta.frame_numbers().end as usize > scene.cameras.len() {
        let (end, have) = (meta.frame_numbers().end, scene.cameras.len());
        return Err(Error::usage(format!("the trace has frames up to {end}, scene {} has {have}", scene.name)));
    }
    let mut found = Against { tables: tables(trace, scene, built)?, ..Against::default() };
    if !found.tables.is_empty() {
        return Ok(found);
    }
    let tracer = Tracer::new(scene, built, TraceSettings::of(meta));
    let missing = trace.missing_tiles();
    let every = |frame| (0..meta.tile_count()).map(move |tile| (frame, tile));
    let tiles: Vec<(u32, u32)> =
        meta.frame_numbers().flat_map(every).filter(|t| missing.binary_search(t).is_err()).collect();
    for batch in tiles.chunks(64 * rayon::current_num_threads()) {
        let check =
            |scratch: &mut Scratch, &(frame, tile): &(u32, u32)| difference(trace, &tracer, (frame, tile), scratch);
        let checked = first_error(batch.par_iter().map_init(Scratch::default, check))?;
        found.tiles += checked.len() as u64;
        found.tiles_wrong += checked.iter().flatten().count() as u64;
        found.first = found.first.take().or(checked.into_iter().flatten().next());
        if !progress(found.tiles) {
            break;
        }
    }
    Ok(found)
}

/// Which column of a tile is another when it is traced again.
fn difference(
    trace: &Trace,
    tracer: &Tracer<'_>,
    (frame, tile): (u32, u32),
    scratch: &mut Scratch,
) -> Result<Option<String>> {
    let readable = trace.readable(frame, tile)?;
    if readable.is_empty() {
        return Ok(None);
    }
    let recorded = trace.tile_with(frame, tile, &readable, scratch)?;
    let again = tracer.tile::<true>(&trace.camera(frame)?, trace.meta().tile_rect(tile), frame, tile);
    let differs = |column: &&Column| recorded.canonical_bytes(**column) != again.canonical_bytes(**column);
    let column = readable.iter().find(differs);
    Ok(column.map(|column| format!("the {} of frame {frame}, tile {tile}", column.name())))
}

/// What differs in metadata, cameras and tables of the scene.
fn tables(trace: &Trace, scene: &Scene, built: &Built) -> Result<Vec<String>> {
    let meta = trace.meta();
    let Meta { width, height, samples, tile, first_frame, frames, .. } = *meta;
    let grid = SampleGrid { width, height, samples, tile, first_frame, frames };
    let wanted = grid.meta(scene, TraceSettings::of(meta), &meta.tool);
    let mut found = Vec::new();
    let mut differ = |differs: bool, what: &str| {
        if differs {
            found.push(what.to_owned());
        }
    };
    differ(meta.scene_hash != wanted.scene_hash, "the hash of the scene's content");
    differ(meta.lights != wanted.lights, "the lights");
    for frame in meta.frame_numbers().filter(|frame| trace.has_frame(*frame)) {
        differ(trace.camera(frame)? != frame_camera(scene, meta, frame), &format!("the camera of frame {frame}"));
    }
    let (is, should) = (trace.bvh(), &built.bvh);
    differ(is.objects != should.objects, "the names of objects");
    differ(is.materials != should.materials, "the materials");
    differ(is.vertices != should.vertices, "the vertices");
    differ(is.nodes != should.nodes, "the tree of boxes (it may have been built on another kind of processor)");
    found.extend(triangles(is, should));
    Ok(found)
}

/// The first triangle that is another, and in what.
fn triangles(is: &Bvh, should: &Bvh) -> Option<String> {
    let (a, b) = (&is.triangles, &should.triangles);
    if a.len() != b.len() {
        return Some(format!("the number of triangles: {}, the scene has {}", a.len(), b.len()));
    }
    let at = a.iter().zip(b).position(|(a, b)| a != b)?;
    let count = a.iter().zip(b).filter(|(a, b)| a != b).count();
    let what = |x: &Triangle, y: &Triangle| match (x.object == y.object, x.material == y.material) {
        (false, _) => format!("object {}, in the scene {}", x.object, y.object),
        (true, false) => format!("material {}, in the scene {}", x.material, y.material),
        (true, true) => "its corners".to_owned(),
    };
    Some(format!("{count} triangles, first number {at}: {}", what(&a[at], &b[at])))
}
