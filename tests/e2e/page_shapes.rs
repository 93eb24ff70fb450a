//! The page of a sweep in a real browser where its values, its results or what is chosen of them have an odd shape.

use std::fs;

use crate::browser::Browser;
use crate::common::small_sweep::small_sweep;
use crate::page::Page;
use crate::rayreel;

/// What the page gives the browser to save.
const CATCH: &str = "window.caught = []; \
    URL.createObjectURL = blob => { window.last = blob; return '#'; }; \
    HTMLAnchorElement.prototype.click = function () { const name = this.download; last.text().then(text => caught.push({ name, text })); };";

fn filter(page: &Page<'_>, text: &str) {
    page.0.run(&format!(
        "const f = document.getElementById('filter'); f.value = '{text}'; f.dispatchEvent(new Event('input'))"
    ));
}

/// An axis of values that agree to seven digits had none for the scripts, and stopped most of them. Skipped, saying so, where no browser
/// is installed.
#[test]
fn values_that_agree_to_seven_digits_stay_apart() {
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: no chromium with chromedriver is installed");
    };
    let folder = tempfile::tempdir().unwrap();
    let close = "[[axis]]\nname = \"pj\"\nkey = \"energy.dram_refresh_pj\"\nvalues = [22400.0, 22400.001]\n";
    let sweep = small_sweep(folder.path(), "close", "sgrt-ti2", close);
    rayreel!["report", &sweep].expect(0);
    let page = Page(&browser);
    browser.resize(1280, 900, false);
    browser.open(&sweep.join("results.html"));
    page.is_sound();
    page.holds("document.querySelectorAll('#points-table tbody tr').length === 16");
    page.choose("#heat-row", "pj");
    page.choose("#heat-column", "l1");
    page.holds("document.querySelectorAll('#heat-map tbody tr').length === 2");
    filter(&page, "pj = 22400.001");
    page.holds("document.getElementById('filter-found').textContent === '8 of 16 points'");
    page.is_sound();
}

/// What a sentence about points that were only counted says stays when some are filtered out.
#[test]
fn a_filter_counts_again_what_was_only_counted() {
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: no chromium with chromedriver is installed");
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    rayreel!["report", &sweep].expect(0);
    let file = sweep.join("results.html");
    let text = fs::read_to_string(&file).unwrap();
    let sentence = "<div id=\"summary-of\"><p class=\"read\" id=\"counts\"><span>8 of 8 points are</span> counted</p>";
    // As a sweep with `--detail counts` has it.
    let counts = "\"kind\":\"text\",\"all\":\"counts\"";
    let counted = text.replacen("\"kind\":\"text\",\"all\":\"full\"", counts, 1);
    assert_ne!(counted, text, "a column says how much was simulated");
    let counted = counted.replacen("<div id=\"summary-of\">", sentence, 1);
    fs::write(&file, counted).unwrap();
    let page = Page(&browser);
    browser.open(&file);
    filter(&page, "l1 = 4KiB");
    page.holds("document.getElementById('counts')?.textContent === '4 of 4 points are counted'");
    page.is_sound();
}

/// What is left out is mentioned, what is saved is whole, and where there is nothing nothing is saved.
#[test]
fn charts_of_some_points_or_none_say_so() {
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: no chromium with chromedriver is installed");
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    rayreel!["report", &sweep].expect(0);
    let page = Page(&browser);
    browser.resize(1280, 900, false);
    browser.open(&sweep.join("results.html"));
    browser.run(CATCH);
    // `full` has no block.
    page.choose("#heat-row", "block");
    page.choose("#heat-column", "l1");
    page.holds(
        "document.getElementById('heat-what').textContent.includes(' 2 points without block or l1 are left out.')",
    );
    // The mean line, the caption and what the colours mean go with the charts.
    let svg = |name: &str| {
        browser.run(&format!(
            "caught.length = 0; [...document.querySelectorAll('figure[data-chart=\"{name}\"] .save button')].at(0).click()"
        ));
        page.holds("caught.length === 1");
        "new DOMParser().parseFromString(caught[0].text, 'image/svg+xml')"
    };
    let heat = svg("heat");
    page.holds(&format!("!{heat}.querySelector('parsererror') && {heat}.querySelectorAll('rect').length > 24"));
    page.holds("caught[0].text.includes(document.getElementById('heat-name').textContent)");
    let bars = svg("effects-time_ms");
    page.holds(&format!(
        "[...{bars}.querySelectorAll('rect')].filter(r => Number(r.getAttribute('width')) <= 2).length >= \
         document.querySelectorAll('figure[data-chart=\"effects-time_ms\"] li').length"
    ));
    page.holds(&format!("[...{bars}.querySelectorAll('text')].some(t => t.textContent.startsWith('time_ms'))"));
    // One result on both axes is one column of the file.
    page.choose("#pareto-x", "time_ms");
    page.choose("#pareto-y", "time_ms");
    browser.run(
        "caught.length = 0; [...document.querySelectorAll('figure[data-chart=\"pareto\"] .save button')].at(1).click()",
    );
    page.holds(
        "caught.length === 1 && caught[0].text.split('\\r\\n')[0].split(',').filter(c => c === 'time_ms').length === 1",
    );
    let disabled =
        "[...document.querySelectorAll('[data-chart=\"heat\"] .save button, [data-chart=\"pareto\"] .save button')]";
    page.holds(&format!("{disabled}.length === 4 && {disabled}.every(b => !b.disabled)"));
    filter(&page, "l1 < 0");
    page.holds(&format!("{disabled}.every(b => b.disabled)"));
    page.is_sound();
}
