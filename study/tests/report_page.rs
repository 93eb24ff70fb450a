//! The page of a study: whole, well-formed, the same every time, and safe whatever the study holds.

#[path = "common/study.rs"]
mod made_up;

use std::fs;
use std::path::Path;

use made_up::{pictures, study, write};
use rayreel_study::html::{self, ReportError};
use rayreel_study::schema::{CostInterval, FILE, SCHEMA, Study, ViewerImages};
use serde_json::Value;

/// The page of a study.
#[track_caller]
fn page(study: &Study) -> String {
    let folder = tempfile::tempdir().unwrap();
    pictures(folder.path());
    let file = folder.path().join("page.html");
    let written = html::write_study(study, folder.path(), &file).unwrap();
    let text = fs::read_to_string(file).unwrap();
    assert_eq!(text.len(), written.bytes);
    text
}

/// Elements that have no end tag.
const VOID: [&str; 5] = ["meta", "link", "img", "input", "br"];

/// Demands that every tag is closed in order and that ids are unique; gives the number of elements.
#[track_caller]
fn well_formed(text: &str) -> usize {
    let (mut open, mut rest, mut count) = (Vec::<String>::new(), text, 0);
    while let Some(start) = rest.find('<') {
        rest = &rest[start + 1..];
        // Attribute values are quoted and never hold `>`: escaping writes `&gt;`.
        let end = rest.find('>').expect("a tag is not closed");
        let (tag, inner) = (&rest[..end], rest[..end].trim_end_matches('/'));
        rest = &rest[end + 1..];
        let name = inner.trim_start_matches('/').split_whitespace().next().unwrap_or_default().to_string();
        assert_eq!(tag.matches('"').count() % 2, 0, "quotes of <{tag}>");
        if tag.starts_with('/') {
            assert_eq!(open.pop().as_ref(), Some(&name), "</{name}> closes something else");
        } else if !tag.starts_with('!') {
            count += 1;
            if !tag.ends_with('/') && !VOID.contains(&name.as_str()) {
                open.push(name.clone());
            }
        }
        if ["style", "script"].contains(&name.as_str()) && !tag.starts_with('/') {
            rest = &rest[rest.find(&format!("</{name}>")).expect("raw text ends")..];
        }
    }
    assert!(open.is_empty(), "not closed: {open:?}");
    let mut ids: Vec<&str> = text.split(" id=\"").skip(1).map(|part| part.split('"').next().unwrap()).collect();
    ids.sort_unstable();
    assert!(ids.windows(2).all(|pair| pair[0] != pair[1]), "an id stands twice: {ids:?}");
    count
}

#[test]
fn every_part_is_there() {
    let text = page(&study());
    let sections = [
        "summary",
        "pictures",
        "figure7",
        "table1",
        "policies",
        "maps",
        "animation",
        "energy",
        "units",
        "srp",
        "ablations",
        "setup",
        "config",
    ];
    for id in sections {
        assert!(text.contains(&format!("<section id=\"{id}\"")), "no section {id}");
        assert!(text.contains(&format!("href=\"#{id}\"")), "{id} is not in the contents");
    }
    assert!(well_formed(&text) > 500);
    for found in
        ["2.43 to 2.98×", "≥ 1.53×", "48.99\u{202f}dB", "1.09×", "5.0\u{202f}%", "frame 150", "(1.50×)", "ti.trv"]
    {
        assert!(text.contains(found), "{found} is missing");
    }
    assert!(!text.contains("NaN") && !text.contains(">inf"), "a number that is none");
}

/// The policy of the summary is drawn last, and frames that are estimates say how far they may be off.
#[test]
fn the_summary_lies_on_top_of_the_animation() {
    let (mut estimated, within) = (study(), CostInterval { energy_mj: 0.0123, ..CostInterval::default() });
    // In the study it comes first.
    let headline = estimated.tracks[0].policy.clone();
    estimated.headline_policy = Some(headline.clone());
    assert!(estimated.tracks.len() > 1);
    for is_estimated in [false, true] {
        estimated.tracks[0].frames[0].interval = is_estimated.then_some(within);
        let text = page(&estimated);
        let section = text.split("<section id=\"animation\"").nth(1).unwrap().split("</section>").next().unwrap();
        for chart in section.split("data-lines=").skip(1) {
            let chart = chart.split("</svg>").next().unwrap();
            let last = chart.rsplit("data-name=\"").next().unwrap().split('"').next().unwrap();
            assert_eq!(last, headline);
        }
        assert_eq!(section.contains("data-within=\"1.23"), is_estimated);
    }
}

