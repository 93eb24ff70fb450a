//! Similarity and rate over the frames of a path: the paper's Figure 4.

use crate::html::parts::{Section, how_to_read};
use crate::html::sections::viewer::Pictures;
use crate::html::text::{escape, fixed, percent};
use crate::html::view::StudyView;
use crate::schema::Map;

/// The section.
pub fn section(view: &StudyView<'_>, pictures: &Pictures) -> Option<Section> {
    let maps = &view.study.maps;
    let mut groups: Vec<(&str, &str)> = Vec::new();
    for map in maps {
        if !groups.contains(&(&map.scene, &map.policy)) {
            groups.push((&map.scene, &map.policy));
        }
    }
    let mut html = String::new();
    for (scene, policy) in &groups {
        let frames = maps.iter().filter(|m| m.scene == *scene && m.policy == *policy);
        html += &format!("<h3>{} <small>{}</small></h3>\n<div class=\"maps\">\n", escape(scene), escape(policy));
        frames.for_each(|map| html += &frame(map, pictures));
        html += "</div>\n";
    }
    if !html.is_empty() {
        html += &how_to_read(
            "One column a frame. Similarity: yellow was interpolated, blue was traced, and of green a part of the rays was traced. Rate: the \
             share of traced samples in each tile, from dark blue (none) over green (a quarter) to light yellow (all). Where similarity changes from tile to tile or from frame to frame, \
             a rate for each tile makes use of it.",
        );
    }
    Section::new("maps", "Similarity and rate over frames", html)
}

fn frame(map: &Map, pictures: &Pictures) -> String {
    let image = |what: &str, name: &str| {
        let alt = format!("{what} of {}, frame {}", map.scene, map.frame);
        pictures.img(name, &alt, "").unwrap_or_default()
    };
    let mut html = map.picture.as_deref().map(|name| image("Picture", name)).unwrap_or_default();
    html += &image("Similarity map", &map.similarity);
    html += &map.rate.as_deref().map(|name| image("Rate map", name)).unwrap_or_default();
    let similar = map.similarity_ratio.map(|r| format!("{} similar", percent(r))).unwrap_or_default();
    let paper = map.paper_ratio.map(|r| format!(" (paper {})", percent(r))).unwrap_or_default();
    format!(
        "<figure>{html}<figcaption><strong>frame {}</strong><br>{similar}{paper}<br>mean rate {}</figcaption></figure>\n",
        map.frame,
        fixed(map.mean_rate, 3)
    )
}
