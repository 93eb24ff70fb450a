//! What a study says in the mean: its policies over all scenes, over the flight, and with one choice changed.
//!
//! ```console
//! $ cargo run --release --example means -- releases/paper-full/study.json
//! ```
//!
//! prints three tables as Markdown: geometric means of performance per watt over that of `full`, with the lowest PSNR of the scenes, by mode
//! and policy; of every policy of the flight the rays in percent of all, the mean energy of a frame on the T&I units alone and
//! the PSNR of the mean squared error; and of every choice that was changed, scene by scene, what the whole GPU then does over what it did.

use std::error::Error;

use rayreel_study::schema::{Ablation, Gain, Point, Study, Track};

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
    ablations(&study.ablations);
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

/// The choices that were changed, one a row, with three columns for each scene.
fn ablations(list: &[Ablation]) {
    let changed: Vec<&Ablation> = list.iter().filter(|ablation| !ablation.base).collect();
    let (mut scenes, mut choices): (Vec<&str>, Vec<&Ablation>) = (Vec::new(), Vec::new());
    for ablation in &changed {
        if !scenes.contains(&&*ablation.scene) {
            scenes.push(&ablation.scene);
        }
        if choices.iter().all(|known| choice(known) != choice(ablation)) {
            choices.push(ablation);
        }
    }
    let heads: String = scenes.iter().map(|scene| format!(" {scene}: perf/W | cycles | PSNR, dB |")).collect();
    println!("\n| policy | choice | changed to |{heads}\n|---|---|---|{}", "---|".repeat(3 * scenes.len()));
    let mut last = ("", "");
    for of in choices {
        let in_scene = |scene: &&str| changed.iter().find(|a| choice(a) == choice(of) && a.scene == **scene);
        let cells: String = scenes
            .iter()
            .map(|scene| in_scene(scene).map_or(" - | - | - |".into(), |found| over_base(found, list)))
            .collect();
        let policy = if last.0 == of.policy { String::new() } else { format!("`{}`", of.policy) };
        let group = if last == (&of.policy, &of.group) { "" } else { &*of.group };
        let note = if of.note.is_empty() { String::new() } else { format!(": {}", of.note) };
        println!("| {policy} | {group} | {}{note} |{cells}", of.name);
        last = (&of.policy, &of.group);
    }
}

/// What was changed, whatever the scene.
fn choice(ablation: &Ablation) -> (&str, &str, &str, &str) {
    (&ablation.group, &ablation.name, &ablation.mode, &ablation.policy)
}

/// Cells of a choice in a scene: performance per watt and cycles over those of the base, and decibels more.
fn over_base(ablation: &Ablation, list: &[Ablation]) -> String {
    let is_base = |base: &&Ablation| {
        let of = |a: &Ablation| (a.group.clone(), a.scene.clone(), a.mode.clone(), a.policy.clone());
        base.base && of(base) == of(ablation)
    };
    let Some(base) = list.iter().find(is_base) else { return " - | - | - |".into() };
    let ratio = |of: Option<f64>, by: Option<f64>| of.zip(by).map(|(of, by)| of / by);
    let half = |ratio: f64| ablation.gain_interval.map(|half| format!(" ± {:.2}", ratio * half.perf_per_watt));
    let perf = ratio(ablation.perf_per_watt, base.perf_per_watt);
    let perf = perf.map_or("-".into(), |ratio| format!("{ratio:.2}{}", half(ratio).unwrap_or_default()));
    let cycles = ratio(ablation.cycles.map(|c| c as f64), base.cycles.map(|c| c as f64));
    let cycles = cycles.map_or("-".into(), |ratio| format!("{ratio:.2}"));
    let more = ablation.psnr_db.zip(base.psnr_db).map(|(db, base)| db - base);
    let more = more.map_or("-".into(), |db| if db.abs() < 0.05 { "0".into() } else { format!("{db:+.1}") });
    format!(" {perf} | {cycles} | {more} |")
}
