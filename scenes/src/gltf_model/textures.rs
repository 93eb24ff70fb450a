//! Pictures of a glTF file: decoded once each; cut-outs scaled so that their cutoff becomes one half.

use std::borrow::Cow;

use glam::{DVec3, Vec3};
use gltf::texture::WrappingMode;
use image::RgbaImage;

use super::{document::Source, uri};
use crate::{
    error::SceneError,
    pictures,
    scene::{MAX_TEXTURE_SIDE, Texture, Wrap},
    warnings::Warnings,
};

/// Most texels of all pictures of a file: four of the largest.
const MAX_TEXELS: u64 = 4 * (MAX_TEXTURE_SIDE as u64) * (MAX_TEXTURE_SIDE as u64);
/// Most bytes of a packed picture.
const MAX_PACKED: u64 = 1 << 30;

/// A format that an extension of glTF allows and that is not read, beside [those of files](pictures::OTHER_ENDINGS).
const BASIS: &str = "basis";

/// A picture and what is made of it: as it is, or with its alpha scaled for a cutoff (the bits of alpha factor and cutoff); and what lies
/// beyond its edges.
type Key = (Image, Option<[u32; 2]>);

/// A picture, and what its sampler says of its edges.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Image {
    pub index: usize,
    pub wrap: [Wrap; 2],
}

/// The textures of a model.
#[derive(Default)]
pub(crate) struct Pictures {
    keys: Vec<Key>,
    list: Vec<Texture>,
    texels: u64,
}

/// What a material's texture names.
pub(crate) enum Named {
    /// This picture.
    Picture(Image),
    /// A picture in a format that is not read.
    NotRead,
}

impl Pictures {
    /// The picture behind a texture.
    pub fn named(source: &Source, texture: &gltf::Texture<'_>, warnings: &mut Warnings) -> Named {
        let image = texture.source().map(|image| image.index());
        let other = image.and_then(|index| other_format(source, index));
        match (image, other) {
            (Some(index), None) => Named::Picture(Image { index, wrap: wraps(&texture.sampler()) }),
            (_, kind) => {
                let kind = kind.unwrap_or("other formats than PNG and JPEG");
                warnings.add("picture format", || {
                    format!(
                        "{}: texture {}: pictures in {kind} are not read, and the plain colour is used; convert them to PNG",
                        source.path.display(),
                        texture.index()
                    )
                });
                Named::NotRead
            }
        }
    }

    /// The texture of a picture as it is.
    pub fn plain(&mut self, source: &Source, image: Image) -> Result<usize, SceneError> {
        if let Some(known) = self.keys.iter().position(|key| *key == (image, None)) {
            return Ok(known);
        }
        let texture = match self.kept(image.index) {
            Some(other) => {
                let copy = self.list[other].clone();
                self.count(source, copy.texels.len() as u64)?;
                copy
            }
            None => self.decode(source, image.index)?,
        };
        Ok(self.add((image, None), Texture { wrap: image.wrap, ..texture }))
    }

    /// A texture that has the texels of a picture as they are.
    fn kept(&self, index: usize) -> Option<usize> {
        self.keys.iter().position(|(image, cut)| image.index == index && cut.is_none())
    }

    /// The cut-out of a picture whose alpha times `factor` must reach `cutoff`; `None` where all of it does.
    pub fn cut_out(
        &mut self,
        source: &Source,
        image: Image,
        factor: f32,
        cutoff: f32,
    ) -> Result<Option<usize>, SceneError> {
        let key = (image, Some([factor.to_bits(), cutoff.to_bits()]));
        if let Some(known) = self.keys.iter().position(|k| *k == key) {
            return Ok(Some(known));
        }
        let plain = self.plain(source, image)?;
        let scaled: Vec<u8> = (0..=255).map(|alpha| scale(alpha, factor, cutoff)).collect();
        let texels = &self.list[plain].texels;
        if texels.iter().all(|texel| scaled[usize::from(texel[3])] >= 128) {
            return Ok(None);
        }
        if scaled.iter().enumerate().all(|(alpha, new)| usize::from(*new) == alpha) {
            return Ok(Some(plain));
        }
        let mut copy = self.list[plain].clone();
        self.count(source, copy.texels.len() as u64)?;
        copy.texels.iter_mut().for_each(|texel| texel[3] = scaled[usize::from(texel[3])]);
        Ok(Some(self.add(key, copy)))
    }

