//! What is left of a capture that was cut short: `repair` makes it a trace, and everything says that it is incomplete.

use std::fs;
use std::path::{Path, PathBuf};

use crate::common::scenes::moving;
use crate::common::trace::open;
use crate::common::{capture, digest, replay};
use crate::rayreel;

/// The first `tenths` of a capture of `options`, as a killed one leaves them.
fn cut(folder: &Path, scene: &str, options: &str, tenths: usize) -> (PathBuf, PathBuf) {
    let whole = folder.join("whole.rtrace");
    capture(scene, options, &whole);
    let bytes = fs::read(&whole).unwrap();
    let partial = folder.join("cut.rtrace.partial");
    fs::write(&partial, &bytes[..bytes.len() * tenths / 10]).unwrap();
    (whole, partial)
}

#[test]
fn an_unfinished_file_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let (_, partial) = cut(folder.path(), "cornell", "--size 64x48", 6);
    for command in ["info", "verify", "digest", "replay"] {
        rayreel![command, &partial].expect(3).says(&["no index", "--resume", "rayreel repair"]);
    }
}

#[test]
fn a_repaired_trace_is_readable_and_incomplete() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, partial) = cut(folder.path(), "cornell", "--size 96x64 --tile 16", 6);
    let fixed = folder.path().join("fixed.rtrace");
    let report = rayreel!["repair", &partial, "-o", &fixed].expect(3);
    let (all, trace) = (open(&whole), open(&fixed));
    let missing = trace.missing_tiles();
    assert!(!missing.is_empty() && missing.len() < all.meta().tile_count() as usize, "{}", missing.len());
    assert!(report.out.contains(&format!("{} tiles are missing", missing.len())), "{}", report.out);

    let info = rayreel!["info", "--json", &fixed].expect(3).json();
    assert_eq!(info["missing_tiles"], missing.len());
    let (first, last) = (missing[0].1, missing[missing.len() - 1].1);
    assert_eq!(info["missing"], serde_json::json!([{ "frame": 0, "tiles": format!("{first}..{}", last + 1) }]));
    assert!(rayreel!["info", &fixed].expect(3).out.contains("tiles are missing"));
    let verified = rayreel!["verify", "--json", &fixed].expect(3).says(&["incomplete"]).json();
    assert_eq!(verified["tiles"], all.meta().tile_count() as usize - missing.len());
    assert_eq!((&verified["tiles_wrong"], &verified["missing_tiles"]), (&0.into(), &missing.len().into()));
    rayreel!["digest", &fixed].expect(3).says(&["incomplete", "missing"]);
    let diff = rayreel!["diff", &whole, &fixed].expect(1).out;
    assert!(diff.contains(&format!("tile {}: there | missing", missing[0].1)), "{diff}");

    // What is there is what was captured.
    for tile in (0..all.meta().tile_count()).filter(|&t| !missing.contains(&(0, t))) {
        let columns = rayreel_formats::tile::Column::ALL;
        assert_eq!(trace.tile(0, tile, &columns).unwrap(), all.tile(0, tile, &columns).unwrap());
    }
}

#[test]
fn a_replay_of_an_incomplete_trace_names_the_tile() {
    let folder = tempfile::tempdir().unwrap();
    let (_, partial) = cut(folder.path(), "cornell", "--size 96x64 --tile 16", 6);
    let fixed = folder.path().join("fixed.rtrace");
    rayreel!["repair", &partial, "-o", &fixed].expect(3);
    let missing = open(&fixed).missing_tiles();
    for policy in ["full", "adaptive", "adaptive-8"] {
        let ran = replay(&fixed, &format!("--policy {policy}")).expect(3).says(&["frame 0"]);
        let named = missing.iter().any(|(_, tile)| ran.err.contains(&format!("tile {tile} ")));
        assert!(named, "one of {missing:?} is named: {}", ran.err);
        assert_eq!(ran.out, "", "no half result");
    }
}

