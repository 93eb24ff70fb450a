//! The charts that the page's script draws, as they first are: for files, which nobody can choose in.

use std::collections::BTreeSet;

use crate::analysis::dims::Dimension;
use crate::analysis::effects::Effect;
use crate::analysis::goals::goal;
use crate::analysis::pareto::front;
use crate::html::charts::WIDTH;
use crate::html::charts::chart::{Chart, Data, Key, cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{COLOURS, Svg, marker, n, shortened};
use crate::html::sweep::number::{number, signed_percent};
use crate::html::sweep::view::{SweepView, VALUES_MAX};
use crate::html::text::escape;
use crate::table::Field;

/// Height of a row.
const ROW: f64 = 20.0;

/// Breadth of the strip for what is infinite.
const STRIP: f64 = 34.0;

/// Most values in a legend.
const KEYS_MAX: usize = 24;

/// Draws them.
pub fn keep(view: &SweepView<'_>) {
    if let Some([x, y]) = view.pair.and_then(|[x, y]| Some([view.results.field(x)?, view.results.field(y)?])) {
        let title = format!("{} against {}", y.name, x.name);
        view.charts.keep(&["pareto"], &title, &pareto(view, [x, y]));
        if let Some((title, chart)) = heat(view, y) {
            view.charts.keep(&["heat"], &title, &chart);
        }
    }
    for field in &view.moved() {
        let effects = view.effects(field);
        if !effects.is_empty() {
            let title = format!("What moves {}", field.name);
            view.charts.keep(&["effects", &field.name], &title, &ranges(field, &effects));
        }
    }
}

fn named(field: &Field) -> String {
    if matches!(field.unit.as_str(), "" | "1") { field.name.clone() } else { format!("{}, {}", field.name, field.unit) }
}

/// Points of two results, and of each group those that no other beats in both.
fn pareto(view: &SweepView<'_>, fields: [&Field; 2]) -> Chart {
    let value = |row: usize| {
        let [x, y] = fields.map(|field| view.result(field, row));
        Some([x?, y?]).filter(|_| view.error(row).is_none())
    };
    let points: Vec<Option<[f64; 2]>> = (0..view.results.rows()).map(value).collect();
    let goals = fields.map(|field| goal(&field.name));
    let fronts: Vec<Vec<usize>> = view.groups().into_iter().map(|(_, rows)| best(&points, &rows, goals)).collect();
    // What is infinite, as the PSNR of the same picture, stands in a strip of its own behind the end of its axis.
    let apart = [0, 1].map(|axis| points.iter().flatten().any(|point| point[axis].is_infinite()));
    let [left, bottom] = [52.0, 240.0];
    let right = WIDTH - if apart[0] { 12.0 + STRIP + 4.0 } else { 12.0 };
    let top = 24.0 + if apart[1] { STRIP + 4.0 } else { 0.0 };
    let finite = |axis: usize| points.iter().flatten().map(move |point| point[axis]).filter(|value| value.is_finite());
    let x = Scale::nice(extent(finite(0)).unwrap_or([0.0, 1.0]), 5, [left, right]);
    let y = Scale::nice(extent(finite(1)).unwrap_or([0.0, 1.0]), 5, [bottom, top]);
    let place = |[a, b]: [f64; 2]| {
        let across = if a.is_infinite() { right + 4.0 + STRIP / 2.0 } else { x.at(a) };
        [across, if b.is_infinite() { top - 4.0 - STRIP / 2.0 } else { y.at(b) }]
    };
    let mut svg = Svg::new(WIDTH, bottom + 38.0);
    for tick in y.ticks() {
        svg.line([left, y.at(tick)], [right, y.at(tick)], "grid");
        svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &y.label(tick));
    }
    for (tick, text) in x.named_ticks(|tick| x.label(tick)) {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &text);
    }
    if apart[0] {
        svg.rect([right + 4.0, top, STRIP, bottom - top], "apart");
        svg.text(right + 4.0 + STRIP / 2.0, top - 5.0, "tick m", "same");
    }
    if apart[1] {
        svg.rect([left, top - 4.0 - STRIP, right - left, STRIP], "apart");
        svg.text(left - 5.0, top - STRIP / 2.0, "tick e", "same");
    }
    svg.line([left, bottom], [right, bottom], "axis");
    svg.text(0.0, 11.0, "note s", &named(fields[1]));
    svg.text(right, bottom + 32.0, "note e", &named(fields[0]));
    for front in &fronts {
        let corner = |row: &usize| points[*row].map(place).map(|[a, b]| format!("{} {}", n(a), n(b)));
        svg.path(&format!("M{}", front.iter().filter_map(corner).collect::<Vec<_>>().join("L")), "frontier", "");
    }
    let on: BTreeSet<usize> = fronts.into_iter().flatten().collect();
    let colour = view.colour().and_then(|name| view.dimensions.iter().find(|dimension| dimension.name == name));
    let names = [fields[0].name.as_str(), &fields[1].name];
    let columns: Vec<&str> =
        ["point"].into_iter().chain(view.dimensions.iter().map(|d| d.name.as_str())).chain(names).collect();
    let mut data = Data::new(&[columns.as_slice(), &["front"]].concat());
    for (row, point) in points.iter().enumerate().filter_map(|(row, point)| Some((row, (*point)?))) {
        let look = colour.and_then(|dimension| dimension.of[row]).unwrap_or(0);
        let (dim, [across, up]) = (if on.contains(&row) { "" } else { " dim" }, place(point));
        svg.raw(&format!(
            "<path d=\"{}\" class=\"dot p{}{dim}\"><title>{}</title></path>",
            marker(look, across, up),
            look % COLOURS,
            escape(&view.describe(row, None))
        ));
        let values = view.dimensions.iter().map(|d| d.of[row].map(|value| d.values[value].clone()).unwrap_or_default());
        let ends = [cell(Some(point[0])), cell(Some(point[1])), on.contains(&row).to_string()];
        data.row([view.number(row)].into_iter().chain(values).chain(ends).collect());
    }
    let names = colour.into_iter().flat_map(|dimension| dimension.values.iter().enumerate());
    let key = |(value, name): (usize, &String)| Key::of_marker(&format!("p{}", value % COLOURS), value, name);
    let keys = names.take(KEYS_MAX).map(key).collect();
    Chart { svg: svg.finish("Points of two results; lines join those that no other beats", ""), data, keys }
}

