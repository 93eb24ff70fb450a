//! The headline numbers.

use crate::analysis::means::{geometric_mean, mean_interval};
use crate::html::charts::scale::extent;
use crate::html::modes::{mode_name, mode_reference};
use crate::html::parts::Section;
use crate::html::text::{decibels, escape, factor, percent, plus_minus};
use crate::html::view::{StudyView, gain, gain_interval};
use crate::schema::{GainBand, Point};

/// A number with what it is.
struct Tile {
    label: String,
    value: String,
    detail: String,
}

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let mut tiles = Vec::new();
    for mode in view.modes() {
        tiles.extend(view.paper_policy(mode).and_then(|policy| paper(view, mode, policy)));
    }
    for mode in view.modes() {
        let policy = view.headline.filter(|policy| view.paper_policy(mode) != Some(*policy));
        tiles.extend(policy.and_then(|policy| headline(view, mode, policy)));
    }
    tiles.extend(dominance(view));
    tiles.extend(overhead(view));
    let tile = |t: &Tile| {
        format!(
            "<div class=\"tile-number\"><dt>{}</dt><dd><b>{}</b><span>{}</span></dd></div>\n",
            escape(&t.label),
            escape(&t.value),
            escape(&t.detail)
        )
    };
    let mut html = String::new();
    if !tiles.is_empty() {
        html += &format!("<dl class=\"numbers\">\n{}</dl>\n", tiles.iter().map(tile).collect::<String>());
    }
    if !view.study.notes.is_empty() {
        let notes: String = view.study.notes.iter().map(|n| format!("<li>{}</li>\n", escape(n))).collect();
        html += &format!("<div class=\"notes\"><h3>Notes</h3><ul>\n{notes}</ul></div>\n");
    }
    Section::new("summary", "Summary", html)
}

/// Gains and worst PSNR of points in words.
fn range(points: &[&Point]) -> String {
    let gains = extent(points.iter().filter_map(|p| gain(p)));
    let psnr = extent(points.iter().filter_map(|p| p.quality.and_then(|q| q.psnr_db)));
    let gains = gains.map(|[low, high]| format!("{} to {}", factor(low), factor(high)));
    let psnr = psnr.map(|[low, _]| format!("PSNR at least {}", decibels(low)));
    [gains, psnr].into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// The part of the machine that a gain is about.
fn part_of(points: &[&Point]) -> &'static str {
    if points.iter().all(|p| p.ti_gain.is_some()) { "T&I units alone" } else { "whole GPU" }
}

fn mean_tile(view: &StudyView<'_>, mode: &str, policy: &str) -> Option<(Tile, usize)> {
    let points = view.everywhere(mode, policy)?;
    let mean = geometric_mean(points.iter().map(|p| gain(p)))?;
    let label = format!("{policy}: performance per watt over {}", mode_reference(mode));
    let scenes = if points.len() == 1 { "one scene".into() } else { format!("mean of {} scenes", points.len()) };
    let detail = format!("{scenes}, {}. {}.", part_of(&points), range(&points));
    let within = mean_interval(points.iter().map(|p| gain_interval(p)));
    Some((Tile { label, value: factor(mean) + &plus_minus(within), detail }, points.len()))
}

fn paper(view: &StudyView<'_>, mode: &str, policy: &str) -> Option<Tile> {
    let (mut tile, _) = mean_tile(view, mode, policy)?;
    let shown = |band: &&GainBand| view.points.iter().any(|point| point.scene == band.scene);
    let bands: Vec<&GainBand> = view.study.references.gains.iter().filter(shown).collect();
    if let Some([low, _]) = extent(bands.iter().map(|band| band.least)) {
        // For some scenes the paper states no upper end.
        let most: Option<Vec<f64>> = bands.iter().map(|band| band.most).collect();
        let high = most.and_then(extent);
        tile.detail += &match high {
            Some([_, high]) => format!(" The paper: {} to {}.", factor(low), factor(high)),
            None => format!(" The paper: at least {}.", factor(low)),
        };
    }
    Some(tile)
}

fn headline(view: &StudyView<'_>, mode: &str, policy: &str) -> Option<Tile> {
    mean_tile(view, mode, policy).map(|(tile, _)| tile)
}

/// In how many scenes, each mode by itself, the headline policy beats the paper's in both respects.
fn dominance(view: &StudyView<'_>) -> Option<Tile> {
    let policy = view.headline?;
    let mut counts = Vec::new();
    for mode in view.modes() {
        let Some(paper) = view.paper_policy(mode).filter(|paper| *paper != policy) else { continue };
        let (won, all) = view.beaten(mode, policy, paper);
        if all > 0 {
            counts.push((won, all, format!("{}: {won} of {all}, against {paper}", mode_name(mode))));
        }
    }
    let (won, all) = counts.iter().fold((0, 0), |(won, all), c| (won + c.0, all + c.1));
    let detail = counts.iter().map(|c| c.2.as_str()).collect::<Vec<_>>().join("; ") + ".";
    // A scene counts once in each mode.
    let what = if counts.len() > 1 { "scenes in a mode" } else { "scenes" };
    let label = format!("{policy}: {what} with both more performance per watt and more PSNR than the paper's policy");
    (all > 0).then(|| Tile { label, value: format!("{won} of {all}"), detail })
}

/// Share of the SRP's cycles that sampling itself takes.
fn overhead(view: &StudyView<'_>) -> Option<Tile> {
    let mut shares = [Vec::new(), Vec::new()];
    for mode in view.modes() {
        let Some(policy) = view.paper_policy(mode) else { continue };
        for point in view.points.iter().filter(|p| p.mode == mode && p.policy == policy && !p.srp.is_empty()) {
            for (share, of_point) in shares.iter_mut().zip(point.sampling_shares()) {
                share.push(of_point.unwrap_or(0.0));
            }
        }
    }
    let [similarity, interpolation] = shares.each_ref().map(|s| s.iter().sum::<f64>() / s.len().max(1) as f64);
    let stated = &view.study.references.srp;
    let paper: Vec<String> = stated.iter().map(|k| format!("{} {}", percent(k.share), k.kernel)).collect();
    let paper = if paper.is_empty() { String::new() } else { format!(" The paper: {}.", paper.join(", ")) };
    (!shares[0].is_empty()).then(|| Tile {
        label: "SRP cycles of the paper's policies for similarity tests and interpolation".into(),
        value: percent(similarity + interpolation),
        detail: format!(
            "{} similarity with its inspector, {} interpolation; mean over scenes and modes.{paper}",
            percent(similarity),
            percent(interpolation)
        ),
    })
}