    /// Whether nothing is left of what is cut out by a texture.
    pub fn is_cut_away(&self, texture: usize) -> bool {
        self.list[texture].texels.iter().all(|texel| texel[3] < 128)
    }

    /// The mean of each channel of a picture, as fractions of the largest value. The picture is not kept.
    pub fn mean(&mut self, source: &Source, image: Image) -> Result<[f64; 4], SceneError> {
        self.mean_of(source, image, |value| f64::from(value) / 255.0)
    }

    /// The mean colour of a picture in sRGB, linear. The picture is not kept.
    pub fn mean_colour(&mut self, source: &Source, image: Image) -> Result<Vec3, SceneError> {
        let linear: [f64; 256] = std::array::from_fn(|value| pictures::srgb_to_linear(value as f64 / 255.0));
        let [r, g, b, _] = self.mean_of(source, image, |value| linear[usize::from(value)])?;
        Ok(DVec3::new(r, g, b).as_vec3())
    }

    /// The mean of each channel, whose values mean what `value` says.
    fn mean_of(&mut self, source: &Source, image: Image, value: impl Fn(u8) -> f64) -> Result<[f64; 4], SceneError> {
        let decoded;
        let texture = match self.kept(image.index) {
            Some(at) => &self.list[at],
            None => {
                decoded = self.decode(source, image.index)?;
                self.texels -= decoded.texels.len() as u64;
                &decoded
            }
        };
        let mut counts = [[0_u64; 256]; 4];
        for texel in &texture.texels {
            (0..4).for_each(|c| counts[c][usize::from(texel[c])] += 1);
        }
        let sum = |counts: [u64; 256]| (0..=255).zip(counts).map(|(v, count)| value(v) * count as f64).sum::<f64>();
        Ok(counts.map(|counts| sum(counts) / texture.texels.len().max(1) as f64))
    }

    /// The textures in the order of their indices.
    pub fn into_list(self) -> Vec<Texture> {
        self.list
    }

    fn add(&mut self, key: Key, texture: Texture) -> usize {
        self.keys.push(key);
        self.list.push(texture);
        self.list.len() - 1
    }

    fn count(&mut self, source: &Source, texels: u64) -> Result<(), SceneError> {
        self.texels += texels;
        if self.texels <= MAX_TEXELS {
            return Ok(());
        }
        let what = format!("its pictures have more than {MAX_TEXELS} texels");
        Err(SceneError::Limit { at: source.at("images"), what, fix: "make them smaller".into() })
    }

    fn decode(&mut self, source: &Source, index: usize) -> Result<Texture, SceneError> {
        let part = format!("image {index}");
        let at = source.at(&part);
        let image = &source.root().images[index];
        let name = image.name.clone().or_else(|| image.uri.clone().filter(|uri| !uri.starts_with("data:")));
        let name = name.unwrap_or_else(|| part.clone());
        let pixels: RgbaImage = match (image.buffer_view, &image.uri) {
            (Some(view), _) => pictures::decode_bytes(&at, &name, source.view(&part, view.value())?)?,
            (None, Some(uri)) => {
                pictures::decode_bytes(&at, &name, &uri::read(&source.path, &at, "texture", uri, MAX_PACKED)?)?
            }
            (None, None) => {
                return Err(source.bad(part, "it has neither a URI nor a buffer view", "export the model again"));
            }
        };
        self.count(source, u64::from(pixels.width()) * u64::from(pixels.height()))?;
        let texels = pixels.pixels().map(|pixel| pixel.0).collect();
        Ok(Texture { name, width: pixels.width(), height: pixels.height(), texels, wrap: [Wrap::Repeat; 2] })
    }
}

