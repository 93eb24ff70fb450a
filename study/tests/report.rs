//! Reports, errors of a replay, and pictures made of it.

use rayreel_formats::Error;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_formats::tile::Tile;
use rayreel_replay::error::RequestError;
use rayreel_replay::image::{files, srgb};
use rayreel_replay::maps;
use rayreel_replay::policy::{Apron, Refine};
use rayreel_replay::{NamedPolicy, Options, Policy, ReplayError, TileSource, replay};
use rayreel_study::figures::{figures, is_key};
use rayreel_study::report::{Origin, Report};
use rayreel_testkit::policy;
use rayreel_testkit::synthetic::{Look, Synthetic};
use serde_json::Value;

fn source() -> Synthetic {
    Synthetic::new(Look::Discs, (60, 40), 2, 32, 1)
}

fn report(frames: impl IntoIterator<Item = u32>, options: Options, policy: &NamedPolicy) -> Report {
    let source = source();
    let stats = replay(&source, &policy.policy, frames, options).unwrap().stats();
    let origin = Origin { trace: "synthetic".into(), trace_digest: Some("abc".into()), ..Origin::default() };
    Report::new(&origin, policy, &source.meta, &stats)
}

#[test]
fn json_has_the_promised_keys_and_the_same_bytes_each_time() {
    let policy = NamedPolicy::load("adaptive", &["apron=retrace".into()]).unwrap();
    let json = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| report(5..8, Options::default(), &policy).to_json().unwrap())
    };
    let text = json(1);
    assert_eq!(text, json(3));
    let value: Value = serde_json::from_str(&text).unwrap();
    for key in [
        "trace",
        "machine",
        "policy",
        "rays_full",
        "rays_traced",
        "samples_traced",
        "samples_interpolated",
        "psnr_db",
        "ssim",
        "flip",
        "worst_frame_psnr_db",
        "worst_tile_psnr_db",
        "worst_tile",
        "flicker",
        "flicker_db",
    ] {
        assert!(value.get(key).is_some(), "{key}");
    }
    assert!(value["machine"].is_null());
    assert_eq!(value["policy"], "adaptive+apron=retrace");
    assert_eq!(value["policy_config"]["similarity"]["plane"], "off");
    let frames = value["frames"].as_array().unwrap();
    assert_eq!(frames.iter().map(|f| f["frame"].as_u64().unwrap()).collect::<Vec<_>>(), [5, 6, 7]);
    for key in ["rays_full", "rays_traced", "rays_apron", "samples_traced"] {
        let sum: u64 = frames.iter().map(|f| f[key].as_u64().unwrap()).sum();
        assert_eq!(value[key].as_u64(), Some(sum), "{key}");
        let part = if key == "rays_full" { "full" } else { "traced" };
        if key.starts_with("rays") && key != "rays_apron" {
            let kinds = value["rays_by_kind"][part].as_object().unwrap();
            assert_eq!(kinds.values().map(|v| v.as_u64().unwrap()).sum::<u64>(), sum, "{key}");
        }
    }
    assert_eq!(frames[0]["tiles"].as_array().unwrap().len(), 4 * 3);
    // Every key is a figure or says what the report is of; every figure is a key and is described, and nothing else is.
    let keys = value.as_object().unwrap().keys();
    let known: Vec<_> = keys.filter(|key| !OF_WHAT.contains(&key.as_str())).map(String::as_str).collect();
    assert_eq!(known, figures().iter().map(|figure| figure.name).collect::<Vec<_>>());
    assert!(OF_WHAT.iter().all(|key| value.get(key).is_some() && !is_key(key)));
    let described: Vec<_> = value["descriptions"].as_object().unwrap().keys().collect();
    assert_eq!(known, described);
}

/// Keys of a report that are no figures.
const OF_WHAT: &[&str] = &[
    "trace",
    "trace_fingerprint",
    "trace_digest",
    "scene",
    "machine",
    "policy",
    "policy_config",
    "width",
    "height",
    "samples_per_axis",
    "tile",
    "frames",
    "descriptions",
];

#[test]
fn psnr_over_frames_is_that_of_the_mean_error() {
    let policy = NamedPolicy::load("adaptive-4", &[]).unwrap();
    let all = report(5..8, Options::default(), &policy);
    let mse = |db: f64| 255.0f64.powi(2) / 10f64.powf(db / 10.0);
    let mean = all.frames.iter().map(|f| mse(f.figures.psnr_db.unwrap())).sum::<f64>() / 3.0;
    assert!((mse(all.sum.psnr_db.unwrap()) - mean).abs() < 1.0e-9 * mean);
}

