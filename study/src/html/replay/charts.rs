//! Figures of a replay over its frames, as lines.

use serde_json::Value;

use crate::figures::column;
use crate::html::charts::gallery::Gallery;
use crate::html::charts::lines::{Line, Lines};
use crate::html::magnitude::{self, Unit};
use crate::html::parts::{grid, how_to_read};

/// A figure of a frame.
pub struct Figure {
    /// Its key in the report.
    pub key: &'static str,
    /// Its name for people.
    pub name: &'static str,
    /// The unit in which it is stored.
    pub unit: &'static str,
    /// How many places are written.
    pub places: usize,
}

impl Figure {
    /// The unit for all frames: the one in which the largest value has enough digits.
    pub fn unit<'a>(&self, frames: impl IntoIterator<Item = &'a Value>) -> Unit {
        magnitude::of(self.unit, frames.into_iter().filter_map(|frame| figure(frame, self.key).as_f64()))
    }

    /// The name with a unit.
    pub fn heading(&self, unit: &str) -> String {
        if unit.is_empty() { self.name.to_owned() } else { format!("{}, {unit}", self.name) }
    }

    /// Whether a frame, or all of them, has a value, or is identical.
    pub fn is_known(&self, figures: &Value) -> bool {
        figure(figures, self.key).is_number() || is_identical(figures, self.key)
    }
}

/// Whether a figure is the PSNR of a picture that equals the reference: it has no number.
pub fn is_identical(figures: &Value, key: &str) -> bool {
    matches!(key, "psnr_db" | "worst_tile_psnr_db" | "worst_frame_psnr_db")
        && figure(figures, key).is_null()
        && figures["identical"] == true
}

/// A figure of a frame or of all, by the name of its column; null where there is none.
pub fn figure<'a>(figures: &'a Value, key: &str) -> &'a Value {
    column(key).map_or(&Value::Null, |column| column.value(figures))
}

/// Half the width of the 95 % interval of a figure of a frame or of all, in percent of it; none where it is exact.
pub fn interval(figures: &Value, key: &str) -> Option<f64> {
    figures["detail"]["interval_percent"][key].as_f64()
}

/// What a gap of a line means, as the page of a study says it.
const GAPS: &str = "A missing piece of a PSNR line is a frame that equals the reference.";

/// A chart for each figure that frames have; none of a single frame.
pub fn over_frames(stats: &Value, figures: &[Figure], drawn: &Gallery) -> String {
    let all = stats["frames"].as_array().map_or(&[][..], Vec::as_slice);
    let number = |frame: &Value| frame["frame"].as_u64().and_then(|number| u32::try_from(number).ok());
    let mut frames: Vec<(u32, &Value)> = all.iter().filter_map(|frame| Some((number(frame)?, frame))).collect();
    frames.sort_by_key(|(number, _)| *number);
    frames.dedup_by_key(|(number, _)| *number);
    if frames.len() < 2 {
        return String::new();
    }
    let numbers: Vec<u32> = frames.iter().map(|(number, _)| *number).collect();
    let chart = |shown: &Figure| {
        let key = shown.key;
        // As in other files: the PSNR of an identical picture is infinite.
        let infinite = |frame: &Value| is_identical(frame, key).then_some(f64::INFINITY);
        let value = |(_, frame): &(u32, &Value)| figure(frame, key).as_f64().or_else(|| infinite(frame));
        let values: Vec<Option<f64>> = frames.iter().map(value).collect();
        if values.iter().all(Option::is_none) {
            return String::new();
        }
        let intervals: Vec<Option<f64>> = frames.iter().map(|(_, frame)| interval(frame, key)).collect();
        let intervals = if intervals.iter().all(Option::is_none) { Vec::new() } else { intervals };
        let (name, column) = (shown.name.into(), shown.heading(shown.unit));
        let line = Line { name, column, values, intervals, class: "p0".into(), dash: "" };
        // Of a picture's likeness a few hundredths count: its axis does not begin at zero.
        let zero = !matches!(key, "psnr_db" | "ssim");
        let Unit { name: unit, scale } = shown.unit(frames.iter().map(|(_, frame)| *frame));
        let (title, lines) = (shown.heading(unit), Lines { unit, scale, frames: &numbers, lines: vec![line], zero });
        drawn.card(&["frames", key], &title, &lines.draw(&format!("Line chart: {title} over frames")), "")
    };
    let charts: String = figures.iter().map(chart).collect();
    let is_line = frames.iter().any(|(_, frame)| figure(frame, "psnr_db").is_number());
    let is_broken = is_line && frames.iter().any(|(_, frame)| is_identical(frame, "psnr_db"));
    let gaps = if is_broken { how_to_read(GAPS) } else { String::new() };
    if charts.is_empty() { charts } else { grid(&charts) + &gaps }
}
