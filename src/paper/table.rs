//! The experiment's results: for people and for programs, beside the paper's.

use std::fmt::Write as _;

use rayreel_replay::machine::srp::KernelId;
use rayreel_replay::report::Report;
use rayreel_replay::report::run::{Cost, RunFigures};
use serde_json::{Value, json};

/// The two ways of the paper to use the adaptive policy: name, samples per pixel and axis.
pub const MODES: [(&str, u32); 2] = [("supersampling", 2), ("undersampling", 1)];

/// PSNR in the paper's Table 1, dB: scene, supersampling, undersampling. The scenes here are our own; only their kind and
/// triangle count are the paper's.
const PAPER_PSNR: [(&str, [f64; 2]); 2] = [("teapot", [48.99, 42.13]), ("chess", [28.53, 34.73])];

/// Performance per watt over full in the paper's Figure 7, T&I units alone: scene, least, most. For the scenes that are not
/// smooth the paper states a least value only.
const PAPER_GAIN: [(&str, f64, Option<f64>); 5] = [
    ("teapot", 2.43, Some(2.98)),
    ("car", 2.43, Some(2.98)),
    ("chess", 1.53, None),
    ("lab", 1.53, None),
    ("provence", 1.53, None),
];

/// Power over full in the paper, mean of all scenes, T&I units alone.
const PAPER_POWER: f64 = 1.09;

/// SRP cycles in the paper: similarity test, interpolation.
const PAPER_SRP: [f64; 2] = [0.05, 0.06];

/// Full and adaptive on one machine.
pub struct Pair {
    /// Every sample traced.
    pub full: Report,
    /// The adaptive policy.
    pub adaptive: Report,
}

/// One scene in one mode.
pub struct Row {
    /// Scene, as a file name.
    pub scene: String,
    /// Index into [`MODES`].
    pub mode: usize,
    /// The adaptive policy with its picture compared.
    pub adaptive: Report,
    /// The machine, and the machine with an SRP that takes no time.
    pub runs: Option<Runs>,
}

/// What was simulated.
pub struct Runs {
    /// The whole machine: `full`; `adaptive` is the row's.
    pub full: Report,
    /// The T&I units alone, as in the paper's Figure 7.
    pub alone: Pair,
}

/// Adaptive relative to full.
#[derive(Clone, Copy)]
struct Gain {
    performance: f64,
    power: f64,
    efficiency: f64,
}

impl Gain {
    /// Of the machine's part that `cost` chooses; nothing where nothing was simulated.
    fn new(full: &RunFigures, adaptive: &RunFigures, cost: fn(&RunFigures) -> Option<Cost>) -> Option<Self> {
        let (full_cost, adaptive_cost) = (cost(full)?, cost(adaptive)?);
        Some(Self {
            performance: adaptive.fps? / full.fps?,
            power: adaptive_cost.power_w? / full_cost.power_w?,
            efficiency: adaptive_cost.perf_per_watt? / full_cost.perf_per_watt?,
        })
    }

    fn json(gain: Option<Self>) -> Value {
        gain.map_or(
            Value::Null,
            |g| json!({ "performance": g.performance, "power": g.power, "perf_per_watt": g.efficiency }),
        )
    }
}

impl Runs {
    fn alone(&self) -> Option<Gain> {
        Gain::new(&self.alone.full.run, &self.alone.adaptive.run, |run| Some(run.ti))
    }

    fn gpu(&self, adaptive: &Report) -> Option<Gain> {
        Gain::new(&self.full.run, &adaptive.run, |run| run.gpu)
    }
}

/// Busy cycles of the SRPs, and those of similarity test and interpolation among them.
fn srp_cycles(report: &Report) -> Option<(u64, [u64; 2])> {
    let (_, run) = report.machine_run.as_ref()?;
    let (mut busy, mut own) = (0, [0; 2]);
    for srp in run.stats.cores.iter().map(|core| &core.srp) {
        busy += srp.activity.busy_cycles();
        own[0] += srp.kernels[KernelId::Similarity as usize].cycles;
        own[1] += srp.kernels[KernelId::Interpolate as usize].cycles;
    }
    Some((busy, own))
}

fn paper_psnr(row: &Row) -> Option<f64> {
    PAPER_PSNR.iter().find(|(name, _)| *name == row.scene).map(|(_, psnr)| psnr[row.mode])
}

fn paper_gain(row: &Row) -> Option<(f64, Option<f64>)> {
    PAPER_GAIN.iter().find(|(name, ..)| *name == row.scene).map(|&(_, least, most)| (least, most))
}

/// A row for programs.
pub fn json_row(row: &Row) -> Value {
    let sum = &row.adaptive.sum;
    let mut value = json!({
        "scene": row.scene,
        "mode": MODES[row.mode].0,
        "policy": row.adaptive.policy,
        "machine": row.adaptive.machine,
        "rays_full": sum.rays_full,
        "rays_traced": sum.rays_traced,
        "ray_ratio": ray_ratio(&row.adaptive),
        "similarity_ratio": sum.similarity_ratio,
        "psnr_db": sum.psnr_db,
        "ssim": sum.ssim,
        "paper_psnr_db": paper_psnr(row),
        "ti_alone": null,
        "gpu": null,
        "srp": null,
    });
    let Some(runs) = &row.runs else { return value };
    let paper = paper_gain(row).map(|(least, most)| json!({ "least": least, "most": most }));
    value["ti_alone"] = json!({
        "full": runs.alone.full.run,
        "adaptive": runs.alone.adaptive.run,
        "gain": Gain::json(runs.alone()),
        "paper_perf_per_watt": paper,
        "paper_power": PAPER_POWER,
    });
    value["gpu"] = json!({
        "full": runs.full.run,
        "adaptive": row.adaptive.run,
        "gain": Gain::json(runs.gpu(&row.adaptive)),
    });
    if let Some((busy, [similarity, interpolation])) = srp_cycles(&row.adaptive) {
        value["srp"] = json!({
            "busy_cycles": busy,
            "similarity_cycles": similarity,
            "interpolation_cycles": interpolation,
            "similarity_share": share(similarity, busy),
            "interpolation_share": share(interpolation, busy),
            "paper_similarity_share": PAPER_SRP[0],
            "paper_interpolation_share": PAPER_SRP[1],
        });
    }
    value
}

