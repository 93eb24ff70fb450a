//! `rayreel report` of a sweep: the command, and the page in a real browser.

use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use crate::browser::Browser;
use crate::common::repository;
use crate::common::small_sweep::{POINTS, small_sweep};
use crate::page::Page;
use crate::rayreel;

#[test]
fn it_writes_one_page() {
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    let told = rayreel!["report", &sweep].expect(0).out;
    let page = fs::read(sweep.join("results.html")).unwrap();
    assert!(told.contains("results.html") && told.contains("8 points"), "{told}");
    let other = folder.path().join("other.html");
    let json = rayreel!["report", &sweep.join("results.parquet"), "-o", &other, "--json"].expect(0).json();
    assert_eq!((json["bytes"].as_u64(), json["points"].as_u64()), (Some(page.len() as u64), Some(POINTS as u64)));
    assert!(fs::read(&other).unwrap() == page, "the same results give the same bytes");
    let text = String::from_utf8(page).unwrap();
    assert!(text.contains("small &amp; &lt;quick&gt;") && !text.contains("<quick>"), "names are escaped");
    // Without a script: axes, main effects, the best points with what they change.
    for words in ["4KiB, 32KiB", "Main effects", "Most perf_per_watt", "<code>ti.trv_l1.size=32KiB</code>"] {
        assert!(text.contains(words), "{words}");
    }
}