#[test]
fn whole_frames_of_a_sequence_survive() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, partial) = cut(folder.path(), &moving(folder.path()), "--size 60x40 --tile 16 --frames 0..5", 7);
    let fixed = folder.path().join("fixed.rtrace");
    rayreel!["repair", &partial, "-o", &fixed].expect(3);
    let (all, trace) = (open(&whole), open(&fixed));
    let missing = trace.missing_tiles();
    assert!(missing.iter().all(|(frame, _)| *frame >= 2), "the first frames are there: {missing:?}");
    assert!(missing.contains(&(4, all.meta().tile_count() - 1)));
}

/// Nothing is lost of a file that is whole, and a lost index is written anew.
#[test]
fn a_complete_trace_stays_what_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, copy, anew) = (folder.path().join("a"), folder.path().join("b"), folder.path().join("c"));
    capture("teapot", "--size 40x20 --samples 1x1", &whole);
    let repaired = rayreel!["repair", &whole, "-o", &copy].expect(0);
    assert!(repaired.out.contains("complete"), "{}", repaired.out);
    assert!(fs::read(&whole).unwrap() == fs::read(&copy).unwrap());
    let bytes = fs::read(&whole).unwrap();
    fs::write(&copy, &bytes[..bytes.len() - 5]).unwrap();
    rayreel!["info", &copy].expect(3).says(&["rayreel repair"]);
    rayreel!["repair", &copy, "-o", &anew].expect(0);
    assert_eq!(digest(&anew), digest(&whole));
    rayreel!["verify", &anew].expect(0);
}

/// Without the tree or the metadata nothing can be decoded: a repair says so instead of leaving a file that every command refuses.
#[test]
fn a_trace_without_its_tree_is_said_to_be_lost() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.rtrace");
    capture("cornell", "--size 32x32", &whole);
    let bytes = fs::read(&whole).unwrap();
    for (kind, name) in [(b"BVH ", "BVH"), (b"META", "META")] {
        let header = bytes.windows(4).position(|four| four == kind).unwrap();
        let (torn, fixed) = (folder.path().join(format!("{name}.torn")), folder.path().join(format!("{name}.rtrace")));
        let mut damaged = bytes.clone();
        damaged[header + 60] ^= 0xff;
        fs::write(&torn, &damaged).unwrap();
        let ran = rayreel!["repair", &torn, "-o", &fixed].expect(1);
        for words in
            [&format!("the {name} chunk is lost") as &str, "damaged: bytes ", "no command", "Capture the scene again"]
        {
            assert!(ran.out.contains(words), "{words}: {}", ran.out);
        }
        assert!(!ran.out.contains(['{', '}']), "no form for programmers: {}", ran.out);
        rayreel!["replay", &fixed].expect(3).says(&[&format!("holds no {name} chunk")]);
    }
}

#[test]
fn a_lost_camera_and_whole_frames_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let whole = folder.path().join("whole.rtrace");
    capture(&moving(folder.path()), "--size 60x40 --frames 0..3", &whole);
    let mut bytes = fs::read(&whole).unwrap();
    let cameras: Vec<usize> = (0..bytes.len() - 4).filter(|&at| &bytes[at..at + 4] == b"FRAM").collect();
    bytes[cameras[2] + 60] ^= 0xff;
    let (torn, fixed) = (folder.path().join("torn"), folder.path().join("fixed.rtrace"));
    fs::write(&torn, &bytes).unwrap();
    let told = rayreel!["repair", &torn, "-o", &fixed].expect(3).out;
    for words in ["the FRAM chunk of frame 2", "2 of 3 frames are whole: replay --frames 0..2 works"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    replay(&fixed, "--frames 0..2").expect(0);
    replay(&fixed, "--frames 2").expect(3);
}

#[test]
fn repair_never_overwrites() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, other) = (folder.path().join("a.rtrace"), folder.path().join("b.rtrace"));
    capture("cornell", "--size 16x16", &whole);
    fs::write(&other, "precious").unwrap();
    rayreel!["repair", &whole, "-o", &other].expect(2).says(&["already exists"]);
    assert_eq!(fs::read_to_string(&other).unwrap(), "precious");
    rayreel!["repair", &whole, "-o", &whole].expect(2).says(&["in place"]);
}
