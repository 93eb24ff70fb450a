//! The page of a replay in a real browser: its pictures over the frames, with a slider and play.

use crate::browser::Browser;
use crate::common::{replay, repository};
use crate::page::Page;
use crate::rayreel;

/// Skipped, saying so, where no browser is installed.
#[test]
fn slider_and_play_go_through_the_frames() {
    let Some(browser) = Browser::start() else {
        return eprintln!(
            "skipped: no chromium with chromedriver is installed (apt-get install chromium chromium-driver)"
        );
    };
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let trace = repository("traces/v1_0_teapot.rtrace");
    let options = format!("--policy multirate --machine sgrt-ti2 --out {}", run.display());
    let said = replay(&trace, &options).expect(0).json();
    rayreel!["report", &run].expect(0);
    let page = Page(&browser);
    for (width, phone) in [(1280, false), (400, true)] {
        browser.resize(width, 900, phone);
        browser.open(&run.join("report.html"));
        page.is_sound();
        let frames: Vec<u64> =
            said["frames"].as_array().unwrap().iter().map(|f| f["frame"].as_u64().unwrap()).collect();
        let shown = |frame: u64| format!("document.getElementById('frame-number').textContent === '{frame}'");
        let source = "document.getElementById('picture-result').src";
        page.holds(&shown(frames[0]));
        let first = browser.run(&format!("return {source}"));
        // The slider: its right end is the last frame, and the pictures are of it.
        let end = page.at("#frame", [0.99, 0.5]);
        browser.point(&[end, end], true);
        page.holds(&shown(*frames.last().unwrap()));
        assert_ne!(browser.run(&format!("return {source}")), first, "another frame has another picture");
        page.holds("document.getElementById('picture-result').naturalWidth > 0");
        // Its keys.
        browser.run("document.getElementById('frame').focus()");
        browser.key("\u{e011}");
        page.holds(&shown(frames[0]));
        assert_eq!(browser.run(&format!("return {source}")), first);
        // Play goes on by itself, and begins anew behind the last; a click stops it.
        browser.run("window.seen = new Set(); new MutationObserver(() => seen.add(document.getElementById('frame-number').textContent))\
                     .observe(document.getElementById('frame-number'), { childList: true, characterData: true, subtree: true })");
        page.choose("#fps", "24");
        page.click("#play");
        page.holds("document.getElementById('play').textContent === 'Pause'");
        page.holds(&format!("seen.size === {}", frames.len()));
        page.click("#play");
        page.holds("document.getElementById('play').getAttribute('aria-pressed') === 'false'");
        let stopped = browser.run("return document.getElementById('frame').value");
        std::thread::sleep(std::time::Duration::from_millis(150));
        assert_eq!(browser.run("return document.getElementById('frame').value"), stopped);
        page.is_sound();
    }
}
