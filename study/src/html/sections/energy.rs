//! Energy by component.

use crate::html::charts::scale::Scale;
use crate::html::charts::stacked::{Part, StackedRow, stacked};
use crate::html::magnitude::Unit;
use crate::html::modes::{by_mode, mode_name};
use crate::html::parts::{Head, Section, details, grid, how_to_read, key, legend, table};
use crate::html::text::{digits, escape, fixed, or_dash, percent, plus_minus};
use crate::html::view::StudyView;
use crate::schema::{Component, Point};

/// Group, name for people, colour class.
const GROUPS: [(&str, &str, &str); 3] =
    [("ti", "T&I units", "e0"), ("srp", "SRPs", "e1"), ("memory", "L2 and DRAM", "e2")];

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    if view.points.iter().all(|p| p.energy.is_empty()) {
        return None;
    }
    let unit = view.energy_unit();
    let mut html = legend(&GROUPS.iter().map(|(_, name, class)| key(class, name)).collect::<String>());
    html += &by_mode(view, |mode| {
        grid(&view.scenes(mode).iter().map(|scene| chart(view, scene, mode, unit)).collect::<String>())
    });
    html += &how_to_read(&format!(
        "Energy of the whole GPU for the scene's frame, {}; shades are the components of a group. Shorter is better. A component \
         that stays long where rays are saved is what limits the gain.{}",
        unit.name,
        view.intervals_drawn()
    ));
    html += &details("Numbers: every component", &by_mode(view, |mode| numbers(view, mode, unit)));
    Section::new("energy", "Energy by component", html)
}

fn total(point: &Point) -> f64 {
    point.energy.iter().map(|c| c.mj).sum()
}

/// An energy with its unit.
fn amount(mj: f64, unit: Unit) -> String {
    format!("{} {}", digits(mj * unit.scale), unit.name)
}

/// How far the energy of the whole GPU may be off, as a part of it.
fn interval(point: &Point) -> Option<f64> {
    Some(point.gpu?.interval?.energy_mj)
}

fn chart(view: &StudyView<'_>, scene: &str, mode: &str, unit: Unit) -> String {
    let points: Vec<&Point> = view.of(scene, mode).into_iter().filter(|p| !p.energy.is_empty()).collect();
    let most = points.iter().map(|p| total(p)).fold(0.0, f64::max);
    if points.is_empty() {
        return String::new();
    }
    let row = |point: &&Point| StackedRow::Bar {
        name: point.policy.clone(),
        parts: parts(point, unit),
        within: interval(point),
        text: amount(total(point), unit) + &plus_minus(interval(point)),
    };
    let text: Vec<String> = points.iter().map(|p| format!("{} {}", p.policy, amount(total(p), unit))).collect();
    let label = format!("Stacked bars, {scene}: energy by component. {}.", text.join("; "));
    let rows: Vec<StackedRow> = points.iter().map(row).collect();
    // The bars, and the file of their values, stay in the unit of the study; only what is written is in the other.
    let tick = |scale: &Scale, tick: f64| scale.times(unit.scale).label(tick * unit.scale);
    view.charts.card(&["energy", mode, scene], scene, &stacked(&rows, (most, "energy, mJ"), tick, &label), "")
}

fn parts(point: &Point, unit: Unit) -> Vec<Part> {
    let all = total(point).max(f64::MIN_POSITIVE);
    let mut parts = Vec::new();
    let mut add = |components: Vec<&Component>, group: &str, class: &str| {
        for (i, component) in components.iter().enumerate() {
            parts.push(Part {
                name: component.component.clone(),
                value: component.mj,
                class: class.into(),
                opacity: (1.0 - 0.13 * i as f64).max(0.3),
                tip: format!(
                    "{}\n{} ({group})\n{}, {}",
                    point.policy,
                    component.component,
                    amount(component.mj, unit),
                    percent(component.mj / all)
                ),
            });
        }
    };
    for (group, name, class) in GROUPS {
        add(point.energy.iter().filter(|c| c.group == group).collect(), name, class);
    }
    let known = |c: &&Component| GROUPS.iter().all(|(group, ..)| *group != c.group);
    add(point.energy.iter().filter(known).collect(), "other", "e3");
    parts
}

fn numbers(view: &StudyView<'_>, mode: &str, unit: Unit) -> String {
    let points =
        || view.scenes(mode).into_iter().flat_map(|scene| view.of(scene, mode)).filter(|p| !p.energy.is_empty());
    let mut names: Vec<&str> = Vec::new();
    for component in points().flat_map(|p| &p.energy) {
        if !names.contains(&component.component.as_str()) {
            names.push(&component.component);
        }
    }
    let mut columns = vec![Head::words("Scene"), Head::words("Policy"), Head::number("All")];
    columns.extend(names.iter().map(|name| Head::number(name)));
    let cell = |mj: f64| fixed(mj * unit.scale, 3);
    let row = |point: &Point| {
        let mut cells =
            vec![escape(&point.scene), escape(&point.policy), cell(total(point)) + &plus_minus(interval(point))];
        let of = |name: &&str| point.energy.iter().find(|c| c.component == *name);
        cells.extend(names.iter().map(|name| or_dash(of(name), |c| cell(c.mj))));
        (String::new(), cells)
    };
    table(&format!("{}: energy, {}", mode_name(mode), unit.name), &columns, &points().map(row).collect::<Vec<_>>())
}
