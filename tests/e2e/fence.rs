//! Objects thinner than a block: a wire fence that plain adaptive sampling loses, and post-correction finds again.

use std::fmt::Write;
use std::path::Path;

use rayreel_formats::trace::Trace;
use rayreel_replay::image::srgb::encode;
use rayreel_replay::policy::{Adaptive, NamedPolicy, Policy};
use rayreel_replay::{Options, replay};

use crate::common::capture;
use crate::common::scenes::text_of;
use crate::common::trace::open;
use rayreel_testkit::preset;

/// Levels of 255 by which a channel must differ to be seen.
const VISIBLE: u8 = 8;

/// A diagonal mesh of flat wires `width` wide and `spacing` apart before a wall below a sky.
fn fence(folder: &Path, width: f32, spacing: f32) -> String {
    let mut obj = String::from("mtllib fence.mtl\n");
    obj +=
        "v -4 -3 -1.5\nv 4 -3 -1.5\nv 4 0.6 -1.5\nv -4 0.6 -1.5\no wall\nusemtl wall\nf 1 2 3 4\no mesh\nusemtl wire\n";
    let mut quads = 0;
    for (dx, dy) in [(1.0f32, 1.0f32), (1.0, -1.0)] {
        let count = (6.0 / spacing) as i32;
        for i in -count..=count {
            // From bottom to top across the picture, a little off the diagonal as real fences are.
            let (x, lean) = (i as f32 * spacing, 1.1 * dx);
            let (ox, oy) = (width * 0.5 * 0.707, width * 0.5 * 0.707 * dy);
            let (x0, y0, x1, y1) = (x - 2.0 * lean * dy, -2.0, x + 2.0 * lean * dy, 2.0);
            for (px, py) in [(x0 - ox, y0 + oy), (x0 + ox, y0 - oy), (x1 + ox, y1 - oy), (x1 - ox, y1 + oy)] {
                writeln!(obj, "v {px} {py} 0").unwrap();
            }
            let first = 5 + 4 * quads;
            writeln!(obj, "f {} {} {} {}", first, first + 1, first + 2, first + 3).unwrap();
            quads += 1;
        }
    }
    let mtl = "newmtl wall\nKd 0.7 0.6 0.5\nillum 1\nnewmtl wire\nKd 0.05 0.06 0.05\nillum 1\n";
    let scene = "model = \"fence.obj\"\n[camera]\nvfov_deg = 45.0\neye = [0.2, 0.1, 4.0]\ntarget = [0.0, 0.0, 0.0]\nup = [0.0, 1.0, 0.0]\n\
        [[lights]]\nkind = \"directional\"\nto_light = [0.4, 1.0, 0.8]\n";
    for (name, text) in [("fence.obj", obj.as_str()), ("fence.mtl", mtl), ("fence.toml", scene)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    text_of(&folder.join("fence.toml"))
}

/// Per pixel whether it visibly differs from `full`, and the rays that were traced.
fn wrong(trace: &Trace, policy: &Policy) -> (Vec<bool>, u64) {
    let first = trace.meta().first_frame;
    let frame = replay(trace, policy, [first], Options::default()).unwrap().frames.remove(0);
    let (sampled, full) = (encode(&frame.image), encode(frame.reference.as_ref().unwrap()));
    let differ = |(a, b): (&[u8; 3], &[u8; 3])| (0..3).any(|i| a[i].abs_diff(b[i]) > VISIBLE);
    (sampled.pixels.iter().zip(&full.pixels).map(differ).collect(), frame.stats.counts.rays_traced.total())
}

/// What plain `adaptive` with this block does, as its presets have it.
fn plain(block: u32) -> Adaptive {
    let name = if block == 2 { "adaptive".into() } else { format!("adaptive-{block}") };
    match NamedPolicy::load(&name, &[]).unwrap().policy {
        Policy::Adaptive(policy) => policy,
        other => panic!("{name} is {other:?}"),
    }
}

/// Share of the pixels that `policy` loses and correction, as `multirate` has it but with `passes`, brings back.
fn recovered(trace: &Trace, policy: &Adaptive, passes: u32) -> f64 {
    let (lost, few) = wrong(trace, &Policy::Adaptive(policy.clone()));
    let mut corrected = policy.clone();
    corrected.sampling.correct = preset("multirate", 8).sampling.correct;
    corrected.sampling.correct.passes = passes;
    let (still, more) = wrong(trace, &Policy::Adaptive(corrected));
    let number = lost.iter().filter(|lost| **lost).count();
    assert!(number > 1000 && more > few, "a fence that is lost");
    lost.iter().zip(&still).filter(|(lost, still)| **lost && !**still).count() as f64 / number as f64
}

/// Passes that reach every part of a tile along its wires.
const PASSES: u32 = 32;

#[test]
fn correction_brings_back_a_wire_fence() {
    let folder = tempfile::tempdir().unwrap();
    // A sample is 2 * 4 * tan(22.5 deg) / 180 = 0.0184 high at the fence; a tile is 0.59. In a mesh as wide as most of a tile,
    // some tiles have wires that no sample of a grid of 8 meets: these stay lost, since tiles are corrected by themselves.
    for (i, (width, spacing, coarse)) in
        [(0.0184, 0.21, 0.95), (0.0184, 0.5, 0.9), (0.026, 0.33, 0.95)].into_iter().enumerate()
    {
        let scene = fence(folder.path(), width, spacing);
        let file = folder.path().join(format!("{i}.rtrace"));
        capture(&scene, "--size 160x90 --samples 2x2 --tile 32", &file);
        let trace = open(&file);
        for (block, least) in [(2, 0.95), (4, 0.95), (8, coarse)] {
            let share = recovered(&trace, &plain(block), PASSES);
            println!("wires {width} wide every {spacing}, block {block}: {:.1} % back", 100.0 * share);
            assert!(share >= least, "wires {width} every {spacing}, block {block}: {share}");
        }
    }
}
