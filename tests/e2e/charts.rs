//! Every chart of every page as SVG and as CSV: from the page, and with `rayreel report --charts`.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use crate::browser::Browser;
use crate::common::small_sweep::small_sweep;
use crate::common::{replay, repository};
use crate::made_up::write;
use crate::page::Page;
use crate::rayreel;

/// A study, a sweep and a replay of two frames: folder, page.
fn pages(folder: &Path) -> [(PathBuf, PathBuf); 3] {
    let study = folder.join("study");
    fs::create_dir(&study).unwrap();
    write(&study);
    let sweep = small_sweep(folder, "a", "sgrt-ti2", "");
    let run = folder.join("replay");
    let options = format!("--policy multirate --machine sgrt-ti2 --out {}", run.display());
    replay(&repository("traces/v1_0_teapot.rtrace"), &options).expect(0);
    [(study, "report.html"), (sweep, "results.html"), (run, "report.html")].map(|(results, page)| {
        rayreel!["report", &results].expect(0);
        let page = results.join(page);
        (results, page)
    })
}

/// The charts that were written, and what stands in them.
fn written(folder: &Path) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    for entry in folder.read_dir().unwrap() {
        let path = entry.unwrap().path();
        let (name, text) = (path.file_stem().unwrap().to_str().unwrap().to_owned(), fs::read_to_string(&path).unwrap());
        if path.extension().unwrap() == "svg" {
            assert!(
                text.starts_with("<svg xmlns=") && !text.contains("var(") && !text.contains("NaN"),
                "{name}: {text}"
            );
            assert!(path.with_extension("csv").is_file(), "{name}");
            names.insert(name);
        } else {
            // All rows have the cells of the first line.
            let mut reader = csv::Reader::from_reader(text.as_bytes());
            let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
            assert!(!rows.is_empty(), "{name} has no rows");
        }
    }
    names
}

#[test]
fn they_are_written_without_a_browser() {
    let folder = tempfile::tempdir().unwrap();
    let pages = pages(folder.path());
    let wanted: [&[&str]; 3] = [
        &["figure7-2x2-", "policies-2x2-", "gains-2x2-", "utilisation-2x2-", "energy-2x2-", "srp-2x2-", "animation-"],
        &["pareto", "heat", "effects-"],
        &["frames-psnr_db", "frames-cycles", "frames-flip"],
    ];
    for ((results, page), wanted) in pages.iter().zip(wanted) {
        let to = results.join("charts");
        let told = rayreel!["report", results, "--charts", &to, "--json"].expect(0).json();
        let names = written(&to);
        assert_eq!(told["charts"].as_array().unwrap().len(), names.len());
        for start in wanted {
            assert!(names.iter().any(|name| name.starts_with(start)), "{start}: {names:?}");
        }
        // Every chart that stands in the page is among them.
        let text = fs::read_to_string(page).unwrap();
        let body = text.split("<script>").next().unwrap();
        for name in body.split("data-chart=\"").skip(1).map(|rest| rest.split('"').next().unwrap()) {
            assert!(names.contains(name), "{name}: {names:?}");
        }
        assert_eq!(
            body.matches("<svg class=\"chart\"").count(),
            body.matches("class=\"save\"").count(),
            "{}",
            page.display()
        );
    }
    let frames = fs::read_to_string(pages[2].0.join("charts/frames-cycles.csv")).unwrap();
    let stats = fs::read(pages[2].0.join("stats.json")).unwrap();
    let stats: serde_json::Value = serde_json::from_slice(&stats).unwrap();
    let lines = stats["frames"].as_array().unwrap().iter().map(|f| format!("{},{}\r\n", f["frame"], f["cycles"]));
    assert_eq!(frames, format!("frame,Cycles\r\n{}", lines.collect::<String>()));
}

/// A policy that full sampling beats was drawn as one that none beats.
#[test]
fn full_sampling_stands_among_the_policies() {
    let (folder, study) = (tempfile::tempdir().unwrap(), repository("releases/paper-full"));
    rayreel!["report", &study, "--charts", folder.path()].expect(0);
    for mode in ["2x2", "1x1"] {
        let all = fs::read_to_string(folder.path().join(format!("policies-{mode}-all_scenes.csv"))).unwrap();
        let full: Vec<&str> = all.lines().filter(|line| line.starts_with("full,inf,1,")).collect();
        assert!(full.len() == 1, "{all}");
        for line in all.lines().skip(1) {
            let cells: Vec<&str> = line.split(',').collect();
            let is_beaten = cells[2].parse::<f64>().unwrap() < 1.0;
            assert!(!is_beaten || cells.last() == Some(&"false"), "{line}");
        }
    }
}

