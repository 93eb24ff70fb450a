//! The five built-in scenes as their traces hold them, and which samples of `chess` a policy interpolated.

use image::codecs::jpeg::JpegEncoder;
use image::{ExtendedColorType, ImageEncoder, RgbImage};
use rayreel_formats::Limits;
use rayreel_formats::trace::{Codec, Trace};
use rayreel_replay::image::{Srgb8, srgb};
use rayreel_replay::maps;
use rayreel_replay::{NamedPolicy, Options, Replayer};
use rayreel_tracer::{CaptureOutput, SampleGrid, TraceSettings};

use crate::table::SCENES;

/// Size of a picture, and the space between two, pixels.
const SIZE: (u32, u32) = (400, 200);
const GAP: u32 = 6;

/// A sheet of three columns and two rows, as JPEG.
pub fn jpeg() -> Result<Vec<u8>, Box<dyn std::error::Error>> {
    let mut sheet = RgbImage::from_pixel(3 * SIZE.0 + 2 * GAP, 2 * SIZE.1 + GAP, image::Rgb([255; 3]));
    let mut cell = 0;
    let mut put = |picture: &Srgb8| {
        let (left, top) = ((cell % 3) * (SIZE.0 + GAP), (cell / 3) * (SIZE.1 + GAP));
        for (i, pixel) in (0..).zip(&picture.pixels) {
            sheet.put_pixel(left + i % picture.width, top + i / picture.width, image::Rgb(*pixel));
        }
        cell += 1;
    };
    for scene in SCENES {
        let (picture, map) = pictures(scene)?;
        put(&picture);
        if scene == "chess" {
            put(&map);
        }
    }
    let mut bytes = Vec::new();
    let encoder = JpegEncoder::new_with_quality(&mut bytes, 88);
    encoder.write_image(&sheet, sheet.width(), sheet.height(), ExtendedColorType::Rgb8)?;
    Ok(bytes)
}

/// A scene with every sample traced, and where `multirate` interpolates (yellow) or traces (blue).
fn pictures(name: &str) -> Result<(Srgb8, Srgb8), Box<dyn std::error::Error>> {
    let scene = rayreel_scenes::load(name)?;
    let built = rayreel_tracer::build(&scene)?;
    let grid = SampleGrid { width: SIZE.0, height: SIZE.1, samples: 2, tile: 32, first_frame: 0, frames: 1 };
    let meta = grid.meta(&scene, TraceSettings::default(), "pictures");
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("scene.rtrace");
    let output = CaptureOutput::new(path.clone(), Codec::Context, 3);
    rayreel_tracer::capture::capture(&scene, &built, &meta, &output, |_| true)?;

    let trace = Trace::open(&path, Limits::default())?;
    let policy = NamedPolicy::load("multirate", &[])?;
    let frame = Replayer::new(&trace, &policy.policy, Options::default())?.frame(0)?;
    let reference = frame.reference.as_ref().ok_or("a replay compares with full")?;
    Ok((srgb::encode(reference), maps::similarity_map_pixels(&frame.states, &frame.blocks, meta.samples)))
}
