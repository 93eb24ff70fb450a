//! `rayreel render`: the reference picture straight from the tracer.

use std::path::{Path, PathBuf};

use anyhow::{Result, bail};
use rayreel_replay::image::{files, srgb};

use crate::common::{GridArgs, build, check_output, frame, keep_scene, meta, render, tile_of};
use crate::exit::Exit;
use crate::scene_args::SceneArgs;

/// Render a scene straight from the tracer, without recording.
#[derive(Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    scene: SceneArgs,
    /// Picture to write: .png (sRGB) or .exr (linear).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    grid: GridArgs,
    /// Frame of the camera path, or of an animated model.
    #[arg(long, default_value_t = 0, value_name = "N", value_parser = frame)]
    frame: u32,
}

pub fn run(args: &Args) -> Result<Exit> {
    let extension = args.output.extension().map(|e| e.to_ascii_lowercase());
    let exr = match extension.as_deref().and_then(|e| e.to_str()) {
        Some("png") => false,
        Some("exr") => true,
        _ => bail!("cannot tell the picture format of {}; end it in .png or .exr", args.output.display()),
    };
    check_output(&args.output, &[Path::new(&args.scene.scene)])?;
    let scene = args.scene.load((args.frame, 1), args.grid.size)?;
    keep_scene(&args.output, &scene)?;
    let built = build(&scene)?;
    let image =
        render(&scene, &built, &meta(&scene, &args.grid, tile_of(args.grid.samples), args.frame, 1), args.frame)?;
    if exr {
        files::write_exr(&args.output, &image)?;
    } else {
        files::write_png(&args.output, &srgb::encode(&image))?;
    }
    Ok(Exit::Done)
}
