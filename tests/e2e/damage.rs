//! Files that were damaged after they were written: the message says where, and nothing crashes.

use std::fs;
use std::path::Path;

use rayreel_formats::container::ChunkKind;

use crate::common::trace::open;
use crate::common::{Ran, capture};
use crate::rayreel;

fn small(folder: &Path) -> (Vec<u8>, std::path::PathBuf) {
    let file = folder.join("whole.rtrace");
    capture("cornell", "--size 64x32 --samples 1x1 --tile 16", &file);
    (fs::read(&file).unwrap(), folder.join("damaged.rtrace"))
}

/// An orderly refusal: no panic, no signal, something to read.
#[track_caller]
fn refused(ran: &Ran, what: &str) {
    assert!(matches!(ran.code, 3 | 65), "{what}: exit code {} of `{}`\n{}", ran.code, ran.what, ran.err);
    assert!(ran.err.starts_with("error: ") && !ran.err.contains("panicked"), "{what}: {}", ran.err);
}

#[test]
fn a_flipped_byte_is_named() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, damaged) = small(folder.path());
    let whole = folder.path().join("whole.rtrace");
    let tiles = open(&whole).reader().chunks().to_vec();
    for record in tiles.iter().filter(|c| c.id.kind == ChunkKind::TILE).step_by(3) {
        let mut changed = bytes.clone();
        // The last byte of a tile belongs to its last column, that of the paths.
        changed[record.end() as usize - 1] ^= 0x10;
        fs::write(&damaged, &changed).unwrap();
        let place = [format!("tile {}", record.id.tile), "frame 0".into(), "byte ".into(), "checksum".into()];
        for ran in [rayreel!["verify", &damaged], rayreel!["digest", &damaged], rayreel!["diff", &whole, &damaged]] {
            let ran = ran.expect(65).says(&place.each_ref().map(String::as_str));
            let offset = ran.err.split("byte ").nth(1).unwrap().split(|c: char| !c.is_ascii_digit()).next().unwrap();
            let offset: u64 = offset.parse().unwrap();
            assert!((record.offset..record.end()).contains(&offset), "byte {offset} is not in {record:?}");
        }
    }
}

/// Replay does not need the paths, so damage there does not stop it; damage in what it reads does.
#[test]
fn a_replay_reads_only_what_it_needs() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, damaged) = small(folder.path());
    let whole = folder.path().join("whole.rtrace");
    let record = *open(&whole).reader().chunks().iter().find(|c| c.id.kind == ChunkKind::TILE).unwrap();
    let mut changed = bytes;
    // Behind header and directory comes the tree column.
    changed[record.end() as usize - record.packed_len as usize + record.directory_len as usize] ^= 1;
    fs::write(&damaged, &changed).unwrap();
    rayreel!["replay", "--quiet", &damaged].expect(65).says(&["tile 0", "frame 0", "byte "]);
    rayreel!["info", &damaged].expect(65).says(&["tile 0", "byte "]);
}

#[test]
fn flips_everywhere_are_noticed() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, damaged) = small(folder.path());
    for i in 0..60 {
        let at = i * (bytes.len() - 1) / 59;
        let mut changed = bytes.clone();
        changed[at] ^= 1 << (i % 8);
        fs::write(&damaged, &changed).unwrap();
        refused(&rayreel!["verify", &damaged], &format!("flip at {at} of {}", bytes.len()));
    }
}

#[test]
fn truncations_are_noticed_and_say_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, damaged) = small(folder.path());
    for i in 1..40 {
        let len = bytes.len() * i / 40;
        fs::write(&damaged, &bytes[..len]).unwrap();
        let ran = rayreel!["verify", &damaged];
        refused(&ran, &format!("{len} of {} bytes", bytes.len()));
        assert!(ran.err.contains("repair"), "{len} bytes: {}", ran.err);
    }
    for len in [0, 1, 7, 11] {
        fs::write(&damaged, &bytes[..len]).unwrap();
        refused(&rayreel!["info", &damaged], &format!("{len} bytes"));
    }
    fs::write(&damaged, [bytes.as_slice(), &[0; 100]].concat()).unwrap();
    refused(&rayreel!["info", &damaged], "bytes behind the end");
}

#[test]
fn repair_saves_what_damage_left() {
    let folder = tempfile::tempdir().unwrap();
    let (bytes, damaged) = small(folder.path());
    let fixed = folder.path().join("fixed.rtrace");
    let mut changed = bytes.clone();
    changed[bytes.len() * 2 / 3] ^= 0xff;
    fs::write(&damaged, &changed).unwrap();
    let report = rayreel!["repair", &damaged, "-o", &fixed].expect(3);
    assert!(report.out.contains("damaged"), "{}", report.out);
    assert_eq!(open(&fixed).missing_tiles().len(), 1, "one tile was hit");
    rayreel!["verify", &fixed].expect(3).says(&["1 tile is missing"]);
}
