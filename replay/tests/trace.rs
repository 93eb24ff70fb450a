//! A trace file gives the same results as the frames it was written from.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::bvh::{Bvh, Shape, Triangle, Vertex};
use rayreel_formats::math::vec3;
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Material, Optics};
use rayreel_formats::tile::Paths;
use rayreel_formats::trace::{BvhTopology, Codec, Scratch, TileCodec, Trace, TraceWriter};
use rayreel_replay::policy::{Apron, Policy, Refine};
use rayreel_replay::{Options, TileSource, replay};
use rayreel_testkit::policy;
use rayreel_testkit::reference;
use rayreel_testkit::synthetic::{Look, Synthetic};

/// A tree over 40 triangles, four an object, as the synthetic frames number them.
fn bvh() -> Bvh {
    let material = Material {
        name: "grey".into(),
        optics: Optics::Dielectric,
        ior: 1.5,
        specular: vec3(0.5, 0.5, 0.5),
        transmission: vec3(0.5, 0.5, 0.5),
        cutout: false,
    };
    let triangles = (0..40).map(|i| Triangle { vertices: [0, 1, 2], object: i / 4, material: 0 }).collect();
    let corners = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.0, 1.0, 0.0)];
    let vertices = corners.map(|position| Vertex { position, normal: Oct::encode(vec3(0.0, 0.0, 1.0)) }).to_vec();
    // A chain: each node holds a leaf of four, the last one two.
    let mut shape = vec![[Shape::Leaf(4), Shape::Inner]; 8];
    shape.push([Shape::Leaf(4), Shape::Leaf(4)]);
    Bvh::new(&shape, triangles, vertices, (0..10).map(|i| format!("object {i}")).collect(), vec![material]).unwrap()
}

/// Writes the frames of `source` without prediction: the plain codec takes any tile, also one that no ray tracer would make.
fn write(source: &Synthetic, path: &Path) {
    let (bvh, limits) = (bvh(), Limits::default());
    let topology = BvhTopology::new(&bvh);
    let mut writer = TraceWriter::create(path, &source.meta, &bvh, 1).unwrap();
    for frame in source.meta.frame_numbers() {
        let camera = source.camera(frame).unwrap();
        writer.frame(frame, &camera).unwrap();
        let codec = TileCodec { meta: &source.meta, bvh: &bvh, topology: &topology, camera: &camera, limits: &limits };
        for index in 0..source.meta.tile_count() {
            let mut tile = source.tile(frame, index).unwrap();
            let rays = tile.tree.ray_count() as usize;
            tile.paths = Paths { steps: Vec::new(), spans: vec![(0, 0); rays] };
            writer.tile(&codec.encode(&tile, Codec::Plain(1), &mut Scratch::default()).unwrap()).unwrap();
        }
    }
    writer.finish().unwrap();
}

#[test]
fn a_trace_replays_like_its_frames() {
    let folder = tempfile::tempdir().unwrap();
    for (i, look) in [Look::Discs, Look::Noise].into_iter().enumerate() {
        let source = Synthetic::new(look, (45, 33), 2, 24, 7);
        let path = folder.path().join(format!("{i}.rtrace"));
        write(&source, &path);
        let trace = Trace::open(&path, Limits::default()).unwrap();
        for policy in [Policy::Full, policy(4, Refine::Hierarchical, Apron::Retrace)] {
            let ours = replay(&trace, &policy, 5..8, Options::default()).unwrap();
            assert_eq!(ours, replay(&source, &policy, 5..8, Options::default()).unwrap(), "{look:?}");
        }
    }
}

/// The reference runs on a trace as well: end-to-end tests use it so.
#[test]
fn the_reference_runs_on_a_trace() {
    let folder = tempfile::tempdir().unwrap();
    let source = Synthetic::new(Look::Discs, (30, 20), 1, 16, 7);
    let path = folder.path().join("a.rtrace");
    write(&source, &path);
    let trace = Trace::open(&path, Limits::default()).unwrap();
    let adaptive = rayreel_testkit::adaptive(2, Refine::Direct, Apron::Share);
    let expected = reference::replay(&trace, &adaptive, 6);
    let frame = replay(&trace, &Policy::Adaptive(adaptive), [6], Options::default()).unwrap().frames.remove(0);
    let bits = |pixels: &[[f32; 3]]| pixels.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!(bits(&frame.image.pixels), bits(&expected.colours));
    assert_eq!(frame.stats.counts.rays_traced.total(), expected.rays_traced.iter().sum::<u64>());
}
