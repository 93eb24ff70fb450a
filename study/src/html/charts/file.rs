//! A chart as a file of its own: its style is in it, in light colours.

use std::fs;
use std::path::Path;

use crate::files::write_named;
use crate::html::ReportError;
use crate::html::charts::chart::{Chart, Key, Symbol};
use crate::html::charts::svg::{line, marker, n, text_width, told_apart};
use crate::html::text::escape;

/// The rules for charts; pages have them too.
const STYLE: &str = include_str!("chart.css");

/// Names of colours: `--name: light-dark(LIGHT, DARK);`.
const COLOURS: &str = include_str!("colours.css");

/// Room around a chart: what it draws may stand out a little.
const MARGIN: f64 = 12.0;

/// Height of a row of the legend.
const KEY_ROW: f64 = 18.0;

/// Edge of the square of a key; markers are about as large.
const SQUARE: f64 = 10.0;

/// Length of the line of a key: as long as the longest pattern of dashes and a little more.
const LINE: f64 = 28.0;

/// What a file has beside the rules.
const FONT: &str = ".chart{font-family:system-ui,\"Segoe UI\",Roboto,\"Noto Sans\",sans-serif}.page{fill:#fff}";

/// A chart as two files.
pub struct Saved {
    /// Name of the files, without ending.
    pub name: String,
    /// The picture, in light colours.
    pub svg: String,
    /// What it shows.
    pub csv: String,
}

/// A chart of a page as a document that needs no other file.
pub fn alone(chart: &Chart, title: &str) -> String {
    let [width, height] = size(&chart.svg);
    let (legend, below) = legend(&chart.keys, [width, height + MARGIN]);
    let (x, y) = (-MARGIN, -MARGIN);
    let (w, h) = (width + 2.0 * MARGIN, height + below + 2.0 * MARGIN);
    let inside = chart.svg.find('>').map_or("", |start| &chart.svg[start + 1..]).trim_end().trim_end_matches("</svg>");
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"chart\" viewBox=\"{x} {y} {w} {h}\" width=\"{w}\" height=\"{h}\">\
         <title>{}</title>\n<style>{FONT}{}</style>\n<rect class=\"page\" x=\"{x}\" y=\"{y}\" width=\"{w}\" height=\"{h}\"/>{}{legend}</svg>\n",
        escape(title),
        in_light(STYLE),
        inside
    )
}

/// What the colours mean, in rows from a place on that are so wide; and how high they are.
fn legend(keys: &[Key], [width, top]: [f64; 2]) -> (String, f64) {
    let (mut drawn, mut x, mut row) = (String::new(), 0.0, 0.0);
    // No name is wider than the chart.
    let widest = ((width + MARGIN - LINE - 5.0) / text_width("m")) as usize;
    let names = told_apart(&keys.iter().map(|key| key.name.as_str()).collect::<Vec<_>>(), widest);
    for (key, name) in keys.iter().zip(&names) {
        let symbol = match key.symbol {
            Symbol::Line(_) => LINE,
            Symbol::Word => -5.0,
            Symbol::Square | Symbol::Marker(_) => SQUARE,
        };
        let room = symbol + 20.0 + text_width(name);
        if x > 0.0 && x + room > width {
            (x, row) = (0.0, row + 1.0);
        }
        let y = top + row * KEY_ROW;
        let class = escape(&key.class);
        drawn += &match key.symbol {
            Symbol::Word => String::new(),
            Symbol::Line(dash) => line([x, x + LINE], y + SQUARE / 2.0, &class, dash),
            Symbol::Marker(shape) => {
                let place = marker(shape, x + SQUARE / 2.0, y + SQUARE / 2.0);
                format!("<path d=\"{place}\" class=\"dot {class}\"/>")
            }
            Symbol::Square => format!(
                "<rect x=\"{}\" y=\"{}\" width=\"{SQUARE}\" height=\"{SQUARE}\" data-mark=\"\" class=\"{class}\" fill-opacity=\"{}\"/>",
                n(x),
                n(y),
                n(key.opacity)
            ),
        };
        let (start, base) = (n(x + symbol + 5.0), n(y + 9.0));
        drawn += &format!("<text x=\"{start}\" y=\"{base}\">{}</text>", escape(name));
        x += room;
    }
    (drawn, if keys.is_empty() { 0.0 } else { (row + 1.0) * KEY_ROW + MARGIN })
}

