//! The page of a replay in a real browser: its pictures over the frames, with a slider and play.

use std::fs;

use crate::browser::Browser;
use crate::common::{replay, repository};
use crate::page::Page;
use crate::rayreel;

/// One folder for several replays: pictures and figures are always of one of them.
#[test]
fn what_an_earlier_replay_left_is_not_shown() {
    let folder = tempfile::tempdir().unwrap();
    let run = folder.path().join("run");
    let trace = repository("traces/v1_0_cornell.rtrace");
    let options = format!("--policy paper-ss --machine none --out {}", run.display());
    let said = replay(&trace, &options).expect(0).json();
    // As a replay of several frames would have left them.
    let numbered = |number: u64, kind: &str| run.join(format!("frame_{number:04}_{kind}.png"));
    let (kinds, frame) =
        (["result", "reference", "error", "flip", "similarity", "rate"], said["frames"][0]["frame"].as_u64().unwrap());
    for kind in kinds {
        [frame, frame + 1].iter().for_each(|number| fs::write(numbered(*number, kind), b"\x89PNG\r\n\x1a\n").unwrap());
    }
    replay(&trace, &options).expect(0);
    let written: u64 = kinds.iter().map(|kind| fs::metadata(run.join(format!("{kind}.png"))).unwrap().len()).sum();
    let told = rayreel!["report", &run, "--json"].expect(0).json();
    assert_eq!((told["pictures"].as_u64(), told["picture_bytes"].as_u64()), (Some(6), Some(written)));
    rayreel!["report", &run, "--animate", "result"].expect(0).prints(&["result.apng: 1 frame, "]);
    assert!(!numbered(frame, "result").exists() && numbered(frame + 1, "result").exists(), "others stay");
    // One that ends early leaves no figures beside pictures that are not theirs.
    fs::remove_file(run.join("result.exr")).unwrap();
    fs::create_dir(run.join("result.exr")).unwrap();
    assert_ne!(replay(&trace, &options).code, 0);
    assert!(!run.join("stats.json").exists());
}

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
