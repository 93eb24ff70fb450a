//! `rayreel report`: the command, and the page in a real browser.

use std::fs;
use std::path::Path;

use crate::browser::Browser;
use crate::made_up::{PICTURE, write};
use crate::page::Page;
use crate::rayreel;

#[test]
fn it_writes_one_page() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let told = rayreel!["report", folder.path()].expect(0).out;
    let page = fs::read(folder.path().join("report.html")).unwrap();
    assert!(told.contains("report.html") && told.contains("6 pictures"), "{told}");
    let other = folder.path().join("other.html");
    let json = rayreel!["report", folder.path(), "-o", &other, "--json", "--threads", "1"].expect(0).json();
    assert_eq!((json["bytes"].as_u64(), json["pictures"].as_u64()), (Some(page.len() as u64), Some(6)));
    assert!(fs::read(&other).unwrap() == page, "the same study gives the same bytes");
    assert!(String::from_utf8(page).unwrap().starts_with("<!DOCTYPE html>"));
}

/// What lies under `releases` is made like this.
#[test]
fn a_study_without_its_pictures_is_a_study() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    let to = folder.path().join("small/figures");
    rayreel!["report", folder.path(), "--figures", &to].expect(0);
    assert_eq!(fs::read_dir(&to).unwrap().count(), 1, "study.json alone");
    let json = rayreel!["report", &to, "--json"].expect(0).json();
    assert_eq!(json["pictures"], 0);
    let page = |folder: &Path| fs::read_to_string(folder.join("report.html")).unwrap();
    rayreel!["report", folder.path()].expect(0);
    let (small, whole) = (page(&to), page(folder.path()));
    let points = |page: &str| page.matches("paper-ss").count();
    assert!(points(&small) > 0 && !small.contains("<img") && whole.contains("<img"), "figures, and no pictures");
    rayreel!["report", &to, "--figures", &to, "--charts", &to].expect(2).says(&["cannot be used with"]);
    let study = fs::read(folder.path().join("study.json")).unwrap();
    rayreel!["report", folder.path(), "--figures", folder.path()].expect(2).says(&["give another folder"]);
    assert_eq!(fs::read(folder.path().join("study.json")).unwrap(), study, "nothing is lost");
    rayreel!["report", &to.join("none"), "--figures", &to].expect(2).says(&["study.json"]);
}

/// The experiment at the paper's size, as it lies in the repository.
#[test]
fn a_page_of_what_was_released() {
    let folder = tempfile::tempdir().unwrap();
    let (released, page) =
        (Path::new(env!("CARGO_MANIFEST_DIR")).join("releases/paper-full"), folder.path().join("x.html"));
    rayreel!["report", &released, "-o", &page].expect(0);
    let page = fs::read_to_string(page).unwrap();
    assert!(page.contains("2048 × 1024 pixels") && page.contains("700 of 700 frames"));
}

#[test]
fn errors_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let (dir, file) = (folder.path(), folder.path().join("study.json"));
    let out = dir.join("x.html");
    let report = |code: i32, words: &[&str]| {
        rayreel!["report", dir, "-o", &out].expect(code).says(words);
        assert!(!out.exists(), "nothing is written");
    };
    report(2, &["study.json", "rayreel paper"]);
    rayreel!["report", &dir.join("missing")].expect(2).says(&["missing", "rayreel paper"]);
    fs::write(&file, "{\"schema\": 1,\n \"tool\": ").unwrap();
    report(65, &["study.json", "line 2", "write it again"]);
    fs::write(&file, "{\"schema\": 7}").unwrap();
    report(65, &["schema 7", &format!("reads {}", rayreel_study::schema::SCHEMA)]);
    write(dir);
    fs::write(dir.join("error.png"), "not a picture").unwrap();
    report(65, &["error.png", "no PNG"]);
    fs::remove_file(dir.join("error.png")).unwrap();
    report(65, &["error.png", "not there"]);
    write(dir);
    rayreel!["report", dir, "-o", &dir.join("no/folder/x.html")].expect(2).says(&["no/folder"]);
}