/// Lines of several policies may have one colour: keys show their dashes. What kernels leave of the busy cycles is the inspector's.
#[test]
fn keys_are_of_lines_and_bars_are_whole() {
    let text = page(&study());
    let part =
        |id: &str| text.split(&format!("<section id=\"{id}\"")).nth(1).unwrap().split("</section>").next().unwrap();
    let legend = part("animation").split("<ul class=\"legend\">").nth(1).unwrap().split("</ul>").next().unwrap();
    let policies = legend.matches("<li>").count();
    assert!(policies > 1 && legend.matches("<line ").count() == policies, "{legend}");
    let dashes: Vec<&str> =
        legend.split("stroke-dasharray=\"").skip(1).map(|rest| rest.split('"').next().unwrap()).collect();
    assert!(!dashes.is_empty() && dashes.iter().all(|dash| part("animation").matches(dash).count() > 1), "{dashes:?}");
    assert!(!part("srp").contains("\ninspector "));
    let mut lacking = study();
    lacking.points.iter_mut().flat_map(|point| &mut point.srp).for_each(|kernel| kernel.share *= 0.75);
    let text = page(&lacking);
    assert!(text.contains("\ninspector 25.0\u{202f}%"));
}

#[test]
fn nothing_is_loaded_from_elsewhere() {
    let text = page(&study());
    for word in ["http://", "https://", "url(", "@import", "src=\"//", "fetch(", "XMLHttpRequest", "import("] {
        assert!(!text.contains(word), "the page holds {word}");
    }
    let sources: Vec<&str> = text.split(" src=\"").skip(1).collect();
    assert!(sources.len() >= 5 && sources.iter().all(|src| src.starts_with("data:image/png;base64,iVBORw0KGgo")));
    assert!(text.contains("default-src 'none'"), "and the browser is told so");
}

#[test]
fn the_same_study_gives_the_same_bytes() {
    assert!(page(&study()) == page(&study()));
}

#[test]
fn a_picture_named_often_is_embedded_once_in_the_viewer() {
    let text = page(&study());
    assert_eq!(text.matches("id=\"picture-").count(), 6, "two sets share six files");
    // Maps show theirs: three for each of two frames.
    assert_eq!(text.matches("data:image/png").count(), 6 + 6);
}

/// Appends to every string of the study what would break out of an element, an attribute or a script.
fn poisoned(value: &mut Value, key: &str) {
    const FILES: [&str; 7] = ["reference", "result", "error", "flip", "similarity", "rate", "picture"];
    match value {
        Value::String(text) if !FILES.contains(&key) => {
            *text += "'\"></td></script><script>alert(1)</script><!-- &\u{1}"
        }
        Value::Array(items) => items.iter_mut().for_each(|item| poisoned(item, key)),
        Value::Object(fields) => fields.iter_mut().for_each(|(key, item)| poisoned(item, key)),
        _ => {}
    }
}

#[test]
fn names_may_hold_any_text() {
    let mut value = serde_json::to_value(study()).unwrap();
    poisoned(&mut value, "");
    let text = page(&serde_json::from_value(value).unwrap());
    assert!(text.contains("&lt;script&gt;alert(1)"), "the names are shown");
    assert!(!text.contains("<script>alert") && !text.contains("<!--") && !text.contains('\u{1}'));
    assert_eq!(text.matches("</script>").count(), 3, "the data of the viewer and the two scripts");
    well_formed(&text);
}

/// What is said of the paper's scenes and figures is said of those that have any.
#[test]
fn sentences_hold_for_the_scenes_that_are_there() {
    let alike = "Its scenes are of the same kind and size as these, but not the same models.";
    let (zone, last) = ("The shaded zone is what the paper states", "The last rows are the paper's");
    let page = |study: &Study| page(study).replace("&#39;", "'");
    let text = page(&study());
    for sentence in
        [alike, "Brackets show", "the paper's performance per watt", zone, last, "geometric mean at the right"]
    {
        assert!(text.contains(sentence), "{sentence}");
    }
    assert!(
        text.contains("multirate: scenes in a mode with both more performance per watt"),
        "a scene counts in each mode"
    );
    assert!(!text.contains("is similar changes from"), "nobody looked");

    let mut mixed = study();
    mixed.scenes[1].paper_triangles = None;
    let text = page(&mixed);
    assert!(!text.contains(alike) && text.contains("it has none like chess."));

    // A model of a user's, in one mode, on a machine without T&I units.
    let mut custom = study();
    custom.scenes.truncate(1);
    // A name of the paper's on another model.
    custom.scenes[0].triangles = 12;
    custom.points.retain(|point| point.scene == "teapot" && point.mode == "2x2");
    custom.points.iter_mut().for_each(|point| (point.ti, point.ti_gain, point.scene) = (None, None, "noise".into()));
    let text = page(&custom);
    assert!(text.contains("None of these scenes is like one of the paper's."));
    for sentence in
        [alike, "Brackets show", "the paper's performance per watt", zone, last, "geometric mean at the right"]
    {
        assert!(!text.contains(sentence), "{sentence}");
    }
    assert!(text.contains("multirate: scenes with both"));
    assert!(text.contains("Energy of the whole GPU, mJ") && text.contains("GPU energy, mJ a frame"));
}

