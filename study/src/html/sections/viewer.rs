//! The pictures: a gallery that reads and prints as it is, and the viewer that the script makes of it.

use std::collections::BTreeMap;

use serde_json::{Value, json};

use crate::html::error::ReportError;
use crate::html::modes::mode_name;
use crate::html::parts::{Section, how_to_read};
use crate::html::text::{base64, escape, script_json};
use crate::html::view::StudyView;
use crate::schema::{Study, TileFigures, ViewerImages, ViewerSet};

/// The PNG files of a study, each once.
pub struct Pictures(BTreeMap<String, Vec<u8>>);

impl Pictures {
    /// Reads every picture that the study names.
    ///
    /// # Errors
    /// The first that `read` gives.
    pub fn load(study: &Study, read: impl Fn(&str) -> Result<Vec<u8>, ReportError>) -> Result<Self, ReportError> {
        let of_set = study.viewer.iter().flat_map(|set| files(&set.images)).filter_map(|(_, file)| file);
        let of_map =
            study.maps.iter().flat_map(|m| [Some(m.similarity.as_str()), m.rate.as_deref(), m.picture.as_deref()]);
        let mut all = BTreeMap::new();
        for name in of_set.chain(of_map.flatten()) {
            if !all.contains_key(name) {
                all.insert(name.to_owned(), read(name)?);
            }
        }
        Ok(Self(all))
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Bytes of all files.
    pub fn bytes(&self) -> usize {
        self.0.values().map(Vec::len).sum()
    }

    /// A picture as an element; `extra` are more attributes, already escaped.
    pub fn img(&self, name: &str, alt: &str, extra: &str) -> Option<String> {
        let bytes = self.0.get(name)?;
        // Width and height stand behind the signature and the head of the first chunk.
        let size = |at: usize| bytes.get(at..at + 4).and_then(|b| b.try_into().ok()).map_or(0, u32::from_be_bytes);
        Some(format!(
            "<img src=\"data:image/png;base64,{}\" width=\"{}\" height=\"{}\" alt=\"{}\" loading=\"lazy\" \
             decoding=\"async\"{extra}>",
            base64(bytes),
            size(16),
            size(20),
            escape(alt)
        ))
    }
}

/// The pictures of a set with their names, in the order in which they are shown.
fn files(images: &ViewerImages) -> [(&'static str, Option<&str>); 6] {
    [
        ("reference", images.reference.as_deref()),
        ("result", images.result.as_deref()),
        ("error", images.error.as_deref()),
        ("FLIP", images.flip.as_deref()),
        ("similarity", images.similarity.as_deref()),
        ("rate", images.rate.as_deref()),
    ]
}

fn name(set: &ViewerSet) -> String {
    format!("{} · {} · {}", set.scene, mode_name(&set.mode).to_lowercase(), set.policy)
}

/// The section.
pub fn section(view: &StudyView<'_>, pictures: &Pictures) -> Option<Section> {
    let shown = |set: &&ViewerSet| files(&set.images).iter().any(|(_, file)| file.is_some());
    let sets: Vec<&ViewerSet> = view.study.viewer.iter().filter(shown).collect();
    if sets.is_empty() {
        return None;
    }
    let mut ids: BTreeMap<&str, usize> = BTreeMap::new();
    let (mut gallery, mut data) = (String::new(), Vec::new());
    let all = sets.len() == view.study.points.len();
    let note = if all { "" } else { "<p>Here are the pictures of some of the policies only.</p>\n" };
    for set in &sets {
        gallery += &format!("<h3>{}</h3>\n<div class=\"pictures\">\n", escape(&name(set)));
        let mut images = serde_json::Map::new();
        for (what, file) in files(&set.images) {
            let Some(file) = file else { continue };
            let next = ids.len();
            let id = *ids.entry(file).or_insert(next);
            images.insert(what.into(), id.into());
            let body = if id == next {
                let alt = format!("{what}: {}", name(set));
                pictures.img(file, &alt, &format!(" id=\"picture-{id}\"")).unwrap_or_default()
            } else {
                "<span class=\"above\">as above</span>".into()
            };
            gallery += &format!("<figure>{body}<figcaption>{what}</figcaption></figure>\n");
        }
        gallery += "</div>\n";
        data.push(json!({
            "name": name(set), "width": set.width, "height": set.height, "tile": set.tile_px, "images": images,
            "tiles": set.tiles.iter().map(tile).collect::<Vec<_>>(),
        }));
    }
    let html = format!(
        "{note}{}<div class=\"gallery\">\n{gallery}</div>\n<script type=\"application/json\" id=\"viewer-data\">{}</script>\n",
        include_str!("../viewer.html"),
        script_json(&Value::Array(data))
    ) + &how_to_read(
        "Reference is every sample traced; result is the policy's picture; error is their difference, amplified; FLIP is where a viewer \
         sees that difference (FLIP), from black to yellow. In the \
         similarity map yellow was interpolated, blue was traced, and of green a part of the rays was traced; a sample that is always traced \
         has the mean of its block. The rate map shows the share of traced samples in each tile, from dark blue (none) over green (a \
         quarter) to light yellow (all). Tile numbers are those of the policy's picture.",
    );
    Section::new("pictures", "Pictures", html)
}

/// A tile for the script, without names: there may be thousands.
fn tile(tile: &TileFigures) -> Value {
    let round = |v: f64, scale: f64| (v * scale).round() / scale;
    json!([
        tile.rays_full,
        tile.rays_traced,
        round(tile.mean_rate, 1e4),
        tile.similarity_ratio.map(|v| round(v, 1e4)),
        tile.psnr_db.map(|v| round(v, 1e2))
    ])
}
