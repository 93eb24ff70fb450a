//! `trim`, `recompress` and `merge`: traces out of traces have the bytes of captures.

use std::fs;

use rayreel_formats::container::{ChunkId, ChunkKind, Encoding, Writer};
use rayreel_formats::tile::Column;

use crate::common::{capture, digest};
use crate::rayreel;

const OPTIONS: &str = "--size 48x32 --samples 1x1";

#[test]
fn parts_have_the_bytes_of_captures() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let bytes = |name: &str| fs::read(at(name)).unwrap();
    for (name, frames) in [("all", "0..3"), ("first", "0"), ("rest", "1..3")] {
        capture("chess", &format!("{OPTIONS} --frames {frames}"), &at(name));
    }
    let ran = rayreel!["trim", "--quiet", &at("all"), "--frames", "1..3", "-o", &at("trimmed")].expect(0);
    assert!(ran.out.contains("frames 1..3, "), "{ran:?}");
    assert_eq!(bytes("trimmed"), bytes("rest"));
    // In whatever order they are named.
    rayreel!["merge", "--quiet", &at("rest"), &at("first"), "-o", &at("merged")].expect(0);
    assert_eq!(bytes("merged"), bytes("all"));
    // To the other codec and back.
    capture("chess", &format!("{OPTIONS} --frames 0..3 --codec plain"), &at("plain"));
    rayreel!["recompress", "--quiet", &at("all"), "--codec", "plain", "-o", &at("made plain")].expect(0);
    assert_eq!(bytes("made plain"), bytes("plain"));
    rayreel!["recompress", "--quiet", "--threads", "1", &at("plain"), "-o", &at("back")].expect(0);
    assert_eq!(bytes("back"), bytes("all"));
    assert_eq!(digest(&at("plain")), digest(&at("all")));
    rayreel!["verify", "--quiet", &at("merged")].expect(0);
}

#[test]
fn fewer_tiles_and_columns_are_said_and_still_read() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("chess", OPTIONS, &at("all"));
    let ran =
        rayreel!["trim", "--quiet", &at("all"), "--tiles", "0..2", "--columns", "hits", "-o", &at("some")].expect(0);
    assert!(ran.out.contains("it is not whole: "), "{ran:?}");
    assert!(fs::metadata(at("some")).unwrap().len() < fs::metadata(at("all")).unwrap().len());
    let info = rayreel!["info", "--json", &at("some")].expect(3).json();
    assert_eq!(info["missing_columns"]["paths"], 2);
    let rows = |name: &str| {
        let args = ["--what", "hits", "--tiles", "0..2", "--columns", "tile,triangle,t", "--format", "csv", "-o", "-"];
        let mut all: Vec<_> = ["export", "--quiet"].map(std::ffi::OsString::from).to_vec();
        all.push(at(name).into());
        all.extend(args.map(std::ffi::OsString::from));
        crate::common::run(&all)
    };
    // Hits have colours, which went with their column; trees alone remain of what rays need.
    assert_eq!(rows("all").code, 0);
}

/// A later version may add chunks, which this one cannot place.
#[test]
fn chunks_that_nobody_knows_are_told_when_they_are_left_out() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("chess", OPTIONS, &at("all"));
    let trace = crate::common::trace::open(&at("all"));
    let mut writer = Writer::create(&at("later")).unwrap();
    for record in trace.reader().chunks() {
        let ChunkId { kind, frame, tile } = record.id;
        if kind == ChunkKind::TILE {
            writer.write_encoded(&trace.copy_tile(frame, tile, &Column::ALL).unwrap()).unwrap();
        } else {
            writer.write(record.id, Encoding::Stored, &trace.reader().read(record).unwrap()).unwrap();
        }
    }
    let new = ChunkId { kind: ChunkKind(*b"XTRA"), frame: 0, tile: 0 };
    writer.write(new, Encoding::Stored, b"of a later version").unwrap();
    writer.finish().unwrap();
    let ran = rayreel!["recompress", "--quiet", &at("later"), "-o", &at("made")].expect(0);
    assert!(ran.err.contains("1 chunks of kinds that this version of rayreel does not know were left out"), "{ran:?}");
    assert!(!rayreel!["recompress", "--quiet", &at("all"), "-o", &at("same")].expect(0).err.contains("left out"));
}

/// Frames that were lost as a whole are missing in what is made of the rest.
#[test]
fn what_was_repaired_is_cut_and_coded_anew() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("chess", &format!("{OPTIONS} --frames 0..4"), &at("whole"));
    let bytes = fs::read(at("whole")).unwrap();
    fs::write(at("cut"), &bytes[..bytes.len() * 6 / 10]).unwrap();
    rayreel!["repair", &at("cut"), "-o", &at("repaired")].expect(3);
    assert!(!crate::common::trace::open(&at("repaired")).has_frame(3), "its camera is lost too");
    for (command, options) in [("recompress", ["--codec", "plain"]), ("trim", ["--columns", "radiance"])] {
        let [a, b] = options;
        let ran = rayreel![command, "--quiet", a, b, &at("repaired"), "-o", &at(command)].expect(0);
        assert!(ran.out.contains("it is not whole: "), "{ran:?}");
    }
    let missing = |name: &str| crate::common::trace::open(&at(name)).missing_tiles();
    assert!(missing("repaired") == missing("recompress") && missing("repaired") == missing("trim"));
    rayreel!["verify", "--quiet", &at("recompress")].expect(3);
    // A frame that lost its camera alone is named.
    let camera = crate::common::trace::open(&at("whole")).reader().find(ChunkId::frame(1)).unwrap().offset as usize;
    let mut bytes = bytes;
    bytes[camera + 60] ^= 0xff;
    fs::write(at("struck"), bytes).unwrap();
    rayreel!["repair", &at("struck"), "-o", &at("blind")].expect(3);
    let ran = rayreel!["trim", "--columns", "hits", &at("blind"), "-o", &at("none")].expect(2);
    assert!(ran.err.contains("the camera of frame 1 is lost") && !at("none").exists(), "{ran:?}");
    rayreel!["trim", "--quiet", "--frames", "2..4", &at("blind"), "-o", &at("rest")].expect(0);
    // A frame of which nothing is left makes no trace.
    let ran = rayreel!["trim", "--frames", "3", &at("repaired"), "-o", &at("none")].expect(2);
    assert!(ran.err.contains("holds nothing of frames 3..4") && !at("none").exists(), "{ran:?}");
}

