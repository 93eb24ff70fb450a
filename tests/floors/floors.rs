//! What is refused: arrows up between the modules of a crate, circles of files.

use std::collections::{BTreeMap, BTreeSet};

use crate::arrows::Arrow;
use crate::modules::{Modules, Segments};

/// The modules at the top of a crate that the order does not name, and names in the order that are no modules.
pub fn unlisted(modules: &Modules, order: &[&str]) -> Vec<String> {
    let found: BTreeSet<&str> = modules[&Segments::new()].children.iter().map(String::as_str).collect();
    let listed: BTreeSet<&str> = order.iter().copied().collect();
    let missing = found.difference(&listed).map(|name| format!("module {name} has no place in the order"));
    missing.chain(listed.difference(&found).map(|name| format!("the order names {name}, which is no module"))).collect()
}

/// An order that the sources would allow; without the modules of rings, and what uses them, it stays incomplete.
pub fn possible(modules: &Modules, arrows: &[Arrow]) -> Vec<String> {
    let tops = &modules[&Segments::new()].children;
    let uses = |top: &String, other: &String| {
        let between = |arrow: &&Arrow| arrow.from.first() == Some(top) && arrow.to.first() == Some(other);
        top != other && arrows.iter().any(|arrow| between(&arrow))
    };
    let mut order: Vec<String> = Vec::new();
    let fits = |order: &[String], top: &&String| {
        !order.contains(top) && tops.iter().all(|other| order.contains(other) || !uses(top, other))
    };
    while let Some(next) = tops.iter().find(|top| fits(&order, top)).cloned() {
        order.push(next);
    }
    order
}

/// Uses of a later module in an earlier one. The root file stands above all: what it declares itself, no module may use.
pub fn up(modules: &Modules, arrows: &[Arrow], order: &[&str]) -> Vec<String> {
    let floor = |path: &Segments| match path.first() {
        Some(top) => order.iter().position(|name| name == top),
        None => Some(order.len()),
    };
    let rises = |arrow: &&Arrow| matches!((floor(&arrow.from), floor(&arrow.to)), (Some(from), Some(to)) if from < to);
    let describe = |arrow: &Arrow| {
        let (from, to) =
            (arrow.from.first().map_or("", String::as_str), arrow.to.first().map_or("the root", String::as_str));
        format!("{}: {to} stands above {from}", place(modules, arrow))
    };
    arrows.iter().filter(rises).map(describe).collect()
}

/// Sets of files that use one another in a ring: one text a ring, which lists its arrows.
pub fn circles(modules: &Modules, arrows: &[Arrow]) -> Vec<String> {
    let mut uses: BTreeMap<&Segments, BTreeSet<&Segments>> = BTreeMap::new();
    for arrow in arrows {
        uses.entry(&arrow.from).or_default().insert(&arrow.to);
    }
    let reached: BTreeMap<&Segments, BTreeSet<&Segments>> =
        uses.keys().map(|from| (*from, everything_below(from, &uses))).collect();
    let ring = |from: &Segments| -> BTreeSet<&Segments> {
        let back = |to: &&&Segments| reached.get(**to).is_some_and(|below| below.contains(from));
        reached[from].iter().filter(back).copied().collect()
    };
    let rings: BTreeSet<BTreeSet<&Segments>> =
        uses.keys().map(|from| ring(from)).filter(|ring| ring.len() > 1).collect();
    rings.iter().map(|ring| describe(modules, arrows, ring)).collect()
}

fn everything_below<'a>(
    from: &Segments,
    uses: &BTreeMap<&'a Segments, BTreeSet<&'a Segments>>,
) -> BTreeSet<&'a Segments> {
    let mut found = BTreeSet::new();
    let mut todo: Vec<&Segments> = uses.get(from).into_iter().flatten().copied().collect();
    while let Some(next) = todo.pop() {
        if found.insert(next) {
            todo.extend(uses.get(next).into_iter().flatten());
        }
    }
    found
}

fn describe(modules: &Modules, arrows: &[Arrow], ring: &BTreeSet<&Segments>) -> String {
    let names: Vec<String> = ring.iter().map(|path| modules[*path].file.display().to_string()).collect();
    let mut first_uses = BTreeMap::new();
    for arrow in arrows.iter().filter(|arrow| ring.contains(&arrow.from) && ring.contains(&arrow.to)) {
        first_uses.entry((&arrow.from, &arrow.to)).or_insert(arrow);
    }
    let lines: Vec<String> = first_uses.values().map(|arrow| format!("\n    {}", place(modules, arrow))).collect();
    format!("circle of {} files: {}{}", names.len(), names.join(", "), lines.concat())
}

/// Where an arrow starts and what it uses.
fn place(modules: &Modules, arrow: &Arrow) -> String {
    let (from, to) = (&modules[&arrow.from].file, &modules[&arrow.to].file);
    format!("{}:{}: {} (in {})", from.display(), arrow.line, arrow.written, to.display())
}
