//! `rayreel info`: what a trace holds.

use anyhow::Result;
use rayon::prelude::*;
use rayreel_formats::container::ChunkKind;
use rayreel_formats::error::first_error;
use rayreel_formats::tile::{Column, RayKind};
use rayreel_formats::trace::{Scratch, Trace};
use serde_json::{Value, json};

use crate::common::{lacks, print, print_json, printable};
use crate::exit::Exit;
use crate::traces::TraceArgs;

/// Show what a trace holds and what each part of it takes.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args) -> Result<Exit> {
    let trace = args.trace.open()?;
    let missing = trace.missing_tiles();
    let rays = count(&trace, &missing)?;
    let value = describe(&trace, &rays, &missing);
    if args.json {
        print_json(&value)?;
    } else {
        print(&table(&trace, &rays, &missing))?;
    }
    Ok(if missing.is_empty() && trace.lacking().is_empty() { Exit::Done } else { Exit::Incomplete })
}

/// Rays by kind over all tiles, read from their trees.
fn count(trace: &Trace, missing: &[(u32, u32)]) -> Result<[u64; 4]> {
    let tiles = 0..trace.meta().tile_count();
    let all = trace.meta().frame_numbers().flat_map(|f| tiles.clone().map(move |t| (f, t)));
    let tiles: Vec<_> = all.filter(|t| missing.binary_search(t).is_err()).collect();
    let of = |scratch: &mut Scratch, &(frame, tile): &(u32, u32)| -> Result<[u64; 4]> {
        let mut rays = [0; 4];
        for node in trace.tile_with(frame, tile, &[Column::Tree], scratch)?.tree.nodes {
            rays[node.class.kind() as usize] += 1;
            rays[RayKind::Shadow as usize] += u64::from(node.shadows.count());
        }
        Ok(rays)
    };
    let counts = first_error(tiles.par_iter().map_init(Scratch::default, of))?;
    Ok(counts.iter().fold([0; 4], |sum, c| std::array::from_fn(|i| sum[i] + c[i])))
}

/// Bytes in the file by part: each column, then the chunks that are not tiles.
fn parts(trace: &Trace) -> Vec<(String, u64)> {
    let mut parts: Vec<(String, u64)> = Column::ALL
        .iter()
        .filter_map(|c| {
            trace.column_totals().iter().find(|t| t.id == *c as u8).map(|t| (c.name().into(), t.packed_bytes))
        })
        .collect();
    for (kind, name) in [(ChunkKind::META, "meta"), (ChunkKind::BVH, "bvh"), (ChunkKind::FRAM, "cameras")] {
        let bytes = trace.reader().chunks().iter().filter(|c| c.id.kind == kind).map(|c| c.total_len()).sum();
        parts.push((name.into(), bytes));
    }
    let known: u64 = parts.iter().map(|(_, bytes)| bytes).sum();
    parts.push(("headers, directories, index".into(), trace.reader().len().saturating_sub(known)));
    parts
}

fn describe(trace: &Trace, rays: &[u64; 4], missing: &[(u32, u32)]) -> Value {
    let meta = trace.meta();
    let by_kind: serde_json::Map<String, Value> =
        RayKind::ALL.iter().map(|k| (k.name().into(), rays[*k as usize].into())).collect();
    json!({
        "format": trace.reader().version().to_string(),
        "tool": meta.tool,
        "scene": meta.scene,
        "scene_hash": meta.scene_hash.iter().map(|b| format!("{b:02x}")).collect::<String>(),
        "width": meta.width,
        "height": meta.height,
        "samples_per_axis": meta.samples,
        "tile": meta.tile,
        "tiles_per_frame": meta.tile_count(),
        "first_frame": meta.first_frame,
        "frames": meta.frames,
        "max_depth": meta.max_depth,
        "lights": meta.lights.len(),
        "triangles": trace.bvh().triangles.len(),
        "bvh_nodes": trace.bvh().nodes.len(),
        "objects": trace.bvh().objects.len(),
        "rays": rays.iter().sum::<u64>(),
        "rays_by_kind": by_kind,
        "file_bytes": trace.reader().len(),
        "bytes": parts(trace).into_iter().collect::<std::collections::BTreeMap<_, _>>(),
        "missing_tiles": missing.len(),
        "missing": by_frame(missing).map(|(frame, tiles)| json!({ "frame": frame, "tiles": tiles.join(",") })).collect::<Vec<_>>(),
        "missing_columns": missing_columns(trace),
    })
}

fn table(trace: &Trace, rays: &[u64; 4], missing: &[(u32, u32)]) -> String {
    let meta = trace.meta();
    let total = rays.iter().sum::<u64>();
    let mut text = String::new();
    let mut line = |name: &str, value: String| text += &format!("{name:<10} {value}\n");
    line(
        "trace",
        format!("{}, format {}, by {}", trace.reader().path().display(), trace.reader().version(), meta.tool),
    );
    line(
        "scene",
        format!(
            "{}, {} triangles, {} objects",
            printable(&meta.scene),
            trace.bvh().triangles.len(),
            trace.bvh().objects.len()
        ),
    );
    line(
        "image",
        format!(
            "{}x{} pixels, {s}x{s} samples, tiles of {} samples",
            meta.width,
            meta.height,
            meta.tile,
            s = meta.samples
        ),
    );
    line("frames", format!("{} from {}", meta.frames, meta.first_frame));
    line("trees", format!("{} bounces, {} lights", meta.max_depth, meta.lights.len()));
    let kinds: Vec<String> = RayKind::ALL.iter().map(|k| format!("{} {}", rays[*k as usize], k.name())).collect();
    line("rays", format!("{total}: {}", kinds.join(", ")));
    line("bytes", format!("{} ({:.3} a ray)", trace.reader().len(), trace.reader().len() as f64 / total.max(1) as f64));
    for (name, bytes) in parts(trace) {
        text += &format!("  {name:<28} {bytes:>12}  {:.3} a ray\n", bytes as f64 / total.max(1) as f64);
    }
    let lacks = lacks(trace);
    if !lacks.is_empty() {
        text += &format!("incomplete: {lacks}\n");
    }
    for (frame, tiles) in by_frame(missing).take(SHOWN_MAX) {
        let more = if tiles.len() > SHOWN_MAX { ", and others" } else { "" };
        let tiles = tiles.iter().take(SHOWN_MAX).cloned().collect::<Vec<_>>().join(",");
        text += &format!("  missing of frame {frame}: {tiles}{more}\n");
    }
    if by_frame(missing).nth(SHOWN_MAX).is_some() {
        text += "  and tiles of other frames, which --json lists\n";
    }
    text
}

/// Frames, and runs of tiles of each, that are shown at most.
const SHOWN_MAX: usize = 10;

/// Frames with the tiles that are missing of each, as `--tiles` takes them: numbers and ranges.
fn by_frame(missing: &[(u32, u32)]) -> impl Iterator<Item = (u32, Vec<String>)> {
    let run = |run: &[(u32, u32)]| match *run {
        [(_, tile)] => tile.to_string(),
        [(_, first), .., (_, last)] => format!("{first}..{}", last + 1),
        [] => String::new(),
    };
    missing.chunk_by(|a, b| a.0 == b.0).map(move |of_frame| {
        let runs = of_frame.chunk_by(|a, b| a.1 + 1 == b.1).map(run);
        (of_frame[0].0, runs.collect())
    })
}

/// How many tiles lack which column.
fn missing_columns(trace: &Trace) -> serde_json::Map<String, Value> {
    trace.lacking().iter().map(|(column, tiles)| (column.name().into(), (*tiles).into())).collect()
}
