//! What policies give over `full`, from a study or from the sweep.

use std::collections::BTreeMap;
use std::error::Error;
use std::path::Path;

use rayreel_study::schema::{Gain, Point, Study};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

/// The scenes in the paper's order.
pub const SCENES: [&str; 5] = ["teapot", "chess", "car", "lab", "provence"];

/// The policies of the table, for each scene in this order.
const POLICIES: [&str; 2] = ["paper-ss", "multirate"];

/// A policy on a scene.
pub struct Row {
    pub scene: String,
    pub policy: String,
    /// Rays of `full` over those traced.
    pub ray_ratio: f64,
    pub psnr_db: f64,
    pub flip: f64,
    /// Performance, power and performance per watt over those of `full`: of the T&I units alone, and of the whole GPU.
    pub gain: [f64; 3],
    pub gpu: [f64; 3],
}

/// Reads `study.json`, or `results.csv` of the sweep; rows come scene by scene, `paper-ss` before `multirate`.
pub fn read(path: &Path) -> Result<Vec<Row>> {
    let is_study = path.extension().is_some_and(|ending| ending == "json");
    let rows = if is_study { of_study(path) } else { of_sweep(path) };
    Ok(rows.map_err(|error| format!("{}: {error}", path.display()))?)
}

fn of_study(path: &Path) -> Result<Vec<Row>> {
    let study: Study = serde_json::from_slice(&std::fs::read(path)?)?;
    let row = |scene: &str, policy: &str| {
        let is = |point: &&Point| (&*point.scene, &*point.policy, &*point.mode) == (scene, policy, "2x2");
        let point = study.points.iter().find(is);
        let none = || format!("not all figures of {scene} under {policy}");
        let point = point.ok_or_else(none)?;
        let factors = |gain: Gain| [gain.performance, gain.power, gain.perf_per_watt];
        let quality = point.quality.ok_or_else(none)?;
        Ok(Row {
            scene: scene.into(),
            policy: policy.into(),
            ray_ratio: point.rays_full as f64 / point.rays_traced as f64,
            psnr_db: quality.psnr_db.ok_or_else(none)?,
            flip: quality.flip.ok_or_else(none)?,
            gain: point.ti_gain.map(factors).ok_or_else(none)?,
            gpu: point.gpu_gain.map(factors).ok_or_else(none)?,
        })
    };
    SCENES.iter().flat_map(|scene| POLICIES.iter().map(|policy| row(scene, policy))).collect()
}

fn of_sweep(path: &Path) -> Result<Vec<Row>> {
    let mut points: BTreeMap<(String, String, String), BTreeMap<String, String>> = BTreeMap::new();
    for record in csv::Reader::from_path(path)?.deserialize::<BTreeMap<String, String>>() {
        let record = record?;
        let part = record.get("srp").cloned().ok_or("no column srp")?;
        points.insert((record["scene"].clone(), record["policy"].clone(), part), record);
    }
    let row = |scene: &str, policy: &str| {
        let value = |policy: &str, part: &str, name: &str| -> Result<f64> {
            let point = points.get(&(scene.to_owned(), policy.to_owned(), part.to_owned()));
            let point = point.ok_or_else(|| format!("no {scene} under {policy}"))?;
            Ok(point.get(name).ok_or_else(|| format!("no column {name}"))?.parse()?)
        };
        let over =
            |part: &str, name: &str| -> Result<f64> { Ok(value(policy, part, name)? / value("full", part, name)?) };
        let [alone, whole] = ["alone", "whole"];
        Ok(Row {
            scene: scene.into(),
            policy: policy.into(),
            ray_ratio: value(policy, alone, "rays_full")?
                / (value(policy, alone, "rays_traced")? + value(policy, alone, "rays_apron")?),
            psnr_db: value(policy, alone, "psnr_db")?,
            flip: value(policy, alone, "flip")?,
            gain: [1.0 / over(alone, "time_ms")?, over(alone, "power_w")?, over(alone, "perf_per_watt")?],
            gpu: [1.0 / over(whole, "time_ms")?, over(whole, "gpu_power_w")?, over(whole, "gpu_perf_per_watt")?],
        })
    };
    SCENES.iter().flat_map(|scene| POLICIES.iter().map(|policy| row(scene, policy))).collect()
}

/// The geometric mean of a figure of a policy over the scenes.
pub fn mean(rows: &[Row], policy: &str, figure: fn(&Row) -> f64) -> f64 {
    let values: Vec<f64> = rows.iter().filter(|row| row.policy == policy).map(figure).collect();
    (values.iter().map(|value| value.ln()).sum::<f64>() / values.len() as f64).exp()
}

/// What the paper has for a scene: perf/W and PSNR (Figure 7 and Table 1; perf/W of `provence` is that of Figure 1).
pub fn paper(scene: &str) -> (&'static str, &'static str) {
    match scene {
        "teapot" => ("2.43 to 2.98", "49.0"),
        "chess" => ("at least 1.53", "28.5"),
        "car" => ("2.43 to 2.98", "34.1"),
        "lab" => ("at least 1.53", "36.3"),
        _ => ("1.83", "30.5"),
    }
}

/// The table of the README.
pub fn markdown(rows: &[Row]) -> String {
    let mut text = "| | | | | | T&I units alone | | | whole GPU | | | the paper | |\n\
                    |---|---|---|---|---|---|---|---|---|---|---|---|---|\n\
                    | scene | policy | ray ratio | PSNR dB | FLIP | perf | power | perf/W | perf | power | perf/W | perf/W | PSNR dB |\n"
        .to_owned();
    for row in rows {
        let Row { ray_ratio, psnr_db, flip, gain, gpu, .. } = row;
        let (scene, band, paper_psnr) = match &*row.policy {
            "paper-ss" => (&*row.scene, paper(&row.scene).0, paper(&row.scene).1),
            _ => ("", "", ""),
        };
        let factors: String = gain.iter().chain(gpu).map(|factor| format!("{factor:.2} | ")).collect();
        text += &format!(
            "| {scene} | `{}` | {ray_ratio:.2} | {psnr_db:.1} | {flip:.4} | {factors}{band} | {paper_psnr} |\n",
            row.policy
        );
    }
    for (scene, policy) in [("geometric mean", "paper-ss"), ("", "multirate")] {
        let rays = mean(rows, policy, |row| row.ray_ratio);
        let of: [fn(&Row) -> f64; 6] =
            [|r| r.gain[0], |r| r.gain[1], |r| r.gain[2], |r| r.gpu[0], |r| r.gpu[1], |r| r.gpu[2]];
        let factors: String = of.iter().map(|of| format!("{:.2} | ", mean(rows, policy, *of))).collect();
        text += &format!("| {scene} | `{policy}` | {rays:.2} | | | {factors} | |\n");
    }
    text
}
