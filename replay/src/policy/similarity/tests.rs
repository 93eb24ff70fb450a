//! The tests of two samples, by hand.

use super::*;
use rayreel_formats::math::vec3;
use rayreel_formats::tile::Shadows;

fn surface() -> SurfacePoint {
    let (normal, position) = (vec3(0.0, 0.0, 1.0), vec3(0.0, 0.0, -10.0));
    SurfacePoint { object: 1, shadows: Shadows(5), normal, position, t: 10.0 }
}

fn node(surface: Option<SurfacePoint>, colour: Vec3) -> Node {
    Node { surface, local: colour, colour, reflect: None, refract: None, hit_rays: 3, rays: 3, len: 1, age: 0 }
}

fn pass(rules: &Similarity, a: &Node, b: &Node, gap: u32) -> bool {
    let slice = std::slice::from_ref;
    Tests::new(rules, 1.0).similar(slice(a), slice(b), gap, f64::INFINITY, &mut Compared::default())
}

fn similar(rules: &Similarity, a: SurfacePoint, b: SurfacePoint) -> bool {
    pass(rules, &node(Some(a), Vec3::ZERO), &node(Some(b), Vec3::ZERO), 2)
}

#[test]
fn each_test_can_be_switched() {
    let a = surface();
    let object = SurfacePoint { object: 2, ..a };
    assert!(similar(&Similarity::NONE, a, object));
    assert!(!similar(&Similarity { object_id: true, ..Similarity::NONE }, a, object));
    let shadow = SurfacePoint { shadows: Shadows(6), ..a };
    assert!(similar(&Similarity::NONE, a, shadow));
    assert!(!similar(&Similarity { shadow: true, ..Similarity::NONE }, a, shadow));
}

#[test]
fn angles_are_inclusive_and_equal_normals_pass_at_zero() {
    let a = surface();
    let limit = |deg| Similarity { normal_deg: Limit::At(deg), ..Similarity::NONE };
    let tilted = |deg: f64| {
        let r = deg.to_radians();
        SurfacePoint { normal: vec3(libm::sin(r) as f32, 0.0, libm::cos(r) as f32), ..a }
    };
    assert!(similar(&limit(12.0), a, tilted(11.999)));
    assert!(!similar(&limit(12.0), a, tilted(12.001)));
    let odd = SurfacePoint { normal: vec3(0.3, 0.7, -0.2).normalized(), ..a };
    assert!(similar(&limit(0.0), odd, odd));
    assert!(similar(&limit(180.0), a, SurfacePoint { normal: -a.normal, ..a }));
}

#[test]
fn distances_are_relative_to_the_shorter_ray() {
    let a = surface();
    let beside = SurfacePoint { position: vec3(1.0, 0.0, -10.0), t: 20.0, ..a };
    let behind = SurfacePoint { position: vec3(0.0, 0.0, -11.0), t: 11.0, ..a };
    let position = |v| Similarity { position: Limit::At(v), ..Similarity::NONE };
    assert!(similar(&position(0.1), a, beside) && !similar(&position(0.09), a, beside));
    let plane = |v| Similarity { plane: Limit::At(v), ..Similarity::NONE };
    assert!(similar(&plane(0.0), a, beside));
    assert!(similar(&plane(0.1), a, behind) && !similar(&plane(0.09), a, behind));
}

#[test]
fn surfaces_bend_one_way() {
    let one_way = |a: [f32; 3], b: [f32; 3], limit: f64| {
        let first = SurfacePoint { normal: Vec3::from(a).normalized(), ..surface() };
        let position = first.position + vec3(2.0, 0.0, 0.0);
        let second = SurfacePoint { normal: Vec3::from(b).normalized(), position, ..first };
        let like = |a, b| similar(&Similarity { convexity: Limit::At(limit), ..Similarity::NONE }, a, b);
        assert_eq!(like(first, second), like(second, first));
        like(first, second)
    };
    let (left, up, right) = ([-0.6, 0.0, 0.8], [0.0, 0.0, 1.0], [0.6, 0.0, 0.8]);
    assert!(one_way(left, right, 0.0), "convex");
    assert!(one_way(right, left, 0.0), "concave");
    assert!(one_way(up, up, 0.0), "flat");
    assert!(one_way(up, right, 0.0), "flat, then falling");
    assert!(!one_way(right, right, 0.59) && one_way(right, right, 0.61), "a step");
    assert!(!one_way(left, [-0.8, 0.0, 0.6], 0.59), "an S-bend");
}

