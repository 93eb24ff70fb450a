//! Where the SRP's cycles go: what similarity tests and interpolation cost.

use crate::html::charts::stacked::{Part, StackedRow, stacked};
use crate::html::modes::by_mode;
use crate::html::parts::{Section, grid, how_to_read, key, legend};
use crate::html::text::{count, percent};
use crate::html::view::StudyView;
use crate::schema::{Kernel, Point};

/// The kernels that sampling adds, with their colour class; the others are grey.
const COLOURS: [(&str, &str); 7] = [
    ("similarity", "k0"),
    ("colour", "k0"),
    ("look_back", "k0"),
    ("control", "k0"),
    ("interpolate", "k1"),
    ("attributes", "k1"),
    ("reshade", "k1"),
];

/// The others, by shade; what the paper does not tell apart is as dark as the first.
const GREYS: [&str; 6] = ["raygen", "shade", "miss", "update", "resolve", "inspector"];

/// What the colours mean.
const KEYS: [(&str, &str); 3] = [("similarity", "k0"), ("interpolation", "k1"), ("other kernels", "k2")];

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    if view.points.iter().all(|p| p.srp.is_empty()) {
        return None;
    }
    let keys = KEYS.into_iter().map(|(name, class)| key(class, name));
    let mut html = legend(&keys.collect::<String>());
    html += &by_mode(view, |mode| {
        grid(&view.scenes(mode).iter().map(|scene| chart(view, scene, mode)).collect::<String>())
    });
    html += &how_to_read(&format!(
        "Busy cycles of the SRPs by kernel; the number is the share that adaptive sampling adds: similarity tests with \
         their colours and inspector, and interpolation with its attributes and shading. The grey rest is ray generation, shading, the \
         resolve step, and the inspector, which sorts the items of all other kernels by branch.{}",
        view.shares_estimated()
    ));
    Section::new("srp", "What the SRP does", html)
}

/// By how much each kernel of a colour is paler than the one before it.
const SHADE: f64 = 0.15;

/// Colour class and shade of a kernel, the same in all bars.
fn look(kernel: &str) -> (&'static str, f64) {
    let paler = |steps: usize| 1.0 - SHADE * steps as f64;
    match COLOURS.iter().position(|(name, _)| *name == kernel) {
        Some(at) => {
            let (_, class) = COLOURS[at];
            (class, paler(COLOURS[..at].iter().filter(|(_, other)| *other == class).count()))
        }
        None => ("k2", paler(GREYS.iter().position(|name| *name == kernel).unwrap_or(0))),
    }
}

/// Less than this is rounding.
const SHARE_LEAST: f64 = 5e-4;

/// The kernels, and the inspector with the busy cycles that none of them has.
fn whole(kernels: &[Kernel]) -> Vec<Kernel> {
    let rest = 1.0 - kernels.iter().map(|kernel| kernel.share).sum::<f64>();
    let inspector = Kernel { kernel: "inspector".into(), cycles: 0, share: rest };
    kernels.iter().cloned().chain((rest > SHARE_LEAST).then_some(inspector)).collect()
}

/// Cycles of the kernels that sampling adds, as a share.
fn added(kernels: &[Kernel]) -> f64 {
    kernels.iter().filter(|k| COLOURS.iter().any(|(name, _)| *name == k.kernel)).map(|k| k.share).sum()
}

fn chart(view: &StudyView<'_>, scene: &str, mode: &str) -> String {
    let points: Vec<&Point> = view.of(scene, mode).into_iter().filter(|p| !p.srp.is_empty()).collect();
    if points.is_empty() {
        return String::new();
    }
    let row = |point: &&Point| StackedRow::Bar {
        name: point.policy.clone(),
        parts: parts(&point.policy, &whole(&point.srp)),
        within: None,
        text: percent(added(&point.srp)),
    };
    let mut rows: Vec<StackedRow> = points.iter().map(row).collect();
    let text: Vec<String> = points.iter().map(|p| format!("{} {}", p.policy, percent(added(&p.srp)))).collect();
    let stated = &view.study.references.srp;
    if !stated.is_empty() {
        let kernels = stated.iter().map(|k| Kernel { kernel: k.kernel.clone(), cycles: 0, share: k.share });
        let mut kernels: Vec<Kernel> = kernels.collect();
        let rest = 1.0 - kernels.iter().map(|k| k.share).sum::<f64>();
        kernels.push(Kernel { kernel: "other kernels".into(), cycles: 0, share: rest });
        let text = percent(added(&kernels));
        rows.push(StackedRow::Bar {
            name: "the paper".into(),
            parts: parts("the paper (it does not say of which scenes)", &kernels),
            within: None,
            text,
        });
    }
    let label = format!("Stacked bars, {scene}: SRP cycles by kernel. Added by sampling: {}.", text.join("; "));
    view.charts.card(
        &["srp", mode, scene],
        scene,
        &stacked(&rows, (1.0, "share of the cycles"), |_, tick| percent(tick).replace(".0", ""), &label),
        "",
    )
}

fn parts(name: &str, kernels: &[Kernel]) -> Vec<Part> {
    let mut sorted: Vec<&Kernel> = kernels.iter().collect();
    // What sampling adds first, so that it begins at zero in every bar.
    sorted.sort_by_key(|k| COLOURS.iter().position(|(name, _)| *name == k.kernel).unwrap_or(COLOURS.len()));
    let part = |kernel: &&Kernel| {
        let cycles = if kernel.cycles > 0 { format!(", {} cycles", count(kernel.cycles)) } else { String::new() };
        let (class, opacity) = look(&kernel.kernel);
        Part {
            name: kernel.kernel.clone(),
            value: kernel.share,
            class: class.into(),
            opacity,
            tip: format!("{name}\n{} {}{cycles}", kernel.kernel, percent(kernel.share)),
        }
    };
    sorted.iter().map(part).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::html::sections::units::KERNELS;

    #[test]
    fn no_two_kernels_look_the_same() {
        let names = COLOURS.iter().map(|(name, _)| *name).chain(GREYS);
        let looks: Vec<_> = names.map(look).collect();
        for (i, one) in looks.iter().enumerate() {
            assert!(one.1 > 0.2 && !looks[..i].contains(one), "{one:?}");
        }
        let is_known = |kernel| COLOURS.iter().any(|(name, _)| *name == kernel) || GREYS.contains(&kernel);
        assert_eq!(
            KERNELS.into_iter().find(|kernel| !is_known(*kernel)),
            None,
            "it would look like the first of the greys"
        );
        assert_eq!([look("other kernels"), look("similarity")], [("k2", 1.0), ("k0", 1.0)]);
    }
}
