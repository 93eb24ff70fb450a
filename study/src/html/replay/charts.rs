//! Figures of a replay over its frames, as lines.

use serde_json::Value;

use crate::figures::column;
use crate::html::charts::gallery::Gallery;
use crate::html::charts::lines::{Line, Lines};
use crate::html::parts::grid;

/// A figure of a frame: key in the report, heading, places.
pub type Figure = (&'static str, &'static str, usize);

/// A figure of a frame or of all, by the name of its column; null where there is none.
pub fn figure<'a>(figures: &'a Value, key: &str) -> &'a Value {
    column(key).map_or(&Value::Null, |column| column.value(figures))
}

/// Half the width of the 95 % interval of a figure of a frame or of all, in percent of it; none where it is exact.
pub fn interval(figures: &Value, key: &str) -> Option<f64> {
    figures["detail"]["interval_percent"][key].as_f64()
}

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
    let chart = |(key, name, _): &Figure| {
        let values: Vec<Option<f64>> = frames.iter().map(|(_, frame)| figure(frame, key).as_f64()).collect();
        if values.iter().all(Option::is_none) {
            return String::new();
        }
        let intervals: Vec<Option<f64>> = frames.iter().map(|(_, frame)| interval(frame, key)).collect();
        let intervals = if intervals.iter().all(Option::is_none) { Vec::new() } else { intervals };
        let line = Line { name: (*name).into(), values, intervals, class: "p0".into(), dash: "" };
        // Of a picture's likeness a few hundredths count: its axis does not begin at zero.
        let zero = !matches!(*key, "psnr_db" | "ssim");
        let lines = Lines { unit: "", scale: 1.0, frames: &numbers, lines: vec![line], zero };
        drawn.card(&["frames", key], name, &lines.draw(&format!("Line chart: {name} over frames")), "")
    };
    let charts: String = figures.iter().map(chart).collect();
    if charts.is_empty() { charts } else { grid(&charts) }
}
