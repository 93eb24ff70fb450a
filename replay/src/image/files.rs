//! Picture files: EXR (linear RGB, f32) and PNG (8-bit sRGB).
//!
//! A file is written whole or not at all. The bytes depend on the picture alone.

use std::fs::File;
use std::io::{self, BufReader, Cursor};
use std::path::Path;

use exr::prelude::{
    AttributeValue, Compression, Encoding, Image as ExrImage, Layer, LayerAttributes, LineOrder, SpecificChannels,
    Text, Vec2, WritableImage, read_first_rgba_layer_from_file,
};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageReader};
use rayreel_formats::durable;

use super::{Image, Srgb8};
use crate::error::{ReplayError, Result};

pub(super) fn write(path: &Path, bytes: &[u8]) -> Result<()> {
    durable::write_whole(path, &[bytes]).map_err(|source| ReplayError::output(path, "write", source))
}

/// What an EXR file says of its picture beside the program that wrote it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExrNotes {
    /// For people: the attribute `comments`.
    pub comments: Option<String>,
    /// For programs: the attribute `rayreel`.
    pub about: Option<String>,
}

/// The program, as EXR files and reports name it.
pub const SOFTWARE: &str = concat!("rayreel ", env!("CARGO_PKG_VERSION"));

/// Writes a picture as EXR: three f32 channels, scan lines top to bottom, ZIP.
///
/// # Errors
/// When the file cannot be written.
pub fn write_exr(path: &Path, image: &Image) -> Result<()> {
    write_exr_with(path, image, &ExrNotes::default())
}

/// As [`write_exr`], with notes on what the picture is of.
///
/// # Errors
/// When the file cannot be written.
pub fn write_exr_with(path: &Path, image: &Image, notes: &ExrNotes) -> Result<()> {
    let width = image.width as usize;
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| {
        let [r, g, b] = image.pixels[at.y() * width + at.x()];
        (r, g, b)
    });
    // The parallel writer and any other line order give other bytes from run to run.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new((width, image.height as usize), attributes(notes), encoding, channels);
    let mut bytes = Cursor::new(Vec::new());
    let result = ExrImage::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    result.map_err(|e| ReplayError::output(path, "encode", io::Error::other(e)))?;
    write(path, bytes.get_ref())
}

/// The attributes. One of them at most has a name of ours: the crate writes those in the order of a hash map, which is another each
/// time.
pub(super) fn attributes(notes: &ExrNotes) -> LayerAttributes {
    let about = notes.about.as_deref().map(|about| (Text::from("rayreel"), AttributeValue::Text(latin(about))));
    LayerAttributes {
        software_name: Some(latin(SOFTWARE)),
        comments: notes.comments.as_deref().map(latin),
        other: about.into_iter().collect(),
        ..LayerAttributes::default()
    }
}

/// EXR has one byte for a character: others stand there as `\u{1234}`.
fn latin(text: &str) -> Text {
    let escaped = |c: char| if c.is_ascii() { c.to_string() } else { c.escape_unicode().to_string() };
    Text::from(text.chars().map(escaped).collect::<String>().as_str())
}

/// Writes a picture as PNG.
///
/// # Errors
/// When the file cannot be written.
pub fn write_png(path: &Path, image: &Srgb8) -> Result<()> {
    let bytes = encode(image).map_err(|e| ReplayError::output(path, "encode", io::Error::other(e)))?;
    write(path, &bytes)
}

/// The bytes of a PNG file.
///
/// # Errors
/// When the picture has no pixels.
pub fn png(image: &Srgb8) -> Result<Vec<u8>> {
    encode(image).map_err(|e| ReplayError::Usage { detail: format!("a picture cannot be written as PNG: {e}") })
}

fn encode(image: &Srgb8) -> image::ImageResult<Vec<u8>> {
    let mut bytes = Vec::new();
    PngEncoder::new_with_quality(&mut bytes, CompressionType::Default, FilterType::Adaptive).write_image(
        image.bytes(),
        image.width,
        image.height,
        ExtendedColorType::Rgb8,
    )?;
    Ok(bytes)
}

