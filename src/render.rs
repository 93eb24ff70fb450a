//! `rayreel render`: the reference picture straight from the tracer.

use std::path::PathBuf;

use anyhow::{Result, bail};
use rayreel_replay::image::{files, srgb};

use crate::common::{GridArgs, build, load_scene, meta, render, tile_of};
use crate::exit::Exit;

/// Render a scene straight from the tracer, without recording.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// Built-in scene, scene file (.toml) or model (.obj).
    scene: String,
    /// Picture to write: .png (sRGB) or .exr (linear).
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    #[command(flatten)]
    grid: GridArgs,
    /// Frame of the camera path.
    #[arg(long, default_value_t = 0, value_name = "N")]
    frame: u32,
}

pub fn run(args: &Args) -> Result<Exit> {
    let extension = args.output.extension().map(|e| e.to_ascii_lowercase());
    let exr = match extension.as_deref().and_then(|e| e.to_str()) {
        Some("png") => false,
        Some("exr") => true,
        _ => bail!("cannot tell the picture format of {}; end it in .png or .exr", args.output.display()),
    };
    let scene = load_scene(&args.scene)?;
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
