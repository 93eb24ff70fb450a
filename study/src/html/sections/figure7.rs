//! The paper's Figure 7: performance, power and performance per watt of its own policies, T&I units alone.

use crate::analysis::means::{geometric_mean, mean_interval};
use crate::html::charts::bars::{Bar, Group, grouped};
use crate::html::modes::{by_mode, mode_name, mode_reference};
use crate::html::parts::{Head, Section, details, how_to_read, key, legend, symbol, table};
use crate::html::text::{escape, factor, or_dash, plus_minus};
use crate::html::view::{StudyView, has_counterpart};
use crate::schema::{Gain, Point, Scene};

/// Name and colour class of the three bars of a scene.
const BARS: [(&str, &str); 3] = [("performance", "b0"), ("power", "b1"), ("performance per watt", "b2")];

/// What the marks of the paper's values mean.
const BRACKETS: &str =
    " Brackets show what the paper states: from least to most, or an arrow where it states a least value only.";

/// How the paper's scenes are like these.
fn models(scenes: &[Scene]) -> String {
    // Nothing is known of scenes that the study does not list.
    if scenes.is_empty() {
        return String::new();
    }
    let unlike: Vec<&str> =
        scenes.iter().filter(|scene| !has_counterpart(scene)).map(|scene| scene.name.as_str()).collect();
    match unlike.len() {
        0 => " Its scenes are of the same kind and size as these, but not the same models.".into(),
        n if n == scenes.len() => " None of these scenes is like one of the paper's.".into(),
        _ => format!(
            " The paper's scenes are of the same kind and size as these, but not the same models; it has none like {}.",
            unlike.join(", ")
        ),
    }
}

/// How far they may be off.
fn intervals(gain: Option<Gain>) -> [Option<f64>; 3] {
    let interval = gain.and_then(|g| g.interval);
    interval.map_or([None; 3], |i| [Some(i.performance), Some(i.power), Some(i.perf_per_watt)])
}

fn values(gain: Option<Gain>) -> [Option<f64>; 3] {
    gain.map_or([None; 3], |g| [Some(g.performance), Some(g.power), Some(g.perf_per_watt)])
}

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let mut charts = String::new();
    for mode in view.modes() {
        charts += &view.paper_policy(mode).map(|policy| chart(view, mode, policy)).unwrap_or_default();
    }
    if charts.is_empty() {
        return None;
    }
    let bars: String = BARS.iter().map(|(name, class)| key(class, name)).collect();
    let bracket = symbol("<path d=\"M4 2h8M8 2v12M4 14h8\" class=\"paper\"/>", "the paper's performance per watt");
    let bracket = if view.has_bands() { bracket } else { String::new() };
    let mut html = legend(&(bars + &bracket)) + &format!("<div class=\"grid two\">\n{charts}</div>\n");
    html += &how_to_read(&format!(
        "Each bar is the adaptive policy relative to tracing every sample in the same scene and mode; the line at 1× is the \
         reference. Bars of performance and performance per watt should be high, power near 1×.{}{}{}",
        view.intervals_drawn(),
        if view.has_bands() { BRACKETS } else { "" },
        models(&view.study.scenes)
    ));
    if let Some(power) = view.study.references.power {
        html += &how_to_read(&format!(
            "The paper states {} of the reference's power; of which scenes, and whether it is a mean, it does not say.",
            factor(power)
        ));
    }
    html +=
        &details("Numbers: every policy, T&I units alone and whole GPU", &by_mode(view, |mode| numbers(view, mode)));
    Section::new("figure7", "The paper's Figure 7", html)
}

fn chart(view: &StudyView<'_>, mode: &str, policy: &str) -> String {
    let gain = |point: &Point| point.ti_gain.or(point.gpu_gain);
    let points: Vec<&Point> =
        view.scenes(mode).into_iter().filter_map(|scene| view.point(scene, mode, policy)).collect();
    if points.iter().all(|p| gain(p).is_none()) {
        return String::new();
    }
    let alone = if points.iter().all(|p| p.ti_gain.is_some()) { "T&I units alone" } else { "whole GPU" };
    let group = |name: &str, values: [Option<f64>; 3], within: [Option<f64>; 3], band| {
        let bar = |i: usize| {
            let ((what, class), value) = (BARS[i], values[i]);
            let tip = format!("{name}\n{policy}, {alone}\n{what} {}{}", or_dash(value, factor), plus_minus(within[i]));
            Bar { name: what, value, within: within[i], class, tip }
        };
        Group { name: name.to_owned(), bars: (0..BARS.len()).map(bar).collect(), band }
    };
    let mut groups: Vec<Group> = points
        .iter()
        .map(|p| group(&p.scene, values(gain(p)), intervals(gain(p)), view.band(&p.scene).map(|b| (b.least, b.most))))
        .collect();
    let text: Vec<String> =
        points.iter().map(|p| format!("{} {}", p.scene, or_dash(gain(p).map(|g| g.perf_per_watt), factor))).collect();
    if points.len() > 1 {
        let mean = |i: usize| geometric_mean(points.iter().map(|p| values(gain(p))[i]));
        let within = |i: usize| mean_interval(points.iter().map(|p| intervals(gain(p))[i]));
        groups.push(group("mean", [mean(0), mean(1), mean(2)], [within(0), within(1), within(2)], None));
    }
    let name = format!("{}: {policy} against {}", mode_name(mode), mode_reference(mode));
    let label = format!("Bar chart. {name}, {alone}; performance per watt: {}.", text.join(", "));
    let words = ["figure7", mode, policy];
    let mean = if points.len() > 1 { "; geometric mean at the right." } else { "." };
    view.charts.card(&words, &name, &grouped(&groups, &label), &format!("{alone}{mean}"))
}

fn numbers(view: &StudyView<'_>, mode: &str) -> String {
    let mut columns = vec![Head::words("Scene"), Head::words("Policy")];
    for part in ["T&I", "GPU"] {
        columns.extend(["performance", "power", "perf/W"].map(|name| Head::number(&format!("{part} {name}"))));
    }
    if mode == "1x1" {
        columns.push(Head::number("perf/W over FSAA 2×2"));
    }
    columns.push(Head::words("Paper perf/W"));
    let mut rows = Vec::new();
    for scene in view.scenes(mode) {
        for point in view.of(scene, mode).into_iter().filter(|p| p.kind != "full") {
            let mut cells = vec![escape(&point.scene), escape(&point.policy)];
            let cell = |(value, within)| or_dash(value, factor) + &plus_minus(within);
            for gain in [point.ti_gain, point.gpu_gain] {
                cells.extend(values(gain).into_iter().zip(intervals(gain)).map(cell));
            }
            if mode == "1x1" {
                cells.push(cell((values(point.fsaa_gain)[2], intervals(point.fsaa_gain)[2])));
            }
            cells.push(or_dash(view.band(scene), |band| match band.most {
                Some(most) => format!("{} to {}", band.least, factor(most)),
                None => format!("≥ {}", factor(band.least)),
            }));
            rows.push((String::new(), cells));
        }
    }
    table(&format!("{}: factors over {}", mode_name(mode), mode_reference(mode)), &columns, &rows)
}
