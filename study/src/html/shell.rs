//! The frame of every page: one file with its style and scripts, head, contents, sections, foot.

use serde_json::Value;

use crate::html::parts::Section;
use crate::html::text::{escape, script_json};

/// Colours by name, rules for charts, and the rest.
const STYLE: &str =
    concat!(include_str!("charts/colours.css"), include_str!("charts/chart.css"), include_str!("style.css"));

/// Nothing is loaded from anywhere, whatever the data may hold.
const POLICY: &str = "default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src 'unsafe-inline'; \
                      base-uri 'none'; form-action 'none'";

/// A page. Fields described as HTML are written as they are; all other text is escaped.
pub struct Shell<'a> {
    /// Title.
    pub title: &'a str,
    /// What stands above all sections: HTML.
    pub head: &'a str,
    /// The sections.
    pub sections: &'a [Section],
    /// What stands below: HTML.
    pub foot: &'a str,
    /// Style beyond that of all pages.
    pub style: &'a str,
    /// What scripts read: the id of the element that holds it.
    pub data: Option<(&'a str, &'a Value)>,
    /// The scripts.
    pub scripts: &'a [&'a str],
}

impl Shell<'_> {
    /// The whole page.
    pub fn html(&self) -> String {
        let entry = |s: &Section| format!("<li><a href=\"#{}\">{}</a></li>\n", s.id, escape(&s.title));
        let contents: String = self.sections.iter().map(entry).collect();
        let body: String = self.sections.iter().map(section).collect();
        let data = |(id, value): (&str, &Value)| {
            format!("<script type=\"application/json\" id=\"{id}\">{}</script>\n", script_json(value))
        };
        let scripts: Vec<String> = self.scripts.iter().map(|script| format!("<script>\n{script}</script>\n")).collect();
        format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
             <meta http-equiv=\"Content-Security-Policy\" content=\"{POLICY}\">\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
             <meta name=\"color-scheme\" content=\"light dark\">\n<title>{title}</title>\n\
             <link rel=\"icon\" href=\"data:,\">\n<style>\n{STYLE}{style}</style>\n</head>\n<body>\n\
             <a class=\"skip\" href=\"#main\">Skip to the results</a>\n{head}\
             <div class=\"layout\">\n<nav aria-label=\"Contents\"><ul>\n{contents}</ul></nav>\n\
             <main id=\"main\">\n{body}</main>\n</div>\n{foot}\
             <div id=\"tip\" role=\"status\" hidden></div>\n{data}{scripts}</body>\n</html>\n",
            title = escape(self.title),
            style = self.style,
            head = self.head,
            foot = self.foot,
            data = self.data.map(data).unwrap_or_default(),
            scripts = scripts.concat(),
        )
    }
}

fn section(section: &Section) -> String {
    format!(
        "<section id=\"{id}\" aria-labelledby=\"{id}-title\">\n<h2 id=\"{id}-title\">{}</h2>\n{}</section>\n",
        escape(&section.title),
        section.html,
        id = section.id
    )
}
