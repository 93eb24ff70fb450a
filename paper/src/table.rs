//! The results for people, beside the paper's.

use std::fmt::Write as _;

use rayreel_study::schema::{Ablation, Gain, Point, Study};

use crate::cells::{or_dash, plus_minus, psnr};
use crate::claims::claims;
use crate::policies::{MODES, word};
use crate::widths::Widths;
use crate::{systems, totals};

/// Everything that is printed.
pub fn table(study: &Study) -> String {
    let (w, h) = (study.width, study.height);
    let mut text =
        format!("the paper's policies against full, {w}x{h} pixels; the paper's PSNR is for its own models\n\n");
    text += &quality(study);
    if let Some(machine) = &study.machine {
        text += &gains(study, machine);
    }
    text += &claims(study, &evaluated(study).collect::<Vec<_>>());
    text += &all(study);
    text += &totals::table(study);
    text += &ablations(&study.ablations, Widths::of(study));
    text += &systems::table(study);
    text += "\nnotes\n";
    study.notes.iter().for_each(|note| text += &format!("- {note}\n"));
    text
}

/// The points of the policies that the paper evaluated.
fn evaluated(study: &Study) -> impl Iterator<Item = &Point> {
    let stated =
        |p: &&Point| study.references.policies.iter().any(|known| known.mode == p.mode && known.policy == p.policy);
    study.points.iter().filter(stated)
}

/// The PSNR of a point, whose pictures may not have been compared.
fn psnr_of(point: &Point) -> String {
    point.quality.map_or("-".into(), |quality| psnr(quality.psnr_db))
}

fn ray_ratio(point: &Point) -> f64 {
    point.rays_full as f64 / point.rays_traced.max(1) as f64
}

fn quality(study: &Study) -> String {
    let Widths { scene, .. } = Widths::of(study);
    let mut text = format!(
        "{:<scene$} {:<14} {:>13} {:>13} {:>10} {:>8} {:>9} {:>9} {:>7}\n",
        "scene", "mode", "rays, full", "rays, traced", "ray ratio", "rate %", "PSNR dB", "paper dB", "SSIM"
    );
    for p in evaluated(study) {
        let paper = study.references.psnr.iter().find(|paper| paper.scene == p.scene && paper.mode == p.mode);
        let _ = writeln!(
            text,
            "{:<scene$} {:<14} {:>13} {:>13} {:>10.2} {:>8.1} {:>9} {:>9} {:>7}",
            p.scene,
            word(&p.mode),
            p.rays_full,
            p.rays_traced,
            ray_ratio(p),
            p.mean_rate * 100.0,
            psnr_of(p),
            or_dash(paper.map(|paper| paper.psnr_db), 2),
            or_dash(p.quality.and_then(|q| q.ssim), 4),
        );
    }
    text
}

fn factors(gain: Option<Gain>) -> [String; 3] {
    [or_dash(gain.map(|g| g.performance), 2), or_dash(gain.map(|g| g.power), 2), perf_per_watt(gain)]
}

/// The factor of performance per watt; of an estimate with half the width of its interval behind it.
fn perf_per_watt(gain: Option<Gain>) -> String {
    let within = gain.and_then(|g| g.interval).map_or_else(String::new, |i| plus_minus(i.perf_per_watt));
    or_dash(gain.map(|g| g.perf_per_watt), 2) + &within
}

/// Whether any gain is an estimate: then columns of them are wider.
fn is_estimated(study: &Study) -> bool {
    study.points.iter().flat_map(|p| [p.ti_gain, p.gpu_gain]).flatten().any(|gain| gain.interval.is_some())
}

