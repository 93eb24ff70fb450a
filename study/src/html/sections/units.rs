//! What the units did with their cycles.

use crate::html::charts::stacked::{Part, StackedRow, stacked};
use crate::html::modes::by_mode;
use crate::html::parts::{Section, grid, how_to_read, key, key_shade, legend};
use crate::html::text::percent;
use crate::html::view::StudyView;
use crate::schema::{Point, StateShare, Unit};

/// States that are known, each with a colour class of its own and what it means; any other is dark.
const STATES: [(&str, &str, &str); 12] = [
    ("busy", "s0", "works"),
    ("bypass", "s1", "passes operations whose data had missed"),
    ("fetch", "s2", "waits for the L1's latency or port"),
    ("memory", "s3", "waits for L2 or DRAM"),
    ("mshr", "s4", "no room for another miss"),
    ("blocked", "s5", "the stage behind is full"),
    ("output", "s9", "the queue of rays to the T&I unit is full"),
    ("unit", "s12", "waits for rays in the T&I unit"),
    ("transfer", "s10", "waits for a tile's transfers"),
    ("border", "s11", "waits for the tiles beside its own"),
    ("starved", "s6", "rays are here, but none needs this stage"),
    ("idle", "s7", "no ray"),
];

/// What an SRP works on: its kernels, and the step that sorts items by branch before them.
pub(super) const KERNELS: [&str; 13] = [
    "raygen",
    "shade",
    "miss",
    "update",
    "similarity",
    "colour",
    "interpolate",
    "attributes",
    "reshade",
    "look_back",
    "control",
    "resolve",
    "inspector",
];

/// The shade of a kernel, below that of a unit that works: each has another, and those that follow one another in `KERNELS` lie
/// far apart.
fn shade(kernel: &str) -> Option<f64> {
    let at = KERNELS.iter().position(|known| *known == kernel)?;
    Some(0.95 - 0.05 * (at * 5 % KERNELS.len()) as f64)
}

/// Share of the cycles in which the unit works.
fn busy(unit: &Unit) -> f64 {
    unit.shares.iter().filter(|s| s.state == "busy" || KERNELS.contains(&s.state.as_str())).map(|s| s.share).sum()
}

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    if view.points.iter().all(|p| p.units.is_empty()) {
        return None;
    }
    let used =
        |state: &str| view.points.iter().flat_map(|p| &p.units).flat_map(|u| &u.shares).any(|s| s.state == state);
    let known = STATES.iter().filter(|(state, ..)| used(state));
    let keys = known.map(|(state, class, what)| key(class, &format!("{state}: {what}")));
    let kernels = KERNELS.iter().filter(|kernel| used(kernel));
    let kernels =
        kernels.map(|kernel| key_shade("s0", shade(kernel).unwrap_or(1.0), &format!("{kernel}: SRP works on it")));
    let mut html = legend(&keys.chain(kernels).collect::<String>());
    html += &by_mode(view, |mode| {
        grid(&view.scenes(mode).iter().map(|scene| chart(view, scene, mode)).collect::<String>())
    });
    html += &how_to_read(&format!(
        "Each bar is all cycles of one kind of unit; the number is the share in which it works (of an SRP, all its kernels). Full sampling stands beside the paper's policy \
         and the one of the summary: if the T&I units were held up by the SRP, their idle part would grow.{}",
        view.shares_estimated()
    ));
    Section::new("units", "Utilisation of the units", html)
}

/// The points worth comparing: full, the paper's policy, the summary's.
pub fn compared<'a>(view: &StudyView<'a>, scene: &str, mode: &str) -> Vec<&'a Point> {
    let wanted = [view.paper_policy(mode), view.headline];
    view.of(scene, mode).into_iter().filter(|p| p.kind == "full" || wanted.contains(&Some(p.policy.as_str()))).collect()
}

fn chart(view: &StudyView<'_>, scene: &str, mode: &str) -> String {
    let points: Vec<&Point> = compared(view, scene, mode).into_iter().filter(|p| !p.units.is_empty()).collect();
    let mut names: Vec<&str> = Vec::new();
    for unit in points.iter().flat_map(|p| &p.units) {
        if !names.contains(&unit.unit.as_str()) {
            names.push(&unit.unit);
        }
    }
    let (mut rows, mut text) = (Vec::new(), Vec::new());
    for name in names {
        rows.push(StackedRow::Head(name.to_owned()));
        for point in &points {
            let Some(unit) = point.units.iter().find(|u| u.unit == name) else { continue };
            let busy = busy(unit);
            text.push(format!("{name} under {} {}", point.policy, percent(busy)));
            rows.push(StackedRow::Bar {
                name: point.policy.clone(),
                parts: parts(unit, &point.policy),
                within: None,
                text: percent(busy),
            });
        }
    }
    if rows.is_empty() {
        return String::new();
    }
    let label = format!("Stacked bars, {scene}: cycles by state. Busy: {}.", text.join("; "));
    view.charts.card(
        &["utilisation", mode, scene],
        scene,
        &stacked(&rows, (1.0, "share of the cycles"), |_, tick| percent(tick).replace(".0", ""), &label),
        "",
    )
}

fn parts(unit: &Unit, policy: &str) -> Vec<Part> {
    let part = |share: &StateShare| {
        let (mut class, mut opacity, mut meaning) = ("s8", 1.0, String::new());
        if let Some((_, colour, what)) = STATES.iter().find(|(state, ..)| *state == share.state) {
            (class, meaning) = (colour, format!(": {what}"));
        } else if let Some(shade) = shade(&share.state) {
            (class, opacity, meaning) = ("s0", shade, ": works".into());
        }
        let tip = format!("{}\n{policy}\n{} {}{meaning}", unit.unit, share.state, percent(share.share));
        Part { name: share.state.clone(), value: share.share, class: class.into(), opacity, tip }
    };
    unit.shares.iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn no_two_classes_look_the_same() {
        let classes: BTreeSet<&str> = STATES.iter().map(|(_, class, _)| *class).collect();
        assert_eq!(classes.len(), STATES.len());
        let style = include_str!("../charts/chart.css");
        let fill = |class: &str| {
            let rule = style
                .split('}')
                .find(|rule| rule.split(['.', ' ', ',']).any(|word| word == class) && rule.contains("fill:"));
            rule.and_then(|rule| rule.split("fill:").nth(1))
                .unwrap_or_else(|| panic!("{class} has no colour"))
                .trim()
                .to_owned()
        };
        let fills: BTreeSet<String> = classes.iter().map(|class| fill(class)).collect();
        assert_eq!(fills.len(), STATES.len(), "{fills:?}");
        let shades: BTreeSet<u64> = KERNELS.iter().map(|kernel| shade(kernel).unwrap().to_bits()).collect();
        assert_eq!(shades.len(), KERNELS.len());
        assert!(KERNELS.iter().all(|kernel| (0.2..1.0).contains(&shade(kernel).unwrap())), "1 is that of `busy`");
    }
}