/// Skipped, saying so, where no browser is installed.
#[test]
fn a_browser_shows_it() {
    let Some(browser) = Browser::start() else {
        eprintln!("skipped: no chromium with chromedriver is installed (apt-get install chromium chromium-driver)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    rayreel!["report", &sweep].expect(0);
    let (file, page) = (sweep.join("results.html"), Page(&browser));
    browser.resize(1280, 900, false);
    browser.open(&file);
    page.is_sound();
    effects_are_those_of_the_file(&page, &file);
    pareto(&page);
    heat(&page);
    table(&page);
    filter(&page);
    phone(&page, &file);
    print(&page, &file);
    // Where no point has figures nothing is offered that is not there.
    let sweep = small_sweep(folder.path(), "failed", "raycore", "exclude = [\"policy = 'full'\"]");
    rayreel!["report", &sweep].expect(0);
    browser.open(&sweep.join("results.html"));
    page.is_sound();
    for section in ["pareto", "heat"] {
        page.holds(&format!(
            "document.getElementById('{section}').hidden && document.querySelector('nav a[href=\"#{section}\"]').closest('li').hidden"
        ));
    }
}

/// A page with other data for its scripts, and other text where `text` is put in place of what follows the summary's beginning.
fn changed(file: &Path, text: &str, change: impl FnOnce(&mut Value)) {
    const START: &str = "<script type=\"application/json\" id=\"sweep-data\">";
    let page = fs::read_to_string(file).unwrap().replacen(
        "<div id=\"summary-of\">",
        &format!("<div id=\"summary-of\">{text}"),
        1,
    );
    let (before, rest) = page.split_once(START).unwrap();
    let (data, after) = rest.split_once("</script>").unwrap();
    let mut data = serde_json::from_str(data).unwrap();
    change(&mut data);
    fs::write(file, format!("{before}{START}{data}</script>{after}")).unwrap();
}

/// Names that no window has room for, words that a shell would read, and estimates.
#[test]
fn odd_names_and_estimates_are_shown() {
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: no chromium with chromedriver is installed");
    };
    let folder = tempfile::tempdir().unwrap();
    let sweep = small_sweep(folder.path(), "a", "sgrt-ti2", "");
    rayreel!["report", &sweep].expect(0);
    let (file, page) = (sweep.join("results.html"), Page(&browser));
    changed(&file, "<p id=\"estimates\"><span>8 of 8 points</span>: what that means</p>", |data| {
        for name in ["time_ms", "cycles"] {
            let column = json!({ "name": format!("{name}_interval_percent"), "unit": "%", "text": "", "role": "status", "kind": "number", "all": 2.5 });
            data["columns"].as_array_mut().unwrap().push(column);
        }
        let columns = data["columns"].as_array_mut().unwrap();
        let column = |name: &str| columns.iter().position(|column| column["name"] == name).unwrap();
        let (trace, policy) = (column("trace"), column("policy"));
        columns[trace]["all"] = json!("it's a; trace.rtrace");
        for name in columns[policy]["of"].as_array_mut().unwrap() {
            *name = json!(format!("{}_{}", name.as_str().unwrap(), "long".repeat(60)));
        }
        let named = columns[policy]["of"].clone();
        let known = data["presets"]["policy"].as_object().unwrap().values().next().unwrap().clone();
        data["presets"]["policy"] =
            named.as_array().unwrap().iter().map(|name| (name.as_str().unwrap().to_owned(), known.clone())).collect();
    });
    for (width, phone) in [(1280, false), (400, true)] {
        browser.resize(width, 900, phone);
        browser.open(&file);
        page.is_sound();
        page.choose("#pareto-x", "time_ms");
        page.choose("#pareto-y", "energy_mj");
        page.choose("#pareto-each", "policy");
        let names = "[...document.querySelectorAll('#pareto-chart text.name')]";
        page.holds(&format!("{names}.length === 2 && {names}.every(t => {{ \
            const [own, box] = [t.getBoundingClientRect(), document.querySelector('#pareto-chart svg').getBoundingClientRect()]; \
            return t.textContent.endsWith('…') && t.textContent.length > 8 && own.left >= box.left && own.right <= box.right; }})"));
        page.is_sound();
    }
    let off = "±\u{202f}2.5\u{202f}%";
    page.holds(&format!(
        "[...document.querySelectorAll('#pareto-table tbody tr')].every(r => r.cells[1].textContent.includes('{off}'))"
    ));
    browser.run("document.querySelector('#pareto-chart svg').focus({ preventScroll: true })");
    browser.key("\u{e014}");
    page.holds(&format!("document.getElementById('tip').textContent.includes('{off}')"));
    page.choose("#heat-result", "time_ms");
    page.choose("#heat-row", "l1");
    page.choose("#heat-column", "block");
    let cells = "[...document.querySelectorAll('#heat-map td.heat')]";
    page.holds(&format!(
        "{cells}.length === 6 && {cells}.every(c => c.dataset.tip.includes('{off}') && c.textContent.includes('{off}'))"
    ));
    page.choose("#heat-column", "policy");
    page.holds(&format!("{cells}.length === 4 && !{cells}[1].dataset.tip.includes('±')"));
    page.holds("[...document.querySelectorAll('#heat-map thead th')].slice(1).every(t => t.offsetWidth < 250 && getComputedStyle(t).overflowX === 'hidden')");
    page.is_sound();
    // A table breaks what is too long for a column, and a file has no formulas.
    let names =
        "[...document.querySelectorAll('#points-table tbody td')].filter(c => c.textContent.includes('longlong'))";
    page.holds(&format!("{names}.length === 8 && {names}.every(c => c.offsetWidth < 400)"));
    page.holds("rayreel.csv([['=a', -1, '-1+1', '-5', Infinity]]) === \"'=a,-1,'-1+1,-5,inf\\r\\n\"");
    browser.run("document.querySelector('#best-tables .pick').click()");
    page.holds("document.querySelector('#chosen .command code').textContent.startsWith(\"rayreel replay 'it'\\\\''s a; trace.rtrace' --frames \")");
    let set = |text: &str| {
        browser.run(&format!(
            "const f = document.getElementById('filter'); f.value = '{text}'; f.dispatchEvent(new Event('input'))"
        ))
    };
    set("l1 = 4KiB");
    page.holds("document.getElementById('estimates').textContent === '4 of 4 points are estimates: what that means'");
    set("point = 0");
    page.holds("document.getElementById('estimates').textContent === '1 of 1 point is an estimate: what that means'");
}

/// Points that failed are found by why, and stay in the summary when some are shown.
#[test]
fn failed_points_and_single_ones_are_shown() {
    let Some(browser) = Browser::start() else {
        return eprintln!("skipped: no chromium with chromedriver is installed");
    };
    let (folder, page) = (tempfile::tempdir().unwrap(), Page(&browser));
    browser.resize(1280, 900, false);
    let sweep = small_sweep(folder.path(), "some", "raycore", "");
    rayreel!["report", &sweep].expect(0);
    browser.open(&sweep.join("results.html"));
    page.is_sound();
    browser.run("const f = document.getElementById('filter'); f.value = 'time_ms < 1e9 and policy is not none'; f.dispatchEvent(new Event('input'))");
    page.holds("document.getElementById('filter-found').textContent === '8 of 8 points, 6 of them without time_ms'");
    browser.run("const f = document.getElementById('filter'); f.value = \"error is not none and block = 2\"; f.dispatchEvent(new Event('input'))");
    page.holds("document.getElementById('filter-found').textContent === '2 of 8 points'");
    page.holds("document.querySelector('#summary-of .read').textContent === '2 of 8 points; 2 of them failed'");
    page.holds(
        "[...document.querySelectorAll('#summary-of caption')].some(c => c.textContent === 'Points that failed')",
    );
    page.is_sound();
    // One point alone: its figures stand in summary and table, and a click shows it whole.
    let sweep = small_sweep(folder.path(), "one", "sgrt-ti2", "exclude = [\"policy != 'full' or l1 = 4096\"]");
    rayreel!["report", &sweep].expect(0).prints(&[", 1 point\n"]);
    browser.open(&sweep.join("results.html"));
    page.is_sound();
    page.holds("document.getElementById('pareto').hidden && document.getElementById('heat').hidden");
    page.holds("document.querySelector('#summary-of dt').textContent === 'time_ms'");
    page.holds(
        "[...document.querySelectorAll('#points-table thead button')].some(b => b.dataset.sort === 'energy_mj')",
    );
    page.click("#points-table .pick");
    page.holds("document.getElementById('chosen').offsetHeight > 100");
    page.holds("document.getElementById('chosen').textContent.includes('time_ms')");
    page.holds("![...document.querySelectorAll('#chosen dd')].some(d => /^1\\u202f[a-z]{3,}s$/.test(d.textContent))");
    page.is_sound();
    // Points of which nothing is simulated have a command too.
    let (plan, sweep) = (folder.path().join("none.toml"), folder.path().join("none.sweep"));
    let trace = repository("traces/v1_0_cornell.rtrace");
    let axis = "[[axis]]\nname = \"block\"\nkey = \"block\"\nvalues = [2, 4]\n";
    fs::write(&plan, format!("traces = [{trace:?}]\nmachines = [\"none\"]\npolicies = [\"adaptive\"]\n{axis}"))
        .unwrap();
    rayreel!["sweep", "--quiet", &plan, "-o", &sweep].expect(0);
    rayreel!["report", &sweep].expect(0);
    browser.open(&sweep.join("results.html"));
    page.click("#points-table .pick");
    page.holds(
        "document.querySelector('#chosen .command code').textContent.endsWith('--machine none --policy adaptive --set block=4') || \
         document.querySelector('#chosen .command code').textContent.endsWith('--machine none --policy adaptive')",
    );
    page.is_sound();
}

/// What the script draws again is what stood there before.
fn effects_are_those_of_the_file(page: &Page<'_>, file: &Path) {
    let text = fs::read_to_string(file).unwrap();
    let shares: Vec<&str> = text.split("data-axis=\"").skip(1).filter(|axis| axis.contains("data-share=\"")).collect();
    let shares: Vec<String> = shares
        .iter()
        .filter_map(|axis| Some(axis.split("data-share=\"").nth(1)?.split('"').next()?.to_owned()))
        .collect();
    let shares: Vec<String> = shares.into_iter().filter(|share| share.parse::<f64>().is_ok()).collect();
    assert!(shares.len() >= 6, "{shares:?}");
    let listed = "[...document.querySelectorAll('#effects-cards [data-share]')].map(e => Number(e.dataset.share))";
    let list = format!("[{}]", shares.join(","));
    page.holds(&format!(
        "{listed}.length === {list}.length && {listed}.every((v, i) => Math.abs(v - {list}[i]) < 1e-4)"
    ));
    page.choose("#effects-result", "ssim");
    page.holds("document.querySelector('#effects-cards .card').dataset.result === 'ssim'");
}

fn pareto(page: &Page<'_>) {
    let browser = page.0;
    let tip = "document.getElementById('tip')";
    page.holds("document.getElementById('pareto-x').value === 'psnr_db' && document.getElementById('pareto-x-goal').value === 'max'");
    page.holds("document.querySelector('#pareto-chart .apart') !== null");
    page.choose("#pareto-x", "time_ms");
    page.choose("#pareto-y", "energy_mj");
    page.choose("#pareto-colour", "l1");
    page.holds("document.getElementById('pareto-x-goal').value === 'min'");
    page.holds("document.getElementById('pareto-name').textContent === 'energy_mj against time_ms'");
    let before = browser.run("return document.getElementById('pareto-count').textContent");
    page.choose("#pareto-y-goal", "max");
    page.holds(&format!("document.getElementById('pareto-count').textContent !== {before}"));
    page.choose("#pareto-y-goal", "min");
    // The chart is found by the keyboard, and a point by its place.
    page.at("#pareto-chart svg", [0.5, 0.5]);
    browser.run("document.querySelector('#pareto-chart svg').focus({ preventScroll: true })");
    browser.key("\u{e014}");
    page.holds(&format!("!{tip}.hidden && {tip}.textContent.includes('time_ms') && {tip}.textContent.includes('l1 ')"));
    let place = browser.run(
        "const r = document.getElementById('pareto-ring').getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]",
    );
    let place = [place[0].as_f64().unwrap(), place[1].as_f64().unwrap()];
    browser.key("\u{e00c}");
    page.holds(&format!("{tip}.hidden"));
    browser.point(&[[place[0] + 3.0, place[1]]], false);
    page.holds(&format!("!{tip}.hidden && {tip}.textContent.startsWith('Point ')"));
    browser.point(&[place, place], true);
    page.holds("!document.getElementById('chosen').hidden");
    page.holds(
        "document.querySelector('#chosen .command code').textContent.startsWith('rayreel replay v1_0_cornell.rtrace')",
    );
    page.holds("document.querySelectorAll('#points-table tr.strong').length === 1");
    browser.run("document.querySelectorAll('#chosen details').forEach(e => { e.open = true })");
    page.holds("document.querySelector('#chosen pre').textContent.includes('ti.trv_l1.size = ')");
    page.is_sound();
    page.click("#chosen button");
    page.holds("document.getElementById('chosen').hidden");
}

fn heat(page: &Page<'_>) {
    page.choose("#heat-result", "time_ms");
    page.choose("#heat-row", "l1");
    page.choose("#heat-column", "block");
    page.holds("document.querySelectorAll('#heat-map td.heat').length === 6");
    page.choose("#heat-column", "policy");
    page.holds("document.querySelectorAll('#heat-map td.heat').length === 4");
    page.holds("document.getElementById('heat-what').textContent.includes('the mean of up to 3 points over block')");
    let values = "[...document.querySelectorAll('#heat-map td.heat')].map(e => Number(e.dataset.value))";
    let mean = page.0.run(&format!("return {values}"));
    page.choose("#heat-how", "max");
    page.holds(&format!("{values}.every((v, i) => v >= {mean}[i]) && {values}[1] > {mean}[1]"));
    page.choose("[data-axis=block]", "0");
    page.holds("document.querySelectorAll('#heat-map td.heat').length === 2");
    page.choose("#heat-column", "l1");
    page.holds("document.getElementById('heat-map').textContent.includes('two different axes')");
    page.choose("#heat-column", "policy");
    page.choose("[data-axis=block]", "");
}

fn table(page: &Page<'_>) {
    let column = "[...document.querySelectorAll('#points-table tbody tr')].map(r => Number(r.cells[[...document.querySelectorAll('#points-table th button')].findIndex(b => b.dataset.sort === 'time_ms')].textContent))";
    let ascends = format!("{column}.length === {POINTS} && {column}.every((v, i, all) => i === 0 || all[i - 1] <= v)");
    let descends = format!("{column}.every((v, i, all) => i === 0 || all[i - 1] >= v)");
    page.click("[data-sort=time_ms]");
    page.holds(&ascends);
    page.holds("document.querySelector('[aria-sort=ascending] button').dataset.sort === 'time_ms'");
    page.0.key("\u{e007}");
    page.holds(&descends);
    page.click("#points-columns summary");
    page.click("#points-search");
    "tested twice".split(' ').next().unwrap().chars().for_each(|c| page.0.key(&c.to_string()));
    page.holds("[...document.querySelectorAll('.checks label:not([hidden])')].length < document.querySelectorAll('.checks label').length");
    page.click("#points-none");
    page.holds("document.querySelectorAll('#points-table thead th').length === 1");
    page.click("#points-default");
    page.holds("document.querySelectorAll('#points-table thead th').length > 6");
    page.is_sound();
}

fn filter(page: &Page<'_>) {
    let rows = "document.querySelectorAll('#points-table tbody tr').length";
    let found = "document.getElementById('filter-found').textContent";
    let set = |text: &str| {
        page.0.run(&format!(
            "const f = document.getElementById('filter'); f.value = '{text}'; f.dispatchEvent(new Event('input'))"
        ));
    };
    page.click("#filter");
    "full".chars().for_each(|c| page.0.key(&c.to_string()));
    page.holds(&format!("{rows} === 2 && {found} === '2 of 8 points'"));
    set("policy = \\'adaptive\\' and block >= 4");
    page.holds(&format!("{rows} === 4"));
    set("l1 = 32KiB and block < 8 and block is not none and psnr_db < 1e9");
    page.holds(&format!("{rows} === 2"));
    // Four with the large cache, and one with the small one.
    set("l1 >= 32KiB or block = 2");
    page.holds(&format!("{rows} === 5 && {found} === '5 of 8 points'"));
    page.holds("document.querySelector('#summary-of .read').textContent.startsWith('5 of 8 points')");
    page.holds("[...document.querySelectorAll('#summary-of tbody tr')].find(r => r.cells[0].textContent === 'block').cells[1].textContent === '3'");
    set("not (l1 >= 32KiB or block = 2)");
    page.holds(&format!("{rows} === 3"));
    let least = "document.querySelector('#summary-of dl').textContent";
    let narrow = page.0.run(&format!("return {least}"));
    // An identical picture has more PSNR than any number.
    set("psnr_db > 1e6");
    page.holds(&format!("{rows} === 2"));
    set("\\'apt\\' in policy");
    page.holds(&format!("{rows} === 6 && {least} !== {narrow}"));
    page.holds("document.getElementById('effects-of').textContent === 'of 6 points'");
    // What stands in the field while it is empty is of this sweep: its axes, with values of the last point.
    page.0.run(
        "const f = document.getElementById('filter'); f.value = f.placeholder; f.dispatchEvent(new Event('input'))",
    );
    page.holds(&format!(
        "document.getElementById('filter').value === 'policy = \"adaptive\" or l1 >= 32KiB' && {rows} > 0 && !{found}.includes('Still')"
    ));
    // The examples that the page itself gives are of its grammar.
    let examples = page.0.run("return [...document.querySelectorAll('#points .read code')].map(c => c.textContent).filter(t => /[=<>]| in /.test(t))");
    let examples: Vec<&str> = examples.as_array().unwrap().iter().map(|text| text.as_str().unwrap()).collect();
    assert!(examples.len() >= 4, "{examples:?}");
    for example in examples {
        set(example);
        page.holds(&format!("/^[0-9]+ of 8 points$/.test({found})"));
    }
    for (text, told) in [
        ("nonsense > 3", "at character 1, nonsense: there is no column nonsense"),
        ("l1 > 3 and (trv", "there is no column trv"),
        ("l1 > 16KB", "at character 6, 16KB: no number"),
        ("policy = full", "at character 10, full: there is no column full; a word stands in quotes"),
        ("policy ~ full", "at character 8, ~: a part of a word"),
    ] {
        set(text);
        page.holds(&format!("{found}.includes('{told}') && {found}.includes('6 of 8 points') && {rows} === 6"));
    }
    set("no such word");
    page.holds(&format!("{rows} === 0"));
    page.is_sound();
    set("");
    page.holds(&format!("{rows} === {POINTS} && document.querySelector('#summary-of > .read') === null"));
}

fn phone(page: &Page<'_>, file: &Path) {
    let browser = page.0;
    browser.resize(360, 740, true);
    browser.open(file);
    page.is_sound();
    browser.run("document.querySelectorAll('details').forEach(e => { e.open = true })");
    browser.run("document.querySelector('#best-tables .pick').click()");
    page.holds("!document.getElementById('chosen').hidden");
    page.is_sound();
    // What goes on to the right says so until its end is seen, and its first column stays in sight.
    page.holds("document.querySelector('#points-table .scroll, #points-table.scroll').classList.contains('more')");
    let left = "document.querySelector('#points-table tbody th').getBoundingClientRect().left";
    let before = browser.run(&format!("return {left}"));
    browser.run("document.querySelector('#points-table .scroll, #points-table.scroll').scrollLeft = 1e6");
    page.holds("!document.querySelector('#points-table .scroll, #points-table.scroll').classList.contains('more')");
    page.holds(&format!("Math.abs({left} - {before}) <= 2"));
}

/// On paper: charts as they are, nothing to press.
fn print(page: &Page<'_>, file: &Path) {
    let browser = page.0;
    browser.resize(800, 1100, false);
    browser.open(file);
    browser.media("print");
    page.holds("document.querySelector('#pareto .controls').offsetHeight === 0 && document.querySelector('nav').offsetHeight === 0");
    page.holds("document.querySelector('#pareto-chart svg').getBoundingClientRect().height > 100");
    page.is_sound();
    browser.media("");
}
