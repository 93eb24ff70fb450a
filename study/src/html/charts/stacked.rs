//! Horizontal bars made of parts: energy by component, cycles by state, kernels.

use crate::html::charts::WIDTH;
use crate::html::charts::bars::{NAME_MAX, beside};
use crate::html::charts::chart::{Chart, Data, Key, cell, ends, once, percent_cell};
use crate::html::charts::scale::Scale;
use crate::html::charts::svg::{Svg, text_width};
use crate::point::known::interval_of;

/// A part of a bar.
pub struct Part {
    /// What it is.
    pub name: String,
    /// Its length.
    pub value: f64,
    /// Colour class.
    pub class: String,
    /// Shade of the colour, 0 to 1.
    pub opacity: f64,
    /// What it says when asked.
    pub tip: String,
}

/// A bar, or a heading between bars.
pub enum StackedRow {
    /// A heading.
    Head(String),
    /// A bar.
    Bar {
        /// Name at its left.
        name: String,
        /// Its parts, from the left.
        parts: Vec<Part>,
        /// Half the interval of all of them together, a part of it; nothing where none is known.
        within: Option<f64>,
        /// What stands behind its end.
        text: String,
    },
}

impl StackedRow {
    /// The name of a bar.
    fn name(&self) -> &str {
        if let Self::Bar { name, .. } = self { name } else { "" }
    }
}

/// Height of a bar with the gap below it.
const ROW: f64 = 21.0;

/// Draws the bars. The axis reaches `most`; `tick` writes a value along it. `value` is what the file of the values calls them, with
/// their unit.
pub fn stacked(
    rows: &[StackedRow],
    (most, value): (f64, &str),
    tick: impl Fn(&Scale, f64) -> String,
    label: &str,
) -> Chart {
    // Heads stand above bars, and take no room beside them.
    let (names, left) = beside(&rows.iter().map(StackedRow::name).collect::<Vec<_>>(), NAME_MAX);
    let texts = rows.iter().map(|row| if let StackedRow::Bar { text, .. } = row { text_width(text) } else { 0.0 });
    let behind = texts.fold(0.0, f64::max) + 10.0;
    let bottom = 4.0 + ROW * rows.len() as f64;
    let within = rows.iter().filter_map(|row| if let StackedRow::Bar { within, .. } = row { *within } else { None });
    let room = within.map(|part| ends(1.0, Some(part))[1]).fold(1.0, f64::max);
    let x = Scale::exact([0.0, if most > 0.0 { most * room } else { 1.0 }], 5, [left, WIDTH - behind]);
    let mut svg = Svg::new(WIDTH, bottom + 22.0);
    for value in x.ticks() {
        svg.line([x.at(value), 2.0], [x.at(value), bottom], "grid");
        svg.text(x.at(value), bottom + 15.0, "tick m", &tick(&x, value));
    }
    for (i, row) in rows.iter().enumerate() {
        let y = 4.0 + ROW * i as f64;
        match row {
            StackedRow::Head(text) => svg.text(0.0, y + 14.0, "head s", text),
            StackedRow::Bar { parts, within, text, .. } => {
                svg.text(left - 6.0, y + 13.0, "label e", &names[i]);
                let mut start = 0.0;
                for part in parts.iter().filter(|part| part.value > 0.0) {
                    let (a, b) = (x.at(start), x.at(start + part.value));
                    svg.mark([a, y + 2.0, b - a, ROW - 6.0], &part.class, part.opacity, &part.tip);
                    start += part.value;
                }
                let ends = ends(start, *within).map(|end| x.at(end));
                svg.level_interval(y + ROW / 2.0 - 1.0, ends);
                svg.text(ends[1] + 5.0, y + 13.0, "value s", text);
            }
        }
    }
    svg.line([left, 2.0], [left, bottom], "axis");
    let parts = rows.iter().flat_map(|row| if let StackedRow::Bar { parts, .. } = row { &parts[..] } else { &[] });
    let key = |part: &Part| Key { opacity: part.opacity, ..Key::new(&part.class, &part.name) };
    let keys = once(parts.filter(|part| part.value > 0.0).map(key));
    Chart { svg: svg.finish(label, ""), data: of_parts(rows, value), keys }
}

fn of_parts(rows: &[StackedRow], value: &str) -> Data {
    let headed = rows.iter().any(|row| matches!(row, StackedRow::Head(_)));
    let estimated = rows.iter().any(|row| matches!(row, StackedRow::Bar { within: Some(_), .. }));
    let of_bar = interval_of("bar");
    let columns = ["of", "bar", "part", value, &of_bar];
    let mut data = Data::new(&columns[usize::from(!headed)..columns.len() - usize::from(!estimated)]);
    let mut head = "";
    for row in rows {
        match row {
            StackedRow::Head(text) => head = text,
            StackedRow::Bar { name, parts, within, .. } => {
                for part in parts {
                    let of = headed.then(|| head.to_owned());
                    let cells = [name.clone(), part.name.clone(), cell(Some(part.value))];
                    let within = estimated.then(|| percent_cell(*within));
                    data.row(of.into_iter().chain(cells).chain(within).collect());
                }
            }
        }
    }
    data
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_of_bars_stand_in_the_file_where_there_are_any() {
        let bar = |within| {
            let part = Part { name: "x".into(), value: 2.0, class: "e0".into(), opacity: 1.0, tip: String::new() };
            StackedRow::Bar { name: "a".into(), parts: vec![part], within, text: "2".into() }
        };
        let chart = |rows: &[StackedRow]| stacked(rows, (2.0, "mJ"), |_, tick| tick.to_string(), "label");
        let exact = chart(&[bar(None)]);
        assert_eq!(exact.data.csv(), "bar,part,mJ\r\na,x,2\r\n");
        assert!(!exact.svg.contains("class=\"within\""));
        let estimated = chart(&[StackedRow::Head("of".into()), bar(Some(0.05)), bar(None)]);
        assert_eq!(estimated.data.csv(), "of,bar,part,mJ,bar_interval_percent\r\nof,a,x,2,5\r\nof,a,x,2,\r\n");
        assert_eq!(estimated.svg.matches("class=\"within\"").count(), 1);
    }
}
