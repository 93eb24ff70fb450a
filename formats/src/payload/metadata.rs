//! The `META` and `FRAM` payloads: bincode 2 with fixed-width little-endian integers, under a byte limit, nothing left
//! over.
//!
//! This is the only place that knows bincode; FORMAT.md spells out the bytes.

use bincode::config::{Configuration, Fixint, Limit, LittleEndian};
use bincode::{Decode, Encode};

use crate::error::{Error, Result};
use crate::limits::Limits;
use crate::scene::{Camera, Light, MAX_LIGHTS, Meta};
use crate::tile::MAX_DEPTH;

/// Largest sample grid edge: sample numbers stay exact in `f32`.
const MAX_GRID: u32 = 1 << 20;

/// A hard limit on what decoding may allocate; [`Limits::max_metadata_bytes`] is checked before.
fn config() -> Configuration<LittleEndian, Fixint, Limit<{ 1 << 26 }>> {
    bincode::config::standard().with_little_endian().with_fixed_int_encoding().with_limit::<{ 1 << 26 }>()
}

/// Encodes a metadata value.
///
/// # Errors
/// When the value is larger than a reader would accept.
pub(super) fn encode<T: Encode>(what: &'static str, value: &T) -> Result<Vec<u8>> {
    bincode::encode_to_vec(value, config()).map_err(|e| Error::decode(what, e.to_string()))
}

/// Decodes a metadata value that fills `bytes`.
///
/// # Errors
/// When the bytes are not such a value, exceed the limit, or go on after it.
pub(super) fn decode<T: Decode<()>>(what: &'static str, bytes: &[u8], limits: &Limits) -> Result<T> {
    let size = bytes.len() as u64;
    if size > limits.max_metadata_bytes {
        return Err(Error::limit("metadata bytes", size, limits.max_metadata_bytes));
    }
    let (value, used) = bincode::decode_from_slice(bytes, config()).map_err(|e| Error::decode(what, e.to_string()))?;
    if used != bytes.len() {
        return Err(Error::decode(what, format!("{} bytes left over", bytes.len() - used)));
    }
    Ok(value)
}

impl Meta {
    /// The payload of a `META` chunk.
    ///
    /// # Errors
    /// When it is larger than a reader would accept.
    pub fn to_payload(&self) -> Result<Vec<u8>> {
        encode("metadata", self)
    }

    /// Decodes and checks the payload of a `META` chunk.
    ///
    /// # Errors
    /// When it is not one, or [`Meta::check`] refuses it.
    pub fn from_payload(bytes: &[u8], limits: &Limits) -> Result<Self> {
        let meta: Self = decode("metadata", bytes, limits)?;
        meta.check(limits).map_err(|detail| Error::decode("metadata", detail))?;
        Ok(meta)
    }

    /// Whether a trace may have this metadata: every number possible, and nothing over a limit.
    ///
    /// # Errors
    /// Says which number is not possible.
    pub fn check(&self, limits: &Limits) -> std::result::Result<(), String> {
        let range = |name: &str, value: u32, low: u32, high: u32| {
            if (low..=high).contains(&value) { Ok(()) } else { Err(format!("{name} is {value}, not {low} to {high}")) }
        };
        range("samples per pixel and axis", self.samples, 1, 8)?;
        range("image width", self.width, 1, MAX_GRID / self.samples)?;
        range("image height", self.height, 1, MAX_GRID / self.samples)?;
        range("tile edge", self.tile, 1, 1024)?;
        let samples = u64::from(self.tile) * u64::from(self.tile);
        if samples > limits.max_samples_per_tile {
            return Err(format!("a tile has {samples} samples, over the limit of {}", limits.max_samples_per_tile));
        }
        range("maximum depth", self.max_depth, 0, MAX_DEPTH)?;
        range("number of lights", self.lights.len() as u32, 0, MAX_LIGHTS as u32)?;
        range("number of frames", self.frames, 1, u32::MAX - self.first_frame)?;
        self.check_tile_count(limits)?;
        let pixels = u64::from(self.width) * u64::from(self.height);
        if pixels > limits.max_pixels {
            return Err(format!("a frame has {pixels} pixels, over the limit of {}", limits.max_pixels));
        }
        if !self.lights.iter().all(light_is_finite) || !self.min_weight.is_finite() {
            return Err("a number is not finite".into());
        }
        Ok(())
    }

    /// In 64 bits: a grid of 2^20 x 2^20 samples in tiles of one has more tiles than `tile_count` can say.
    fn check_tile_count(&self, limits: &Limits) -> std::result::Result<(), String> {
        let (columns, rows) = self.tile_grid();
        let tiles_per_frame = u64::from(columns) * u64::from(rows);
        let tiles = tiles_per_frame.saturating_mul(u64::from(self.frames));
        if tiles_per_frame > u64::from(u32::MAX) || tiles > limits.max_index_entries {
            return Err(format!("{tiles} tiles, over the limit of {}", limits.max_index_entries));
        }
        Ok(())
    }
}

fn light_is_finite(light: &Light) -> bool {
    match light {
        Light::Point { position, colour } => position.is_finite() && colour.is_finite(),
        Light::Directional { to_light, colour } => to_light.is_finite() && colour.is_finite(),
    }
}

impl Camera {
    /// The payload of a `FRAM` chunk.
    ///
    /// # Errors
    /// Those of the encoder, of which a camera meets none: its size is fixed and far below the limit.
    pub fn to_payload(&self) -> Result<Vec<u8>> {
        encode("camera", self)
    }

    /// Decodes the payload of a `FRAM` chunk.
    ///
    /// # Errors
    /// When it is not a camera of finite numbers.
    pub fn from_payload(bytes: &[u8], limits: &Limits) -> Result<Self> {
        let camera: Self = decode("camera", bytes, limits)?;
        if [camera.eye, camera.corner, camera.right, camera.down].iter().all(|v| v.is_finite()) {
            Ok(camera)
        } else {
            Err(Error::decode("camera", "a number is not finite"))
        }
    }
}
