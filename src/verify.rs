//! `rayreel verify`: does a trace follow from itself?

use anyhow::{Result, bail};
use rayreel_formats::trace::Trace;
use rayreel_tracer::TOOL;
use rayreel_tracer::against::{Against, against};
use rayreel_tracer::verify::verify;
use serde_json::json;

use crate::common::{build, frame, lacks, print, print_json};
use crate::exit::Exit;
use crate::progress::{self, Progress};
use crate::scene_args::SceneChanges;
use crate::traces::TraceArgs;

/// Traverse the BVH of a trace again and check every path, hit and shadow state, bit for bit.
///
/// Needs no scene, and so says nothing of what only the scene knows: to which object a triangle belongs, colours of lights, which
/// materials are cut-outs and where, local colours, black surfaces, triangles that no ray meets. With --scene these are compared too,
/// and every tile is traced again. Exits with 1 at a mismatch, 3 if tiles are missing, 65 if the file is damaged.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    trace: TraceArgs,
    /// Also compare with the scene that the trace is of: built-in scene, scene file or model.
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    #[command(flatten, next_help_heading = "With --scene, as the capture was told")]
    changes: SceneChanges,
    /// The frame as at which moving meshes and lights of a glTF model stand: the first one of the capture, which is not that of the
    /// trace where it was cut out of a longer one.
    #[arg(long, value_name = "N", value_parser = frame, requires = "scene")]
    stands_at: Option<u32>,
    /// Print JSON.
    #[arg(long)]
    json: bool,
}

pub fn run(args: &Args, quiet: bool) -> Result<Exit> {
    if let Some(flag) = args.changes.first_flag().filter(|_| args.scene.is_none()) {
        bail!("{flag} says how the scene was captured; name it with --scene");
    }
    let trace = args.trace.open()?;
    let missing = trace.missing_tiles().len();
    let stop = progress::stop_on_signal();
    let total = u64::from(trace.meta().tile_count()) * u64::from(trace.meta().frames);
    let mut bar = Progress::new("verify", total, quiet);
    let found = verify(&trace, |tiles| {
        bar.set(tiles, || format!("{tiles} tiles"));
        !stop.is_requested()
    })?;
    bar.finish();
    if stop.is_requested() {
        return Ok(interrupted());
    }
    let against = args.scene.as_deref().map(|scene| compare(&trace, scene, args, quiet)).transpose()?;
    if stop.is_requested() {
        return Ok(interrupted());
    }
    let first = found.first.as_ref();
    if args.json {
        print_json(&json!({
            "tool": trace.meta().tool,
            "scene": against.as_ref().map(|found| json!({
                "tables_wrong": found.tables, "tiles": found.tiles, "tiles_wrong": found.tiles_wrong, "first_mismatch": found.first,
            })),
            "tiles": found.tiles, "rays": found.rays, "steps": found.steps,
            "tiles_wrong": found.tiles_wrong, "missing_tiles": missing,
            "tiles_without_paths": found.without_paths, "tiles_unchecked": found.unchecked,
            "first_mismatch": first.map(|m| json!({"frame": m.frame, "tile": m.tile, "x": m.x, "y": m.y, "detail": m.detail})),
        }))?;
    } else if let Some(m) = first {
        print(&format!(
            "{} of {} tiles do not follow from the trace\nfirst: frame {}, tile {}, sample ({}, {}): {}\n",
            found.tiles_wrong, found.tiles, m.frame, m.tile, m.x, m.y, m.detail
        ))?;
        print(&captured_otherwise(&trace.meta().tool))?;
    } else {
        print(&format!("verified: {} tiles, {} rays, {} steps\n", found.tiles, found.rays, found.steps))?;
    }
    if !args.json {
        print(&of_scene(against.as_ref()))?;
        let may_stand_otherwise = args.stands_at.is_none() && trace.meta().first_frame > 0;
        if may_stand_otherwise && against.as_ref().is_some_and(|found| !found.tables.is_empty()) {
            print(
                "if the trace was cut out of a longer one, moving meshes and lights stand as at the first frame of that: say it with \
                 --stands-at N\n",
            )?;
        }
    }
    if against.is_some_and(|found| !found.agrees()) {
        return Ok(Exit::No);
    }
    let lacks = lacks(&trace);
    if found.tiles_wrong > 0 {
        return Ok(Exit::No);
    }
    if lacks.is_empty() {
        return Ok(Exit::Done);
    }
    tell!("incomplete: {lacks}");
    if found.without_paths + found.unchecked > 0 {
        let (steps, tiles) = (found.without_paths, found.unchecked);
        tell!("not checked: the steps of {steps} tiles, and {tiles} tiles altogether");
    }
    Ok(Exit::Incomplete)
}

/// Says that nothing is known of the tiles that were not looked at.
fn interrupted() -> Exit {
    tell!("interrupted: not all tiles were looked at");
    Exit::Interrupted
}

/// Why a trace that `tool` wrote may be right all the same.
fn captured_otherwise(tool: &str) -> String {
    if tool == TOOL {
        return String::new();
    }
    format!("it was captured by {tool}, which need not trace as {TOOL} does: capture it again to verify it\n")
}

/// Compares with the scene.
fn compare(trace: &Trace, scene: &str, args: &Args, quiet: bool) -> Result<Against> {
    let (stop, meta) = (progress::stop_on_signal(), trace.meta());
    let frames = (args.stands_at.unwrap_or(meta.first_frame), meta.frames);
    let scene = args.changes.load(scene, frames, (meta.width, meta.height))?;
    let built = build(&scene)?;
    let total = u64::from(trace.meta().tile_count()) * u64::from(trace.meta().frames);
    let mut bar = Progress::new("trace again", total, quiet);
    let found = against(trace, &scene, &built, |tiles| {
        bar.set(tiles, || format!("{tiles} tiles"));
        !stop.is_requested()
    })?;
    bar.finish();
    Ok(found)
}

/// What was found of the scene, or what is not known without it.
fn of_scene(found: Option<&Against>) -> String {
    let Some(found) = found else {
        return "not bound to a scene: objects, colours of lights and surfaces, cut-outs and what no ray met are believed \
                (--scene SCENE compares them)\n"
            .into();
    };
    let mut text: String = found.tables.iter().map(|what| format!("differs from the scene: {what}\n")).collect();
    match &found.first {
        Some(first) => {
            text += &format!("{} of {} tiles differ when traced again, first {first}\n", found.tiles_wrong, found.tiles)
        }
        None if text.is_empty() => {
            text += &format!("as the scene: all tables, and {} tiles traced again\n", found.tiles)
        }
        None => {}
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_of_another_tracer_it_is_said() {
        assert_eq!(captured_otherwise(TOOL), "");
        let words = captured_otherwise("rayreel 0.1.0");
        assert!(words.starts_with("it was captured by rayreel 0.1.0, which need not trace as rayreel "), "{words}");
    }
}
