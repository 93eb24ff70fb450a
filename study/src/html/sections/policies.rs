//! Every policy: Pareto charts of performance per watt and PSNR, bars beside the paper's bands, and the numbers.

use crate::analysis::means::{geometric_mean, mean_interval};
use crate::html::charts::bars::{HorizontalBar, rows};
use crate::html::charts::scatter::{Dot, frontier, scatter};
use crate::html::magnitude::{TIME, for_all};
use crate::html::modes::{by_mode, mode_name};
use crate::html::parts::{Head, Section, details, grid, how_to_read, table};
use crate::html::text::{amount, count, decibels, escape, factor, fixed, or_dash, percent, plus_minus, psnr};
use crate::html::view::{StudyView, gain, gain_interval};
use crate::schema::{Cost, CostInterval, Point};

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    if view.points.iter().all(|p| gain(p).is_none()) {
        let numbers = by_mode(view, |mode| numbers(view, mode));
        return Section::new("policies", "All policies", numbers);
    }
    let mut policies = view.policies(None);
    policies.extend(view.points.iter().find(|p| p.kind == "full").map(|p| p.policy.as_str()));
    let mut html = view.legend(&policies);
    html += &by_mode(view, |mode| grid(&pareto(view, mode)));
    html += &how_to_read(&format!(
        "Further right is closer to the reference picture, further up does more with a watt. The line joins the policies that \
         none beats in both; those that are beaten are dimmed. Point at one for its numbers, or choose a chart with the \
         tabulator key and go through its points with the arrow keys.{}",
        view.intervals_drawn()
    ));
    html += "<h3 id=\"bars\">Performance per watt of every policy</h3>\n";
    html += &by_mode(view, |mode| grid(&bars(view, mode)));
    let zone =
        if view.has_bands() { " The shaded zone is what the paper states for its policy in this scene." } else { "" };
    let intervals = view.intervals_drawn();
    html +=
        &how_to_read(&format!("Factors over tracing every sample.{zone}{intervals} Behind each bar stands its PSNR."));
    html += &details("Numbers of every policy", &by_mode(view, |mode| numbers(view, mode)));
    Section::new("policies", "All policies: efficiency against quality", html)
}

fn tip(point: &Point) -> String {
    let mut text = format!("{}\n{}", point.policy, point.scene);
    for (part, gain) in [("T&I alone", point.ti_gain), ("GPU", point.gpu_gain)] {
        let Some(gain) = gain else { continue };
        text += &format!(
            "\n{part}: {}{} perf/W, {} performance, {} power",
            factor(gain.perf_per_watt),
            plus_minus(gain.interval.map(|i| i.perf_per_watt)),
            factor(gain.performance),
            factor(gain.power)
        );
    }
    if let Some(quality) = point.quality {
        text += &format!("\nPSNR {}", psnr(quality.psnr_db));
        text += &quality.worst_tile_psnr_db.map(|v| format!(", worst tile {}", decibels(v))).unwrap_or_default();
    }
    text + &format!("\n{} of {} rays traced", amount(point.rays_traced as f64, ""), amount(point.rays_full as f64, ""))
}

fn dot(view: &StudyView<'_>, point: &Point) -> Option<Dot> {
    let (full, look) = (point.kind == "full", view.look(&point.policy));
    // `full` is compared with itself: the same picture at the same cost.
    let x = if full { None } else { point.quality?.psnr_db };
    let y = gain(point).or(full.then_some(1.0))?;
    Some(Dot {
        name: point.policy.clone(),
        x,
        y,
        within: gain_interval(point),
        class: look.class(),
        shape: look.shape,
        tip: tip(point),
    })
}

fn pareto(view: &StudyView<'_>, mode: &str) -> String {
    let mut html = overall(view, mode);
    for scene in view.scenes(mode) {
        let dots: Vec<Dot> = view.of(scene, mode).into_iter().filter_map(|point| dot(view, point)).collect();
        html += &chart(view, &["policies", mode, scene], scene, &dots, "performance per watt");
    }
    html
}

fn chart(view: &StudyView<'_>, words: &[&str], title: &str, dots: &[Dot], y_name: &str) -> String {
    if dots.len() < 2 {
        return String::new();
    }
    let best = frontier(dots);
    let on: Vec<String> = dots
        .iter()
        .zip(&best)
        .filter(|(_, on)| **on)
        .map(|(d, _)| format!("{} {} at {}", d.name, factor(d.y), psnr(d.x)))
        .collect();
    let label = format!("Scatter chart, {title}: {y_name} against PSNR. Not beaten: {}.", on.join("; "));
    view.charts.card(words, title, &scatter(dots, ["PSNR, dB", y_name], &label), "")
}

