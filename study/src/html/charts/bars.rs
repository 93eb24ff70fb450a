//! Bars: groups of vertical ones (the paper's Figure 7), and rows of horizontal ones (a value for each policy).

use crate::html::charts::WIDTH;
use crate::html::charts::chart::{Chart, Data, Key, cell, ends, once, percent_cell};
use crate::html::charts::scale::{Scale, extent};
use crate::html::charts::svg::{Svg, n, text_width, told_apart};
use crate::html::text::factor;
use crate::point::known::interval_of;

/// A vertical bar of a group.
pub struct Bar {
    /// What it is.
    pub name: &'static str,
    /// Its height; nothing leaves a gap.
    pub value: Option<f64>,
    /// Half its interval, a part of it; nothing where it is exact.
    pub within: Option<f64>,
    /// Colour class.
    pub class: &'static str,
    /// What it says when asked.
    pub tip: String,
}

/// Bars side by side over one name.
pub struct Group {
    /// The name.
    pub name: String,
    /// The bars.
    pub bars: Vec<Bar>,
    /// What the paper states for the last bar: least and, if stated, most.
    pub band: Option<(f64, Option<f64>)>,
}

/// Height of the vertical chart.
const HEIGHT: f64 = 250.0;

/// Groups of vertical bars over a common axis of factors. A line marks 1, the reference.
pub fn grouped(groups: &[Group], label: &str) -> Chart {
    let [right, top, bottom] = [WIDTH - 4.0, 14.0, HEIGHT - 26.0];
    let values = groups.iter().flat_map(|g| {
        let (least, most) = g.band.unwrap_or((0.0, None));
        g.bars.iter().filter_map(|b| Some(ends(b.value?, b.within)[1])).chain([least, most.unwrap_or(least)])
    });
    let [_, most] = extent(values).unwrap_or([0.0, 1.0]);
    // Room above the highest bar for its number.
    let y = Scale::exact([0.0, most.max(1.0) * 1.09], 6, [bottom, top]);
    let left = y.margin(34.0, |tick| factor_tick(&y, tick));
    let mut svg = Svg::new(WIDTH, HEIGHT);
    for tick in y.ticks() {
        svg.line([left, y.at(tick)], [right, y.at(tick)], "grid");
        svg.text(left - 5.0, y.at(tick) + 4.0, "tick e", &factor_tick(&y, tick));
    }
    svg.line([left, y.at(1.0)], [right, y.at(1.0)], "one");
    let slot = (right - left) / groups.len().max(1) as f64;
    let names: Vec<&str> = groups.iter().map(|group| group.name.as_str()).collect();
    let names = told_apart(&names, (slot / 6.2) as usize);
    for (i, (group, name)) in groups.iter().zip(&names).enumerate() {
        upright(&mut svg, (group, name), [left + slot * i as f64, slot], &y, bottom);
    }
    svg.line([left, bottom], [right, bottom], "axis");
    let bars = groups.iter().flat_map(|group| &group.bars);
    let keys = once(bars.map(|bar| Key::new(bar.class, bar.name)));
    Chart { svg: svg.finish(label, ""), data: of_groups(groups), keys }
}

fn of_groups(groups: &[Group]) -> Data {
    let mut data = Data::new(&["group", "bar", "factor", &interval_of("factor"), "paper_least", "paper_most"]);
    for group in groups {
        for (i, bar) in group.bars.iter().enumerate() {
            let band = group.band.filter(|_| i + 1 == group.bars.len());
            let (least, most) = (band.map(|band| band.0), band.and_then(|band| band.1));
            let values = [cell(bar.value), percent_cell(bar.within), cell(least), cell(most)];
            data.row([group.name.clone(), bar.name.into()].into_iter().chain(values).collect());
        }
    }
    data
}

fn factor_tick(scale: &Scale, tick: f64) -> String {
    scale.label(tick) + "×"
}

/// One group and its name in its slot: left end and width.
fn upright(svg: &mut Svg, (group, name): (&Group, &str), [start, slot]: [f64; 2], y: &Scale, bottom: f64) {
    // The last slot is for the paper's bracket.
    let places = group.bars.len() as f64 + 0.8;
    let (pad, middle) = (slot * 0.08, start + slot / 2.0);
    let width = ((slot - 2.0 * pad) / places).min(24.0);
    let first = middle - width * places / 2.0;
    for (i, bar) in group.bars.iter().enumerate() {
        let Some(value) = bar.value else { continue };
        let x = first + width * i as f64;
        svg.mark([x + 0.75, y.at(value), width - 1.5, bottom - y.at(value)], bar.class, 1.0, &bar.tip);
        let ends = ends(value, bar.within).map(|end| y.at(end));
        svg.upright_interval(x + width / 2.0, ends, "within");
        if i + 1 == group.bars.len() {
            let text = factor(value).trim_end_matches('×').to_owned();
            // There is room above the low bar of power, and the bracket stands at the right.
            svg.text(x + width + 1.0, ends[1] - 4.0, "value over e", &text);
        }
    }
    if let Some(band) = group.band {
        bracket(svg, first + width * (places - 0.3), band, y);
    }
    svg.text(middle, bottom + 17.0, "label m", name);
}

/// What the paper states: from least to most, or an arrow upwards from least.
fn bracket(svg: &mut Svg, x: f64, (least, most): (f64, Option<f64>), y: &Scale) {
    let (low, high) = (y.at(least), most.map_or(y.at(least) - 16.0, |m| y.at(m)));
    let cap = |at: f64| format!("M{} {}h7", n(x - 3.5), n(at));
    let top = match most {
        Some(_) => cap(high),
        None => format!("M{} {}l3.5 -5l3.5 5", n(x - 3.5), n(high + 5.0)),
    };
    svg.path(&format!("{}M{x} {}V{}{top}", cap(low), n(low), n(high), x = n(x)), "paper", "");
}