/// Skipped, saying so, where no browser is installed.
#[test]
fn a_browser_shows_it() {
    let Some(browser) = Browser::start() else {
        eprintln!("skipped: no chromium with chromedriver is installed (apt-get install chromium chromium-driver)");
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    write(folder.path());
    rayreel!["report", folder.path()].expect(0);
    let file = folder.path().join("report.html");
    desktop(&browser, &file);
    phone(&browser, &file);
    print(&browser, &file);
    // What has found nothing can find something.
    browser.run("setTimeout(() => { throw new Error('on purpose') })");
    std::thread::sleep(std::time::Duration::from_millis(100));
    assert!(browser.console().iter().any(|line| line.contains("on purpose")), "the console is listened to");
}

fn desktop(browser: &Browser, file: &Path) {
    let page = Page(browser);
    browser.resize(1280, 900, false);
    browser.open(file);
    page.is_sound();
    slider(&page);
    tiles(&page);
    pictures(&page);
    charts(&page);
    // Light, dark, and back to what the system says.
    let back = "getComputedStyle(document.body).backgroundColor";
    page.click("#theme");
    page.holds(&format!("document.documentElement.dataset.theme === 'light' && {back} === 'rgb(251, 251, 249)'"));
    page.click("#theme");
    page.holds(&format!("document.documentElement.dataset.theme === 'dark' && {back} === 'rgb(17, 21, 26)'"));
    page.is_sound();
    page.click("#theme");
    page.holds("document.documentElement.dataset.theme === undefined");
}

fn slider(page: &Page<'_>) {
    let browser = page.0;
    page.holds("!document.getElementById('viewer').hidden && document.querySelector('.gallery').offsetHeight === 0");
    let (middle, left) = (page.at("#viewer-stage", [0.5, 0.6]), page.at("#viewer-stage", [0.25, 0.6]));
    browser.point(&[middle, left], true);
    page.holds("Math.abs(document.getElementById('viewer-slide').value - 250) < 10");
    let clip = "parseFloat(document.querySelectorAll('.pane')[1].style.clipPath.split(' ')[3])";
    page.holds(&format!("Math.abs({clip} / document.getElementById('viewer-stage').clientWidth - 0.25) < 0.01"));
    browser.run("document.getElementById('viewer-slide').focus()");
    let before = browser.run("return document.getElementById('viewer-slide').value");
    browser.key("\u{e014}");
    page.holds(&format!("Number(document.getElementById('viewer-slide').value) > {}", before.as_str().unwrap()));
}

fn tiles(page: &Page<'_>) {
    let (browser, [width, height, tile]) = (page.0, PICTURE.map(f64::from));
    let middle_of = |column: f64, row: f64| [(column + 0.5) * tile / width, (row + 0.5) * tile / height];
    let line = "document.getElementById('viewer-tile').textContent";
    browser.point(&[page.at("#viewer-stage", middle_of(3.0, 1.0))], false);
    // Five columns: tile 8 is the fourth of the second row.
    page.holds(&format!("{line}.startsWith('Tile 8 (column 3, row 1): 108 of 1\\u202f008 rays')"));
    page.holds(&format!("{line}.includes('50.0\\u202f% similar') && {line}.includes('43.21\\u202fdB')"));
    browser.run("document.getElementById('viewer-stage').focus({ preventScroll: true })");
    browser.key("\u{e014}");
    page.holds(&format!("{line}.startsWith('Tile 9 ')"));
    browser.key("\u{e013}");
    page.holds(&format!("{line}.startsWith('Tile 4 ')"));
    page.holds("!document.querySelector('.box').hidden && document.querySelector('.box').style.width === '8px'");
}

fn pictures(page: &Page<'_>) {
    let browser = page.0;
    let shown = |pane: u32, picture: u32| {
        let image = format!("document.querySelectorAll('.pane img')[{pane}]");
        page.holds(&format!(
            "{image}.src === document.getElementById('picture-{picture}').src && {image}.naturalWidth > 0"
        ));
    };
    shown(0, 0);
    shown(1, 1);
    page.choose("#viewer-right", "error");
    shown(1, 2);
    page.choose("#viewer-set", "1");
    page.holds("document.querySelectorAll('.pane img')[0].alt.includes('chess')");
    shown(1, 2);
    page.click("[value=flip] + span");
    page.holds("getComputedStyle(document.querySelectorAll('.pane')[1]).visibility === 'hidden'");
    page.click("#viewer-flip");
    page.holds("getComputedStyle(document.querySelectorAll('.pane')[1]).visibility === 'visible'");
    page.click("[value=side] + span");
    page.holds("document.querySelectorAll('.pane')[1].offsetLeft > 100");
    page.click("#viewer-in");
    page.holds("document.querySelector('.plane').classList.contains('sharp')");
    page.holds("getComputedStyle(document.querySelector('.plane img')).imageRendering === 'pixelated'");
    let before = browser.run("return document.querySelector('.plane').style.transform");
    browser.point(&[page.at("#viewer-stage", [0.2, 0.5]), page.at("#viewer-stage", [0.1, 0.4])], true);
    page.holds(&format!("document.querySelector('.plane').style.transform !== {before}"));
    page.click("#viewer-fit");
    page.holds("!document.querySelector('.plane').classList.contains('sharp')");
    page.click("[value=slider] + span");
}

fn charts(page: &Page<'_>) {
    let browser = page.0;
    let tip = "document.getElementById('tip')";
    browser.point(&[page.at("#figure7 rect[data-mark]", [0.5, 0.5])], false);
    page.holds(&format!("!{tip}.hidden && {tip}.textContent.includes('performance')"));
    browser.point(&[page.at("#animation svg.chart", [0.5, 0.5])], false);
    page.holds(&format!("{tip}.textContent.startsWith('frame 3') && document.querySelector('.cursor')"));
    // In sight first: a page that scrolls hides its tip.
    page.at("#policies svg.chart", [0.5, 0.5]);
    browser.run("document.querySelector('#policies svg.chart').focus({ preventScroll: true })");
    browser.key("\u{e014}");
    page.holds(&format!("!{tip}.hidden && {tip}.textContent.includes('PSNR')"));
    browser.key("\u{e00c}");
    page.holds(&format!("{tip}.hidden"));
    let hidden =
        |mode: &str| format!("[...document.querySelectorAll('.mode[data-mode=\"{mode}\"]')].every(e => e.hidden)");
    page.holds(&hidden("1x1"));
    page.click("#policies > .modes button:nth-child(2)");
    page.holds(&hidden("2x2"));
    page.click("#config-values summary");
    page.click("#config-search");
    "l2".chars().for_each(|c| browser.key(&c.to_string()));
    page.holds("document.getElementById('config-found').textContent === '1 of 2'");
}

fn phone(browser: &Browser, file: &Path) {
    let page = Page(browser);
    browser.resize(360, 740, true);
    browser.open(file);
    page.is_sound();
    browser.run("document.querySelectorAll('details').forEach(e => { e.open = true })");
    page.is_sound();
    page.click("#viewer-stage");
    page.holds("document.getElementById('viewer-tile').textContent.startsWith('Tile ')");
    page.click("[value=side] + span");
    page.holds("document.querySelectorAll('.pane')[1].offsetTop > 50");
    page.is_sound();
}

/// On paper: everything unfolded, all pictures, nothing to press.
fn print(browser: &Browser, file: &Path) {
    let page = Page(browser);
    browser.resize(800, 1100, false);
    browser.open(file);
    browser.media("print");
    browser.run("dispatchEvent(new Event('beforeprint'))");
    page.holds("document.querySelectorAll('details:not([open])').length === 0");
    page.holds("[...document.querySelectorAll('.mode')].every(e => e.offsetHeight > 0)");
    page.holds(
        "document.querySelector('.gallery').offsetHeight > 0 && document.getElementById('viewer').offsetHeight === 0",
    );
    page.holds("document.querySelector('nav').offsetHeight === 0");
    page.is_sound();
    browser.run("dispatchEvent(new Event('afterprint'))");
    page.holds("document.querySelectorAll('details[open]').length === 0");
    browser.media("");
}