/// The format of a picture, if it is one that is not read: as the file says, and in a data URI as its first bytes do.
fn other_format(source: &Source, index: usize) -> Option<&'static str> {
    let image = &source.root().images[index];
    let uri = image.uri.as_deref().unwrap_or("");
    let (inside, ending) = (uri::mime_type(uri), uri.to_lowercase());
    let mime = image.mime_type.as_ref().map(|mime| mime.0.to_lowercase());
    let is = |kind: &str| match &inside {
        Some(inside) => *inside == format!("image/{kind}"),
        None => mime == Some(format!("image/{kind}")) || ending.ends_with(&format!(".{kind}")),
    };
    let stated = || pictures::OTHER_ENDINGS.into_iter().chain([BASIS]).find(|kind| is(kind));
    // What cannot be had is an error when the picture is decoded.
    let begin = || match image.buffer_view {
        Some(view) => source.view("image", view.value()).ok().map(Cow::from),
        None => uri::head(&source.path, uri, pictures::HEAD).map(Cow::from),
    };
    if inside.is_some() && begin().is_some_and(|begin| pictures::is_read(&begin)) {
        return None;
    }
    stated().or_else(|| pictures::other_format(&begin()?))
}

/// What a sampler says of the edges.
fn wraps(sampler: &gltf::texture::Sampler<'_>) -> [Wrap; 2] {
    [sampler.wrap_s(), sampler.wrap_t()].map(|mode| match mode {
        WrappingMode::Repeat => Wrap::Repeat,
        WrappingMode::MirroredRepeat => Wrap::Mirror,
        WrappingMode::ClampToEdge => Wrap::Clamp,
    })
}

/// Alpha so that one half is where `alpha * factor` reaches `cutoff`: what a cut-out of the scene compares with. The map is
/// affine, so that between two texels the edge lies where the file has it; of those that stay within 0 and 1 it is the steepest.
fn scale(alpha: u8, factor: f32, cutoff: f32) -> u8 {
    let (value, cutoff) = (f64::from(alpha) / 255.0 * f64::from(factor), f64::from(cutoff));
    let half = if cutoff < 0.5 { 1.0 - (1.0 - value) * 0.5 / (1.0 - cutoff) } else { value * 0.5 / cutoff };
    let nearest = (half * 255.0).round() as u8;
    // Rounding must not carry a texel over the edge.
    if value < cutoff { nearest.min(127) } else { nearest.max(128) }
}

#[cfg(test)]
mod tests {
    use super::scale;

    /// It lay in the middle between a hole and what is whole, whatever the cutoff.
    #[test]
    fn the_edge_between_texels_lies_at_the_cutoff() {
        for (cutoff, factor) in [(0.25, 1.0), (0.5, 1.0), (0.75, 1.0), (0.25, 0.5), (0.3, 0.4)] {
            for (low, high) in [(0, 255), (20, 250)] {
                let [from, to] = [low, high].map(|alpha| f64::from(scale(alpha, factor, cutoff)) / 255.0);
                let [low, high] = [low, high].map(|alpha| f64::from(alpha) / 255.0 * f64::from(factor));
                let (edge, wanted) = ((0.5 - from) / (to - from), (f64::from(cutoff) - low) / (high - low));
                assert!((edge - wanted).abs() < 0.02, "cutoff {cutoff}, factor {factor}: {edge}, not {wanted}");
            }
        }
    }

    #[test]
    fn each_texel_stays_on_its_side_of_the_cutoff() {
        for cutoff in (0..=110).map(|percent| percent as f32 / 100.0) {
            for (alpha, factor) in (0..=255).flat_map(|alpha| [(alpha, 1.0_f32), (alpha, 0.7)]) {
                let is_shown = f64::from(alpha) / 255.0 * f64::from(factor) >= f64::from(cutoff);
                assert_eq!(scale(alpha, factor, cutoff) >= 128, is_shown, "{alpha} of {factor} at {cutoff}");
            }
        }
        assert!((0..=255).all(|alpha| scale(alpha, 1.0, 0.5) == alpha), "nothing to change");
    }
}