/// A horizontal bar.
pub struct HorizontalBar {
    /// Name at its left.
    pub name: String,
    /// Its length.
    pub value: f64,
    /// Half its interval, a part of it; nothing where it is exact.
    pub within: Option<f64>,
    /// What stands behind its end.
    pub text: String,
    /// Colour class.
    pub class: String,
    /// What it says when asked.
    pub tip: String,
}

/// Height of a row.
const ROW: f64 = 22.0;

/// Horizontal bars over an axis of factors that reaches `most`; the zone is what the paper states.
pub fn rows(rows: &[HorizontalBar], most: f64, zone: Option<(f64, Option<f64>)>, label: &str) -> Chart {
    let top = if zone.is_some() { 20.0 } else { 6.0 };
    let (names, left) = beside(&rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), NAME_MAX);
    let height = top + ROW * rows.len() as f64 + 22.0;
    let bottom = height - 22.0;
    let behind = rows.iter().map(|r| text_width(&r.text)).fold(0.0, f64::max) + 8.0;
    let room = rows.iter().map(|row| ends(1.0, row.within)[1]).fold(1.0, f64::max);
    let x = Scale::exact([0.0, most.max(1.0) * room], 6, [left, WIDTH - behind]);
    let mut svg = Svg::new(WIDTH, height);
    if let Some((least, end)) = zone {
        let (a, b) = (x.at(least), end.map_or(WIDTH - behind, |m| x.at(m)));
        svg.rect([a, top - 4.0, (b - a).max(2.0), bottom - top + 4.0], "zone");
        let text =
            end.map_or_else(|| format!("paper ≥ {}", factor(least)), |m| format!("paper {least} to {}", factor(m)));
        let middle = f64::midpoint(a, b).min(WIDTH - text_width(&text) / 2.0).max(text_width(&text) / 2.0);
        svg.text(middle, top - 8.0, "note m", &text);
    }
    for tick in x.ticks() {
        svg.line([x.at(tick), top - 4.0], [x.at(tick), bottom], "grid");
        svg.text(x.at(tick), bottom + 15.0, "tick m", &factor_tick(&x, tick));
    }
    for (i, row) in rows.iter().enumerate() {
        let y = top + ROW * i as f64;
        svg.text(left - 6.0, y + 13.5, "label e", &names[i]);
        svg.mark([left, y + 3.0, x.at(row.value) - left, ROW - 7.0], &row.class, 1.0, &row.tip);
        svg.level_interval(y + ROW / 2.0 - 0.5, ends(row.value, row.within).map(|end| x.at(end)));
    }
    svg.line([x.at(1.0), top - 4.0], [x.at(1.0), bottom], "one");
    for (i, row) in rows.iter().enumerate() {
        let [_, end] = ends(row.value, row.within);
        svg.text(x.at(end) + 5.0, top + ROW * i as f64 + 13.5, "value over s", &row.text);
    }
    svg.line([left, top - 4.0], [left, bottom], "axis");
    let mut data = Data::new(&["name", "factor", &interval_of("factor"), "text", "paper_least", "paper_most"]);
    for row in rows {
        let (least, end) = (zone.map(|zone| zone.0), zone.and_then(|zone| zone.1));
        let (value, within) = (cell(Some(row.value)), percent_cell(row.within));
        data.row(vec![row.name.clone(), value, within, row.text.clone(), cell(least), cell(end)]);
    }
    Chart { svg: svg.finish(label, ""), data, keys: Vec::new() }
}

/// Most characters of a name beside a bar.
pub const NAME_MAX: usize = 15;

/// Names cut to so many characters, and room for the longest of them.
pub fn beside(names: &[&str], most: usize) -> (Vec<String>, f64) {
    let names = told_apart(names, most);
    let width = names.iter().map(|name| text_width(name)).fold(30.0, f64::max) + 8.0;
    (names, width)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_drawn_and_stand_in_the_file() {
        let group = |within| {
            let bar = |name, within| Bar { name, value: Some(4.0), within, class: "b0", tip: String::new() };
            Group { name: "a".into(), bars: vec![bar("exact", None), bar("estimated", within)], band: None }
        };
        let chart = grouped(&[group(Some(0.1234))], "label");
        assert_eq!(chart.svg.matches("class=\"within\"").count(), 1, "{}", chart.svg);
        let lines = "group,bar,factor,factor_interval_percent,paper_least,paper_most\r\na,exact,4,,,\r\na,estimated,4,12.34,,\r\n";
        assert_eq!(chart.data.csv(), lines);
        // A tenth of a percent would be a dot.
        for within in [None, Some(0.001)] {
            assert!(!grouped(&[group(within)], "label").svg.contains("class=\"within\""));
        }
    }

    /// A study may state anything: a note that is wider than the chart made the least place of its middle greater than the most.
    #[test]
    fn a_note_wider_than_the_chart_is_drawn() {
        let bar = |value| HorizontalBar {
            name: "a".into(),
            value,
            within: None,
            text: "1.0".into(),
            class: "c1".into(),
            tip: String::new(),
        };
        for (least, most) in [(1e300, Some(1e301)), (f64::MIN_POSITIVE, None), (2.0, Some(1.0)), (0.0, Some(f64::MAX))]
        {
            let chart = rows(&[bar(1.0), bar(least)], 1.0, Some((least, most)), "label").svg;
            assert!(chart.starts_with("<svg") && chart.trim_end().ends_with("</svg>"), "{chart}");
        }
    }
}
