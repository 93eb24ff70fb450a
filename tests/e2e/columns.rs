//! Tiles of other writers may lack columns: what does not need them works, and everything says what is missing.

use rayreel_formats::tile::Column;

use crate::common::trace::{open, without};
use crate::common::{capture, digest, replay};
use crate::rayreel;

#[test]
fn without_paths_all_works_but_the_machine() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, bare) = (folder.path().join("whole.rtrace"), folder.path().join("bare.rtrace"));
    capture("teapot", "--size 48x32 --tile 16", &whole);
    let tiles = open(&whole).meta().tile_count();
    without(&open(&whole), &bare, Column::Paths);
    let told = format!("{tiles} tiles hold no paths");
    assert!(rayreel!["info", &bare].expect(3).out.contains(&told));
    assert_eq!(rayreel!["info", "--json", &bare].expect(3).json()["missing_columns"]["paths"], tiles);
    // The digest is that of the whole trace, but for what is not there.
    let hashes = rayreel!["digest", "--json", &bare].expect(3).says(&[&told]).json();
    let all = digest(&whole);
    for part in ["meta", "bvh", "cameras", "tree", "hits", "radiance"] {
        assert_eq!(hashes[part], all[part], "{part}");
    }
    assert_ne!(hashes["paths"], all["paths"]);
    let verified = rayreel!["verify", "--json", &bare].expect(3).says(&[&told, "not checked: the steps of"]).json();
    assert_eq!((&verified["tiles"], &verified["tiles_without_paths"]), (&tiles.into(), &tiles.into()));
    assert_eq!(
        (&verified["rays"], &verified["steps"]),
        (&rayreel!["info", "--json", &whole].expect(0).json()["rays"], &0.into())
    );
    // The pictures and counts are those of the whole trace.
    let figures = |file| {
        let said = replay(file, "--machine none").expect(0).json();
        ["rays_traced", "samples_traced", "psnr_db", "frames"].map(|key| said[key].clone())
    };
    assert_eq!(figures(&bare), figures(&whole));
    replay(&bare, "--machine sgrt-ti2")
        .expect(3)
        .says(&["holds no paths in the TILE chunk of frame 0", "--machine none"]);
}

#[test]
fn without_colours_hits_are_still_read() {
    let folder = tempfile::tempdir().unwrap();
    let (whole, bare) = (folder.path().join("whole.rtrace"), folder.path().join("bare.rtrace"));
    capture("cornell", "--size 32x32", &whole);
    without(&open(&whole), &bare, Column::Radiance);
    let hashes = rayreel!["digest", "--json", &bare].expect(3).says(&["tiles hold no radiance"]).json();
    let all = digest(&whole);
    for part in ["tree", "hits", "paths"] {
        assert_eq!(hashes[part], all[part], "{part}");
    }
    let verified = rayreel!["verify", "--json", &bare].expect(3).says(&["tiles altogether"]).json();
    assert_eq!(
        (&verified["tiles"], &verified["tiles_unchecked"]),
        (&0.into(), &open(&whole).meta().tile_count().into())
    );
    replay(&bare, "--machine none").expect(3).says(&["holds no radiance in the TILE chunk of frame 0"]);
}
