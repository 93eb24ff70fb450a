//! Argument types and small steps that several commands share.

use std::io::Write;
use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use clap::builder::{PathBufValueParser, TypedValueParser};
use rayreel_columns::ColumnsError;
use rayreel_formats::Limits;
use rayreel_formats::container::MAGIC;
use rayreel_formats::durable::WholeFile;
use rayreel_formats::scene::Meta;
use rayreel_formats::tile::MAX_DEPTH;
use rayreel_formats::trace::{Trace, digest};
use rayreel_replay::image::Image;
use rayreel_replay::image::resolve::Resolver;
use rayreel_scenes::Scene;
use rayreel_settings::files::begins_with;
use rayreel_study::sweep::folder::PLAN;
use rayreel_tracer::{Built, SampleGrid, TOOL, TraceSettings};

use crate::memory;

/// The sample grid of a picture or a capture.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct GridArgs {
    /// Image size in pixels.
    #[arg(long, default_value = "1024x512", value_name = "WxH", value_parser = size)]
    pub size: (u32, u32),
    /// Samples per pixel: 1x1 (pixel centres), or sub-pixels: 2x2 to 8x8.
    #[arg(long, default_value = "2x2", value_name = "NxN", value_parser = samples)]
    pub samples: u32,
    /// Secondary bounces allowed; 0 is primary and shadow rays only.
    #[arg(long, default_value_t = TraceSettings::default().max_depth, value_name = "N", value_parser = depth)]
    pub depth: u32,
}

impl GridArgs {
    /// The size if none is given.
    pub const SIZE: (u32, u32) = (1024, 512);
    /// The samples in a row of a pixel if none are given.
    pub const SAMPLES: u32 = 2;
}

/// Parses a number of bounces.
pub fn depth(text: &str) -> Result<u32, String> {
    let depth = text.parse().ok().filter(|depth| *depth <= MAX_DEPTH);
    depth.ok_or_else(|| format!("give a number of bounces from 0 to {MAX_DEPTH}"))
}

/// Parses `WxH`.
pub fn size(text: &str) -> Result<(u32, u32), String> {
    let parse = |s: &str| s.parse::<u32>().ok().filter(|&v| (1..=131_072).contains(&v));
    let pair = text.split_once('x').and_then(|(w, h)| Some((parse(w)?, parse(h)?)));
    let (width, height) = pair.ok_or("give width and height in pixels, such as 1024x512")?;
    let most = Limits::default().max_pixels;
    if u64::from(width) * u64::from(height) > most {
        return Err(format!("a picture has at most {most} pixels"));
    }
    Ok((width, height))
}

/// Most samples of a pixel in a row: what a trace can hold.
const SAMPLES_MAX: u32 = 8;

/// Parses `NxN`.
pub fn samples(text: &str) -> Result<u32, String> {
    let known = (1..=SAMPLES_MAX).find(|n| text == format!("{n}x{n}"));
    known.ok_or_else(|| {
        format!("give as many samples across as down, from 1x1 to {SAMPLES_MAX}x{SAMPLES_MAX}, such as 2x2")
    })
}

/// The tile edge that is taken where none is given, in samples: the first from 32 on that holds whole pixels, and whole blocks of 2,
/// 4, 8 and 16 samples.
pub fn tile_of(samples: u32) -> u32 {
    (2..).map(|blocks| 16 * blocks).find(|tile| tile % samples == 0).unwrap_or(32)
}

/// Parses the name of a file to write: it is renamed when it is whole, and many are not written from front to back.
pub fn output_file() -> impl TypedValueParser<Value = PathBuf> {
    PathBufValueParser::new().try_map(|path| {
        let is_piped = path == Path::new("-");
        if is_piped { Err("standard output cannot take it; name a file (./- is one called -)") } else { Ok(path) }
    })
}

/// Parses how many of something.
pub fn count(text: &str) -> Result<usize, String> {
    text.parse().map_err(|_| "give a whole number from 0 on".to_string())
}