fn ray_ratio(adaptive: &Report) -> f64 {
    adaptive.sum.rays_full as f64 / adaptive.sum.rays_traced as f64
}

fn share(part: u64, whole: u64) -> Option<f64> {
    (whole > 0).then(|| part as f64 / whole as f64)
}

fn or_dash(value: Option<f64>, digits: usize) -> String {
    value.map_or("-".to_string(), |v| format!("{v:.digits$}"))
}

/// All rows for people.
pub fn table(size: (u32, u32), rows: &[Row]) -> String {
    let (w, h) = size;
    let mut text =
        format!("adaptive sampling against full, {w}x{h} pixels; the paper's PSNR is for its own models\n\n");
    text += &format!(
        "{:<10} {:<14} {:>13} {:>13} {:>10} {:>8} {:>9} {:>9} {:>7}\n",
        "scene", "mode", "rays, full", "rays, adapt.", "ray ratio", "similar", "PSNR dB", "paper dB", "SSIM"
    );
    for row in rows {
        let sum = &row.adaptive.sum;
        let _ = writeln!(
            text,
            "{:<10} {:<14} {:>13} {:>13} {:>10.2} {:>8} {:>9} {:>9} {:>7}",
            row.scene,
            MODES[row.mode].0,
            sum.rays_full,
            sum.rays_traced,
            ray_ratio(&row.adaptive),
            or_dash(sum.similarity_ratio.map(|r| r * 100.0), 1) + " %",
            or_dash(sum.psnr_db, 2),
            or_dash(paper_psnr(row), 2),
            or_dash(sum.ssim, 4),
        );
    }
    if let Some(machine) = rows.first().and_then(|row| row.runs.as_ref().and(row.adaptive.machine.as_ref())) {
        text += &gains(machine, rows);
        text += &speeds(machine, rows);
    }
    text
}

/// Adaptive relative to full.
fn gains(machine: &str, rows: &[Row]) -> String {
    let mut text = format!(
        "\nadaptive relative to full on {machine}; T&I alone is as in the paper's Figure 7: its SRP takes no time\n\n"
    );
    let _ =
        writeln!(text, "{:<25} {:-^34}   {:-^20}   {:-^19}", "", " T&I units alone ", " whole GPU ", " % of SRP busy ");
    let _ = writeln!(
        text,
        "{:<10} {:<14} {:>6} {:>6} {:>7} {:>12}   {:>6} {:>6} {:>6}   {:>9} {:>9}",
        "scene", "mode", "perf", "power", "perf/W", "paper", "perf", "power", "perf/W", "similar.", "interp."
    );
    for row in rows {
        let Some(runs) = &row.runs else { continue };
        let [alone, gpu] = [runs.alone(), runs.gpu(&row.adaptive)].map(|gain| {
            [gain.map(|g| g.performance), gain.map(|g| g.power), gain.map(|g| g.efficiency)].map(|v| or_dash(v, 2))
        });
        let paper = match paper_gain(row) {
            Some((least, Some(most))) => format!("{least} to {most}"),
            Some((least, None)) => format!(">= {least}"),
            None => "-".into(),
        };
        let srp = srp_cycles(&row.adaptive);
        let srp = [0, 1].map(|i| or_dash(srp.and_then(|(busy, own)| share(own[i], busy)).map(|s| s * 100.0), 1));
        let _ = writeln!(
            text,
            "{:<10} {:<14} {:>6} {:>6} {:>7} {paper:>12}   {:>6} {:>6} {:>6}   {:>9} {:>9}",
            row.scene, MODES[row.mode].0, alone[0], alone[1], alone[2], gpu[0], gpu[1], gpu[2], srp[0], srp[1]
        );
    }
    let _ = writeln!(
        text,
        "{:<25} {:>6} {:>6} {:>7} {:>12}   {:>6} {:>6} {:>6}   {:>9} {:>9}",
        "the paper, mean",
        "",
        PAPER_POWER,
        "",
        "",
        "",
        "",
        "",
        format!("{:.0}", PAPER_SRP[0] * 100.0),
        format!("{:.0}", PAPER_SRP[1] * 100.0)
    );
    text
}

/// How fast it is, and at what power.
fn speeds(machine: &str, rows: &[Row]) -> String {
    let mut text = format!("\nwhole GPU, {machine}\n\n");
    let _ = writeln!(text, "{:<25} {:-^31}   {:-^31}", "", " full ", " adaptive ");
    let _ = writeln!(
        text,
        "{:<10} {:<14} {:>9} {:>9} {:>11}   {:>9} {:>9} {:>11}",
        "scene", "mode", "frames/s", "Mrays/s", "power W", "frames/s", "Mrays/s", "power W"
    );
    for row in rows {
        let Some(runs) = &row.runs else { continue };
        let [full, adaptive] = [&runs.full.run, &row.adaptive.run].map(|run| {
            let power = or_dash(run.gpu.and_then(|gpu| gpu.power_w), 2);
            format!("{:>9} {:>9} {power:>11}", or_dash(run.fps, 1), or_dash(run.mrays_per_s, 1))
        });
        let _ = writeln!(text, "{:<10} {:<14} {full}   {adaptive}", row.scene, MODES[row.mode].0);
    }
    text
}