/// All scenes in one chart: the mean gain and the worst picture.
fn overall(view: &StudyView<'_>, mode: &str) -> String {
    let scenes = view.scenes(mode).len();
    if scenes < 2 {
        return String::new();
    }
    let mut dots = Vec::new();
    // Full sampling is in the charts of the scenes too: what it beats is beaten.
    let full = view.points.iter().find(|p| p.kind == "full" && p.mode == mode).map(|p| p.policy.as_str());
    for policy in full.into_iter().chain(view.policies(Some(mode))) {
        let Some(points) = view.everywhere(mode, policy) else { continue };
        let Some(mean) = geometric_mean(points.iter().map(|p| gain(p))) else { continue };
        let Some(qualities) = points.iter().map(|p| p.quality).collect::<Option<Vec<_>>>() else { continue };
        let least = qualities.iter().map(|q| q.psnr_db.unwrap_or(f64::INFINITY)).fold(f64::INFINITY, f64::min);
        let (x, look) = (least.is_finite().then_some(least), view.look(policy));
        let within = mean_interval(points.iter().map(|p| gain_interval(p)));
        let tip = format!(
            "{policy}\nall {scenes} scenes\nmean {}{} perf/W\nworst PSNR {}",
            factor(mean),
            plus_minus(within),
            psnr(x)
        );
        dots.push(Dot { name: policy.to_owned(), x, y: mean, within, class: look.class(), shape: look.shape, tip });
    }
    let title = format!("All {scenes} scenes: geometric mean, and worst PSNR");
    chart(view, &["policies", mode, "all scenes"], &title, &dots, "performance per watt, mean")
}

fn bars(view: &StudyView<'_>, mode: &str) -> String {
    // What the paper states is drawn too, so the axis reaches it.
    let stated = |scene| view.band(scene).into_iter().flat_map(|band| [band.least, band.most.unwrap_or(band.least)]);
    let gains = view.points.iter().filter(|p| p.mode == mode).filter_map(|p| gain(p));
    let most = gains.chain(view.scenes(mode).into_iter().flat_map(stated)).fold(1.0, f64::max);
    let mut html = String::new();
    for scene in view.scenes(mode) {
        let points = view.of(scene, mode).into_iter().filter(|p| p.kind != "full");
        let row = |point: &Point| {
            let value = gain(point)?;
            let psnr_text = point.quality.map(|q| format!(" · {}", psnr(q.psnr_db))).unwrap_or_default();
            Some(HorizontalBar {
                name: point.policy.clone(),
                value,
                within: gain_interval(point),
                text: factor(value) + &plus_minus(gain_interval(point)) + &psnr_text,
                class: view.look(&point.policy).class(),
                tip: tip(point),
            })
        };
        let all: Vec<HorizontalBar> = points.filter_map(row).collect();
        if all.is_empty() {
            continue;
        }
        let text: Vec<String> = all.iter().map(|r| format!("{} {}", r.name, r.text)).collect();
        let label = format!("Bar chart, {scene}: performance per watt and PSNR. {}.", text.join("; "));
        let chart = rows(&all, most, view.band(scene).map(|b| (b.least, b.most)), &label);
        html += &view.charts.card(&["gains", mode, scene], scene, &chart, "");
    }
    html
}

fn numbers(view: &StudyView<'_>, mode: &str) -> String {
    let energy = view.energy_unit();
    let time = for_all(&TIME, view.points.iter().filter_map(|point| point.gpu).map(|cost| cost.time_ms));
    let columns = [
        Head::words("Scene"),
        Head::words("Policy"),
        Head::number("Rays traced"),
        Head::number("of all"),
        Head::number("Mean rate"),
        Head::number(&format!("GPU time, {}", time.name)),
        Head::number("GPU power, W"),
        Head::number(&format!("GPU energy, {}", energy.name)),
        Head::number("T&I perf/W, frames/J"),
        Head::number("PSNR"),
    ];
    let mut rows = Vec::new();
    for scene in view.scenes(mode) {
        for point in view.of(scene, mode) {
            let cells = vec![
                escape(scene),
                escape(&point.policy),
                count(point.rays_traced),
                percent(point.rays_traced as f64 / point.rays_full.max(1) as f64),
                fixed(point.mean_rate, 3),
                cost(point.gpu, |c| fixed(c.time_ms * time.scale, 3), |i| i.cycles),
                cost(point.gpu, |c| fixed(c.power_w, 3), |i| i.power_w),
                cost(point.gpu, |c| fixed(c.energy_mj * energy.scale, 3), |i| i.energy_mj),
                cost(point.ti, |c| fixed(c.perf_per_watt, 1), |i| i.perf_per_watt),
                or_dash(point.quality.filter(|_| point.kind != "full"), |q| psnr(q.psnr_db)),
            ];
            let class = if point.kind == "full" { "paper-row" } else { "" };
            rows.push((class.into(), cells));
        }
    }
    table(&format!("{}: every policy", mode_name(mode)), &columns, &rows)
}

/// A figure of a cost, and how far it may be off.
fn cost(cost: Option<Cost>, show: impl FnOnce(Cost) -> String, within: fn(CostInterval) -> f64) -> String {
    or_dash(cost, |c| show(c) + &plus_minus(c.interval.map(within)))
}
