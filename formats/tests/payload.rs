//! Metadata, cameras and trees: what goes in comes out, and what cannot be is refused for the right reason.

mod trace_support;

use std::sync::Arc;

use rayreel_formats::budget::Budget;
use rayreel_formats::bvh::{Bvh, MAX_TREE_DEPTH, Shape, Triangle, Vertex};
use rayreel_formats::math::vec3;
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Camera, Light, Meta};
use rayreel_formats::{Error, Limits};
use trace_support::{Random, soup};

const LEAF: fn(u8) -> Shape = Shape::Leaf;
const INNER: Shape = Shape::Inner;

fn triangle(vertices: [u32; 3]) -> Triangle {
    Triangle { vertices, object: 0, material: 0 }
}

/// A tree of this shape over so many equal triangles.
fn tree(shape: &[[Shape; 2]], triangles: usize) -> Result<Bvh, String> {
    let vertex = |x: f32| Vertex { position: vec3(x, x * x, 1.0), normal: Oct::default() };
    let vertices = (0..3u8).map(|i| vertex(f32::from(i))).collect();
    Bvh::new(shape, vec![triangle([0, 1, 2]); triangles], vertices, vec!["o".into()], soup::materials())
}

#[test]
fn trees_come_back() {
    for seed in 0..300 {
        let random = &mut Random(seed);
        let most = [5, 60, 600][random.below(3) as usize];
        let count = random.below(most);
        let before = soup::bvh(random, count);
        let bytes = before.to_payload().expect("it encodes");
        let after = Bvh::from_payload(&bytes, &Limits::default()).expect("it decodes");
        assert_eq!(before, after, "seed {seed}");
        assert_eq!(after.to_payload().expect("it encodes"), bytes, "seed {seed}");
        // Boxes are exact: each is the box of the corners below it.
        let all = before.triangles.iter().flat_map(|t| t.vertices).map(|v| before.vertices[v as usize].position);
        let around = all.fold(rayreel_formats::bvh::Aabb::EMPTY, |b, p| b.with(p));
        assert_eq!(after.bounds(), around, "seed {seed}");
    }
}

#[test]
fn shapes_that_are_not_one_tree_are_refused() {
    assert!(tree(&[[LEAF(1), LEAF(2)]], 3).is_ok());
    assert!(tree(&[[INNER, LEAF(2)], [LEAF(0), LEAF(1)]], 3).is_ok());
    let refused: [(&str, &[[Shape; 2]], usize, &str); 8] = [
        ("no node", &[], 0, "not possible"),
        ("a leaf too large", &[[LEAF(5), LEAF(0)]], 5, "leaf of 5 triangles"),
        ("more triangles in leaves than there are", &[[LEAF(2), LEAF(2)]], 3, "leaf of 2 triangles"),
        ("triangles in no leaf", &[[LEAF(1), LEAF(1)]], 3, "2 of 3 triangles"),
        ("a child that is not there", &[[INNER, LEAF(1)]], 1, "a child that is not there"),
        ("a child too few", &[[INNER, INNER], [LEAF(1), LEAF(1)]], 3, "a child that is not there"),
        ("a node in no tree", &[[LEAF(1), LEAF(1)], [LEAF(1), LEAF(0)]], 3, "reaches 1 of 2 nodes"),
        ("a wild leaf", &[[LEAF(254), LEAF(0)]], 254, "leaf of 254 triangles"),
    ];
    for (name, shape, triangles, reason) in refused {
        let error = tree(shape, triangles).expect_err(name);
        assert!(error.contains(reason), "{name}: {error}");
    }
}

/// A chain of inner nodes, each the child of the last on the side that `side` says.
fn chain(depth: usize, side: impl Fn(usize) -> usize) -> Vec<[Shape; 2]> {
    let mut shape = vec![[LEAF(0); 2]; depth];
    for (i, node) in shape.iter_mut().enumerate().take(depth - 1) {
        node[side(i)] = INNER;
    }
    shape
}