/// The last two numbers of `viewBox`.
fn size(svg: &str) -> [f64; 2] {
    let numbers = svg.split("viewBox=\"").nth(1).and_then(|rest| rest.split('"').next()).unwrap_or_default();
    let mut numbers = numbers.split(' ').skip(2).map(|number| number.parse().unwrap_or(1.0));
    [numbers.next().unwrap_or(1.0), numbers.next().unwrap_or(1.0)]
}

/// The rules with the light value of each name in its place, for programs that know no names.
fn in_light(style: &str) -> String {
    let light = |line: &str| {
        let (name, value) = line.trim().split_once(": light-dark(")?;
        Some((format!("var({name})"), value.split(',').next()?.to_owned()))
    };
    COLOURS.lines().filter_map(light).fold(style.to_owned(), |style, (name, value)| style.replace(&name, &value))
}

/// Writes each chart into a folder as `NAME.svg` and `NAME.csv`; the folder is made.
///
/// # Errors
/// When a file cannot be written.
pub fn write(folder: &Path, charts: &[Saved]) -> Result<(), ReportError> {
    fs::create_dir_all(folder).map_err(|source| ReportError::Io { path: folder.to_path_buf(), source })?;
    for chart in charts {
        for (ending, text) in [("svg", &chart.svg), ("csv", &chart.csv)] {
            let file = folder.join(format!("{}.{ending}", chart.name));
            write_named(&file, text.as_bytes()).map_err(|e| ReportError::Write { source: Box::new(e) })?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::charts::chart::Data;

    #[test]
    fn a_file_has_its_colours_in_it() {
        let svg = "<svg class=\"chart\" viewBox=\"0 0 360 100\" role=\"img\"><rect class=\"p0\"/></svg>\n".to_owned();
        let names = ["one", "a name that is as long as half of it", "two & more"];
        let keys = names.iter().map(|name| Key::new("p0", name)).collect();
        let svg = alone(&Chart { svg, data: Data::new(&["x"]), keys }, "a < b");
        // The legend takes two rows: the first is full.
        assert!(svg.contains("viewBox=\"-12 -12 384 172\"") && svg.contains("<title>a &lt; b</title>"), "{svg}");
        assert!(!svg.contains("var(") && svg.contains(".p0 { fill: #0072b2; stroke: #0072b2; }"), "{svg}");
        assert!(
            svg.contains("<rect class=\"p0\"/><rect x=\"0\"") && svg.ends_with(">two &amp; more</text></svg>\n"),
            "{svg}"
        );
    }

    #[test]
    fn keys_of_lines_show_their_dashes() {
        let keys = [Key::of_line("p0", "", "one"), Key::of_line("p0", "2 3", "two")];
        let (drawn, _) = legend(&keys, [360.0, 0.0]);
        assert_eq!(drawn.matches("class=\"line p0\"").count(), 2);
        assert_eq!(drawn.matches(" stroke-dasharray=\"2 3\"").count(), 1, "{drawn}");
        assert!(!drawn.contains("<rect"), "{drawn}");
    }

    /// They ended where the picture does, and the last of too many were not mentioned.
    #[test]
    fn long_keys_are_cut_and_missing_ones_counted() {
        let long = |end: &str| Key::new("p0", &format!("{}{end}", "long".repeat(30)));
        let (drawn, _) = legend(&[long("1"), long("2"), Key::more(3)], [360.0, 0.0]);
        assert!(drawn.contains("1</text>") && drawn.contains("2</text>") && drawn.contains("…"), "{drawn}");
        assert!(!drawn.contains(&"long".repeat(14)) && drawn.contains(">and 3 more</text>"), "{drawn}");
        assert_eq!(drawn.matches("<rect").count(), 2, "{drawn}");
    }

    /// Ten policies have seven colours.
    #[test]
    fn keys_of_markers_show_their_shapes() {
        let keys = [Key::of_marker("p0", 0, "full"), Key::of_marker("p0", 1, "aggressive")];
        let (drawn, _) = legend(&keys, [360.0, 0.0]);
        assert_eq!(drawn.matches("class=\"dot p0\"").count(), 2, "{drawn}");
        assert!(drawn.contains(&marker(0, 5.0, 5.0)) && !drawn.contains("<rect"), "{drawn}");
    }
}
