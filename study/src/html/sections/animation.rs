//! The animation, frame by frame.

use crate::html::charts::chart::in_percent;
use crate::html::charts::lines::{Line, Lines};
use crate::html::magnitude::{self, Unit};
use crate::html::modes::mode_name;
use crate::html::parts::{Head, Section, grid, how_to_read, table};
use crate::html::text::{escape, fixed, or_dash, percent, plus_minus, psnr};
use crate::html::view::StudyView;
use crate::schema::{CostInterval, Track, TrackFrame};

/// What is drawn: title, unit, value of a frame, its interval, whether the axis begins at zero.
type Plot = (&'static str, &'static str, fn(&TrackFrame) -> Option<f64>, fn(CostInterval) -> Option<f64>, bool);

const PLOTS: [Plot; 6] = [
    ("Rays traced", "rays", |f| Some(f.rays_traced as f64), |_| None, true),
    ("Mean rate: traced samples per sample", "", |f| Some(f.mean_rate), |_| None, true),
    ("PSNR, dB", "dB", |f| f.psnr_db, |_| None, false),
    ("Power of the T&I units, W", "W", |f| f.power_w, |i| Some(i.power_w), true),
    ("Energy of the T&I units, mJ", "mJ", |f| f.energy_mj, |i| Some(i.energy_mj), true),
    ("Time of a frame, ms", "ms", |f| f.time_ms, |i| Some(i.cycles), true),
];

/// What the figures of the tracks are of, as a chart and as a column name it: a machine without T&I units has only the whole.
fn part(view: &StudyView<'_>) -> [&'static str; 2] {
    let is_whole = view.points.iter().any(|p| p.gpu.is_some()) && view.points.iter().all(|p| p.ti.is_none());
    if is_whole { ["whole GPU", "GPU"] } else { ["T&I units", "T&I"] }
}

/// The unit of a figure over some tracks; `stored` is that of the study.
fn unit_of(tracks: &[&Track], stored: &'static str, value: fn(&TrackFrame) -> Option<f64>) -> Unit {
    magnitude::of(stored, tracks.iter().flat_map(|track| &track.frames).filter_map(value))
}

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let mut groups: Vec<(&str, &str)> = Vec::new();
    for track in &view.study.tracks {
        if !groups.contains(&(&track.scene, &track.mode)) {
            groups.push((&track.scene, &track.mode));
        }
    }
    let mut html = String::new();
    for (scene, mode) in groups {
        let tracks: Vec<&Track> = view.study.tracks.iter().filter(|t| t.scene == scene && t.mode == mode).collect();
        let policies: Vec<&str> = tracks.iter().map(|t| t.policy.as_str()).collect();
        html += &format!("<h3>{} <small>{}</small></h3>\n", escape(scene), escape(&mode_name(mode).to_lowercase()));
        html += &view.legend_of_lines(&policies);
        html += &grid(&PLOTS.iter().map(|plot| chart(view, scene, &tracks, plot)).collect::<String>());
        html += &totals(scene, &tracks, part(view)[1]);
    }
    if !html.is_empty() {
        let others = if view.study.tracks.iter().any(|track| track.interval.is_some()) {
            "Where a sample of the frames was simulated, power, energy and time of the others are estimated from the simulated \
             frames before and after, by their rays; the table says how far means over the path may be off."
        } else {
            "Power, energy and time are those of the frames that were simulated; rays and pictures are of all."
        };
        html += &how_to_read(&format!(
            "One line for each policy over the frames of the camera path, which count from 1 as in the paper: frame 340 is frame 339 of \
             rayreel capture --frames. Point at a frame to read its values. Where there are few, each has a dot, and a line between \
             dots passes frames that were left out. A missing piece of a PSNR line is a frame that equals the reference. Flicker is the error of the change from frame to frame: smaller is \
             steadier. {others}"
        ));
    }
    Section::new("animation", "The animation, frame by frame", html)
}

