//! A small SVG writer: escapes what it is given and prints coordinates the same way everywhere.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use crate::html::text::escape;

/// An SVG picture in the making.
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

/// A coordinate with two places at most.
pub fn n(value: f64) -> String {
    // Values near the end of the floating-point range; SVG has no word for what they give.
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" { "0".into() } else { short.into() }
}

/// A rectangle: left, top, width, height.
pub type Rect = [f64; 4];

/// Shortest interval that is drawn, and half the width of its caps, units.
const INTERVAL_LEAST: f64 = 2.0;
const CAP: f64 = 2.5;

impl Svg {
    /// An empty picture.
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new() }
    }

    /// A rectangle.
    pub fn rect(&mut self, [x, y, w, h]: Rect, class: &str) {
        let _ = write!(self.body, "<rect {}/>", at([x, y, w.max(0.0), h.max(0.0)], class));
    }

    /// A rectangle that tells something when asked; `opacity` tells the shades of one colour apart.
    pub fn mark(&mut self, [x, y, w, h]: Rect, class: &str, opacity: f64, tip: &str) {
        let fade = if opacity < 1.0 { format!(" fill-opacity=\"{}\"", n(opacity)) } else { String::new() };
        let rect = at([x, y, w.max(0.0), h.max(0.0)], class);
        let _ = write!(self.body, "<rect {rect}{fade} data-mark=\"\"><title>{}</title></rect>", escape(tip));
    }

    /// A line.
    pub fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], class: &str) {
        let _ = write!(
            self.body,
            "<line x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\" class=\"{class}\"/>",
            n(x1),
            n(y1),
            n(x2),
            n(y2)
        );
    }

    /// Text; `class` says how it is aligned (`s`, `m`, `e`).
    pub fn text(&mut self, x: f64, y: f64, class: &str, text: &str) {
        let _ = write!(self.body, "<text x=\"{}\" y=\"{}\" class=\"{class}\">{}</text>", n(x), n(y), escape(text));
    }

    /// A path; `extra` are more attributes, already escaped.
    pub fn path(&mut self, d: &str, class: &str, extra: &str) {
        let _ = write!(self.body, "<path d=\"{d}\" class=\"{class}\"{extra}/>");
    }

    /// An interval along a vertical line, with a cap at either end, if it is long enough to be seen; `class` may dim it.
    pub fn upright_interval(&mut self, x: f64, ends: [f64; 2], class: &str) {
        if (ends[0] - ends[1]).abs() >= INTERVAL_LEAST {
            let [a, b] = ends.map(n);
            let left = n(x - CAP);
            self.path(&format!("M{left} {a}h{0}M{1} {a}V{b}M{left} {b}h{0}", n(2.0 * CAP), n(x)), class, "");
        }
    }

    /// The same along a horizontal line.
    pub fn level_interval(&mut self, y: f64, ends: [f64; 2]) {
        if (ends[0] - ends[1]).abs() >= INTERVAL_LEAST {
            let [a, b] = ends.map(n);
            let top = n(y - CAP);
            self.path(&format!("M{a} {top}v{0}M{a} {1}H{b}M{b} {top}v{0}", n(2.0 * CAP), n(y)), "within", "");
        }
    }

    /// SVG as it is.
    pub fn raw(&mut self, svg: &str) {
        self.body.push_str(svg);
    }

    /// The element, described by `label`; `extra` are more attributes, already escaped.
    pub fn finish(self, label: &str, extra: &str) -> String {
        format!(
            "<svg class=\"chart\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"{extra}>{}</svg>\n",
            n(self.width),
            n(self.height),
            escape(label),
            self.body
        )
    }
}

fn at([x, y, w, h]: Rect, class: &str) -> String {
    format!("x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" class=\"{class}\"", n(x), n(y), n(w), n(h))
}

/// A line that lies level, as charts of lines draw theirs: a colour class and a pattern of dashes, which may be empty.
pub fn line([from, to]: [f64; 2], y: f64, class: &str, dash: &str) -> String {
    let (from, to, y) = (n(from), n(to), n(y));
    format!("<line x1=\"{from}\" x2=\"{to}\" y1=\"{y}\" y2=\"{y}\" class=\"line {class}\"{}/>", dashed(dash))
}

/// A pattern of dashes as an attribute; nothing for a line without.
pub fn dashed(dash: &str) -> String {
    if dash.is_empty() { String::new() } else { format!(" stroke-dasharray=\"{dash}\"") }
}

/// Number of colours that values take in turn: classes `p0`, `p1` and so on of `chart.css`. Shapes are 6, so 42 values look different.
pub const COLOURS: usize = 7;