/// The rows of a group that no other of it beats, along the first result.
fn best(points: &[Option<[f64; 2]>], rows: &[usize], goals: [crate::analysis::goals::Goal; 2]) -> Vec<usize> {
    let here: Vec<Option<[f64; 2]>> = rows.iter().map(|row| points[*row]).collect();
    let mut on: Vec<usize> = rows.iter().zip(front(&here, goals)).filter(|(_, on)| *on).map(|(row, _)| *row).collect();
    let key = |row: &usize| points[*row].unwrap_or_default();
    on.sort_by(|a, b| key(a)[0].total_cmp(&key(b)[0]).then(key(a)[1].total_cmp(&key(b)[1])));
    on
}

/// The mean of a result over the two axes that move it most.
fn heat(view: &SweepView<'_>, field: &Field) -> Option<(String, Chart)> {
    let [down, across] = view.heat_axes()?;
    let mut sums = vec![vec![(0.0, 0_u32); across.values.len()]; down.values.len()];
    for row in 0..view.results.rows() {
        let (Some(a), Some(b), Some(value)) = (down.of[row], across.of[row], field.cells.number(row)) else { continue };
        if value.is_finite() && view.error(row).is_none() {
            sums[a][b].0 += value;
            sums[a][b].1 += 1;
        }
    }
    // Values that no point has with the result are left out, as on the page.
    let has = |a: usize, b: usize| sums[a][b].1 > 0;
    let [all_down, all_across] = [down, across].map(|axis| 0..axis.values.len());
    let rows: Vec<usize> = all_down.clone().filter(|a| all_across.clone().any(|b| has(*a, b))).collect();
    let columns: Vec<usize> = all_across.filter(|b| all_down.clone().any(|a| has(a, *b))).collect();
    if rows.is_empty() || rows.len().max(columns.len()) > VALUES_MAX {
        return None;
    }
    let cells: Vec<Vec<(f64, u32)>> = rows.iter().map(|a| columns.iter().map(|b| sums[*a][*b]).collect()).collect();
    let names = |axis: &Dimension, kept: &[usize]| kept.iter().map(|value| axis.values[*value].clone()).collect();
    let title = format!("{} by {} and {}", named(field), down.name, across.name);
    let sides = [
        Side { name: &down.name, values: names(down, &rows) },
        Side { name: &across.name, values: names(across, &columns) },
    ];
    Some((title, map(field, &sides, &cells)))
}