#[test]
fn results_without_charts_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let (run, to) = (folder.path().join("run"), folder.path().join("charts"));
    let options = format!("--policy full --machine none --frames 0 --out {}", run.display());
    replay(&repository("traces/v1_0_cornell.rtrace"), &options).expect(0);
    rayreel!["report", &run, "--charts", &to].expect(2).says(&["has no charts"]);
    rayreel!["report", &folder.path().join("none"), "--charts", &to].expect(2).says(&["no study.json"]);
    assert!(!to.exists());
}

/// Demands that two tables are the same but for how their numbers are written; the page has seven digits.
#[track_caller]
fn same(name: &str, page: &str, file: &str) {
    let table = |text: &str| {
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(text.as_bytes());
        reader.records().map(|row| row.unwrap().iter().map(str::to_owned).collect()).collect::<Vec<Vec<String>>>()
    };
    let (page, file) = (table(page), table(file));
    assert_eq!(page.len(), file.len(), "{name}: {page:?} {file:?}");
    for (a, b) in page.iter().flatten().zip(file.iter().flatten()) {
        let near = || {
            let (a, b) = (a.parse::<f64>().ok()?, b.parse::<f64>().ok()?);
            Some((a - b).abs() <= 1e-6 * b.abs())
        };
        assert!(a == b || near() == Some(true), "{name}: {a} is not {b}");
    }
}

/// Catches what the page gives the browser to save.
const CATCH: &str = "window.caught = []; \
    URL.createObjectURL = blob => { window.last = blob; return '#'; }; \
    HTMLAnchorElement.prototype.click = function () { const name = this.download; last.text().then(text => caught.push({ name, text })); };";

/// Skipped, saying so, where no browser is installed.
#[test]
fn pages_save_them() {
    let Some(browser) = Browser::start() else {
        return eprintln!(
            "skipped: no chromium with chromedriver is installed (apt-get install chromium chromium-driver)"
        );
    };
    let folder = tempfile::tempdir().unwrap();
    for (results, file) in pages(folder.path()) {
        let page = Page(&browser);
        browser.resize(1280, 900, false);
        browser.open(&file);
        page.is_sound();
        browser.run(CATCH);
        page.holds("[...document.querySelectorAll('figure[data-chart]')].every(f => f.querySelectorAll('.save > *').length === 2)");
        page.holds("document.querySelectorAll('svg.chart').length === document.querySelectorAll('figure[data-chart] svg.chart').length");
        let count = browser.run(
            "const all = [...document.querySelectorAll('.save button')]; all.forEach(b => b.click()); return all.length",
        );
        page.holds(&format!("caught.length === {count}"));
        let sound = "caught.filter(c => c.name.endsWith('.svg')).every(c => { \
            const svg = new DOMParser().parseFromString(c.text, 'image/svg+xml'); \
            return !svg.querySelector('parsererror') && svg.querySelectorAll('rect, path').length > 1 && svg.querySelector('text') \
                && !/var\\(|NaN|class=/.test(c.text); })";
        page.holds(&format!("caught.some(c => c.name.endsWith('.svg')) && {sound}"));
        // What the colours mean goes with the chart, and is below it.
        let keyed = "[...document.querySelectorAll('section .legend')].map(list => list.closest('section')).every(part => { \
            const names = [...part.querySelectorAll('.legend li')].map(entry => entry.textContent); \
            return [...part.querySelectorAll('figure[data-chart]')].every(figure => { \
                const { text } = caught.find(c => c.name === figure.dataset.chart + '.svg'); \
                const words = [...new DOMParser().parseFromString(text, 'image/svg+xml').querySelectorAll('text')]; \
                return names.includes(words.at(-1).textContent); }); })";
        page.holds(keyed);
        // A chart as the command writes it has the same numbers.
        let to = results.join("charts");
        rayreel!["report", &results, "--charts", &to].expect(0);
        let links = browser.run(
            "return Promise.all([...document.querySelectorAll('.save a')].map(a => [a.download, decodeURIComponent(a.href.slice(a.href.indexOf(',') + 1))]))",
        );
        for link in links.as_array().unwrap() {
            let (name, text) = (link[0].as_str().unwrap(), link[1].as_str().unwrap());
            assert_eq!(text, fs::read_to_string(to.join(name)).unwrap(), "{name}");
        }
        // So have those that a script draws, at first.
        let caught = browser.run("return caught.filter(c => c.name.endsWith('.csv'))");
        for file in caught.as_array().unwrap() {
            let (name, text) = (file["name"].as_str().unwrap(), file["text"].as_str().unwrap());
            same(name, text, &fs::read_to_string(to.join(name)).unwrap());
        }
        let files = "caught.filter(c => c.name.endsWith('.csv')).every(c => c.text.split('\\r\\n').length > 2)";
        page.holds(files);
        page.is_sound();
    }
}
