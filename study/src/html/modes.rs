//! Modes: what they are called, and the parts of a section that are one each.

use crate::html::text::escape;
use crate::html::view::StudyView;

/// A mode for people.
pub fn mode_name(mode: &str) -> String {
    match mode {
        "2x2" => "Supersampling".into(),
        "1x1" => "Undersampling".into(),
        other => other.into(),
    }
}

/// What a mode is compared with.
pub fn mode_reference(mode: &str) -> String {
    match mode {
        "2x2" => "FSAA 2×2".into(),
        "1x1" => "standard 1×1".into(),
        other => format!("full {other}"),
    }
}

/// What `part` makes of each mode, under the mode's name; the script shows one mode at a time.
pub fn by_mode(view: &StudyView<'_>, mut part: impl FnMut(&str) -> String) -> String {
    let mut html = String::new();
    for mode in view.modes() {
        let part_html = part(mode);
        if part_html.is_empty() {
            continue;
        }
        let name = escape(&mode_name(mode));
        let against = escape(&format!("against {}", mode_reference(mode)));
        html += &format!(
            "<div class=\"mode\" data-mode=\"{}\" data-name=\"{name}\"><h3>{name} <small>{against}</small></h3>\n{part_html}</div>\n",
            escape(mode)
        );
    }
    html
}