#[test]
fn what_cannot_be_done_is_said_and_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    capture("chess", &format!("{OPTIONS} --frames 0..3"), &at("a"));
    capture("chess", &format!("{OPTIONS} --frames 4"), &at("later"));
    capture("cornell", &format!("{OPTIONS} --frames 0"), &at("other"));
    let refused = |ran: crate::common::Ran, says: &str| {
        let ran = ran.expect(2);
        assert!(ran.err.contains(says), "{ran:?}");
        assert!(!at("out").exists() && !at("out.partial").exists(), "{ran:?}");
    };
    refused(rayreel!["trim", &at("a"), "-o", &at("out")], "nothing would be left out");
    refused(rayreel!["trim", &at("a"), "--frames", "7", "-o", &at("out")], "frame 7 is not in the trace");
    refused(rayreel!["trim", &at("a"), "--tiles", "99", "-o", &at("out")], "tile 99 is not in the trace");
    refused(rayreel!["trim", &at("a"), "--columns", "path", "-o", &at("out")], "take some of tree");
    refused(rayreel!["merge", &at("a"), &at("later"), "-o", &at("out")], "do not follow on frame 2");
    refused(rayreel!["merge", &at("a"), &at("a"), "-o", &at("out")], "do not follow on frame 2");
    refused(rayreel!["merge", &at("a"), &at("other"), "-o", &at("out")], "differ in the scene");
    // What another command left is not ours to delete, whatever the folder is called; what we began is.
    let odd = at("odd.partial");
    fs::create_dir(&odd).unwrap();
    fs::write(odd.join("out.partial"), "theirs").unwrap();
    rayreel!["trim", "--frames", "0", &at("a"), "-o", &odd.join("out")].expect(2);
    assert_eq!(fs::read(odd.join("out.partial")).unwrap(), b"theirs");
    refused(rayreel!["merge", &at("a"), &at("other"), "-o", &odd.join("new")], "differ in the scene");
    // What was begun goes where a tile turns out to be damaged, and that is what is said.
    let mut bytes = fs::read(at("a")).unwrap();
    let middle = bytes.len() * 3 / 4;
    bytes[middle] ^= 0xff;
    fs::write(at("damaged"), bytes).unwrap();
    let ran = rayreel!["recompress", &at("damaged"), "-o", &at("out")].expect(65);
    assert!(ran.err.contains("damaged") && !at("out").exists() && !at("out.partial").exists(), "{ran:?}");
    // Nor is what a killed capture left, where the parts do not go together.
    let begun = fs::read(at("other")).unwrap();
    fs::write(at("long.partial"), &begun).unwrap();
    rayreel!["merge", &at("a"), &at("other"), "-o", &at("long")].expect(2);
    assert_eq!(fs::read(at("long.partial")).unwrap(), begun);
    assert!(!odd.join("new.partial").exists());
    // Nor where the output may be replaced: it may be all that there is of a long capture.
    rayreel!["trim", "--force", "--frames", "0", &at("a"), "-o", &at("long")]
        .expect(2)
        .says(&["long.partial", "--resume"]);
    assert_eq!(fs::read(at("long.partial")).unwrap(), begun);
    rayreel!["trim", "--quiet", "--columns", "hits", &at("a"), "-o", &at("hits")].expect(0);
    refused(rayreel!["trim", &at("hits"), "--columns", "paths", "-o", &at("out")], "holds no paths");
    // A trace of which one frame has them and the other does not.
    rayreel!["trim", "--quiet", "--frames", "2", &at("a"), "-o", &at("end")].expect(0);
    rayreel!["trim", "--quiet", "--frames", "0..2", &at("hits"), "-o", &at("begin")].expect(0);
    rayreel!["merge", "--quiet", &at("begin"), &at("end"), "-o", &at("mixed")].expect(0);
    let paths =
        |frames: &str| rayreel!["trim", &at("mixed"), "--columns", "paths", "--frames", frames, "-o", &at("out")];
    refused(paths("0..2"), "holds no paths in these frames");
    rayreel!["trim", "--quiet", "--columns", "paths", &at("mixed"), "-o", &at("paths")].expect(0);
    rayreel!["trim", "--quiet", "--tiles", "0", &at("a"), "-o", &at("tile")].expect(0);
    refused(rayreel!["trim", &at("tile"), "--tiles", "0..2", "-o", &at("out")], "holds no tile 1 in these frames");
    let ran = rayreel!["recompress", &at("a"), "-o", &at("later")].expect(2);
    assert!(ran.err.contains("already exists"), "{ran:?}");
    rayreel!["recompress", "--quiet", "--force", &at("a"), "-o", &at("later")].expect(0);
    assert_eq!(fs::read(at("later")).unwrap(), fs::read(at("a")).unwrap());
}
