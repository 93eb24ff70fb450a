//! Rays rebuilt from a trace: all of them, in order, and to the last bit those that met what the trace says.

mod trace_support;

use std::path::Path;

use rayreel_formats::intersect::intersect;
use rayreel_formats::rays::{self, RayEnd};
use rayreel_formats::tile::{Column, RayKind, ShadowState};
use rayreel_formats::trace::Codec;
use rayreel_formats::{Limits, Trace};
use trace_support::whole::Content;

fn golden(name: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&path, Limits::default()).expect("a golden trace")
}

/// Every ray of every tile once, in ray order, with the node that it belongs to.
fn assert_walks_all(trace: &Trace) {
    let meta = trace.meta();
    for (frame, index) in meta.frame_numbers().flat_map(|f| (0..meta.tile_count()).map(move |t| (f, t))) {
        let tile = trace.tile(frame, index, &[Column::Hits]).expect("it decodes");
        let (numbers, walked) = (tile.tree.ray_index(), trace.rays(frame, index).expect("it decodes"));
        let mut count = 0;
        for ray in walked {
            let node = tile.tree.nodes[ray.node as usize];
            assert_eq!(ray.index, count, "tile {index}");
            assert_eq!(ray.class, node.class);
            assert!(tile.tree.sample(ray.sample as usize).contains(&(ray.node as usize)));
            match ray.end {
                RayEnd::Sky => assert!(!node.hit),
                RayEnd::Hit(hit) => assert_eq!(hit, tile.hits[ray.node as usize]),
                RayEnd::Light { light, state } => {
                    assert!(state == node.shadows.get(light) && state != ShadowState::NotCast);
                }
            }
            assert_eq!(ray.kind() == RayKind::Shadow, count > numbers[ray.node as usize]);
            count += 1;
        }
        assert_eq!(u64::from(count), tile.tree.ray_count(), "tile {index}");
    }
}

#[test]
fn all_rays_are_walked_in_order() {
    assert_walks_all(&golden("v1_0_cornell.rtrace"));
    assert_walks_all(&golden("v1_0_teapot.rtrace"));
}

/// In these no ray leads anywhere: refractions where there are none, triangles that no ray meets.
#[test]
fn rays_of_made_up_traces_are_walked() {
    for (seed, edge, triangles, depth, lights) in
        [(1, 8, 40, 5, 3), (2, 5, 0, 3, 2), (3, 16, 300, 14, 16), (4, 3, 5, 0, 0)]
    {
        let bytes = Content::random(seed, (edge + 3, edge), edge, triangles, depth, lights).bytes(|_| Codec::Context);
        assert_walks_all(&Trace::from_bytes(bytes, Limits::default()).expect("it opens"));
    }
}

/// The `t` that a ray was traced to is the `t` of its rebuilt ray.
#[test]
fn rebuilt_rays_meet_their_triangles_to_the_last_bit() {
    let trace = golden("v1_0_teapot.rtrace");
    let mut kinds = [0; 4];
    for (frame, index) in trace.meta().frame_numbers().flat_map(|f| (0..trace.meta().tile_count()).map(move |t| (f, t)))
    {
        for ray in trace.rays(frame, index).expect("it decodes") {
            kinds[ray.kind() as usize] += 1;
            let RayEnd::Hit(hit) = ray.end else { continue };
            let met = intersect(&ray.ray, trace.bvh().corners(hit.triangle as usize), ray.ray.t_max).expect("it meets");
            assert_eq!(met.t.to_bits(), hit.t.to_bits());
        }
    }
    assert!(kinds.iter().all(|&count| count > 0), "the trace has rays of every kind: {kinds:?}");
}

/// A shadow ray leaves the hit of its node and ends at the light.
#[test]
fn shadow_rays_go_from_their_hit_to_their_light() {
    let trace = golden("v1_0_cornell.rtrace");
    let frame = trace.meta().first_frame;
    let mut parent = None;
    for ray in (0..trace.meta().tile_count()).flat_map(|tile| trace.rays(frame, tile).expect("it decodes")) {
        match ray.end {
            RayEnd::Hit(hit) => parent = Some((ray, hit)),
            RayEnd::Sky => parent = None,
            RayEnd::Light { light, .. } => {
                let (from, hit) = parent.expect("a shadow ray follows the ray whose hit it leaves");
                let corners = trace.bvh().corners(hit.triangle as usize);
                let surface = rays::surface(&from.ray, hit.t, corners, hit.normal);
                assert_eq!(ray.ray, rays::shadow(&surface, &trace.meta().lights[light]));
                assert_eq!((ray.node, ray.sample), (from.node, from.sample));
            }
        }
    }
}
