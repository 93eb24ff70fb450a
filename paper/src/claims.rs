//! What the paper claims, put to the test: its overhead, its performance in proportion to the rays cut, its power.

use std::fmt::Write as _;

use rayreel_study::schema::{Point, Study};

use crate::policies::word;
use crate::widths::Widths;

/// More time than a free SRP takes, by which an SRP hinders the T&I units.
const HINDERS: f64 = 1.05;

/// Fewer points than this tell nothing of a line.
const POINTS_LEAST: usize = 3;

/// The section: verdicts on the points of the policies that the paper evaluated, with `headline` beside them.
pub fn claims(study: &Study, evaluated: &[&Point]) -> String {
    overhead(study, evaluated) + &proportion(evaluated) + &power(study, evaluated)
}

/// "Cannot hinder the T&I unit": the time of a frame with the SRP over that with one that takes no time. `full` has no sampling
/// to pay for; what a policy has more than `full` is sampling's.
fn overhead(study: &Study, evaluated: &[&Point]) -> String {
    let slower = |p: &Point| Some(p.gpu?.time_ms / p.ti?.time_ms);
    let Widths { scene, .. } = Widths::of(study);
    let mut rows = String::new();
    let (mut held, mut all) = (0, 0);
    for p in evaluated {
        let full = study.points.iter().find(|q| q.policy == "full" && q.scene == p.scene && q.mode == p.mode);
        let (Some(policy), Some(full)) = (slower(p), full.and_then(slower)) else { continue };
        let holds = policy <= full.max(HINDERS);
        (held, all) = (held + u32::from(holds), all + 1);
        let verdict = if holds { "does not hinder" } else { "hinders" };
        let _ = writeln!(rows, "{:<scene$} {:<14} {policy:>12.2} {full:>12.2}   {verdict}", p.scene, word(&p.mode));
    }
    if all == 0 {
        return String::new();
    }
    format!(
        "\n\"cannot hinder the T&I unit\": time of a frame with the real SRP over that with a free one;\nsampling \
         hinders where that is more than under full, and more than {HINDERS}\n\n\
         {:<scene$} {:<14} {:>12} {:>12}\n{rows}it holds in {held} of {all}\n",
        "scene", "mode", "the policy", "full"
    )
}

/// "Performance in proportion to the rays cut": a line through the origin, by least squares.
fn proportion(evaluated: &[&Point]) -> String {
    let pair = |p: &&Point| Some((p.rays_full as f64 / p.rays_traced.max(1) as f64, p.ti_gain?.performance));
    let pairs: Vec<(f64, f64)> = evaluated.iter().filter_map(pair).collect();
    if pairs.len() < POINTS_LEAST {
        return String::new();
    }
    let (slope, part) = line(&pairs);
    format!(
        "\n\"performance in proportion to the rays cut\", T&I alone: performance = {slope:.2} x ray ratio{} ({} points)\n",
        explained(part),
        pairs.len()
    )
}

/// A part of the variance in words. A line that is further from the points than their mean explains nothing, however far it is.
fn explained(part: Option<f64>) -> String {
    match part {
        None => "; all performances are the same, so there is no variance to explain".into(),
        Some(part) if part <= 0.0 => " explains nothing of the variance".into(),
        Some(part) if part < 0.005 => " explains less than 1 % of the variance".into(),
        Some(part) => format!(" explains {:.0} % of the variance", 100.0 * part),
    }
}

/// Slope of the line through the origin that fits best, and the part of the variance of the second values that it explains; no part
/// where they are all the same.
fn line(pairs: &[(f64, f64)]) -> (f64, Option<f64>) {
    let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|&(x, y)| of(x, y)).sum::<f64>();
    let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
    // Not from the variance: that of equal values is rounding and need not be zero.
    if pairs.iter().all(|(_, y)| *y == pairs[0].1) {
        return (slope, None);
    }
    let mean = sum(&|_, y| y) / pairs.len() as f64;
    (slope, Some(1.0 - sum(&|x, y| (y - slope * x).powi(2)) / sum(&|_, y| (y - mean).powi(2))))
}

/// Power by component: that of the paper's policies and of `full`, mean over the same points, whole GPU.
fn power(study: &Study, evaluated: &[&Point]) -> String {
    let full = |p: &&Point| study.points.iter().find(|q| q.policy == "full" && q.scene == p.scene && q.mode == p.mode);
    let pairs: Vec<(&Point, &Point)> = evaluated.iter().filter_map(|p| Some((*p, full(p)?))).collect();
    let pairs: Vec<_> = pairs.into_iter().filter(|(p, full)| p.gpu.is_some() && full.gpu.is_some()).collect();
    let Some((first, _)) = pairs.first() else { return String::new() };
    let watts = |p: &Point, name: &str| {
        let energy: f64 = p.energy.iter().filter(|part| part.component == name).map(|part| part.mj).sum();
        p.gpu.map_or(0.0, |cost| energy / cost.time_ms)
    };
    let mean = |of: &dyn Fn(&(&Point, &Point)) -> f64| pairs.iter().map(of).sum::<f64>() / pairs.len() as f64;
    let mut text = format!(
        "\npower by component, whole GPU, mean over scenes and modes, mW (the paper: 1.09 of full, T&I alone)\n\n\
         {:<14} {:<8} {:>10} {:>10} {:>8}\n",
        "component", "group", "full", "adaptive", "factor"
    );
    for part in &first.energy {
        let [adaptive, full] =
            [mean(&|(p, _)| watts(p, &part.component)), mean(&|(_, full)| watts(full, &part.component))];
        let factor = if full > 0.0 { format!("{:.2}", adaptive / full) } else { "-".into() };
        let _ = writeln!(
            text,
            "{:<14} {:<8} {:>10.1} {:>10.1} {factor:>8}",
            part.component,
            part.group,
            1000.0 * full,
            1000.0 * adaptive
        );
    }
    text + &behind(&pairs)
}