#[test]
fn sky_is_like_sky_only() {
    let (sky, hit) = (node(None, Vec3::ZERO), node(Some(surface()), Vec3::ZERO));
    let similar = |a, b| pass(&Similarity::NONE, a, b, 2);
    assert!(similar(&sky, &sky) && !similar(&sky, &hit) && !similar(&hit, &sky));
}

/// Square roots 0.5 and 0.6, so a difference of 0.11 / (1.1 + DARK).
#[test]
fn colours_are_compared_as_displayed() {
    let grey = |v: f32| vec3(v, v, v);
    let (a, b) = (grey(0.25), grey(0.36));
    let expected = 0.11 / (1.1 + DARK);
    assert!((difference((a, b), (a, b)) - expected).abs() < 1.0e-7);
    assert_eq!(difference((grey(2.0), grey(7.0)), (grey(2.0), grey(7.0))), 0.0, "both are displayed as white");
    let limit = |v| Similarity { colour: Limit::At(v), ..Similarity::NONE };
    let (a, b) = (node(Some(surface()), a), node(Some(surface()), b));
    assert!(pass(&limit(expected + 1.0e-6), &a, &b, 2) && !pass(&limit(expected - 1.0e-6), &a, &b, 2));
    assert!(pass(&limit(2.0 * expected + 1.0e-6), &a, &b, 4), "half the limit across twice the gap");
    assert!(!pass(&limit(2.0 * expected - 1.0e-6), &a, &b, 4));
    let dear = |n: &Node| Node { rays: 12, ..*n };
    assert!(pass(&limit(expected / 2.0 + 1.0e-6), &dear(&a), &dear(&b), 2), "twice the limit for four times the rays");
    assert!(!pass(&limit(expected / 2.0 - 1.0e-6), &dear(&a), &dear(&b), 2));
    let broken = Node { colour: grey(f32::NAN), ..b };
    assert!(!pass(&limit(1.0), &a, &broken, 2), "a NaN is like nothing");
}

#[test]
fn secondary_hits_are_compared_where_colours_do_not_excuse_them() {
    let weight = Some(vec3(0.5, 0.5, 0.5));
    let tree = |object| {
        let child = node(Some(SurfacePoint { object, ..surface() }), Vec3::ZERO);
        [Node { reflect: weight, len: 2, rays: 6, ..node(Some(surface()), Vec3::ZERO) }, child]
    };
    let (a, b) = (tree(5), tree(6));
    let run = |rules: &Similarity| {
        let mut compared = Compared::default();
        let like = Tests::new(rules, 1.0).similar(&a, &b, 2, f64::INFINITY, &mut compared);
        (like, compared.pairs)
    };
    let ids = Similarity { object_id: true, ..Similarity::NONE };
    assert_eq!(run(&ids), (true, 1), "primary hits only");
    assert_eq!(run(&Similarity { secondary: true, ..ids.clone() }), (false, 2));
    assert_eq!(run(&Similarity { secondary: true, ..Similarity::NONE }), (true, 2));
    let near = Similarity { secondary: true, colour: Limit::At(0.1), ..ids };
    assert_eq!(run(&Similarity { unlike: Limit::At(0.5), ..near.clone() }), (true, 1));
    // What excuses unlike primary hits excuses what lies below alike ones too; where colours come first, no hit is looked at.
    let excused = Similarity { unlike_primary: Limit::At(0.5), ..near.clone() };
    assert_eq!(run(&near), (false, 2));
    assert_eq!(run(&excused), (true, 1));
    assert_eq!(run(&Similarity { first: First::Colours, ..excused }), (true, 0));
}
