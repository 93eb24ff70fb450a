//! Policies on machines: efficiency against quality, and what the paper states or expects that holds where.

use crate::analysis::systems::{Pair, STATEMENTS, Systems};
use crate::html::charts::scatter::{Dot, scatter};
use crate::html::parts::{Head, Section, grid, how_to_read, table};
use crate::html::text::{decibels, escape, factor, fixed, or_dash, plus_minus};
use crate::html::view::StudyView;

/// The section.
pub fn section(view: &StudyView<'_>) -> Option<Section> {
    let systems = Systems::of(&view.study.systems)?;
    let pairs = systems.pairs();
    let policies: Vec<&str> = systems.policies.clone();
    let mut html = view.legend(&policies);
    html += &grid(&(everything(view, &systems, &pairs) + &by_machine(view, &systems, &pairs)));
    html += &how_to_read(&format!(
        "Means over all scenes, 2×2 samples a pixel. The first chart compares machines too: frames a second and watt over \
         those of the first machine under full, one mark for each policy on each machine. The others compare the policies of one \
         machine with full on it, for the whole GPU and, where there are any, for the T&I units alone. The line joins what nothing beats \
         in both.{}",
        if pairs.iter().any(|pair| pair.interval.is_some()) {
            " Thin lines with caps are 95 % intervals, of the whole GPU on one machine alone."
        } else {
            ""
        }
    ));
    html += &gains(&systems, &pairs);
    html += &verdicts(&systems);
    html += &how_to_read(
        "What the paper states of SGRT, and what it expects of multi-rate sampling, looked at on every machine that can run adaptive \
         policies: the value that decides, for the T&I units alone where there are any, and for the whole GPU.",
    );
    Section::new("systems", "Policies on machines", html)
}

fn psnr(pair: &Pair) -> String {
    if pair.psnr_db.is_finite() { decibels(pair.psnr_db) } else { "same picture".into() }
}

/// The mark of a policy on a machine at a height, which may be off by a part of it.
fn dot(view: &StudyView<'_>, systems: &Systems<'_>, pair: &Pair, name: String, (y, within): (f64, Option<f64>)) -> Dot {
    let (look, machine) = (view.look(systems.policies[pair.policy]), systems.machines[pair.machine]);
    let tip = format!(
        "{} on {machine}\n{} perf/W over full there{}\nPSNR {}",
        systems.policies[pair.policy],
        factor(pair.gain),
        plus_minus(pair.interval),
        psnr(pair)
    );
    let x = pair.psnr_db.is_finite().then_some(pair.psnr_db);
    Dot { name, x, y, within, class: look.class(), shape: look.shape, tip }
}

fn everything(view: &StudyView<'_>, systems: &Systems<'_>, pairs: &[Pair]) -> String {
    let dots: Vec<Dot> = pairs
        .iter()
        .map(|pair| dot(view, systems, pair, systems.machines[pair.machine].to_owned(), (pair.merit, None)))
        .collect();
    let names = systems.frontier();
    let names: Vec<String> = names
        .iter()
        .map(|pair| format!("{} on {}", systems.policies[pair.policy], systems.machines[pair.machine]))
        .collect();
    let caption = format!("Beaten by nothing: {}.", names.join(", "));
    let chart = scatter(&dots, ["mean PSNR, dB", "performance per watt"], "All policies on all machines");
    view.charts.card(&["systems", "all"], "All machines", &chart, &caption)
}

fn by_machine(view: &StudyView<'_>, systems: &Systems<'_>, pairs: &[Pair]) -> String {
    let mut html = String::new();
    for (machine, name) in systems.machines.iter().enumerate() {
        let of_machine = pairs.iter().filter(|pair| pair.machine == machine);
        let dots: Vec<Dot> = of_machine
            .map(|pair| dot(view, systems, pair, systems.policies[pair.policy].to_owned(), (pair.gain, pair.interval)))
            .collect();
        html += &chart(view, &dots, name, "whole GPU");
        let alone = pairs.iter().filter(|pair| pair.machine == machine).filter_map(|pair| {
            Some(dot(view, systems, pair, systems.policies[pair.policy].to_owned(), (pair.ti_gain?, None)))
        });
        html += &chart(view, &alone.collect::<Vec<_>>(), name, "T&I units alone");
    }
    html
}

fn chart(view: &StudyView<'_>, dots: &[Dot], machine: &str, part: &str) -> String {
    if dots.len() < 2 {
        return String::new();
    }
    let title = format!("{machine}, {part}");
    let chart = scatter(dots, ["mean PSNR, dB", "performance per watt over full"], &title);
    view.charts.card(&["systems", machine, part], &title, &chart, "")
}

fn gains(systems: &Systems<'_>, pairs: &[Pair]) -> String {
    let mut columns = vec![Head::words("Machine"), Head::number("Full, over the first machine")];
    let others: Vec<usize> = (0..systems.policies.len()).filter(|p| systems.policies[*p] != "full").collect();
    columns.extend(others.iter().map(|policy| Head::number(systems.policies[*policy])));
    let pair = |machine: usize, policy: usize| pairs.iter().find(|p| (p.machine, p.policy) == (machine, policy));
    let full = systems.policies.iter().position(|policy| *policy == "full");
    let row = |machine: usize| {
        let mut cells = vec![escape(systems.machines[machine])];
        cells.push(or_dash(full.and_then(|full| pair(machine, full)), |pair| factor(pair.merit)));
        cells.extend(others.iter().map(|policy| {
            or_dash(pair(machine, *policy), |pair| {
                let alone = pair.ti_gain.map(|v| format!(" <small>({})</small>", factor(v))).unwrap_or_default();
                factor(pair.gain) + &plus_minus(pair.interval) + &alone
            })
        }));
        (String::new(), cells)
    };
    let mut rows: Vec<_> = (0..systems.machines.len()).map(row).collect();
    let quality = |policy: &usize| or_dash(pairs.iter().find(|pair| pair.policy == *policy), psnr);
    let mut last = vec!["Mean PSNR".to_owned(), String::new()];
    last.extend(others.iter().map(quality));
    rows.push(("strong".into(), last));
    table("Performance per watt over full on the same machine, whole GPU (T&I units alone)", &columns, &rows)
}

fn verdicts(systems: &Systems<'_>) -> String {
    let verdicts = systems.verdicts();
    let mut columns = vec![Head::words("Statement")];
    columns.extend(verdicts.iter().map(|verdict| Head::words(systems.machines[verdict.machine])));
    let part = |name: &str, value: Option<(bool, f64)>| {
        value.map(|(holds, v)| format!("{} {} <small>{name}</small>", if holds { "yes" } else { "no" }, fixed(v, 2)))
    };
    let cell = |both: &[Option<(bool, f64)>; 2]| {
        let parts: Vec<String> = [part("T&amp;I", both[0]), part("GPU", both[1])].into_iter().flatten().collect();
        parts.join("<br>")
    };
    let row = |(i, name): (usize, &&str)| {
        let cells = verdicts.iter().map(|verdict| cell(&verdict.holds[i]));
        (String::new(), [escape(name)].into_iter().chain(cells).collect())
    };
    table(
        "What the paper states or expects, and where it holds",
        &columns,
        &STATEMENTS.iter().enumerate().map(row).collect::<Vec<_>>(),
    )
}
