//! Pictures of textures: decoded with limits.

use std::{
    io::{BufRead, Cursor, ErrorKind, Seek},
    path::Path,
};

use image::{ImageError, ImageFormat, ImageReader, Limits, RgbaImage, error::ImageFormatHint};
use rayreel_settings::files;

use crate::{
    error::{Location, SceneError},
    scene::MAX_TEXTURE_SIDE,
};

/// Memory that decoding one texture may take: 16384 x 16384 RGBA.
const MAX_DECODE_BYTES: u64 = 1 << 30;

/// sRGB to linear, both from 0 to 1.
pub(crate) fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Endings of pictures in formats that are not read.
pub(crate) const OTHER_ENDINGS: [&str; 16] = [
    "tga", "bmp", "tif", "tiff", "gif", "webp", "dds", "exr", "hdr", "psd", "ktx", "ktx2", "avif", "jp2", "pcx", "ppm",
];

/// Whether a name is that of a picture in a format that is not read.
fn is_other_picture(file: &Path) -> bool {
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    ending.is_some_and(|ending| OTHER_ENDINGS.contains(&ending.as_str()))
}

/// Bytes at the beginning of a picture that say what it is.
pub(crate) const HEAD: usize = 16;

/// The format that the first bytes of a picture say it has, if it is one that is not read.
pub(crate) fn other_format(head: &[u8]) -> Option<&'static str> {
    let format = image::guess_format(head).ok().filter(|format| is_other(*format))?;
    format.extensions_str().first().copied()
}

/// Whether the first bytes of a picture say that it is one that is read.
pub(crate) fn is_read(head: &[u8]) -> bool {
    image::guess_format(head).is_ok_and(|format| !is_other(format))
}

fn is_other(format: ImageFormat) -> bool {
    !matches!(format, ImageFormat::Png | ImageFormat::Jpeg)
}

/// Whether a picture could not be decoded because it has another format, whatever its name.
fn has_other_format(error: &ImageError) -> bool {
    let ImageError::Unsupported(error) = error else { return false };
    matches!(error.format_hint(), ImageFormatHint::Exact(format) if is_other(format))
}

/// Decodes a picture file that is named at `at`; none if its format is not read.
pub(crate) fn decode_file(at: &Location, file: &Path) -> Result<Option<RgbaImage>, SceneError> {
    let missing = |source| SceneError::missing(at.clone(), "texture", file, source);
    files::check(file, MAX_DECODE_BYTES).map_err(missing)?;
    let reader = ImageReader::open(file).map_err(missing)?;
    match decode(reader) {
        Ok(image) => Ok(Some(image)),
        Err(ImageError::Unsupported(_)) if is_other_picture(file) => Ok(None),
        Err(error) if has_other_format(&error) => Ok(None),
        Err(ImageError::IoError(source)) if source.kind() != ErrorKind::UnexpectedEof => Err(missing(source)),
        Err(other) => Err(undecoded(at, &file.display().to_string(), &other)),
    }
}

/// Decodes a picture in memory; `name` is for messages.
pub(crate) fn decode_bytes(at: &Location, name: &str, bytes: &[u8]) -> Result<RgbaImage, SceneError> {
    decode(ImageReader::new(Cursor::new(bytes))).map_err(|error| undecoded(at, name, &error))
}

fn undecoded(at: &Location, name: &str, error: &ImageError) -> SceneError {
    SceneError::input(
        at.clone(),
        format!("the texture `{name}` cannot be decoded: {error}"),
        format!("PNG and JPEG up to {MAX_TEXTURE_SIDE} x {MAX_TEXTURE_SIDE} texels can"),
    )
}

fn decode<R: BufRead + Seek>(reader: ImageReader<R>) -> Result<RgbaImage, ImageError> {
    let mut reader = reader.with_guessed_format().map_err(ImageError::IoError)?;
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_TEXTURE_SIDE);
    limits.max_image_height = Some(MAX_TEXTURE_SIDE);
    limits.max_alloc = Some(MAX_DECODE_BYTES);
    reader.limits(limits);
    Ok(reader.decode()?.to_rgba8())
}
