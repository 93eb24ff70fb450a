//! The page around the sections: head, contents, foot.

use super::parts::Section;
use super::sections::{self, viewer::Pictures};
use super::text::{bytes, escape};
use super::view::View;
use crate::report::study::Study;

const STYLE: &str = include_str!("style.css");
const SCRIPT: &str = include_str!("script.js");
const VIEWER: &str = include_str!("viewer.js");

/// Nothing is loaded from anywhere, whatever a study may hold.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      base-uri 'none'; form-action 'none'";

/// The whole page.
pub fn page(study: &Study, pictures: &Pictures) -> String {
    let view = View::new(study);
    let sections = sections::all(&view, pictures);
    let title = if study.title.is_empty() { "Rayreel report" } else { &study.title };
    let contents: String =
        sections.iter().map(|s| format!("<li><a href=\"#{}\">{}</a></li>\n", s.id, escape(&s.title))).collect();
    let body: String = sections.iter().map(section).collect();
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
         <link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}</style>\n</head>\n<body>\n\
         <a class=\"skip\" href=\"#main\">Skip to the results</a>\n{head}\
         <div class=\"layout\">\n<nav aria-label=\"Contents\"><ul>\n{contents}</ul></nav>\n\
         <main id=\"main\">\n{body}</main>\n</div>\n{foot}\
         <div id=\"tip\" role=\"status\" hidden></div>\n<script>\n{SCRIPT}</script>\n<script>\n{VIEWER}</script>\n</body>\n</html>\n",
        title = escape(title),
        head = head(study, title),
        foot = foot(study, pictures),
    )
}

fn section(section: &Section) -> String {
    format!(
        "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{}</h2>\n{}</section>\n",
        escape(&section.title),
        section.html,
        id = section.id
    )
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