/// What stands behind the power of the components, as numbers alone: time and rays need not fall, and caches may gain or lose.
fn behind(pairs: &[(&Point, &Point)]) -> String {
    let time = |p: &Point| p.gpu.map_or(0.0, |cost| cost.time_ms);
    let rays = |p: &Point| p.rays_traced.max(1) as f64;
    let memory = |p: &Point| p.energy.iter().filter(|part| part.group == "memory").map(|part| part.mj).sum::<f64>();
    // Mean of the factors over full.
    let mean =
        |of: &dyn Fn(&Point) -> f64| pairs.iter().map(|(p, full)| of(p) / of(full)).sum::<f64>() / pairs.len() as f64;
    let mut text = format!(
        "a frame takes {:.2} times full's time and traces {:.2} times its rays: what costs the same for each ray draws {:.2} \
         times the power",
        mean(&time),
        mean(&rays),
        mean(&|p| rays(p) / time(p))
    );
    if pairs.iter().all(|(_, full)| memory(full) > 0.0) {
        text +=
            &format!("; for each ray L2, wires and DRAM take {:.2} times the energy", mean(&|p| memory(p) / rays(p)));
    }
    text + "\n"
}

#[cfg(test)]
mod tests {
    use rayreel_study::schema::{Component, Cost, Gain};

    use super::*;

    #[test]
    fn a_line_through_the_origin() {
        assert_eq!(line(&[(1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]), (2.0, Some(1.0)));
        let (slope, part) = line(&[(1.0, 1.0), (2.0, 1.5), (3.0, 1.0)]);
        assert!((slope - 0.5).abs() < 1e-12 && part.unwrap() < 0.0, "worse than their mean");
    }

    /// Traces `rays` of 1000 rays in `time_ms`; `memory_mj` are spent behind the L1 caches.
    fn point(policy: &str, rays: u64, time_ms: f64, memory_mj: f64) -> Point {
        let cost = Cost { time_ms, ..Cost::default() };
        let gain = Gain { performance: 2.0 / time_ms, ..Gain::default() };
        let part = |name: &str, group: &str, mj| Component { component: name.into(), group: group.into(), mj };
        Point {
            policy: policy.into(),
            rays_full: 1000,
            rays_traced: rays,
            gpu: Some(cost),
            ti_gain: Some(gain),
            energy: vec![part("trv", "ti", rays as f64 * 1e-3), part("dram", "memory", memory_mj)],
            ..Point::default()
        }
    }

    #[test]
    fn a_share_is_said_only_where_there_is_one() {
        let said = |points: &[(u64, f64)]| {
            let points: Vec<Point> = points.iter().map(|(rays, time)| point("paper-ss", *rays, *time, 1.0)).collect();
            proportion(&points.iter().collect::<Vec<_>>())
        };
        assert!(
            said(&[(500, 1.0), (250, 0.5), (125, 0.25)]).contains("1.00 x ray ratio explains 100 % of the variance (3")
        );
        let worse = said(&[(900, 3.0), (500, 2.0), (250, 3.5)]);
        assert!(worse.contains("explains nothing of the variance (3 points)") && !worse.contains('%'), "{worse}");
        // Three times 0.1 and a third of it is not 0.1: the variance of equal values is not zero.
        let same = said(&[(900, 20.0), (500, 20.0), (250, 20.0)]);
        assert!(same.contains("all performances are the same") && !same.contains("NaN"), "{same}");
        assert!(explained(Some(0.001)).contains("less than 1 %"));
    }

    #[test]
    fn what_stands_behind_power_is_what_was_found() {
        let said = |rays, time_ms, memory_mj| {
            let [full, policy] = [point("full", 1000, 2.0, 4.0), point("paper-ss", rays, time_ms, memory_mj)];
            let study = Study { points: vec![full, policy], ..Study::default() };
            power(&study, &[&study.points[1]])
        };
        let falls = said(500, 1.25, 3.0);
        assert!(
            falls.contains("takes 0.62 times full's time and traces 0.50 times its rays")
                && falls.contains("draws 0.80 times the power"),
            "{falls}"
        );
        assert!(falls.contains("L2, wires and DRAM take 1.50 times the energy"), "{falls}");
        // More time for fewer rays, and less to do for each: nothing is said that is not so.
        let rises = said(500, 3.0, 1.0);
        assert!(
            rises.contains("takes 1.50 times full's time") && rises.contains("take 0.50 times the energy"),
            "{rises}"
        );
        assert!(!rises.contains("less") && !rises.contains("more"), "{rises}");
    }
}
