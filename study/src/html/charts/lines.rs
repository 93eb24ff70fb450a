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
    /// One value for each frame of the chart; a missing one breaks the line.
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
        let [left, right, top, bottom] = [44.0, WIDTH - 8.0, 10.0, HEIGHT - 36.0];
        let [mut low, high] =
            extent(self.lines.iter().flat_map(|l| l.values.iter().flatten().copied())).unwrap_or([0.0, 1.0]);
        if self.zero {
            low = low.min(0.0);
        }
        let y = Scale::nice([low, high], 4, [bottom, top]);
        let ends = (self.frames.first().copied().unwrap_or(0), self.frames.last().copied().unwrap_or(1));
        let x = Scale::exact([f64::from(ends.0), f64::from(ends.1)], 6, [left, right]);
        let mut svg = Svg::new(WIDTH, HEIGHT);
        for tick in y.ticks() {
            svg.line([left, y.at(tick)], [right, y.at(tick)], "grid");
            svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &y.times(self.scale).label(tick * self.scale));
        }
        // There is no frame one and a half.
        for tick in x.ticks().into_iter().filter(|tick| (tick - tick.round()).abs() < 1e-9) {
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
            ends.0,
            ends.1,
            escape(self.unit)
        );
        let keys = self.lines.iter().map(|line| Key::of_line(&line.class, line.dash, &line.name));
        let keys = if self.lines.len() > 1 { keys.collect() } else { Vec::new() };
        Chart { svg: svg.finish(label, &plot), data: self.data(), keys }
    }

    fn data(&self) -> Data {
        // A line, and behind it what its estimates may be off.
        let columns = self.lines.iter().flat_map(|line| {
            let intervals = (!line.intervals.is_empty()).then(|| (interval_of(&line.name), &line.intervals));
            std::iter::once((line.name.clone(), &line.values)).chain(intervals)
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
            let Some(value) = value else {
                drawing = false;
                continue;
            };
            let (px, py) = (n(x.at(f64::from(*frame))), n(y.at(*value)));
            let _ = write!(d, "{}{px} {py}", if drawing { 'L' } else { 'M' });
            let alone = !drawing && line.values.get(i + 1).is_none_or(Option::is_none);
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

/// A value for the script: four digits are enough to read out.
fn short(value: f64) -> String {
    let places = match value.abs() {
        v if v >= 1000.0 => 0,
        v if v >= 10.0 => 2,
        _ => 4,
    };
    format!("{value:.places$}")
}
