//! A small study with every part filled: two scenes, both modes, three policies, and pictures beside it.

use std::path::Path;

use rayreel_replay::image::Srgb8;
use rayreel_replay::image::files::write_png;
use rayreel_study::schema::*;

const SCENES: [&str; 2] = ["teapot", "chess"];
const MODES: [&str; 2] = ["2x2", "1x1"];
const POLICIES: [&str; 3] = ["full", "paper-ss", "multirate"];

/// Size of the pictures and edge of their tiles, pixels: the last column and row of tiles are cut off.
pub const PICTURE: [u32; 3] = [72, 40, 16];

/// Writes the study and its pictures into a folder.
pub fn write(folder: &Path) -> Study {
    let study = study();
    std::fs::write(folder.join(FILE), serde_json::to_string_pretty(&study).unwrap()).unwrap();
    pictures(folder);
    study
}

/// Writes the pictures, each of its own colour.
pub fn pictures(folder: &Path) {
    let [width, height, _] = PICTURE;
    for (i, name) in (0u8..).zip(["reference", "result", "error", "flip", "similarity", "rate"]) {
        let pixel = |n: u32| [40 * i, (n % width * 3) as u8, (n / width * 6) as u8];
        let image = Srgb8 { width, height, pixels: (0..width * height).map(pixel).collect() };
        write_png(&folder.join(format!("{name}.png")), &image).unwrap();
    }
}

/// The study.
pub fn study() -> Study {
    let each = |n: usize| (0..n).map(|i| i as f64);
    let mut points = Vec::new();
    for (scene, s) in SCENES.iter().zip(each(2)) {
        for mode in MODES {
            points.extend(POLICIES.iter().zip(each(3)).map(|(policy, p)| point(scene, mode, policy, p + 0.4 * s * p)));
        }
    }
    let scene = |name: &&str| Scene {
        name: (*name).into(),
        triangles: 14_996,
        paper_triangles: Some(15_000),
        lights: 2,
        frame: 1,
        rays_full: MODES.map(|mode| ModeRays { mode: mode.into(), rays: 1_234_567 }).into(),
    };
    let policy = |name: &&str| Policy {
        name: (*name).into(),
        summary: format!("what {name} does"),
        config_toml: "block = 2\n".into(),
    };
    let systems = ["sgrt-ti2", "mimd-trax"].iter().flat_map(|machine| points.iter().map(move |p| (*machine, p)));
    let systems = systems.filter(|(_, point)| point.mode == MODES[0]).map(|(machine, point)| system(machine, point));
    Study {
        schema: SCHEMA,
        systems: systems.collect(),
        tool: "rayreel 0.0.0".into(),
        title: "A small study".into(),
        command: "rayreel paper".into(),
        machine: Some("sgrt-ti2".into()),
        detail: Some("full".into()),
        width: PICTURE[0],
        height: PICTURE[1],
        notes: vec!["a note".into()],
        headline_policy: None,
        scenes: SCENES.iter().map(scene).collect(),
        policies: POLICIES.iter().map(policy).collect(),
        points,
        references: references(),
        maps: vec![map(1), map(150)],
        tracks: POLICIES.iter().zip(each(3)).map(|(policy, p)| track(policy, p)).collect(),
        ablations: [("on chip", true), ("external", false)].map(|(name, base)| ablation(name, base)).into(),
        viewer: vec![set("teapot", "paper-ss"), set("chess", "multirate")],
        config: vec![value("ti.trv", "4"), value("l2.size", "256 KiB")],
    }
}

/// The point on a machine, of which only the first has T&I units.
fn system(machine: &str, point: &Point) -> SystemPoint {
    let has_units = machine == "sgrt-ti2";
    SystemPoint {
        scene: point.scene.clone(),
        machine: machine.into(),
        policy: point.policy.clone(),
        rays_full: point.rays_full,
        rays_traced: point.rays_traced,
        psnr_db: point.quality.and_then(|quality| quality.psnr_db),
        gpu: point.gpu,
        ti: point.ti.filter(|_| has_units),
        gpu_gain: point.gpu_gain,
        ti_gain: point.ti_gain.filter(|_| has_units),
    }
}

