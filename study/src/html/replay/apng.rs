//! The pictures of one kind as an animated PNG: every browser plays it.

use std::path::Path;

use png::{BitDepth, ColorType, Decoder, Encoder, Transformations};

use super::folder::Folder;
use crate::files::write_named;
use crate::html::ReportError;
use crate::point::wanted::Kind;

/// Writes the pictures of `kind` in a replay's folder as an animated PNG of so many frames a second. Its bytes depend on the pictures
/// alone. Gives the number of frames.
///
/// # Errors
/// When the folder or a picture cannot be read, the replay has no such pictures, they differ in size, or `file` cannot be written.
pub fn animate(folder: &Path, kind: Kind, fps: u16, file: &Path) -> Result<usize, ReportError> {
    let replay = Folder::read(folder)?;
    let place = Kind::ALL.iter().position(|other| *other == kind).unwrap_or_default();
    let bad = |name: String, detail| ReportError::BadPicture { path: folder.join("stats.json"), name, detail };
    let mut frames = Vec::new();
    for number in &replay.frames {
        let name = format!("{} of frame {number}", kind.name());
        let Some(bytes) = replay.pictures.get(&(place, *number)) else {
            return Err(ReportError::NoPicture { path: folder.join("stats.json"), name });
        };
        frames.push(pixels(bytes).ok_or_else(|| bad(name, "it is no 8-bit RGB picture"))?);
    }
    let (width, height, _) = frames[0];
    if frames.iter().any(|(w, h, _)| (*w, *h) != (width, height)) {
        return Err(bad(kind.name().into(), "the frames have several sizes"));
    }
    let encoded = encode((width, height), fps, &frames)
        .map_err(|e| ReportError::Io { path: file.to_path_buf(), source: std::io::Error::other(e) })?;
    write_named(file, &encoded).map_err(|e| ReportError::Write { source: Box::new(e) })?;
    Ok(frames.len())
}

type Frame = (u32, u32, Vec<u8>);

fn encode((width, height): (u32, u32), fps: u16, frames: &[Frame]) -> Result<Vec<u8>, png::EncodingError> {
    let mut bytes = Vec::new();
    let mut encoder = Encoder::new(&mut bytes, width, height);
    encoder.set_color(ColorType::Rgb);
    encoder.set_depth(BitDepth::Eight);
    // A picture alone is a PNG file as any other.
    if frames.len() > 1 {
        encoder.set_animated(frames.len() as u32, 0)?;
        encoder.set_frame_delay(1, fps)?;
    }
    let mut writer = encoder.write_header()?;
    frames.iter().try_for_each(|(_, _, pixels)| writer.write_image_data(pixels))?;
    writer.finish()?;
    Ok(bytes)
}

fn pixels(bytes: &[u8]) -> Option<Frame> {
    let mut decoder = Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(Transformations::EXPAND);
    let mut reader = decoder.read_info().ok()?;
    let mut pixels = vec![0; reader.output_buffer_size()?];
    let info = reader.next_frame(&mut pixels).ok()?;
    let rgb = (info.color_type, info.bit_depth) == (ColorType::Rgb, BitDepth::Eight);
    pixels.truncate(info.buffer_size());
    rgb.then_some((info.width, info.height, pixels))
}
