//! Lines over frames. The values stand in the picture as data, so that the script can read them out under the pointer.

use std::fmt::Write as _;

use crate::html::charts::WIDTH;
use crate::html::charts::chart::{Chart, Data, Key, cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{Svg, dashed, n};
use crate::html::text::{escape, fixed};
use crate::point::known::interval_of;

/// A line.
pub struct Line {
    /// Its name.
    pub name: String,
    /// Its name in the file of the values, which may say their unit.
    pub column: String,
    /// One value for each frame of the chart; a missing one breaks the line, and so does an infinite one: that of an identical
    /// picture.
    pub values: Vec<Option<f64>>,
    /// Of values that are estimates half the width of the interval, in percent; empty where all are exact.
    pub intervals: Vec<Option<f64>>,
    /// Colour class.
    pub class: String,
    /// Dash pattern: colour is not all that tells lines apart.
    pub dash: &'static str,
}

/// A chart of lines.
pub struct Lines<'a> {
    /// Unit of a value read out.
    pub unit: &'a str,
    /// How many of it one of the stored unit is: the file of the values keeps the stored one.
    pub scale: f64,
    /// Frames, ascending.
    pub frames: &'a [u32],
    /// The lines.
    pub lines: Vec<Line>,
    /// Whether the axis begins at zero.
    pub zero: bool,
}

/// Most frames of which each has a dot: of more they would hide the line.
const DOTTED: usize = 40;

/// Height of the chart.
const HEIGHT: f64 = 200.0;

impl Lines<'_> {
    /// The chart; `label` describes it.
    pub fn draw(&self, label: &str) -> Chart {
        let [right, top, bottom] = [WIDTH - 8.0, 10.0, HEIGHT - 36.0];
        let known = self.lines.iter().flat_map(|l| l.values.iter().flatten().copied()).filter(|v| v.is_finite());
        let extent = extent(known);
        let [mut low, high] = extent.unwrap_or([0.0, 1.0]);
        if self.zero {
            low = low.min(0.0);
        }
        let y = Scale::nice([low, high], 4, [bottom, top]);
        let text = |tick: f64| y.times(self.scale).label(tick * self.scale);
        let left = y.margin(44.0, text);
        let ends = (self.frames.first().copied().unwrap_or(0), self.frames.last().copied().unwrap_or(1));
        // A single frame stands in the middle.
        let [first, last] = [ends.0, ends.1].map(f64::from);
        let about = if first < last { 0.0 } else { 1.0 };
        let x = Scale::exact([first - about, last + about], 6, [left, right]);
        let mut svg = Svg::new(WIDTH, HEIGHT);
        let mut values = self.lines.iter().flat_map(|line| line.values.iter().flatten());
        if extent.is_none() && values.any(|value| value.is_infinite()) {
            svg.text(f64::midpoint(left, right), f64::midpoint(top, bottom), "note m", "identical");
        }
        for tick in y.ticks().into_iter().filter(|_| extent.is_some()) {
            svg.line([left, y.at(tick)], [right, y.at(tick)], "grid");
            svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &text(tick));
        }
        // There is no frame one and a half.
        let is_frame = |tick: &f64| (tick - tick.round()).abs() < 1e-9 && (first..=last).contains(tick);
        for tick in x.ticks().into_iter().filter(is_frame) {
            svg.line([x.at(tick), bottom], [x.at(tick), bottom + 4.0], "axis");
            svg.text(x.at(tick), bottom + 16.0, "tick m", &fixed(tick, 0));
        }
        svg.line([left, bottom], [right, bottom], "axis");
        svg.text(right, HEIGHT - 4.0, "note e", "frame");
        self.lines.iter().for_each(|line| self.line(&mut svg, line, &x, &y));
        let frames: Vec<String> = self.frames.iter().map(u32::to_string).collect();
        let plot = format!(
            " data-lines=\"\" data-x=\"{}\" data-plot=\"{} {} {} {}\" data-ends=\"{} {}\" data-unit=\"{}\"",
            frames.join(","),
            n(left),
            n(right),
            n(top),
            n(bottom),
            x.domain[0],
            x.domain[1],
            escape(self.unit)
        );
        let keys = self.lines.iter().map(|line| Key::of_line(&line.class, line.dash, &line.name));
        let keys = if self.lines.len() > 1 { keys.collect() } else { Vec::new() };
        Chart { svg: svg.finish(label, &plot), data: self.data(), keys }
    }

    fn data(&self) -> Data {
        // A line, and behind it what its estimates may be off.
        let columns = self.lines.iter().flat_map(|line| {
            let intervals = (!line.intervals.is_empty()).then(|| (interval_of(&line.column), &line.intervals));
            std::iter::once((line.column.clone(), &line.values)).chain(intervals)
        });
        let (names, columns): (Vec<String>, Vec<&Vec<Option<f64>>>) = columns.unzip();
        let names: Vec<&str> = std::iter::once("frame").chain(names.iter().map(String::as_str)).collect();
        let mut data = Data::new(&names);
        for (i, frame) in self.frames.iter().enumerate() {
            let values = columns.iter().map(|column| cell(column.get(i).copied().flatten()));
            data.row(std::iter::once(frame.to_string()).chain(values).collect());
        }
        data
    }

    fn line(&self, svg: &mut Svg, line: &Line, x: &Scale, y: &Scale) {
        let (mut d, mut dots, mut drawing) = (String::new(), String::new(), false);
        for (i, (frame, value)) in self.frames.iter().zip(&line.values).enumerate() {
            let Some(value) = value.filter(|value| value.is_finite()) else {
                drawing = false;
                continue;
            };
            let (px, py) = (n(x.at(f64::from(*frame))), n(y.at(value)));
            let _ = write!(d, "{}{px} {py}", if drawing { 'L' } else { 'M' });
            let alone = !drawing && line.values.get(i + 1).is_none_or(|next| !next.is_some_and(f64::is_finite));
            // A frame without neighbours would be a line of no length.
            if alone || self.frames.len() <= DOTTED {
                let _ = write!(dots, "M{px} {py}m-2.5 0a2.5 2.5 0 1 0 5 0a2.5 2.5 0 1 0 -5 0");
            }
            drawing = true;
        }
        d += &dots;
        let list = |values: &mut dyn Iterator<Item = Option<f64>>| {
            values.map(|v| v.map(short).unwrap_or_default()).collect::<Vec<_>>().join(",")
        };
        let values = line.values.iter().map(|value| value.map(|value| value * self.scale));
        let mut data =
            format!("{} data-name=\"{}\" data-v=\"{}\"", dashed(line.dash), escape(&line.name), list(&mut { values }));
        if !line.intervals.is_empty() {
            data += &format!(" data-within=\"{}\"", list(&mut line.intervals.iter().copied()));
        }
        svg.path(&d, &format!("line {}", line.class), &data);
    }
}