fn chart(view: &StudyView<'_>, scene: &str, tracks: &[&Track], (title, stored, value, within, zero): &Plot) -> String {
    let unit = unit_of(tracks, stored, *value);
    // Frames without any value are left out: where only some are simulated, the line goes from one to the next.
    let known = tracks.iter().flat_map(|t| t.frames.iter().filter(|f| value(f).is_some()).map(|f| f.frame));
    let mut frames: Vec<u32> = known.collect();
    frames.sort_unstable();
    frames.dedup();
    let line = |track: &&Track| {
        let (mut values, mut intervals) = (vec![None; frames.len()], vec![None; frames.len()]);
        for frame in &track.frames {
            if let Ok(i) = frames.binary_search(&frame.frame) {
                values[i] = value(frame);
                intervals[i] = frame.interval.and_then(within).map(in_percent);
            }
        }
        if intervals.iter().all(Option::is_none) {
            intervals.clear();
        }
        let look = view.look(&track.policy);
        let [name, column] = [track.policy.clone(), track.policy.clone()];
        Line { name, column, values, intervals, class: look.class(), dash: look.dash() }
    };
    let mut lines: Vec<Line> = tracks.iter().map(line).filter(|l| l.values.iter().any(Option::is_some)).collect();
    // The policy of the summary lies on top: others would hide it where they come near.
    lines.sort_by_key(|line| view.headline == Some(line.name.as_str()));
    if lines.is_empty() {
        return String::new();
    }
    let means = lines.iter().map(|l| {
        let known: Vec<f64> = l.values.iter().flatten().copied().collect();
        format!("{} {}", l.name, fixed(known.iter().sum::<f64>() / known.len() as f64 * unit.scale, 3))
    });
    // The file of the chart keeps its name and its unit, whatever is written here.
    let shown = title.replace("T&I units", part(view)[0]).replace(&format!(", {stored}"), &format!(", {}", unit.name));
    let label = format!("Line chart, {scene}: {shown} over frames. Means: {}.", means.collect::<Vec<_>>().join(", "));
    let drawn = Lines { unit: unit.name, scale: unit.scale, frames: &frames, lines, zero: *zero }.draw(&label);
    view.charts.card(&["animation", &tracks[0].mode, scene, title], &shown, &drawn, "")
}

fn totals(scene: &str, tracks: &[&Track], part: &str) -> String {
    let unit = unit_of(tracks, "mJ", |frame| frame.energy_mj);
    let columns = [
        Head::words("Policy"),
        Head::number("Frames"),
        Head::number("Rays traced of all"),
        Head::number(&format!("{part} energy, {} a frame", unit.name)),
        Head::number("PSNR"),
        Head::number("Flicker"),
    ];
    let row = |track: &&Track| {
        let (full, traced) =
            track.frames.iter().fold((0, 0), |(full, traced), f| (full + f.rays_full, traced + f.rays_traced));
        let energy: Vec<f64> = track.frames.iter().filter_map(|f| f.energy_mj).collect();
        let sum = energy.iter().sum::<f64>();
        let off = |f: &TrackFrame| Some(f.energy_mj? * f.interval?.energy_mj);
        // Frames that are alike may be off alike, if they were estimated one by one.
        let one_by_one = || track.frames.iter().filter_map(off).sum::<f64>() / sum;
        let within = track.interval.map_or_else(one_by_one, |interval| interval.energy_mj);
        let (known, all) = (energy.len(), track.frames.len());
        let of = if known < all { format!(" ({known} of {all} frames)") } else { String::new() };
        let energy = (known > 0).then(|| sum / known as f64);
        let cells = vec![
            escape(&track.policy),
            all.to_string(),
            percent(traced as f64 / (full as f64).max(1.0)),
            or_dash(energy, |e| fixed(e * unit.scale, 3) + &plus_minus(Some(within)) + &of),
            psnr(track.psnr_db),
            or_dash(track.flicker, |f| fixed(f, 4)),
        ];
        (String::new(), cells)
    };
    table(&format!("{scene}: all frames that were replayed"), &columns, &tracks.iter().map(row).collect::<Vec<_>>())
}
