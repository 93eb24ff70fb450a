//! The page of a replay: figures of all frames, pictures with a slider, figures of each frame.

use serde_json::{Value, json};

use super::charts::{self, Figure};
use super::folder::Folder;
use crate::figures::{FixedColumn, columns};
use crate::html::charts::file::Saved;
use crate::html::charts::gallery::Gallery;
use crate::html::magnitude::Unit;
use crate::html::parts::{Head, Section, how_to_read, table};
use crate::html::shell::Shell;
use crate::html::text::{base64, bytes, count, counted, escape, plus_minus};
use crate::point::wanted::Kind;
use crate::report::extent::Extent;

const STYLE: &str = include_str!("player.css");

/// Figures of a frame.
const OF_FRAMES: &[Figure] = &[
    figure("rays_traced", "Rays", "", 0),
    figure("samples_interpolated", "Interpolated samples", "", 0),
    figure("psnr_db", "PSNR", "dB", 2),
    figure("ssim", "SSIM", "", 4),
    figure("flip", "FLIP", "", 4),
    figure("flicker", "Flicker", "", 2),
    figure("cycles", "Cycles", "", 0),
    figure("time_ms", "Time", "ms", 3),
    figure("energy_mj", "Energy of the T&I units", "mJ", 3),
    figure("gpu_energy_mj", "Energy of the GPU", "mJ", 3),
];

const fn figure(key: &'static str, name: &'static str, unit: &'static str, places: usize) -> Figure {
    Figure { key, name, unit, places }
}

/// The whole page.
pub fn page(replay: &Folder) -> (String, Vec<Saved>) {
    let drawn = Gallery::default();
    let lines = Section::new("lines", "Over the frames", charts::over_frames(&replay.stats, OF_FRAMES, &drawn));
    let sections: Vec<Section> =
        [pictures(replay), lines, frames(&replay.stats), figures(&replay.stats)].into_iter().flatten().collect();
    let title = format!("{} · {}", text(&replay.stats, "scene"), text(&replay.stats, "policy"));
    let html = Shell {
        title: &title,
        head: &head(&title, replay),
        sections: &sections,
        foot: &format!(
            "<footer><p>Written by rayreel {}. This file holds everything it shows, {} pictures of {} among it; it loads nothing.</p></footer>\n",
            env!("CARGO_PKG_VERSION"),
            replay.pictures.len(),
            bytes(replay.bytes())
        ),
        style: STYLE,
        data: Some(("player-data", &data(replay))),
        scripts: &[include_str!("../script.js"), include_str!("player.js")],
    }
    .html();
    (html, drawn.into_saved())
}

fn text<'a>(stats: &'a Value, key: &str) -> &'a str {
    stats[key].as_str().unwrap_or_default()
}

fn head(title: &str, replay: &Folder) -> String {
    let stats = &replay.stats;
    let machine = stats["machine"].as_str().map_or_else(|| "no machine".into(), |name| format!("machine {name}"));
    let facts = [
        text(stats, "trace").to_owned(),
        machine,
        format!("{} of {} x {} pixels", counted(replay.frames.len(), "frame"), replay.size[0], replay.size[1]),
    ];
    let facts: String =
        facts.iter().filter(|fact| !fact.is_empty()).map(|fact| format!("<li>{}</li>", escape(fact))).collect();
    let command = stats["command"].as_str().map(|command| {
        format!("<p class=\"command\"><span>Repeat it:</span> <code tabindex=\"0\">{}</code></p>\n", escape(command))
    });
    let extent = Extent::read(stats).map(|extent| extent.clauses()).filter(|clauses| !clauses.is_empty());
    let extent = extent.map(|clauses| how_to_read(&sentences(&clauses))).unwrap_or_default();
    format!(
        "<header>\n<div><h1>{}</h1>\n<ul class=\"facts\">{facts}</ul>\n{}{extent}</div>\n\
         <button type=\"button\" id=\"theme\" hidden>Theme: system</button>\n</header>\n",
        escape(title),
        command.unwrap_or_default()
    )
}

/// Clauses as sentences: each begins with a capital letter and ends with a stop.
fn sentences(clauses: &[String]) -> String {
    let sentence = |clause: &String| {
        let first = clause.chars().take(1).flat_map(char::to_uppercase);
        first.chain(clause.chars().skip(1)).collect::<String>() + "."
    };
    clauses.iter().map(sentence).collect::<Vec<_>>().join(" ")
}

/// A figure of a frame or of all in a unit as people read it, with what it may be off; a dash where there is none.
fn shown(figures: &Value, key: &str, places: usize, scale: f64) -> String {
    let figure = charts::figure(figures, key);
    let number = match (figure.as_u64(), figure.as_f64()) {
        _ if charts::is_identical(figures, key) => return "identical".into(),
        (Some(whole), _) if scale == 1.0 => count(whole),
        (_, Some(number)) => written(number * scale, places),
        _ => return "–".into(),
    };
    number + &plus_minus(charts::interval(figures, key).map(|percent| percent / 100.0))
}

