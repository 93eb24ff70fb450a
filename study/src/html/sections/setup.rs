//! What was rendered and how: scenes and policies.

use crate::html::modes::mode_name;
use crate::html::parts::{Head, Section, details, table};
use crate::html::text::{count, escape, fixed, or_dash};
use crate::html::view::{StudyView, has_counterpart};

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let html = scenes(view) + &policies(view);
    Section::new("setup", "Scenes and policies", html)
}

fn scenes(view: &StudyView<'_>) -> String {
    let all = &view.study.scenes;
    if all.is_empty() {
        return String::new();
    }
    let mut modes: Vec<&str> = Vec::new();
    for mode in all.iter().flat_map(|s| s.rays_full.iter().map(|r| r.mode.as_str())) {
        if !modes.contains(&mode) {
            modes.push(mode);
        }
    }
    let mut columns = vec![
        Head::words("Scene"),
        Head::number("Triangles"),
        Head::number("The paper's"),
        Head::number("Lights"),
        Head::number("Frame"),
    ];
    columns.extend(modes.iter().map(|mode| Head::number(&format!("Rays, {}", mode_name(mode).to_lowercase()))));
    let row = |scene: &crate::schema::Scene| {
        // Its name alone makes no scene of the paper's.
        let paper = scene.paper_triangles.filter(|_| has_counterpart(scene)).map(|n| {
            format!(
                "{} <small>({}{}\u{202f}%)</small>",
                count(n),
                sign(scene.triangles, n),
                fixed(100.0 * (scene.triangles as f64 / n as f64 - 1.0), 1)
            )
        });
        let mut cells = vec![
            escape(&scene.name),
            count(scene.triangles),
            or_dash(paper, |p| p),
            scene.lights.to_string(),
            scene.frame.to_string(),
        ];
        let rays = |mode: &&str| or_dash(scene.rays_full.iter().find(|r| r.mode == *mode), |r| count(r.rays));
        cells.extend(modes.iter().map(rays));
        (String::new(), cells)
    };
    "<h3>Scenes</h3>\n".to_owned() + &table("Scenes", &columns, &all.iter().map(row).collect::<Vec<_>>())
}

fn sign(measured: u64, paper: u64) -> &'static str {
    if measured > paper { "+" } else { "" }
}

fn policies(view: &StudyView<'_>) -> String {
    let policy = |p: &crate::schema::Policy| {
        let file = if p.config_toml.is_empty() {
            String::new()
        } else {
            details(
                &format!("{}: every value", p.name),
                &format!("<pre tabindex=\"0\">{}</pre>", escape(&p.config_toml)),
            )
        };
        format!("<dt>{}</dt><dd>{}{file}</dd>\n", escape(&p.name), escape(&p.summary))
    };
    let all: String = view.study.policies.iter().map(policy).collect();
    if all.is_empty() { all } else { format!("<h3>Policies</h3>\n<dl class=\"policies\">\n{all}</dl>\n") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::{Scene, Study};

    /// A model of a user stood beside the paper's scene of that name, 99 % smaller.
    #[test]
    fn a_scene_stands_beside_the_papers_only_if_it_is_like_it() {
        let page = |triangles| {
            let scene = Scene { name: "teapot".into(), triangles, paper_triangles: Some(15_000), ..Scene::default() };
            scenes(&StudyView::new(&Study { scenes: vec![scene], ..Study::default() }))
        };
        let paper = count(15_000);
        assert!(page(15_168).contains(&paper) && page(15_168).contains("+1.1"));
        assert!(!page(12).contains(&paper), "{}", page(12));
    }
}