/// Reads the first RGB layer of an EXR file.
///
/// # Errors
/// When the file cannot be read or has no such layer.
pub fn read_exr(path: &Path) -> Result<Image> {
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| Image {
            width: size.width() as u32,
            height: size.height() as u32,
            pixels: vec![[0.0; 3]; size.area()],
        },
        |image, at, (r, g, b, _): (f32, f32, f32, f32)| {
            let width = image.width as usize;
            image.pixels[at.y() * width + at.x()] = [r, g, b];
        },
    );
    Ok(image.map_err(|e| unreadable(path, &e))?.layer_data.channel_data.pixels)
}

/// Reads a PNG file as 8-bit RGB.
///
/// # Errors
/// When the file cannot be read.
pub fn read_png(path: &Path) -> Result<Srgb8> {
    let file = File::open(path).map_err(|e| unreadable(path, &e))?;
    let reader = ImageReader::with_format(BufReader::new(file), image::ImageFormat::Png);
    let rgb = reader.decode().map_err(|e| unreadable(path, &e))?.into_rgb8();
    Ok(Srgb8 { width: rgb.width(), height: rgb.height(), pixels: rgb.pixels().map(|p| p.0).collect() })
}

fn unreadable(path: &Path, error: &dyn std::error::Error) -> ReplayError {
    ReplayError::Picture { path: path.to_path_buf(), detail: error.to_string() }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    fn picture() -> Image {
        let pixels = (0..37 * 21).map(|i| [i as f32 * 0.001, 1.0 / (i + 1) as f32, (i % 7) as f32]).collect();
        Image { width: 37, height: 21, pixels }
    }

    #[test]
    fn exr_comes_back_and_has_the_same_bytes_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let paths: Vec<_> = (0..4).map(|i| folder.path().join(format!("{i}.exr"))).collect();
        paths.iter().for_each(|path| write_exr(path, &picture()).unwrap());
        assert_eq!(read_exr(&paths[0]).unwrap(), picture());
        let first = fs::read(&paths[0]).unwrap();
        assert!(paths.iter().all(|path| fs::read(path).unwrap() == first));
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "no temporary file is left");
    }

    #[test]
    fn exr_says_what_it_is_of_and_has_the_same_bytes_each_time() {
        let folder = tempfile::tempdir().unwrap();
        let notes =
            ExrNotes { comments: Some("rayreel replay é.rtrace".into()), about: Some("{\"machine\":\"m\"}".into()) };
        let paths: Vec<_> = (0..8).map(|i| folder.path().join(format!("{i}.exr"))).collect();
        paths.iter().for_each(|path| write_exr_with(path, &picture(), &notes).unwrap());
        let first = fs::read(&paths[0]).unwrap();
        assert!(paths.iter().all(|path| fs::read(path).unwrap() == first));
        assert_eq!(read_exr(&paths[0]).unwrap(), picture());
        let header = exr::meta::MetaData::read_from_file(&paths[0], true).unwrap().headers[0].own_attributes.clone();
        let text = |text: &Option<Text>| text.as_ref().map(ToString::to_string);
        assert_eq!(text(&header.software_name).as_deref(), Some(SOFTWARE));
        assert_eq!(text(&header.comments).as_deref(), Some("rayreel replay \\u{e9}.rtrace"));
        assert_eq!(header.other[&Text::from("rayreel")], AttributeValue::Text(Text::from("{\"machine\":\"m\"}")));
    }

    #[test]
    fn png_comes_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let image = super::super::srgb::encode(&picture());
        write_png(&path, &image).unwrap();
        assert_eq!(read_png(&path).unwrap(), image);
    }

    #[test]
    fn failures_name_the_file_and_leave_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let error = write_exr(&folder.path().join("no/a.exr"), &picture()).unwrap_err();
        assert!(error.to_string().contains("a.exr"), "{error}");
        // A folder of that name cannot be replaced; the temporary file goes.
        let taken = folder.path().join("taken.png");
        fs::create_dir(&taken).unwrap();
        fs::write(taken.join("x"), "x").unwrap();
        assert!(write_png(&taken, &super::super::srgb::encode(&picture())).is_err());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
        fs::write(folder.path().join("bad.png"), "not a picture").unwrap();
        assert!(read_png(&folder.path().join("bad.png")).is_err());
        assert!(read_exr(&folder.path().join("bad.png")).is_err());
    }
}