/// The shape of full sampling: no policy takes it in turn.
pub const FULL: usize = usize::MAX;

/// Markers that differ in shape, so that colour is never all that tells them apart. About 10 units across.
pub fn marker(shape: usize, x: f64, y: f64) -> String {
    let points: &[[f64; 2]] = match shape % 6 {
        _ if shape == FULL => &[
            [0.0, -2.4],
            [2.8, -5.2],
            [5.2, -2.8],
            [2.4, 0.0],
            [5.2, 2.8],
            [2.8, 5.2],
            [0.0, 2.4],
            [-2.8, 5.2],
            [-5.2, 2.8],
            [-2.4, 0.0],
            [-5.2, -2.8],
            [-2.8, -5.2],
        ],
        0 => return format!("M{} {}a5 5 0 1 0 10 0a5 5 0 1 0 -10 0z", n(x - 5.0), n(y)),
        1 => &[[-4.4, -4.4], [4.4, -4.4], [4.4, 4.4], [-4.4, 4.4]],
        2 => &[[0.0, -5.6], [5.4, 4.2], [-5.4, 4.2]],
        3 => &[[0.0, -6.2], [6.2, 0.0], [0.0, 6.2], [-6.2, 0.0]],
        4 => &[[0.0, 5.6], [5.4, -4.2], [-5.4, -4.2]],
        _ => &[
            [-1.8, -5.5],
            [1.8, -5.5],
            [1.8, -1.8],
            [5.5, -1.8],
            [5.5, 1.8],
            [1.8, 1.8],
            [1.8, 5.5],
            [-1.8, 5.5],
            [-1.8, 1.8],
            [-5.5, 1.8],
            [-5.5, -1.8],
            [-1.8, -1.8],
        ],
    };
    let corners: Vec<String> = points.iter().map(|[dx, dy]| format!("{} {}", n(x + dx), n(y + dy))).collect();
    format!("M{}z", corners.join("L"))
}

/// Width of a text of 12 units, roughly: what a browser will use is not known here.
pub fn text_width(text: &str) -> f64 {
    text.chars().count() as f64 * 6.4
}

/// The text cut to so many characters.
pub fn shortened(text: &str, most: usize) -> String {
    if text.chars().count() <= most {
        return text.to_owned();
    }
    text.chars().take(most.saturating_sub(1)).chain(['…']).collect()
}

/// Texts cut to so many characters: at their ends, or where that would make two of them the same, inside. What no cut tells apart
/// begins with its number.
pub fn told_apart(texts: &[&str], most: usize) -> Vec<String> {
    let different = texts.iter().collect::<BTreeSet<_>>().len();
    let is_told = |cut: &Vec<String>| cut.iter().collect::<BTreeSet<_>>().len() == different;
    let number = |text: &str| texts.iter().position(|other| *other == text).unwrap_or_default() + 1;
    let numbered = || texts.iter().map(|text| shortened(&format!("{} {text}", number(text)), most)).collect();
    // Half of each side first: both are read then.
    let mut tails = std::iter::once(0).chain(most / 2..most).chain(1..most / 2);
    let cut = |tail| texts.iter().map(|text| without_middle(text, most, tail)).collect::<Vec<_>>();
    tails.find_map(|tail| Some(cut(tail)).filter(is_told)).unwrap_or_else(numbered)
}

/// The text cut to so many characters, of which so many are its last.
fn without_middle(text: &str, most: usize, tail: usize) -> String {
    let length = text.chars().count();
    if length <= most || tail == 0 {
        return shortened(text, most);
    }
    let head = text.chars().take(most.saturating_sub(tail + 1));
    head.chain(['…']).chain(text.chars().skip(length - tail)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_are_cut_stay_apart() {
        assert_eq!(told_apart(&["one", "two", "one"], 5), ["one", "two", "one"]);
        assert_eq!(told_apart(&["adaptive-quality", "multirate"], 10), ["adaptive-…", "multirate"]);
        assert_eq!(told_apart(&["0.1000 to 0.2000", "0.1000 to 0.3000"], 10), ["0.10….2000", "0.10….3000"]);
        let inside = ["aaaaaaaa1aaaaaaaaaaaaa", "aaaaaaaa2aaaaaaaaaaaaa"];
        assert_eq!(told_apart(&inside, 6), ["1 aaa…", "2 aaa…"]);
        assert!(told_apart(&["ab", "cd"], 0).len() == 2 && told_apart(&[], 4).is_empty());
    }
}
