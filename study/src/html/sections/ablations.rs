//! One choice changed at a time.

use crate::html::parts::{Head, Section, how_to_read, table};
use crate::html::text::{count, escape, factor, fixed, or_dash, percent, plus_minus, psnr};
use crate::html::view::StudyView;
use crate::schema::{Ablation, CostInterval, GainInterval};

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let all = &view.study.ablations;
    let mut groups: Vec<&str> = Vec::new();
    for ablation in all {
        if !groups.contains(&ablation.group.as_str()) {
            groups.push(&ablation.group);
        }
    }
    let mut html = String::new();
    for group in groups {
        let rows: Vec<&Ablation> = all.iter().filter(|a| a.group == group).collect();
        html += &group_table(group, &rows);
    }
    if !html.is_empty() {
        html += &how_to_read(
            "Each table changes one choice and keeps all others. The marked row is the unchanged one; the numbers in brackets \
             compare with it: factors for cycles, power and performance per watt of the whole GPU, decibels for PSNR.",
        );
    }
    Section::new("ablations", "Ablations", html)
}

fn group_table(group: &str, all: &[&Ablation]) -> String {
    let columns = [
        Head::words("Choice"),
        Head::words("Scene"),
        Head::words("Policy"),
        Head::number("Rays of all"),
        Head::number("Cycles"),
        Head::number("Power, W"),
        Head::number("Performance/W"),
        Head::number("PSNR"),
    ];
    let mut rows = Vec::new();
    for ablation in all {
        let base = all
            .iter()
            .find(|b| b.base && b.scene == ablation.scene && b.mode == ablation.mode && b.policy == ablation.policy);
        let base = base.filter(|_| !ablation.base);
        let note =
            if ablation.note.is_empty() { String::new() } else { format!("<small>{}</small>", escape(&ablation.note)) };
        let within = |of: fn(CostInterval) -> f64| ablation.interval.map(of);
        let over = |of: fn(GainInterval) -> f64| ablation.gain_interval.map(of);
        let cells = vec![
            format!("{}{note}", escape(&ablation.name)),
            format!("{} <small>{}</small>", escape(&ablation.scene), escape(&ablation.mode.replace('x', "×"))),
            escape(&ablation.policy),
            percent(ablation.rays_traced as f64 / ablation.rays_full.max(1) as f64),
            or_dash(ablation.cycles, |v| {
                let base = base.and_then(|b| b.cycles).map(|v| v as f64);
                count(v) + &plus_minus(within(|i| i.cycles)) + &times(v as f64, base, over(|i| i.performance))
            }),
            or_dash(ablation.power_w, |v| {
                let base = base.and_then(|b| b.power_w);
                fixed(v, 3) + &plus_minus(within(|i| i.power_w)) + &times(v, base, over(|i| i.power))
            }),
            or_dash(ablation.perf_per_watt, |v| {
                let base = base.and_then(|b| b.perf_per_watt);
                fixed(v, 1) + &plus_minus(within(|i| i.perf_per_watt)) + &times(v, base, over(|i| i.perf_per_watt))
            }),
            psnr(ablation.psnr_db) + &difference(ablation.psnr_db, base.and_then(|b| b.psnr_db)),
        ];
        rows.push((if ablation.base { "strong".into() } else { String::new() }, cells));
    }
    table(&capitalised(group), &columns, &rows)
}

fn times(value: f64, base: Option<f64>, within: Option<f64>) -> String {
    let times = |base: f64| format!(" <small class=\"under\">({}{})</small>", factor(value / base), plus_minus(within));
    base.filter(|b| *b > 0.0).map(times).unwrap_or_default()
}

fn difference(value: Option<f64>, base: Option<f64>) -> String {
    let (Some(value), Some(base)) = (value, base) else { return String::new() };
    let sign = if value > base { "+" } else { "" };
    format!(" <small class=\"under\">({sign}{})</small>", fixed(value - base, 2))
}

/// The text with a capital first letter.
fn capitalised(text: &str) -> String {
    let mut rest = text.chars();
    rest.next().map_or_else(String::new, |first| first.to_uppercase().chain(rest).collect())
}
