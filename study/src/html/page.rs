//! The page of a study: its head and foot around its sections.

use crate::html::charts::file::Saved;
use crate::html::sections::{self, viewer::Pictures};
use crate::html::shell::Shell;
use crate::html::text::{bytes, escape};
use crate::html::view::StudyView;
use crate::schema::Study;

const SCRIPT: &str = include_str!("script.js");
const VIEWER: &str = include_str!("viewer.js");

/// The whole page, and its charts.
pub fn page(study: &Study, pictures: &Pictures) -> (String, Vec<Saved>) {
    let view = StudyView::new(study);
    let sections = sections::all(&view, pictures);
    let title = if study.title.is_empty() { "Rayreel report" } else { &study.title };
    let html = Shell {
        title,
        head: &head(study, title),
        sections: &sections,
        foot: &foot(study, pictures),
        style: "",
        data: None,
        scripts: &[SCRIPT, VIEWER],
    }
    .html();
    (html, view.charts.into_saved())
}

fn head(study: &Study, title: &str) -> String {
    let mut facts = Vec::new();
    if !study.scenes.is_empty() {
        let scenes = study.scenes.len();
        facts.push(if scenes == 1 { "1 scene".into() } else { format!("{scenes} scenes") });
    }
    if study.width > 0 {
        facts.push(format!("{} × {} pixels", study.width, study.height));
    }
    facts.extend(study.machine.as_ref().map(|name| format!("machine {name}")));
    facts.extend(study.detail.as_ref().filter(|detail| *detail != "full").map(|detail| format!("detail {detail}")));
    let facts: String = facts.iter().map(|f| format!("<li>{}</li>", escape(f))).collect();
    let command = if study.command.is_empty() {
        String::new()
    } else {
        format!(
            "<p class=\"command\"><span>Repeat it:</span> <code tabindex=\"0\">{}</code></p>\n",
            escape(&study.command)
        )
    };
    format!(
        "<header>\n<div><h1>{}</h1>\n<ul class=\"facts\">{facts}</ul>\n{command}</div>\n\
         <button type=\"button\" id=\"theme\" hidden>Theme: system</button>\n</header>\n",
        escape(title)
    )
}

fn foot(study: &Study, pictures: &Pictures) -> String {
    format!(
        "<footer><p>Written by {}. This file holds everything it shows, {} pictures of {} among it; it loads nothing.</p></footer>\n",
        escape(&study.tool),
        pictures.len(),
        bytes(pictures.bytes())
    )
}
