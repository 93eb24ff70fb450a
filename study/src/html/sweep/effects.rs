//! Which axis moves which result by how much.

use crate::analysis::dims::Dimension;
use crate::analysis::effects::Effect;
use crate::html::parts::{Head, Section, how_to_read, table};
use crate::html::sweep::number::{number, signed_percent};
use crate::html::sweep::view::SweepView;
use crate::html::text::{escape, or_dash, percent};
use crate::table::Field;

/// The section.
pub fn section(view: &SweepView<'_>) -> Option<Section> {
    let moved = view.moved();
    if view.dimensions.is_empty() || moved.is_empty() {
        return None;
    }
    let cards: String = moved.iter().map(|field| card(view, field)).collect();
    let read = "For each value of an axis the result is averaged over points that differ in that axis alone. As many values are compared \
                as stand together in such points; a bar says how many others are left out, as a machine that has an axis of its own, and \
                how many points it is of where some lack partners. Axes that go forward together have one effect, and name each other. \
                An axis of which no two values stand together has none. A bar reaches from the least to the most of these means, as far \
                as they lie from the mean of them all: its length is the main effect. Effects that axes have only together do not show here; the \
                heat map shows them.";
    let controls = "<div class=\"controls only-js\"><label class=\"wide\">Another result <select id=\"effects-result\"></select></label>\
                    <output id=\"effects-of\"></output></div>\n";
    let html = format!(
        "{controls}<div id=\"effects-cards\" class=\"grid two\">\n{cards}</div>\n<div id=\"effects-table\">{}</div>\n{}",
        all(view, &moved),
        how_to_read(read)
    );
    Section::new("effects", "Sensitivity", html)
}

/// The bars of one result.
fn card(view: &SweepView<'_>, field: &Field) -> String {
    let effects = view.effects(field);
    let low = effects.iter().map(|(_, effect)| effect.end(0)).fold(0.0, f64::min);
    let high = effects.iter().map(|(_, effect)| effect.end(1)).fold(0.0, f64::max);
    let width = if high > low { high - low } else { 1.0 };
    let at = |end: f64| (end - low) / width * 100.0;
    let bar = |(dimension, effect): &(&Dimension, Effect)| {
        let (from, to) = (at(effect.end(0)), at(effect.end(1)));
        format!(
            "<li data-axis=\"{name}\" data-share=\"{share:.6}\"><span class=\"bar-name\">{name}<small>{ends}</small></span>\
             <span class=\"bar-track\" data-mark=\"\" data-tip=\"{tip}\"><span class=\"bar-fill\" style=\"left:{from:.2}%;width:{:.2}%\">\
             </span><span class=\"bar-mid\" style=\"left:{:.2}%\"></span></span><span class=\"bar-value\">{}</span></li>\n",
            to - from,
            at(0.0),
            percent(effect.share()),
            name = escape(&dimension.name),
            share = effect.share(),
            ends = escape(&ends(dimension, effect)),
            tip = escape(&tip(field, dimension, effect)),
        )
    };
    let bars: String = effects.iter().map(bar).collect();
    let bars = if bars.is_empty() {
        "<p>No two of these points differ in one axis alone.</p>".into()
    } else {
        format!("<ul class=\"bars\">\n{bars}</ul>")
    };
    let mean = mean(view, field);
    format!(
        "<figure class=\"card\" data-result=\"{name}\"><figcaption><strong>{name}</strong> <small>{}</small><p>{}</p></figcaption>\
         {bars}</figure>\n",
        escape(&mean),
        escape(&field.description),
        name = escape(&field.name),
    )
}

/// The mean of a result over all points, not only over those that some bar compares.
fn mean(view: &SweepView<'_>, field: &Field) -> String {
    let values: Vec<f64> = (0..view.results.rows()).filter_map(|row| view.result(field, row)).collect();
    let finite: Vec<f64> = values.iter().copied().filter(|value| value.is_finite()).collect();
    if finite.is_empty() {
        return String::new();
    }
    let mean = finite.iter().sum::<f64>() / finite.len() as f64;
    let without = match values.iter().filter(|value| value.is_infinite()).count() {
        0 => "",
        1 => ", without 1 infinite value",
        count => &format!(", without {count} infinite values"),
    };
    format!("mean {} {}", number(mean), unit(field)).trim_end().to_owned() + without
}

fn unit(field: &Field) -> &str {
    if field.unit == "1" { "" } else { &field.unit }
}

/// The values with the least and the most mean.
fn ends(dimension: &Dimension, effect: &Effect) -> String {
    let value = |end: usize| &dimension.values[effect.ends[end]];
    let ends = if effect.share() == 0.0 { "no change".into() } else { format!("{} to {}", value(0), value(1)) };
    let together =
        if effect.together.is_empty() { String::new() } else { format!(", with {}", effect.together.join(", ")) };
    let part = if effect.in_part { format!(", of {} points", effect.points) } else { String::new() };
    let left_out = match effect.left_out {
        0 => "",
        1 => ", without 1 value",
        count => &format!(", without {count} values"),
    };
    ends + &together + &part + left_out
}

/// The mean of each value, shown when a bar is pointed at.
fn tip(field: &Field, dimension: &Dimension, effect: &Effect) -> String {
    let mut text = format!("{} by {}", field.name, dimension.name);
    for (value, mean) in dimension.values.iter().zip(&effect.means).take(24) {
        let Some(mean) = mean else { continue };
        text += &format!("\n{value}: {} {} ({})", number(*mean), unit(field), signed_percent(effect.relative(*mean)));
    }
    if dimension.values.len() > 24 {
        text += "\n…";
    }
    text
}

/// Every axis against every result.
fn all(view: &SweepView<'_>, results: &[&Field]) -> String {
    let columns: Vec<Head> =
        [Head::words("Axis")].into_iter().chain(results.iter().map(|field| Head::number(&field.name))).collect();
    let row = |dimension: &Dimension| {
        let share = |field: &&Field| or_dash(view.effect(dimension, field), |effect| percent(effect.share()));
        let cells = [escape(&dimension.name)].into_iter().chain(results.iter().map(share)).collect();
        (String::new(), cells)
    };
    let rows: Vec<_> = view.dimensions.iter().map(row).collect();
    table("Main effects, % of the mean", &columns, &rows)
}
