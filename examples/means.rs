//! What a study says in the mean: its policies over all scenes, and over the flight.
//!
//! ```console
//! $ cargo run --release --example means -- releases/paper-full/study.json
//! ```
//!
//! prints both as Markdown: geometric means of performance per watt over that of `full`, with the lowest PSNR of the scenes, by mode and
//! policy; and of every policy of the flight the rays in percent of all, the mean energy of a frame on the T&I units alone and
//! the PSNR of the mean squared error.

use std::error::Error;

use rayreel_study::schema::{Gain, Point, Study, Track};

/// What fixed blocks are called in the documents.
const NAMES: [(&str, &str); 3] =
    [("fixed 2x2", "one block of 2"), ("fixed 4x4", "one block of 4"), ("fixed 8x8", "one block of 8")];

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give a study.json")?;
    let read = || -> Result<Study, Box<dyn Error>> { Ok(serde_json::from_slice(&std::fs::read(&path)?)?) };
    let study = read().map_err(|error| format!("{path}: {error}"))?;
    println!("| samples a pixel | policy | T&I units alone | whole GPU | PSNR at least, dB |\n|---|---|---|---|---|");
    let mut last_mode = "";
    for (mode, policy) in kinds(&study) {
        let of: Vec<&Point> = study.points.iter().filter(|p| (&*p.mode, &*p.policy) == (mode, policy)).collect();
        let psnr = of.iter().filter_map(|point| point.quality?.psnr_db).fold(f64::INFINITY, f64::min);
        let [ti, gpu] = [mean(&of, |point| point.ti_gain), mean(&of, |point| point.gpu_gain)];
        println!("| {} | `{policy}` | {ti} | {gpu} | {psnr:.1} |", if mode == last_mode { "" } else { mode });
        last_mode = mode;
    }
    println!("\n| policy | rays, % | energy, mJ a frame | PSNR, dB |\n|---|---|---|---|");
    for track in study.tracks.iter().filter(|track| track.frames.iter().all(|frame| frame.energy_mj.is_some())) {
        println!("{}", flight(track));
    }
    Ok(())
}

/// Modes with their policies, `full` left out, in the order of the study.
fn kinds(study: &Study) -> Vec<(&str, &str)> {
    let mut kinds = Vec::new();
    for Point { mode, policy, .. } in &study.points {
        if policy != "full" && !kinds.contains(&(mode.as_str(), policy.as_str())) {
            kinds.push((mode, policy));
        }
    }
    kinds
}

/// The geometric mean of performance per watt, `-` where not all were simulated.
fn mean(points: &[&Point], gain: impl Fn(&Point) -> Option<Gain>) -> String {
    let logs: Option<Vec<f64>> = points.iter().map(|point| Some(gain(point)?.perf_per_watt.ln())).collect();
    logs.map_or("-".into(), |logs| format!("{:.2}", (logs.iter().sum::<f64>() / logs.len() as f64).exp()))
}

/// The row of a policy of the flight.
fn flight(track: &Track) -> String {
    let name = NAMES
        .iter()
        .find(|(name, _)| *name == track.policy)
        .map_or(format!("`{}`", track.policy), |(_, n)| (*n).into());
    let (mut traced, mut full, mut energy) = (0, 0, 0.0);
    for frame in &track.frames {
        (traced, full) = (traced + frame.rays_traced, full + frame.rays_full);
        energy += frame.energy_mj.unwrap_or_default();
    }
    let rays = 100.0 * traced as f64 / full as f64;
    let rays = if traced == full { format!("{rays:.0}") } else { format!("{rays:.1}") };
    let interval = track.interval.map_or(String::new(), |interval| format!(" ± {:.1} %", 100.0 * interval.energy_mj));
    let psnr = track.psnr_db.map_or(String::new(), |db| format!("{db:.1} "));
    format!("| {name} | {rays} | {:.3}{interval} | {psnr}|", energy / track.frames.len() as f64)
}
