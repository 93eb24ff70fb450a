//! Textures from files: decoded once each, with limits.

use std::path::{Path, PathBuf};

use image::RgbaImage;

use super::line::Map;
use crate::{
    error::{Location, SceneError},
    pictures,
    scene::{Texture, Wrap},
    warnings::Warnings,
};

/// The textures of a model; a file that several materials name is decoded once.
#[derive(Debug, Default)]
pub(crate) struct TextureSet {
    keys: Vec<(PathBuf, bool)>,
    textures: Vec<Texture>,
}

impl TextureSet {
    /// Loads a texture that a statement of the library at `path` names. A `mask` is a `map_d` with a picture of its own: where
    /// that is opaque, its luminance becomes alpha. None for a picture in a format that is not read, which is told.
    pub fn load(
        &mut self,
        path: &Path,
        Map { file, line, .. }: &Map,
        mask: bool,
        warnings: &mut Warnings,
    ) -> Result<Option<usize>, SceneError> {
        let key = (file.to_owned(), mask);
        if let Some(known) = self.keys.iter().position(|k| *k == key) {
            return Ok(Some(known));
        }
        let Some(mut image) = pictures::decode_file(&Location::line(path, *line), file)? else {
            warnings.add("picture format", || {
                format!(
                    "{}:{line}: `{}` is no PNG or JPEG, and the material is drawn without it; convert it to PNG",
                    path.display(),
                    file.display()
                )
            });
            return Ok(None);
        };
        if mask {
            luminance_to_alpha(&mut image);
        }
        let name = file.file_name().unwrap_or(file.as_os_str()).to_string_lossy().into_owned();
        let texels = image.pixels().map(|p| p.0).collect();
        self.textures.push(Texture {
            name,
            width: image.width(),
            height: image.height(),
            texels,
            wrap: [Wrap::Repeat; 2],
        });
        self.keys.push(key);
        Ok(Some(self.textures.len() - 1))
    }

    /// Whether a texel of a texture is not opaque.
    pub fn has_alpha(&self, texture: usize) -> bool {
        self.textures[texture].texels.iter().any(|texel| texel[3] != 255)
    }

    /// Whether nothing is left of what is cut out by a texture.
    pub fn is_cut_away(&self, texture: usize) -> bool {
        self.textures[texture].texels.iter().all(|texel| texel[3] < 128)
    }

    /// The files that were read; one that is colour and mask stands there twice.
    pub fn files(&self) -> impl Iterator<Item = PathBuf> {
        self.keys.iter().map(|(file, _)| file.clone())
    }

    /// The textures in the order of their indices.
    pub fn into_list(self) -> Vec<Texture> {
        self.textures
    }
}

/// Puts the luminance into alpha, unless the image already has a texel that is not opaque. Masks are often exported as RGBA
/// whose alpha says nothing.
fn luminance_to_alpha(image: &mut RgbaImage) {
    if image.pixels().any(|p| p.0[3] != 255) {
        return;
    }
    for p in image.pixels_mut() {
        let [r, g, b, _] = p.0.map(u32::from);
        // Rec. 709 weights in integers, so that every machine rounds alike.
        p.0[3] = ((r * 2126 + g * 7152 + b * 722 + 5000) / 10_000) as u8;
    }
}