/// Parses the number of a frame. There is one less than a `u32` holds, so that the one after the last has a number too.
pub fn frame(text: &str) -> Result<u32, String> {
    let number = text.trim().parse().ok().filter(|frame| *frame < u32::MAX);
    number.ok_or_else(|| format!("give the number of a frame, below {}", u32::MAX))
}

/// Parses `A..B` or `A` to first frame and number of frames.
pub fn frames(text: &str) -> Result<(u32, u32), String> {
    let wrong = || "give frames as A..B with A below B, such as 0..60, or one number".to_string();
    let number = |s: &str| s.trim().parse::<u32>().map_err(|_| wrong());
    let Some((first, end)) = text.split_once("..") else {
        return frame(text).map(|frame| (frame, 1)).map_err(|_| wrong());
    };
    let (first, end) = (number(first)?, number(end)?);
    if first < end { Ok((first, end - first)) } else { Err(wrong()) }
}

/// Tells what was odd in a scene's files.
pub fn tell_warnings(scene: &Scene) {
    for warning in &scene.warnings {
        let times = if warning.count == 1 { String::new() } else { format!(" ({} times)", warning.count) };
        tell!("warning: {}{times}", printable(&warning.message));
    }
}

/// Text with names from files, for a terminal: control characters are escaped, so that no name moves the cursor, changes colours or
/// begins a line.
pub fn printable(text: &str) -> String {
    let escaped = |c: char| if c.is_control() { c.escape_default().to_string() } else { c.to_string() };
    text.chars().map(escaped).collect()
}

/// Builds a scene's BVH.
pub fn build(scene: &Scene) -> Result<Built> {
    let built = rayreel_tracer::build(scene)?;
    if built.left_out > 0 {
        tell!("warning: {} triangles are copies of others in the same place and are left out", built.left_out);
    }
    Ok(built)
}

/// Renders one frame straight from the tracer.
pub fn render(scene: &Scene, built: &Built, meta: &Meta, frame: u32) -> Result<Image> {
    let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
    rayreel_tracer::render(scene, built, meta, frame, |rect, colours| {
        for (i, colour) in (0u32..).zip(colours) {
            resolver.add(rect.x + i % rect.width, rect.y + i / rect.width, colour);
        }
    })?;
    Ok(resolver.finish())
}

/// The metadata of a render or capture.
pub fn meta(scene: &Scene, grid: &GridArgs, tile: u32, first_frame: u32, frames: u32) -> Meta {
    let (width, height) = grid.size;
    let samples = SampleGrid { width, height, samples: grid.samples, tile, first_frame, frames };
    let settings = TraceSettings { max_depth: grid.depth, ..TraceSettings::default() };
    samples.meta(scene, settings, TOOL)
}

/// Opens a trace.
pub fn open(path: &Path) -> Result<Trace> {
    Ok(Trace::open(path, memory::limits())?)
}

/// What is wrong with the trace or the replay that a table is made of, as other commands say it.
pub fn plain(error: ColumnsError) -> anyhow::Error {
    match error {
        ColumnsError::Trace(error) => error.into(),
        ColumnsError::Replay(error) => error.into(),
        error => error.into(),
    }
}

/// A file's name without its folders: what results name, so that they are the same wherever they are made.
pub fn bare(text: &str) -> String {
    text.rsplit(['/', '\\']).next().unwrap_or(text).to_owned()
}

/// Refuses an output that would take the place of an input.
pub fn keep_input(output: &Path, input: &Path) -> Result<()> {
    let place = |path: &Path| path.canonicalize().ok();
    if place(output).is_some_and(|to| Some(to) == place(input)) {
        bail!("{} is what is read; name another file to write", output.display());
    }
    Ok(())
}

/// Refuses an output that would take the place of a trace, or of a file that the sweep in `folder` lives on. Its results may be
/// written again.
pub fn keep_sweep(output: &Path, folder: &Path) -> Result<()> {
    let is_trace = begins_with(output, &MAGIC);
    let inside = output.parent().and_then(|parent| parent.canonicalize().ok()).zip(folder.canonicalize().ok());
    let within = inside.is_some_and(|(parent, folder)| parent != folder && parent.starts_with(folder));
    if is_trace || within {
        let what = if is_trace { "is a trace" } else { "is among the files that the sweep lives on" };
        bail!("{} {what}; name another file to write", output.display());
    }
    keep_input(output, &folder.join(PLAN))
}