/// The paper's policies relative to full.
fn gains(study: &Study, machine: &str) -> String {
    let mut text =
        format!("\nrelative to full on {machine}; T&I alone is as in the paper's Figure 7: its SRP takes no time\n\n");
    let [of_alone, of_gpu] = if is_estimated(study) { [12, 12] } else { [7, 6] };
    let (alone, gpu) = (27 + of_alone, 14 + of_gpu);
    let Widths { scene, .. } = Widths::of(study);
    let names = scene + 15;
    let _ = writeln!(
        text,
        "{:<names$} {:-^alone$}   {:-^gpu$}   {:-^19}",
        "", " T&I units alone ", " whole GPU ", " % of SRP busy "
    );
    let _ = writeln!(
        text,
        "{:<scene$} {:<14} {:>6} {:>6} {:>of_alone$} {:>12}   {:>6} {:>6} {:>of_gpu$}   {:>9} {:>9}",
        "scene", "mode", "perf", "power", "perf/W", "paper", "perf", "power", "perf/W", "similar.", "interp."
    );
    for p in evaluated(study) {
        let [alone, gpu] = [p.ti_gain, p.gpu_gain].map(factors);
        let band = study.references.gains.iter().find(|band| band.scene == p.scene);
        let paper = band.map_or("-".into(), |b| match b.most {
            Some(most) => format!("{} to {most}", b.least),
            None => format!(">= {}", b.least),
        });
        let shares = p.sampling_shares().map(|share| share.map(|share| share * 100.0));
        let _ = writeln!(
            text,
            "{:<scene$} {:<14} {:>6} {:>6} {:>of_alone$} {paper:>12}   {:>6} {:>6} {:>of_gpu$}   {:>9} {:>9}",
            p.scene,
            word(&p.mode),
            alone[0],
            alone[1],
            alone[2],
            gpu[0],
            gpu[1],
            gpu[2],
            or_dash(shares[0], 1),
            or_dash(shares[1], 1)
        );
    }
    let paper = |name: &str| study.references.srp.iter().find(|k| k.kernel == name).map(|k| k.share * 100.0);
    let _ = writeln!(
        text,
        "{:<names$} {:>6} {:>6} {:>of_alone$} {:>12}   {:>6} {:>6} {:>of_gpu$}   {:>9} {:>9}",
        "the paper",
        "",
        or_dash(study.references.power, 2),
        "",
        "",
        "",
        "",
        "",
        or_dash(paper("similarity"), 0),
        or_dash(paper("interpolate"), 0)
    );
    text
}

/// All policies in both modes.
fn all(study: &Study) -> String {
    let mut text = String::new();
    let wide = if is_estimated(study) { 12 } else { 10 };
    let widths @ Widths { scene, policy } = Widths::of(study);
    for mode in &MODES {
        let _ = writeln!(
            text,
            "\nevery policy, {}; gains over full {}, T&I alone and whole GPU{}\n",
            mode.word,
            mode.name,
            if mode.samples == 1 { ", and of the T&I alone over full 2x2" } else { "" }
        );
        let _ = writeln!(
            text,
            "{:<policy$} {:<scene$} {:>9} {:>8} {:>7} {:>7} {:>9} {:>7}  {:>wide$} {:>wide$} {:>wide$}",
            "policy",
            "scene",
            "ray ratio",
            "PSNR dB",
            "SSIM",
            "FLIP",
            "worst dB",
            "rate %",
            "T&I perf/W",
            "GPU perf/W",
            "over 2x2"
        );
        for policy in study.policies.iter().filter(|p| p.name != "full") {
            let points: Vec<&Point> =
                study.points.iter().filter(|p| p.mode == mode.name && p.policy == policy.name).collect();
            points.iter().for_each(|point| text += &line(point, mode.samples == 1, (widths, wide)));
            if points.len() > 1 {
                text += &mean(&policy.name, &points, mode.samples == 1, (widths, wide));
            }
        }
    }
    text
}

fn line(p: &Point, over: bool, (Widths { scene, policy }, wide): (Widths, usize)) -> String {
    let quality = p.quality.unwrap_or_default();
    format!(
        "{:<policy$} {:<scene$} {:>9.2} {:>8} {:>7} {:>7} {:>9} {:>7.1}  {:>wide$} {:>wide$} {:>wide$}\n",
        p.policy,
        p.scene,
        ray_ratio(p),
        psnr_of(p),
        or_dash(quality.ssim, 4),
        or_dash(quality.flip, 4),
        or_dash(quality.worst_tile_psnr_db, 2),
        p.mean_rate * 100.0,
        perf_per_watt(p.ti_gain),
        perf_per_watt(p.gpu_gain),
        if over { perf_per_watt(p.fsaa_gain) } else { String::new() }
    )
}

