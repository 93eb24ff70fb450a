//! What the paper claims, put to the test: its overhead, its performance in proportion to the rays cut, its power.

use std::fmt::Write as _;

use rayreel_study::schema::{Point, Study};

use crate::policies::word;

/// More time than a free SRP takes, by which an SRP hinders the T&I units.
const HINDERS: f64 = 1.05;

/// The section: verdicts on the points of the policies that the paper evaluated, with `headline` beside them.
pub fn claims(study: &Study, evaluated: &[&Point]) -> String {
    overhead(study, evaluated) + &proportion(evaluated) + &power(study, evaluated)
}

/// "Cannot hinder the T&I unit": the time of a frame with the SRP over that with one that takes no time. `full` has no sampling
/// to pay for; what a policy has more than `full` is sampling's.
fn overhead(study: &Study, evaluated: &[&Point]) -> String {
    let slower = |p: &Point| Some(p.gpu?.time_ms / p.ti?.time_ms);
    let mut rows = String::new();
    let (mut held, mut all) = (0, 0);
    for p in evaluated {
        let full = study.points.iter().find(|q| q.policy == "full" && q.scene == p.scene && q.mode == p.mode);
        let (Some(policy), Some(full)) = (slower(p), full.and_then(slower)) else { continue };
        let holds = policy <= full.max(HINDERS);
        (held, all) = (held + u32::from(holds), all + 1);
        let verdict = if holds { "does not hinder" } else { "hinders" };
        let _ = writeln!(rows, "{:<10} {:<14} {policy:>12.2} {full:>12.2}   {verdict}", p.scene, word(&p.mode));
    }
    if all == 0 {
        return String::new();
    }
    format!(
        "\n\"cannot hinder the T&I unit\": time of a frame with the real SRP over that with a free one\n\n\
         {:<10} {:<14} {:>12} {:>12}\n{rows}it holds in {held} of {all}\n",
        "scene", "mode", "the policy", "full"
    )
}

/// "Performance in proportion to the rays cut": a line through the origin, by least squares.
fn proportion(evaluated: &[&Point]) -> String {
    let pair = |p: &&Point| Some((p.rays_full as f64 / p.rays_traced.max(1) as f64, p.ti_gain?.performance));
    let pairs: Vec<(f64, f64)> = evaluated.iter().filter_map(pair).collect();
    if pairs.len() < 3 {
        return String::new();
    }
    let (slope, explained) = line(&pairs);
    format!(
        "\n\"performance in proportion to the rays cut\", T&I alone: performance = {slope:.2} x ray ratio explains {:.0} % of the \
         variance ({} points)\n",
        100.0 * explained,
        pairs.len()
    )
}

/// Slope of the line through the origin that fits best, and the part of the variance of the second values that it explains.
fn line(pairs: &[(f64, f64)]) -> (f64, f64) {
    let sum = |of: &dyn Fn(f64, f64) -> f64| pairs.iter().map(|&(x, y)| of(x, y)).sum::<f64>();
    let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
    let mean = sum(&|_, y| y) / pairs.len() as f64;
    (slope, 1.0 - sum(&|x, y| (y - slope * x).powi(2)) / sum(&|_, y| (y - mean).powi(2)))
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
    text + "time falls less than rays do, so what costs the same for each ray draws less; the rays that are left share fewer lines, so L2, \
            wires and DRAM have more to do for each\n"
}

#[cfg(test)]
mod tests {
    use super::line;

    #[test]
    fn a_line_through_the_origin() {
        assert_eq!(line(&[(1.0, 2.0), (2.0, 4.0), (3.0, 6.0)]), (2.0, 1.0));
        let (slope, explained) = line(&[(1.0, 1.0), (2.0, 1.0)]);
        assert!((slope - 0.6).abs() < 1e-12 && explained < 0.0, "worse than their mean");
    }
}
