//! What the units did with their cycles.

use super::super::charts::stacked::{Part, Row, stacked};
use super::super::parts::{Section, by_mode, card, grid, how_to_read, key, legend};
use super::super::text::percent;
use super::super::view::View;
use crate::report::study::{Point, Unit};

/// States that are known, with their colour class and what they mean; any other is grey.
const STATES: [(&str, &str, &str); 8] = [
    ("busy", "s0", "works"),
    ("bypass", "s1", "passes operations whose data had missed"),
    ("fetch", "s2", "waits for the L1's latency or port"),
    ("memory", "s3", "waits for L2 or DRAM"),
    ("mshr", "s4", "no room for another miss"),
    ("blocked", "s5", "the stage behind is full"),
    ("starved", "s6", "rays are here, but none needs this stage"),
    ("idle", "s7", "no ray"),
];

/// The section.
pub fn section(view: &View<'_>) -> Option<Section> {
    if view.points.iter().all(|p| p.units.is_empty()) {
        return None;
    }
    let used =
        |state: &str| view.points.iter().flat_map(|p| &p.units).flat_map(|u| &u.shares).any(|s| s.state == state);
    let known = STATES.iter().filter(|(state, ..)| used(state));
    let keys = known.map(|(state, class, what)| key(class, &format!("{state}: {what}")));
    let mut html = legend(&keys.collect::<String>());
    html += &by_mode(view, |mode| {
        grid(&view.scenes(mode).iter().map(|scene| chart(view, scene, mode)).collect::<String>())
    });
    html += &how_to_read(
        "Each bar is all cycles of one kind of unit; the number is the busy share. Full sampling stands beside the paper's policy \
         and the one of the summary: if the T&I units were held up by the SRP, their idle part would grow.",
    );
    Section::new("units", "Utilisation of the units", html)
}

/// The points worth comparing: full, the paper's policy, the summary's.
pub fn compared<'a>(view: &View<'a>, scene: &str, mode: &str) -> Vec<&'a Point> {
    let wanted = [view.paper_policy(mode), view.headline];
    view.of(scene, mode).into_iter().filter(|p| p.kind == "full" || wanted.contains(&Some(p.policy.as_str()))).collect()
}

fn chart(view: &View<'_>, scene: &str, mode: &str) -> String {
    let points: Vec<&Point> = compared(view, scene, mode).into_iter().filter(|p| !p.units.is_empty()).collect();
    let mut names: Vec<&str> = Vec::new();
    for unit in points.iter().flat_map(|p| &p.units) {
        if !names.contains(&unit.unit.as_str()) {
            names.push(&unit.unit);
        }
    }
    let (mut rows, mut text) = (Vec::new(), Vec::new());
    for name in names {
        rows.push(Row::Head(name.to_owned()));
        for point in &points {
            let Some(unit) = point.units.iter().find(|u| u.unit == name) else { continue };
            let busy = unit.shares.iter().find(|s| s.state == "busy").map_or(0.0, |s| s.share);
            text.push(format!("{name} under {} {}", point.policy, percent(busy)));
            rows.push(Row::Bar { name: point.policy.clone(), parts: parts(unit, &point.policy), text: percent(busy) });
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let label = format!("Stacked bars, {scene}: cycles by state. Busy: {}.", text.join("; "));
    card(scene, &stacked(&rows, 1.0, |_, tick| percent(tick).replace(".0", ""), &label), "")
}

fn parts(unit: &Unit, policy: &str) -> Vec<Part> {
    let part = |share: &crate::report::study::StateShare| {
        let known = STATES.iter().find(|(state, ..)| *state == share.state);
        let meaning = known.map(|(_, _, what)| format!(": {what}")).unwrap_or_default();
        Part {
            value: share.share,
            class: known.map_or("s8", |(_, class, _)| class).into(),
            opacity: 1.0,
            tip: format!("{}\n{policy}\n{} {}{meaning}", unit.unit, share.state, percent(share.share)),
        }
    };
    unit.shares.iter().map(part).collect()
}
