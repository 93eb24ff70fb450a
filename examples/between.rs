//! How well frames of a flight are estimated from the simulated ones before and after: takes a study of which every frame was simulated,
//! keeps every eleventh frame and the last, beginning with each of the first eleven, and compares what is estimated of the others.
//!
//! ```text
//! cargo run --release --example between -- study.json
//! ```
//!
//! Errors are in percent, of sums over the path with the widest half interval behind them, and of the frame that is furthest off.

use std::error::Error;

use rayreel_paper::between::{EVERY, estimate};
use rayreel_study::schema::{CostInterval, Study, TrackFrame};

/// A figure: its name, its value, and what intervals say of it.
type Figure = (&'static str, fn(&TrackFrame) -> Option<f64>, fn(&CostInterval) -> f64);

const FIGURES: [Figure; 2] =
    [("energy", |frame| frame.energy_mj, |interval| interval.energy_mj), ("time", |frame| frame.time_ms, |i| i.cycles)];

/// What is left of a flight, from frame `first` on.
fn sample(whole: &[TrackFrame], first: usize) -> Vec<TrackFrame> {
    let mut frames = whole.to_vec();
    for (at, frame) in frames.iter_mut().enumerate() {
        let is_end = at == 0 || at + 1 == whole.len();
        if !is_end && at % EVERY as usize != first {
            (frame.time_ms, frame.energy_mj, frame.power_w) = (None, None, None);
        }
    }
    frames
}

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the study.json of a flight of which every frame was simulated")?;
    let study: Study = serde_json::from_slice(&std::fs::read(&path)?)?;
    let (mut sums, mut sums_held, mut frames, mut frames_held) = (0, 0, 0, 0);
    println!("{:<12} {:<7} {:>14} {:>12}", "policy", "figure", "sum", "worst frame");
    for track in &study.tracks {
        if track.frames.iter().any(|frame| frame.energy_mj.is_none()) {
            continue;
        }
        for (name, value, width) in FIGURES {
            let (mut worst, mut widest, mut worst_frame) = (0.0_f64, 0.0_f64, 0.0_f64);
            for first in 0..EVERY as usize {
                let mut estimated = sample(&track.frames, first);
                let Some(interval) = estimate(&mut estimated) else { continue };
                let sum = |frames: &[TrackFrame]| frames.iter().filter_map(value).sum::<f64>();
                let error = (sum(&estimated) / sum(&track.frames) - 1.0).abs();
                (worst, widest) = (worst.max(error), widest.max(width(&interval)));
                (sums, sums_held) = (sums + 1, sums_held + u32::from(error <= width(&interval)));
                for (is, of) in track.frames.iter().zip(&estimated) {
                    let (Some(interval), Some(is), Some(of)) = (of.interval, value(is), value(of)) else { continue };
                    let error = (of / is - 1.0).abs();
                    worst_frame = worst_frame.max(error);
                    (frames, frames_held) = (frames + 1, frames_held + u32::from(error <= width(&interval)));
                }
            }
            let [worst, widest, worst_frame] = [worst, widest, worst_frame].map(|part| 100.0 * part);
            println!("{:<12} {name:<7} {worst:>6.2} ±{widest:>6.2} {worst_frame:>12.1}", track.policy);
        }
    }
    if sums == 0 {
        return Err(format!("{path}: no track of which every frame was simulated").into());
    }
    println!("intervals that hold: {sums_held} of {sums} sums, {frames_held} of {frames} frames");
    Ok(())
}