/// `strength` 0 is full sampling.
fn point(scene: &str, mode: &str, policy: &str, strength: f64) -> Point {
    let gain = Gain { performance: 1.0 + 1.1 * strength, power: 1.05, perf_per_watt: 1.0 + strength, interval: None };
    let cost = |scale: f64| Cost {
        cycles: (1e6 * scale / gain.performance) as u64,
        time_ms: 2.0 * scale / gain.performance,
        power_w: 0.4,
        energy_mj: 0.8 * scale / gain.performance,
        perf_per_watt: 600.0 * gain.perf_per_watt / scale,
        interval: None,
    };
    let (full, over) = (policy == "full", (policy != "full").then_some(gain));
    let share = |state: &str, share| StateShare { state: state.into(), share };
    let component = |name: &str, group: &str, mj| Component { component: name.into(), group: group.into(), mj };
    let kernel = |name: &str, share| Kernel { kernel: name.into(), cycles: (share * 1e6) as u64, share };
    Point {
        scene: scene.into(),
        mode: mode.into(),
        policy: policy.into(),
        machine: Some("sgrt-ti2".into()),
        block: (!full).then_some(2),
        kind: if full { "full" } else { "adaptive" }.into(),
        rays_full: 1_234_567,
        rays_traced: (1_234_567.0 / (1.0 + strength)) as u64,
        samples_full: 100_000,
        samples_traced: (1e5 / (1.0 + strength)) as u64,
        mean_rate: 1.0 / (1.0 + strength),
        ti: Some(cost(1.0)),
        gpu: Some(cost(1.7)),
        ti_gain: over,
        gpu_gain: over,
        fsaa_gain: over.filter(|_| mode == "1x1"),
        quality: Some(Quality {
            psnr_db: (!full).then_some(35.0 + 5.0 * strength),
            ssim: Some(0.99),
            flip: Some(0.01),
            worst_tile_psnr_db: (!full).then_some(25.0),
        }),
        units: vec![Unit { unit: "trv/inner".into(), shares: vec![share("busy", 0.6), share("memory", 0.4)] }],
        energy: vec![component("trv", "ti", 0.5), component("srp", "srp", 0.4), component("dram", "memory", 0.3)],
        srp: vec![kernel("shade", 0.9), kernel("similarity", 0.04), kernel("interpolate", 0.06)],
    }
}

fn references() -> References {
    let (scene, mode) = ("teapot".to_string(), "2x2".to_string());
    let kernel = |name: &str, share| PaperKernel { kernel: name.into(), share };
    References {
        policies: MODES.map(|mode| ModePolicy { mode: mode.into(), policy: "paper-ss".into() }).into(),
        gains: vec![
            GainBand { scene: scene.clone(), least: 2.43, most: Some(2.98) },
            GainBand { scene: "chess".into(), least: 1.53, most: None },
        ],
        power: Some(1.09),
        psnr: vec![PaperPsnr { scene, mode, psnr_db: 48.99 }],
        srp: vec![kernel("similarity", 0.05), kernel("interpolate", 0.06)],
    }
}

fn map(frame: u32) -> Map {
    Map {
        scene: "chess".into(),
        policy: "multirate".into(),
        frame,
        similarity: "similarity.png".into(),
        rate: Some("rate.png".into()),
        picture: Some("result.png".into()),
        similarity_ratio: Some(0.62),
        mean_rate: 0.3,
        paper_ratio: Some(0.6),
    }
}

fn track(policy: &str, strength: f64) -> Track {
    let frame = |frame: u32| TrackFrame {
        frame,
        rays_full: 1_000_000,
        rays_traced: (1e6 / (1.0 + strength)) as u64 + u64::from(frame),
        power_w: Some(0.4),
        time_ms: Some(2.0),
        energy_mj: Some(0.8),
        interval: None,
        // A frame that equals the reference.
        psnr_db: (frame != 3).then_some(40.0 + strength),
        mean_rate: 1.0 / (1.0 + strength),
        similarity_ratio: Some(0.5),
    };
    Track {
        scene: "chess".into(),
        policy: policy.into(),
        mode: "2x2".into(),
        frames: (1..=5).map(frame).collect(),
        interval: None,
        flicker: Some(0.002),
        psnr_db: Some(41.0),
    }
}

fn ablation(name: &str, base: bool) -> Ablation {
    Ablation {
        group: "tile buffer".into(),
        name: name.into(),
        note: "a remark".into(),
        scene: "chess".into(),
        mode: "2x2".into(),
        policy: "multirate".into(),
        base,
        rays_traced: 300,
        rays_full: 1000,
        cycles: Some(if base { 1000 } else { 1500 }),
        power_w: Some(1.0),
        perf_per_watt: Some(400.0),
        interval: None,
        gain_interval: None,
        psnr_db: Some(41.0),
    }
}

fn set(scene: &str, policy: &str) -> ViewerSet {
    let [width, height, tile_px] = PICTURE;
    let tile = |i: u32| TileFigures {
        rays_full: 1000 + u64::from(i),
        rays_traced: 100 + u64::from(i),
        mean_rate: 0.25,
        similarity_ratio: (i != 0).then_some(0.5),
        psnr_db: (i != 1).then_some(43.21),
    };
    let file = |name: &str| Some(format!("{name}.png"));
    ViewerSet {
        scene: scene.into(),
        mode: "2x2".into(),
        policy: policy.into(),
        width,
        height,
        tile_px,
        images: ViewerImages {
            reference: file("reference"),
            result: file("result"),
            error: file("error"),
            flip: file("flip"),
            similarity: file("similarity"),
            rate: file("rate"),
        },
        tiles: (0..width.div_ceil(tile_px) * height.div_ceil(tile_px)).map(tile).collect(),
    }
}

fn value(key: &str, value: &str) -> ConfigValue {
    ConfigValue {
        key: key.into(),
        value: value.into(),
        unit: "bytes".into(),
        class: "paper".into(),
        source: "section 2".into(),
    }
}
