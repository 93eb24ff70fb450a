//! Pieces of HTML that sections share. Arguments called `html` are HTML already; all others are escaped here.

use crate::html::charts::svg::line;
use crate::html::text::escape;

/// A section of the page.
pub struct Section {
    /// Anchor.
    pub id: &'static str,
    /// Heading.
    pub title: String,
    /// HTML below the heading.
    pub html: String,
}

impl Section {
    /// A section, unless it is empty.
    pub fn new(id: &'static str, title: &str, html: String) -> Option<Self> {
        (!html.is_empty()).then(|| Self { id, title: title.into(), html })
    }
}

/// A paragraph that says how to read what stands above it.
pub fn how_to_read(text: &str) -> String {
    format!("<p class=\"read\">{}</p>\n", escape(text))
}

/// A grid of cards.
pub fn grid(html: &str) -> String {
    format!("<div class=\"grid\">\n{html}</div>\n")
}

/// The head of a column.
pub struct Head {
    /// Its text.
    pub name: String,
    /// Whether the column holds numbers, which stand right.
    pub number: bool,
}

impl Head {
    /// A column of words.
    pub fn words(name: &str) -> Self {
        Self { name: name.into(), number: false }
    }

    /// A column of numbers.
    pub fn number(name: &str) -> Self {
        Self { name: name.into(), number: true }
    }
}

/// A table; the first cell of a row heads it. `rows` hold a class and cells, which are HTML.
pub fn table(caption: &str, columns: &[Head], rows: &[(String, Vec<String>)]) -> String {
    let class = |column: &Head| if column.number { " class=\"num\"" } else { "" };
    let head = |c: &Head| format!("<th scope=\"col\"{}>{}</th>", class(c), escape(&c.name));
    let row = |(row_class, cells): &(String, Vec<String>)| {
        let cell = |(i, (column, html)): (usize, (&Head, &String))| match i {
            0 => format!("<th scope=\"row\"{}>{html}</th>", class(column)),
            _ => format!("<td{}>{html}</td>", class(column)),
        };
        let cells: String = columns.iter().zip(cells).enumerate().map(cell).collect();
        let row_class = if row_class.is_empty() { String::new() } else { format!(" class=\"{row_class}\"") };
        format!("<tr{row_class}>{cells}</tr>\n")
    };
    let (head, body): (String, String) = (columns.iter().map(head).collect(), rows.iter().map(row).collect());
    format!(
        "<div class=\"scroll{many}\" tabindex=\"0\" role=\"region\" aria-label=\"{label}\"><table><caption>{label}</caption>\
         <thead><tr>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n",
        label = escape(caption),
        // Wide ones get smaller type on paper.
        many = if columns.len() > 11 { " many" } else { "" }
    )
}

/// An entry of a legend: a square of a colour class, and what it stands for.
pub fn key(class: &str, name: &str) -> String {
    key_shade(class, 1.0, name)
}

/// The same in a shade of the colour, from 0 to 1.
pub fn key_shade(class: &str, shade: f64, name: &str) -> String {
    let opacity = if shade < 1.0 { format!(" opacity=\"{shade:.2}\"") } else { String::new() };
    let square = format!("<rect x=\"2\" y=\"2\" width=\"12\" height=\"12\" class=\"{class}\"{opacity}/>");
    symbol(&square, name)
}

/// An entry of a legend: a drawing of 16 by 16 units, and what it stands for.
pub fn symbol(svg: &str, name: &str) -> String {
    format!("<li><svg viewBox=\"0 0 16 16\" aria-hidden=\"true\">{svg}</svg>{}</li>", escape(name))
}

/// An entry of a legend: a line as a chart draws it, and what it stands for.
pub fn line_key(class: &str, dash: &str, name: &str) -> String {
    let svg = line([0.0, 28.0], 8.0, class, dash);
    format!("<li><svg class=\"long\" viewBox=\"0 0 28 16\" aria-hidden=\"true\">{svg}</svg>{}</li>", escape(name))
}

/// A legend of entries.
pub fn legend(html: &str) -> String {
    format!("<ul class=\"legend\">{html}</ul>\n")
}

/// Something to unfold.
pub fn details(summary: &str, html: &str) -> String {
    format!("<details><summary>{}</summary>\n{html}</details>\n", escape(summary))
}