/// Sums over frames against what the frames say; a frame by itself has no flicker.
#[test]
fn flip_worst_tile_and_flicker_over_frames() {
    let policy = NamedPolicy::load("adaptive-4", &[]).unwrap();
    let all = report(5..8, Options::default(), &policy);
    let frames: Vec<_> = all.frames.iter().map(|f| &f.figures).collect();
    let mean = frames.iter().map(|f| f.flip.unwrap()).sum::<f64>() / 3.0;
    assert!(mean > 0.0 && (all.sum.flip.unwrap() - mean).abs() < 1.0e-15);
    // The worst of each frame is the least of its tiles, that of all frames the least of them.
    for (frame, figures) in all.frames.iter().zip(&frames) {
        let least = frame.tiles.iter().filter_map(|t| t.psnr_db).fold(f64::INFINITY, f64::min);
        let tile = figures.worst_tile.unwrap() as usize;
        assert_eq!((figures.worst_tile_psnr_db, frame.tiles[tile].psnr_db), (Some(least), Some(least)));
        assert_eq!(figures.worst_tile_frame, Some(frame.frame));
        assert!(least < figures.psnr_db.unwrap());
    }
    let worst = frames.iter().map(|f| f.worst_tile_psnr_db.unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(all.sum.worst_tile_psnr_db, Some(worst));
    let of = all.frames.iter().find(|f| Some(f.frame) == all.sum.worst_tile_frame).unwrap();
    assert_eq!((of.figures.worst_tile_psnr_db, of.figures.worst_tile), (Some(worst), all.sum.worst_tile));
    let worst = frames.iter().map(|f| f.psnr_db.unwrap()).fold(f64::INFINITY, f64::min);
    assert_eq!(all.sum.worst_frame_psnr_db, Some(worst));
    assert!(frames.iter().all(|f| f.worst_frame_psnr_db == f.psnr_db));
    // Flicker: two pairs, none for the first frame; the root of the mean of the squares.
    assert_eq!(frames.iter().map(|f| f.flicker.is_some()).collect::<Vec<_>>(), [false, true, true]);
    let square = (frames[1].flicker.unwrap().powi(2) + frames[2].flicker.unwrap().powi(2)) / 2.0;
    assert!((all.sum.flicker.unwrap() - square.sqrt()).abs() < 1.0e-12);
    let db = 20.0 * (255.0 / all.sum.flicker.unwrap()).log10();
    assert!((all.sum.flicker_db.unwrap() - db).abs() < 1.0e-9);
    let alone = report([6], Options::default(), &policy);
    assert_eq!((alone.sum.flicker, alone.sum.flicker_db), (None, None));
    assert_eq!(alone.sum.flip, frames[1].flip);
}

#[test]
fn full_is_identical_and_no_comparison_is_null() {
    let full = NamedPolicy { name: "full".into(), policy: Policy::Full };
    let same = report([5], Options::default(), &full);
    assert_eq!((same.sum.psnr_db, same.sum.ssim, same.sum.identical), (None, Some(1.0), Some(true)));
    assert!(same.to_string().contains("PSNR identical"));
    assert_eq!((same.sum.flip, same.sum.worst_tile_psnr_db, same.sum.worst_tile), (Some(0.0), None, None));
    let steady = report(5..7, Options::default(), &full);
    assert_eq!((steady.sum.flicker, steady.sum.flicker_db), (Some(0.0), None));
    let none = report([5], Options { reference: false, ..Options::default() }, &full);
    assert_eq!((none.sum.psnr_db, none.sum.ssim, none.sum.identical), (None, None, None));
    assert_eq!((none.sum.flip, none.sum.worst_tile, none.sum.flicker), (None, None, None));
    let value: Value = serde_json::from_str(&none.to_json().unwrap()).unwrap();
    assert!(value["frames"][0]["tiles"].is_array());
    let short: Value = serde_json::from_str(&none.without_tiles().to_json().unwrap()).unwrap();
    assert!(short["frames"][0].get("tiles").is_none());
    assert!(value["psnr_db"].is_null() && value["similarity_ratio"].is_null());
}

#[test]
fn the_table_says_what_matters() {
    let text = report(5..7, Options::default(), &NamedPolicy::load("adaptive", &[]).unwrap()).to_string();
    for part in [
        "synthetic: policy adaptive, 60 x 40 pixels",
        "interpolated",
        "reflection",
        "saved",
        "PSNR",
        "FLIP 0.",
        "worst tile",
        "of frame ",
        "flicker ",
        "    5 ",
        "    6 ",
    ] {
        assert!(text.contains(part), "{part:?} is missing in\n{text}");
    }
    assert!(text.lines().all(|line| line.len() <= 100), "{text}");
}

#[test]
fn blocks_must_fill_tiles() {
    let error = replay(&source(), &policy(3, Refine::Direct, Apron::Share), [5], Options::default()).unwrap_err();
    let text = error.to_string();
    assert!(text.contains("(2, 4, 8, 16)") && text.contains("such as 30 or 33"), "{text}");
    let odd = Synthetic::new(Look::Flat, (9, 9), 1, 7, 0);
    let text = replay(&odd, &policy(8, Refine::Direct, Apron::Share), [5], Options::default()).unwrap_err().to_string();
    assert!(text.contains("none does") && text.contains("such as 8)"), "{text}");
}

#[test]
fn frames_must_exist() {
    let run = |frames: &[u32]| replay(&source(), &Policy::Full, frames.iter().copied(), Options::default());
    let text = run(&[5, 8]).unwrap_err().to_string();
    assert!(text.contains("frame 8") && text.contains("5 to 7"), "{text}");
    assert!(matches!(run(&[]).unwrap_err(), ReplayError::Request(RequestError::Nothing { .. })));
    let empty = Synthetic::new(Look::Flat, (0, 9), 1, 8, 0);
    assert!(matches!(
        replay(&empty, &Policy::Full, [5], Options::default()),
        Err(ReplayError::Request(RequestError::Nothing { .. }))
    ));
}

/// A source that fails, or lies, from tile 3 on.
struct Bad {
    inner: Synthetic,
    lie: bool,
}

impl TileSource for Bad {
    fn meta(&self) -> &Meta {
        &self.inner.meta
    }
    fn object_of(&self, triangle: u32) -> u32 {
        triangle
    }
    fn camera(&self, frame: u32) -> Result<Camera, Error> {
        self.inner.camera(frame)
    }
    fn tile(&self, frame: u32, index: u32) -> Result<Tile, Error> {
        let mut tile = self.inner.tile(frame, index)?;
        match (index >= 3, self.lie) {
            (true, false) => Err(Error::usage("made to fail")),
            (true, true) => {
                tile.hits.pop();
                Ok(tile)
            }
            _ => Ok(tile),
        }
    }
}

#[test]
fn a_failing_source_is_an_error_that_names_the_first_bad_tile() {
    for (lie, part) in [(false, "cannot read tile 3 of frame 5"), (true, "frame 5, tile 3: ")] {
        let bad = Bad { inner: source(), lie };
        let error = replay(&bad, &Policy::Full, [5], Options::default()).unwrap_err();
        assert!(error.to_string().starts_with(part), "{error}");
        assert_eq!(std::error::Error::source(&error).is_some(), !lie);
    }
}

#[test]
fn the_map_reads_like_the_figure() {
    // Flat: all similar. R-samples take the colour of their block, so all is yellow but for the lone corner.
    let flat = Synthetic::new(Look::Flat, (8, 8), 1, 8, 0);
    let frame =
        replay(&flat, &policy(4, Refine::Direct, Apron::Share), [5], Options::default()).unwrap().frames.remove(0);
    let picture = maps::similarity_map(&frame.states, &frame.blocks);
    assert!(picture.pixels.iter().all(|p| *p == maps::YELLOW), "{picture:?}");
    // Full: nothing is similar.
    let frame = replay(&flat, &Policy::Full, [5], Options::default()).unwrap().frames.remove(0);
    assert!(maps::similarity_map(&frame.states, &frame.blocks).pixels.iter().all(|p| *p == maps::BLUE));
    let small = maps::similarity_map_pixels(&frame.states, &frame.blocks, 2);
    assert_eq!((small.width, small.height, small.pixels[0]), (4, 4, maps::BLUE));
}

/// Pictures to look at: set RAYREEL_PICTURES to a folder.
#[test]
fn pictures_can_be_written() {
    let kept = std::env::var_os("RAYREEL_PICTURES").map(std::path::PathBuf::from);
    let temporary = tempfile::tempdir().unwrap();
    let folder = kept.as_deref().unwrap_or(temporary.path());
    let source = Synthetic::new(Look::Discs, (160, 100), 2, 32, 1);
    for name in ["adaptive", "adaptive-8"] {
        let policy = NamedPolicy::load(name, &[]).unwrap();
        let frame = replay(&source, &policy.policy, [5], Options::default()).unwrap().frames.remove(0);
        let map = maps::similarity_map(&frame.states, &frame.blocks);
        files::write_png(&folder.join(format!("{name}-map.png")), &map).unwrap();
        let pixels = maps::similarity_map_pixels(&frame.states, &frame.blocks, 2);
        files::write_png(&folder.join(format!("{name}-map-pixels.png")), &pixels).unwrap();
        files::write_png(&folder.join(format!("{name}.png")), &srgb::encode(&frame.image)).unwrap();
        files::write_exr(&folder.join(format!("{name}.exr")), &frame.image).unwrap();
        assert_eq!(files::read_exr(&folder.join(format!("{name}.exr"))).unwrap(), frame.image);
    }
}