/// Small frames cost little: what is written has digits, and the files of charts keep the unit of the study.
#[test]
fn energies_and_times_have_a_unit_of_their_size() {
    let text = page(&study());
    for words in ["energy, mJ", "GPU time, ms", "GPU energy, mJ", "1.20 mJ", "<td class=\"num\">0.500</td>"] {
        assert!(text.contains(words), "{words}");
    }
    assert!(!text.contains("µ"), "what has digits stays as it is");
    let small = |scale: f64| {
        let mut study = study();
        for point in &mut study.points {
            point.energy.iter_mut().for_each(|part| part.mj *= scale);
            for cost in [&mut point.ti, &mut point.gpu].into_iter().flatten() {
                (cost.time_ms, cost.energy_mj) = (cost.time_ms * scale, cost.energy_mj * scale);
            }
        }
        for frame in study.tracks.iter_mut().flat_map(|track| &mut track.frames) {
            frame.energy_mj = frame.energy_mj.map(|mj| mj * scale);
            frame.time_ms = frame.time_ms.map(|ms| ms * scale);
        }
        study
    };
    let text = page(&small(1e-3));
    for words in [
        "energy, µJ",
        "frame, µJ;",
        "GPU time, µs",
        "GPU energy, µJ",
        "1.20 µJ",
        "<td class=\"num\">0.500</td>",
        "T&amp;I energy, µJ a frame",
        "Energy of the T&amp;I units, µJ",
        "Time of a frame, µs",
        "data-unit=\"µJ\"",
    ] {
        assert!(text.contains(words), "{words}");
    }
    assert!(!text.contains(">0.000<") && !text.contains(" mJ"), "no cell is without digits");
    assert!(page(&small(1e-6)).contains("energy, nJ"));

    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let charts = |scale: f64| {
        fs::write(folder.path().join(FILE), serde_json::to_string(&small(scale)).unwrap()).unwrap();
        let names = html::write_charts(folder.path(), folder.path()).unwrap();
        (names, fs::read_to_string(folder.path().join("energy-2x2-teapot.csv")).unwrap())
    };
    let ((names, of_large), (small_names, of_small)) = (charts(1.0), charts(1e-3));
    assert_eq!(names, small_names, "files of charts keep their names");
    let begin = "bar,part,\"energy, mJ\"\r\nfull,trv,";
    assert!(of_large.starts_with(&format!("{begin}0.5\r\n")), "{of_large}");
    assert!(of_small.starts_with(&format!("{begin}0.0005\r\n")), "{of_small}");
}

/// Whatever is missing is left out; nothing is made up for it.
#[test]
fn a_study_may_lack_anything() {
    let empty = page(&Study { schema: SCHEMA, ..Study::default() });
    well_formed(&empty);
    assert!(!empty.contains("<section"));
    let strip: [fn(&mut Study); 9] = [
        |s| s.points.clear(),
        |s| s.scenes.clear(),
        |s| s.policies.clear(),
        |s| s.references = Default::default(),
        |s| s.machine = None,
        |s| s.points.iter_mut().for_each(|p| (p.ti, p.gpu, p.ti_gain, p.gpu_gain) = (None, None, None, None)),
        |s| s.points.iter_mut().for_each(|p| p.quality = None),
        |s| s.tracks.iter_mut().for_each(|t| t.frames.clear()),
        |s| {
            s.viewer
                .iter_mut()
                .for_each(|v| v.images = ViewerImages { result: v.images.result.take(), ..Default::default() })
        },
    ];
    for (i, strip) in strip.into_iter().enumerate() {
        let mut study = study();
        strip(&mut study);
        let text = page(&study);
        well_formed(&text);
        assert!(!text.contains("NaN") && !text.contains(">inf"), "without part {i}");
    }
}

/// Zeros, and numbers at the end of what JSON can hold.
#[test]
fn numbers_may_be_any() {
    for number in [0.0, 1e-300, 1e300, f64::MAX, -1.0] {
        let mut study = study();
        for point in &mut study.points {
            for gain in [&mut point.ti_gain, &mut point.gpu_gain].into_iter().flatten() {
                (gain.performance, gain.power, gain.perf_per_watt) = (number, number, number);
            }
            point.energy.iter_mut().for_each(|c| c.mj = number);
            point.srp.iter_mut().for_each(|k| k.share = number);
            point.units.iter_mut().flat_map(|u| &mut u.shares).for_each(|s| s.share = number);
            point.rays_full = 0;
        }
        study.viewer.iter_mut().for_each(|v| v.tile_px = 0);
        let text = page(&study);
        well_formed(&text);
        assert!(!text.contains("NaN") && !text.contains("\"inf"), "{number}");
    }
}

#[test]
fn a_study_is_read_back_from_its_folder() {
    let folder = tempfile::tempdir().unwrap();
    let study = write(folder.path());
    assert_eq!(html::load(folder.path()).unwrap().viewer.len(), study.viewer.len());
    let file = folder.path().join("a.html");
    let written = html::write(folder.path(), &file).unwrap();
    assert_eq!(written.pictures, 6);
    assert!(fs::read_to_string(&file).unwrap() == page(&study));
    fs::remove_file(folder.path().join("rate.png")).unwrap();
    let error = html::write(folder.path(), &file).unwrap_err();
    assert!(matches!(&error, ReportError::NoPicture { name, .. } if name == "rate.png"), "{error}");
    assert!(error.is_bad_data() && error.to_string().contains(FILE));
    assert!(matches!(html::write(Path::new("/nonexistent"), &file), Err(ReportError::NoStudy { .. })));
}
