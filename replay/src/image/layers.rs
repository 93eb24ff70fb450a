//! EXR files of many named layers: what compositing programs and NumPy read by name.

use std::io::{self, Cursor};
use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Compression, Encoding, FlatSamples, Image as ExrImage, Layer, LineOrder, Text,
    WritableImage,
};

use super::files::{ExrNotes, attributes, write};
use crate::error::{ReplayError, Result};

/// The values of a channel, row by row, one a pixel.
#[derive(Clone, Debug, PartialEq)]
pub enum Values {
    /// Numbers.
    Floats(Vec<f32>),
    /// Numbers of things, and counts.
    Whole(Vec<u32>),
}

/// A channel of a layer, by its name in the file: `normal.X` is channel `X` of layer `normal`; `R`, `G` and `B` alone are the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Its name.
    pub name: String,
    /// Its values.
    pub values: Values,
}

/// Writes channels as one EXR file: 32 bits a value, scan lines top to bottom, ZIP. Its bytes depend on the arguments alone.
///
/// # Errors
/// A channel that has not one value a pixel; a file that cannot be written.
pub fn write_layers(path: &Path, (width, height): (u32, u32), channels: &[Channel], notes: &ExrNotes) -> Result<()> {
    let size = (width as usize, height as usize);
    let mut list = Vec::new();
    for Channel { name, values } in channels {
        let (len, samples) = match values {
            Values::Floats(values) => (values.len(), FlatSamples::F32(values.clone())),
            Values::Whole(values) => (values.len(), FlatSamples::U32(values.clone())),
        };
        if len != size.0 * size.1 {
            let detail = format!("channel {name} has {len} values for {width} x {height} pixels");
            return Err(ReplayError::Usage { detail });
        }
        list.push(AnyChannel::new(Text::from(name.as_str()), samples));
    }
    // The parallel writer and any other line order give other bytes from run to run.
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: exr::image::Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, attributes(notes), encoding, AnyChannels::sort(list.into_iter().collect()));
    let mut bytes = Cursor::new(Vec::new());
    let result = ExrImage::from_layer(layer).write().non_parallel().to_buffered(&mut bytes);
    result.map_err(|e| ReplayError::output(path, "encode", io::Error::other(e)))?;
    write(path, bytes.get_ref())
}