/// Every path down counts, whichever side it takes: each visit may put the other child aside.
#[test]
fn trees_deeper_than_the_stacks_are_refused() {
    let sides: [fn(usize) -> usize; 3] = [|_| 0, |_| 1, |i| i % 2];
    for side in sides {
        assert!(tree(&chain(MAX_TREE_DEPTH, side), 0).is_ok());
        let error = tree(&chain(MAX_TREE_DEPTH + 1, side), 0).expect_err("one node too deep");
        assert!(error.contains("deeper than"), "{error}");
        assert!(tree(&chain(100_000, side), 0).is_err());
    }
}

#[test]
fn triangles_name_what_is_there() {
    let vertices = || vec![Vertex { position: vec3(0.0, 1.0, 2.0), normal: Oct::default() }; 3];
    let make =
        |t: Triangle, v: Vec<Vertex>| Bvh::new(&[[LEAF(1), LEAF(0)]], vec![t], v, vec!["o".into()], soup::materials());
    assert!(make(triangle([0, 1, 2]), vertices()).is_ok());
    assert!(make(triangle([0, 1, 3]), vertices()).is_err_and(|e| e.contains("vertex")));
    assert!(make(Triangle { object: 1, ..triangle([0; 3]) }, vertices()).is_err_and(|e| e.contains("object")));
    assert!(make(Triangle { material: 8, ..triangle([0; 3]) }, vertices()).is_err_and(|e| e.contains("material")));
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        let mut vertices = vertices();
        vertices[2].position.y = bad;
        assert!(make(triangle([0, 1, 2]), vertices).is_err_and(|e| e.contains("finite")));
    }
}