/// Refuses an output that would take the place of a file that a scene is made of.
pub fn keep_scene(output: &Path, scene: &Scene) -> Result<()> {
    scene.files.iter().try_for_each(|file| keep_input(output, file))
}

/// Refuses an output that cannot be written, or would take the place of one of `inputs`: before the work is done that it is for.
/// Inputs that are no files, such as names of presets, do not matter.
pub fn check_output(output: &Path, inputs: &[&Path]) -> Result<()> {
    inputs.iter().try_for_each(|input| keep_input(output, input))?;
    if output.is_dir() {
        bail!("{} is a folder; name a file to write", output.display());
    }
    // It is there for a moment only.
    let begun = WholeFile::create(output).with_context(|| format!("cannot write {}", output.display()))?;
    drop(begun);
    Ok(())
}

/// Writes to standard output; the caller decides what a closed pipe means.
pub fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    out.write_all(text.as_bytes()).and_then(|()| out.flush()).context("cannot write to standard output")
}

/// Prints a JSON value, indented, with a newline.
pub fn print_json(value: &serde_json::Value) -> Result<()> {
    print(&format!("{value:#}\n"))
}

/// `12_345_678` as `12.35 M`, for people: the unit follows at once.
pub fn si(value: f64) -> String {
    let (scale, unit) = match value {
        v if v >= 1e9 => (1e9, " G"),
        v if v >= 1e6 => (1e6, " M"),
        v if v >= 1e3 => (1e3, " k"),
        _ => return format!("{value:.0} "),
    };
    format!("{:.2}{unit}", value / scale)
}

/// The digest of a trace whose every frame is read anyway; none where only `frames` of more are: it would decode them all.
pub fn digest_if_whole(trace: &Trace, frames: &Range<u32>) -> Result<Option<String>> {
    let is_whole = *frames == trace.meta().frame_numbers();
    Ok(if is_whole { Some(digest(trace)?.total().to_string()) } else { None })
}

/// How many tiles are missing, in words.
pub fn missing_tiles(missing: usize) -> String {
    if missing == 1 { "1 tile is missing".into() } else { format!("{missing} tiles are missing") }
}

/// What a trace lacks, in words: whole tiles, and columns of tiles that are there. Empty if it is complete.
pub fn lacks(trace: &Trace) -> String {
    let missing = trace.missing_tiles().len();
    let tiles = (missing > 0).then(|| missing_tiles(missing));
    let columns = trace.lacking().iter().map(|(column, tiles)| format!("{tiles} tiles hold no {}", column.name()));
    tiles.into_iter().chain(columns).collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_unit_stands_apart_from_its_number() {
        assert_eq!(
            [0.4, 548.0, 12_345.0, 2e9].map(|rate| format!("{}rays/s", si(rate))),
            ["0 rays/s", "548 rays/s", "12.35 krays/s", "2.00 Grays/s"]
        );
    }

    #[test]
    fn samples_are_as_many_across_as_down() {
        assert_eq!(
            (1..=8).map(|n| samples(&format!("{n}x{n}"))).collect::<Vec<_>>(),
            (1..=8).map(Ok).collect::<Vec<_>>()
        );
        for wrong in ["0x0", "9x9", "2x3", "2", "", "x", "02x02"] {
            assert!(samples(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn names_do_not_write_to_the_terminal() {
        assert_eq!(printable("Stra\u{df}e"), "Stra\u{df}e");
        assert_eq!(printable("\u{1b}[31mx\nerror: y\u{7f}"), "\\u{1b}[31mx\\nerror: y\\u{7f}");
    }

    #[test]
    fn tiles_hold_whole_pixels_and_blocks() {
        assert_eq!((1..=8).map(tile_of).collect::<Vec<_>>(), [32, 32, 48, 32, 80, 48, 112, 32]);
    }
}