/// Geometric means over the scenes.
fn mean(name: &str, points: &[&Point], over: bool, (Widths { scene, policy }, wide): (Widths, usize)) -> String {
    let mean = |values: Vec<Option<f64>>| or_dash(geometric_mean(values), 2);
    let watt = |gain: fn(&Point) -> Option<Gain>| {
        mean(points.iter().map(|point| gain(point).map(|g| g.perf_per_watt)).collect())
    };
    format!(
        "{name:<policy$} {:<scene$} {:>9} {:>8} {:>7} {:>7} {:>9} {:>7}  {:>wide$} {:>wide$} {:>wide$}\n",
        "(geo mean)",
        mean(points.iter().map(|point| Some(ray_ratio(point))).collect()),
        "",
        "",
        "",
        "",
        "",
        watt(|p| p.ti_gain),
        watt(|p| p.gpu_gain),
        if over { watt(|p| p.fsaa_gain) } else { String::new() }
    )
}

/// Nothing where a value is missing. The product is of a few factors near one, and its root is found by halving: the
/// platform's logarithm would not give the same digits everywhere.
fn geometric_mean(values: Vec<Option<f64>>) -> Option<f64> {
    let values: Vec<f64> = values.into_iter().collect::<Option<_>>()?;
    let (mut low, mut high) =
        (values.iter().copied().fold(f64::INFINITY, f64::min), values.iter().copied().fold(0.0, f64::max));
    for _ in 0..64 {
        let middle = 0.5 * (low + high);
        if values.iter().map(|v| v / middle).product::<f64>() > 1.0 { low = middle } else { high = middle }
    }
    Some(0.5 * (low + high))
}

/// The ablations, each relative to the unchanged one of its group.
fn ablations(all: &[Ablation], Widths { scene, .. }: Widths) -> String {
    if all.is_empty() {
        return String::new();
    }
    let mut text = "\none choice changed at a time, whole GPU; factors over the first of each group\n".to_owned();
    let mut group = "";
    for ablation in all {
        if ablation.group != group {
            group = &ablation.group;
            let _ = writeln!(
                text,
                "\n{:<34} {:<scene$} {:>9} {:>8} {:>10} {:>10} {:>10}",
                group, "scene", "ray ratio", "PSNR dB", "cycles", "power", "perf/W"
            );
        }
        let base = all.iter().find(|b| b.base && b.group == ablation.group && b.scene == ablation.scene);
        let over = |of: fn(&Ablation) -> Option<f64>| or_dash(base.and_then(|b| Some(of(ablation)? / of(b)?)), 3);
        let _ = writeln!(
            text,
            "{:<34} {:<scene$} {:>9.2} {:>8} {:>10} {:>10} {:>10}",
            ablation.name,
            ablation.scene,
            ablation.rays_full as f64 / ablation.rays_traced.max(1) as f64,
            psnr(ablation.psnr_db),
            over(|a| a.cycles.map(|c| c as f64)),
            over(|a| a.power_w),
            over(|a| a.perf_per_watt)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use rayreel_study::schema::Ablation;

    use super::*;

    /// A dash stood for it, as for what was not measured.
    #[test]
    fn an_ablation_that_changes_no_pixel_has_the_same_picture() {
        let row = |psnr_db| Ablation { name: "off".into(), psnr_db, ..Ablation::default() };
        let text = ablations(&[row(None), row(Some(31.416))], Widths::of(&Study::default()));
        let said: Vec<&str> =
            text.lines().filter_map(|line| line.strip_prefix("off")?.split_whitespace().nth(1)).collect();
        assert_eq!(said, ["same", "31.42"], "{text}");
    }

    #[test]
    fn the_geometric_mean() {
        assert!((geometric_mean(vec![Some(2.0), Some(8.0)]).unwrap() - 4.0).abs() < 1e-12);
        assert!((geometric_mean(vec![Some(3.0)]).unwrap() - 3.0).abs() < 1e-12);
        assert_eq!(geometric_mean(vec![Some(2.0), None]), None);
    }
}