#[test]
fn tree_payloads_that_lie_are_refused() {
    let bytes = soup::bvh(&mut Random(1), 50).to_payload().expect("it encodes");
    let decode = |bytes: &[u8]| Bvh::from_payload(bytes, &Limits::default());
    for len in 0..bytes.len() {
        assert!(decode(&bytes[..len]).is_err(), "{len} bytes");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    assert!(decode(&longer).is_err());
    // The last byte is the highest of a normal's code, which has two.
    let mut more = bytes.clone();
    *more.last_mut().expect("it is not empty") += 1;
    assert!(decode(&more).is_err());
    for count in 0..4 {
        for value in [0, 1, u32::MAX, 1 << 28] {
            let mut forged = bytes.clone();
            forged[4 * count..4 * count + 4].copy_from_slice(&value.to_le_bytes());
            assert!(decode(&forged).is_err(), "count {count} of {value}");
        }
    }
    let over = |limits| matches!(Bvh::from_payload(&bytes, &limits), Err(Error::LimitExceeded { .. }));
    assert!(over(Limits { max_triangles: 49, ..Limits::default() }));
    assert!(over(Limits { max_bvh_nodes: 3, ..Limits::default() }));
    assert!(over(Limits { memory: Arc::new(Budget::new(bytes.len() as u64 + 2000)), ..Limits::default() }));
}

fn meta() -> Meta {
    soup::meta(&mut Random(3), (640, 480), 32, 4, 3)
}

fn refusal(meta: &Meta) -> Option<String> {
    let bytes = meta.to_payload().expect("it encodes");
    Meta::from_payload(&bytes, &Limits::default()).err().map(|e| e.to_string())
}

#[test]
fn metadata_comes_back_and_fills_its_bytes() {
    let bytes = meta().to_payload().expect("it encodes");
    assert_eq!(Meta::from_payload(&bytes, &Limits::default()).expect("it decodes"), meta());
    for len in 0..bytes.len() {
        assert!(Meta::from_payload(&bytes[..len], &Limits::default()).is_err(), "{len} bytes");
    }
    let mut longer = bytes.clone();
    longer.push(0);
    let error = Meta::from_payload(&longer, &Limits::default()).expect_err("a byte too many");
    assert!(error.to_string().contains("1 bytes left over"), "{error}");
    let limits = Limits { max_metadata_bytes: bytes.len() as u64 - 1, ..Limits::default() };
    assert!(matches!(Meta::from_payload(&bytes, &limits), Err(Error::LimitExceeded { .. })));
}

#[test]
fn impossible_metadata_is_refused() {
    assert_eq!(refusal(&meta()), None);
    let point = |x: f32| Light::Point { position: vec3(0.0, x, 0.0), colour: vec3(1.0, 1.0, 1.0) };
    let colour = |x: f32| Light::Directional { to_light: vec3(0.0, 1.0, 0.0), colour: vec3(1.0, x, 1.0) };
    type Change = Box<dyn Fn(&mut Meta)>;
    let cases: Vec<(&str, Change)> = vec![
        ("image width", Box::new(|m| m.width = 0)),
        ("image height", Box::new(|m| m.height = 0)),
        ("image width", Box::new(|m| m.width = (1 << 20) + 1)),
        ("image height", Box::new(|m| (m.height, m.samples) = ((1 << 19) + 1, 2))),
        ("image width", Box::new(|m| m.width = u32::MAX)),
        ("samples per pixel", Box::new(|m| m.samples = 0)),
        ("samples per pixel", Box::new(|m| m.samples = 9)),
        ("tile edge", Box::new(|m| m.tile = 0)),
        ("tile edge", Box::new(|m| m.tile = 1025)),
        ("number of frames", Box::new(|m| m.frames = 0)),
        ("number of frames", Box::new(|m| (m.first_frame, m.frames) = (u32::MAX - 1, 2))),
        ("number of frames", Box::new(|m| m.first_frame = u32::MAX)),
        ("maximum depth", Box::new(|m| m.max_depth = 15)),
        ("number of lights", Box::new(move |m| m.lights = vec![point(1.0); 17])),
        ("not finite", Box::new(move |m| m.lights[1] = point(f32::NAN))),
        ("not finite", Box::new(move |m| m.lights[2] = colour(f32::INFINITY))),
        ("not finite", Box::new(|m| m.min_weight = f32::NAN)),
        ("tiles, over the limit", Box::new(|m| m.frames = u32::MAX - m.first_frame)),
        // 2^40 tiles: their number does not fit 32 bits, and its low half is 0.
        ("tiles, over the limit", Box::new(|m| (m.width, m.height, m.tile) = (1 << 20, 1 << 20, 1))),
        ("pixels, over the limit", Box::new(|m| (m.width, m.height, m.tile) = (1 << 20, 1 << 20, 1024))),
        ("tiles, over the limit", Box::new(|m| (m.width, m.height, m.tile) = (1 << 16, 1 << 16, 1))),
    ];
    for (reason, change) in cases {
        let mut changed = meta();
        change(&mut changed);
        let error = refusal(&changed).unwrap_or_else(|| panic!("{reason}: accepted {changed:?}"));
        assert!(error.contains(reason), "{reason}: {error}");
    }
    let limits = Limits { max_samples_per_tile: 1023, ..Limits::default() };
    assert!(meta().check(&limits).is_err_and(|e| e.contains("1024 samples")));
}

/// What stands at the edge of what is allowed.
#[test]
fn extreme_metadata_is_accepted() {
    let edge = Meta { width: 1 << 20, height: 1, samples: 1, tile: 1024, ..meta() };
    let last = Meta { first_frame: u32::MAX - 1, frames: 1, max_depth: 14, ..meta() };
    let dark = Meta { lights: Vec::new(), max_depth: 0, width: 1, height: 1, ..meta() };
    for meta in [edge, last, dark] {
        assert_eq!(refusal(&meta), None, "{meta:?}");
    }
}

#[test]
fn a_camera_is_four_finite_vectors() {
    let camera = soup::camera(&mut Random(9));
    let bytes = camera.to_payload().expect("it encodes");
    assert_eq!(bytes.len(), 48, "twelve f32");
    assert_eq!(Camera::from_payload(&bytes, &Limits::default()).expect("it decodes"), camera);
    for at in 0..12 {
        for bad in [f32::NAN, f32::INFINITY] {
            let mut forged = bytes.clone();
            forged[4 * at..4 * at + 4].copy_from_slice(&bad.to_le_bytes());
            let error = Camera::from_payload(&forged, &Limits::default()).expect_err("not finite");
            assert!(error.to_string().contains("not finite"), "{error}");
        }
    }
    assert!(Camera::from_payload(&bytes[..47], &Limits::default()).is_err());
    let longer = [&bytes[..], &[0]].concat();
    assert!(Camera::from_payload(&longer, &Limits::default()).is_err());
}