/// A number with so many places; one of which these would leave nothing by its power of ten.
fn written(number: f64, places: usize) -> String {
    let fixed = format!("{number:.places$}");
    let digits = fixed.trim_start_matches(['-', '0', '.']).len();
    if number != 0.0 && places > 0 && digits == 0 { format!("{number:.3e}") } else { fixed }
}

/// The figures of all frames together, with what they mean.
fn figures(stats: &Value) -> Option<Section> {
    let row = |column: &FixedColumn| {
        let FixedColumn { name, unit, description, .. } = column;
        let value = column.value(stats);
        let is_figure = column.is_figure && (value.is_number() || charts::is_identical(stats, name));
        let cells = || vec![escape(name), shown(stats, name, 4, 1.0), escape(unit), escape(description)];
        is_figure.then(|| (String::new(), cells()))
    };
    let rows: Vec<_> = columns().iter().filter_map(row).collect();
    let heads = [Head::words("Figure"), Head::number("Value"), Head::words("Unit"), Head::words("Meaning")];
    Section::new(
        "figures",
        "All frames",
        if rows.is_empty() { String::new() } else { table("Figures of all frames", &heads, &rows) },
    )
}

/// The figures of each frame.
fn frames(stats: &Value) -> Option<Section> {
    let all = stats["frames"].as_array()?;
    let known = OF_FRAMES.iter().filter(|figure| all.iter().any(|frame| figure.is_known(frame)));
    // One unit for a column: its values compare at a glance.
    let wanted: Vec<(&Figure, Unit)> = known.map(|figure| (figure, figure.unit(all))).collect();
    let heads = wanted.iter().map(|(figure, unit)| Head::number(&figure.heading(unit.name)));
    let columns: Vec<Head> = std::iter::once(Head::number("Frame")).chain(heads).collect();
    let row = |frame: &Value| {
        let figures = wanted.iter().map(|(figure, unit)| shown(frame, figure.key, figure.places, unit.scale));
        (String::new(), std::iter::once(frame["frame"].to_string()).chain(figures).collect())
    };
    let rows: Vec<_> = all.iter().map(row).collect();
    Section::new("frames", "Frame by frame", table("Figures of each frame", &columns, &rows))
}

/// The pictures: those of the first frame as they are, and what the script needs to show the others.
fn pictures(replay: &Folder) -> Option<Section> {
    if replay.pictures.is_empty() {
        return None;
    }
    let first = replay.frames[0];
    let mut gallery = String::new();
    for (place, kind) in Kind::ALL.iter().enumerate() {
        let Some(picture) = replay.pictures.get(&(place, first)) else { continue };
        let (source, name) = (base64(picture), kind.name());
        gallery += &format!(
            "<figure><img id=\"picture-{name}\" src=\"data:image/png;base64,{source}\" alt=\"{name}\" width=\"{}\" height=\"{}\">\
             <figcaption>{name}</figcaption></figure>\n",
            replay.size[0], replay.size[1]
        );
    }
    let controls = if replay.frames.len() > 1 {
        "<div id=\"player\" class=\"player\" hidden>\n<button type=\"button\" id=\"play\" aria-pressed=\"false\">Play</button>\n\
         <label for=\"frame\">Frame <output id=\"frame-number\" for=\"frame\"></output></label>\n\
         <input type=\"range\" id=\"frame\" min=\"0\" value=\"0\" step=\"1\">\n\
         <label for=\"fps\">Frames a second</label>\n<select id=\"fps\"><option>4</option><option selected>12</option><option>24</option>\
         <option>60</option></select>\n</div>\n"
    } else {
        ""
    };
    let html = format!("{controls}<div class=\"frames\">\n{gallery}</div>\n")
        + &how_to_read(
            "Result is the policy's picture, reference every sample traced; error is their difference times 8; flip is where a viewer \
             sees it, from black to yellow. In similarity yellow was interpolated, blue was traced, and of green a part of the rays \
             was traced; a sample that is always traced has the mean of its block. Rate is the share of traced samples in each tile, from dark \
             blue (none) over green (a quarter) to light yellow (all).",
        );
    Section::new("pictures", "Pictures", html)
}

/// The pictures of all frames for the script.
fn data(replay: &Folder) -> Value {
    let of_kind = |(place, kind): (usize, &Kind)| {
        let of_frame = |frame: &u64| replay.pictures.get(&(place, *frame)).map(|picture| base64(picture));
        let all: Option<Vec<String>> = replay.frames.iter().map(of_frame).collect();
        // One frame stands in the page already.
        all.filter(|_| replay.frames.len() > 1).map(|all| (kind.name().to_owned(), json!(all)))
    };
    let pictures: serde_json::Map<String, Value> = Kind::ALL.iter().enumerate().filter_map(of_kind).collect();
    json!({ "frames": replay.frames, "pictures": pictures })
}