/// A side of a map: an axis with those of its values that stand there.
struct Side<'a> {
    name: &'a str,
    values: Vec<String>,
}

fn map(field: &Field, [down, across]: &[Side<'_>; 2], cells: &[Vec<(f64, u32)>]) -> Chart {
    let mean = |(sum, count): &(f64, u32)| (*count > 0).then(|| sum / f64::from(*count));
    let ends = extent(cells.iter().flatten().filter_map(mean)).unwrap_or([0.0, 1.0]);
    let (left, top) = (96.0, 40.0);
    let width = (WIDTH - left) / across.values.len().max(1) as f64;
    let mut svg = Svg::new(WIDTH, top + ROW * cells.len() as f64 + 4.0);
    svg.text(0.0, 11.0, "note s", &format!("{} down, {} across", down.name, across.name));
    for (i, value) in across.values.iter().enumerate() {
        let room = ((width / 6.2) as usize).max(1);
        svg.text(left + width * (i as f64 + 0.5), top - 8.0, "tick m", &shortened(value, room));
    }
    let mut data = Data::new(&[down.name, across.name, &field.name, "points"]);
    for (i, (value, row)) in down.values.iter().zip(cells).enumerate() {
        let y = top + ROW * i as f64;
        svg.text(left - 6.0, y + 14.0, "tick e", &shortened(value, 14));
        for (j, sum) in row.iter().enumerate() {
            let mean = mean(sum);
            data.row(vec![value.clone(), across.values[j].clone(), cell(mean), sum.1.to_string()]);
            let Some(mean) = mean else { continue };
            let share = if ends[1] > ends[0] { (mean - ends[0]) / (ends[1] - ends[0]) } else { 0.0 };
            let x = left + width * j as f64;
            let tip = format!("{} {value}, {} {}\n{}", down.name, across.name, across.values[j], number(mean));
            svg.mark([x, y, width - 1.0, ROW - 1.0], "b2", 0.08 + 0.72 * share, &tip);
            if width >= 34.0 {
                svg.text(x + width / 2.0, y + 14.0, "value m", &number(mean));
            }
        }
    }
    Chart { svg: svg.finish("Mean of a result over two axes", ""), data, keys: Vec::new() }
}

/// For each axis how far the means of a result at its values lie from the mean of all.
fn ranges(field: &Field, effects: &[(&Dimension, Effect)]) -> Chart {
    let (left, right, top) = (110.0, WIDTH - 56.0, 6.0);
    let bottom = top + ROW * effects.len() as f64;
    let ends = effects.iter().flat_map(|(_, effect)| [effect.end(0), effect.end(1), 0.0]);
    let x = Scale::nice(extent(ends).unwrap_or([-0.1, 0.1]), 3, [left, right]);
    let mut svg = Svg::new(WIDTH, bottom + 22.0);
    for tick in x.ticks() {
        svg.line([x.at(tick), top], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &signed_percent(tick).replace(".0", ""));
    }
    let mut data = Data::new(&["axis", "value", &field.name]);
    for (i, (dimension, effect)) in effects.iter().enumerate() {
        let y = top + ROW * i as f64;
        let (a, b) = (x.at(effect.end(0)), x.at(effect.end(1)));
        svg.text(left - 6.0, y + 13.0, "label e", &shortened(&dimension.name, 16));
        let tip = format!("{} to {}", dimension.values[effect.ends[0]], dimension.values[effect.ends[1]]);
        svg.mark([a, y + 3.0, (b - a).max(1.0), ROW - 7.0], "b2", 1.0, &tip);
        svg.text(right + 6.0, y + 13.0, "value s", &signed_percent(effect.share()).replace('+', ""));
        for (value, mean) in dimension.values.iter().zip(&effect.means) {
            let Some(mean) = mean else { continue };
            data.row(vec![dimension.name.clone(), value.clone(), cell(Some(*mean))]);
        }
    }
    svg.line([x.at(0.0), top], [x.at(0.0), bottom], "axis");
    Chart {
        svg: svg.finish("Main effects: from the least to the most mean, from the mean of all", ""),
        data,
        keys: Vec::new(),
    }
}