/// A value for the script: whole numbers in full, of others the digits that it reads out, four or one behind the point.
fn short(value: f64) -> String {
    let digits = if value.abs() < 1e3 { 3 } else { 6 };
    let text = if value.fract() == 0.0 { format!("{value}") } else { format!("{value:.digits$e}") };
    match text.parse::<f64>() {
        Ok(v) if v.is_infinite() => if v > 0.0 { "Infinity" } else { "-Infinity" }.into(),
        Ok(v) if v == 0.0 || (1e-6..1e15).contains(&v.abs()) => v.to_string(),
        Ok(v) => format!("{v:e}"),
        Err(_) => text,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(frames: &[u32], values: &[Option<f64>]) -> Chart {
        let line = Line {
            name: "a".into(),
            column: "a, ms".into(),
            values: values.to_vec(),
            intervals: Vec::new(),
            class: "p0".into(),
            dash: "",
        };
        Lines { unit: "µs", scale: 1e3, frames, lines: vec![line], zero: true }.draw("label")
    }

    /// Four places made 0 of the small ones.
    #[test]
    fn values_are_read_out_as_they_are() {
        assert_eq!(
            [2e-5, 123_456.0, 1e-9, 1_234.567_89, 0.0].map(short),
            ["0.00002", "123456", "1e-9", "1234.568", "0"]
        );
        let chart = lines(&[0, 1, 2], &[Some(2e-6), None, Some(f64::INFINITY)]);
        assert!(chart.svg.contains("data-v=\"0.002,,Infinity\"") && !chart.svg.contains("inf "), "{}", chart.svg);
        assert_eq!(chart.data.csv(), "frame,\"a, ms\"\r\n0,0.000002\r\n1,\r\n2,inf\r\n");
    }

    #[test]
    fn a_single_frame_has_one_tick() {
        let chart = lines(&[0], &[Some(1.0)]).svg;
        assert!(chart.contains("data-ends=\"-1 1\"") && chart.matches("\"tick m\"").count() == 1, "{chart}");
    }
}
