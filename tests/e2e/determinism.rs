//! The same capture gives the same bytes: for any number of threads, and each time.

use std::fs;

use crate::common::scenes::moving;
use crate::common::{capture, digest, replay};
use crate::rayreel;

/// Captures `scene` with each of `options`; demands the same bytes.
fn same_bytes(scene: &str, options: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    let mut first = None;
    for (i, options) in options.iter().enumerate() {
        let file = folder.path().join(format!("{i}.rtrace"));
        capture(scene, options, &file);
        let found = (fs::read(&file).unwrap(), digest(&file));
        assert!(found.0.len() > 1000, "{scene} {options}: {} bytes", found.0.len());
        let expected = first.get_or_insert_with(|| found.clone());
        assert_eq!(expected.1, found.1, "{scene} {options}: digests");
        assert!(expected.0 == found.0, "{scene} {options}: the digests agree and the bytes do not");
    }
}

#[test]
fn threads_do_not_change_a_byte() {
    let size = "--size 95x51 --samples 2x2 --tile 16";
    let options = [1, 1, 2, 3].map(|threads| format!("{size} --threads {threads}"));
    same_bytes("cornell", &options.each_ref().map(String::as_str));
    let size = "--size 61x33 --tile 8";
    let options = [1, 2, 3].map(|threads| format!("{size} --threads {threads}"));
    same_bytes("teapot", &options.each_ref().map(String::as_str));
    let options = [1, 3].map(|threads| format!("--size 40x20 --samples 1x1 --codec plain --threads {threads}"));
    same_bytes("chess", &options.each_ref().map(String::as_str));
}

#[test]
fn threads_do_not_change_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let scene = moving(folder.path());
    let options = [1, 2, 3].map(|threads| format!("--size 48x32 --tile 16 --frames 1..4 --threads {threads}"));
    same_bytes(&scene, &options.each_ref().map(String::as_str));
}

/// A machine's results and its timeline, too.
#[test]
fn threads_do_not_change_what_a_machine_does() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("a.rtrace");
    capture("teapot", "--size 48x32 --tile 16 --frames 3..5", &file);
    for (machine, policy) in [("sgrt-ti2", "adaptive"), ("raycore", "full"), ("no-direct-interface", "adaptive-4")] {
        let runs = [1, 2, 2, 3].map(|threads| {
            let timeline = folder.path().join(format!("{threads}.json"));
            let options = format!("--machine {machine} --policy {policy} --threads {threads} --timeline");
            let said = replay(&file, &format!("{options} {}", timeline.display())).expect(0).out;
            (said, fs::read_to_string(timeline).unwrap())
        });
        assert!(runs.iter().all(|run| run.0 == runs[0].0), "{machine}: JSON");
        assert!(runs.iter().all(|run| run.1 == runs[0].1), "{machine}: timeline");
    }
}

/// A digest says what a trace holds, not how it is packed.
#[test]
fn digests_depend_on_neither_codec_nor_level() {
    let folder = tempfile::tempdir().unwrap();
    for scene in ["cornell", "teapot"] {
        let size = "--size 63x35 --samples 2x2";
        let packings = ["--level 9", "--level 1", "--level 19", "--codec plain --level 1", "--codec plain --level 12"];
        let mut digests = Vec::new();
        let mut files = Vec::new();
        for (i, packing) in packings.iter().enumerate() {
            let file = folder.path().join(format!("{scene}-{i}.rtrace"));
            capture(scene, &format!("{size} {packing}"), &file);
            digests.push(digest(&file));
            files.push(file);
        }
        assert!(digests.iter().all(|d| *d == digests[0]), "{scene}: {digests:#?}");
        assert!(fs::read(&files[0]).unwrap() != fs::read(&files[4]).unwrap(), "the codec changes the file");
        rayreel!["diff", &files[0], &files[4]].expect(0);
    }
}

/// The opposite: what changes the trace changes its digest, in the columns that it must.
#[test]
fn digests_tell_captures_apart() {
    let folder = tempfile::tempdir().unwrap();
    let base = "--size 32x16 --samples 1x1";
    let of = |name: &str, scene: &str, options: &str| {
        let file = folder.path().join(name);
        capture(scene, options, &file);
        digest(&file)
    };
    let first = of("a", "cornell", base);
    let others = [
        of("b", "cornell", "--size 32x17 --samples 1x1"),
        of("c", "cornell", "--size 32x16 --samples 2x2"),
        of("d", "cornell", &format!("{base} --depth 0")),
        of("e", "cornell", &format!("{base} --tile 8")),
        of("f", "teapot", base),
    ];
    for other in &others {
        assert_ne!(first["total"], other["total"]);
        assert_ne!(first["tree"], other["tree"]);
    }
    assert_eq!(first["bvh"], others[0]["bvh"], "the same scene has the same tree");
    assert_ne!(first["bvh"], others[4]["bvh"]);
}
