//! What stand-ins do to a picture. A stand-in is the recorded child that takes the place of an interpolated hit's child. Here the
//! ray that hardware would shoot from the interpolated position and normal is really traced, and takes the stand-in's place.

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::{self, Ray, Surface};
use rayreel_formats::scene::{Camera, Rect};
use rayreel_formats::tile::{Column, RayKind, Tile, composite};
use rayreel_formats::trace::Trace;
use rayreel_replay::TileSource;
use rayreel_replay::image::resolve::Resolver;
use rayreel_replay::image::srgb::encode;
use rayreel_tracer::{TraceSettings, Tracer, build};

use crate::common::capture;
use crate::common::trace::open;
use rayreel_testkit::past::Traced;
use rayreel_testkit::reference::{self, Outcome};
use rayreel_testkit::{preset, rules::Hit};

/// What was measured over the children of interpolated hits.
#[derive(Default)]
struct Measured {
    /// Angle between the shot and the recorded ray, degrees, where the recorded hit is on the interpolated one's object.
    degrees: Vec<f64>,
    /// Children whose recorded parent is on another object, or reflects totally where the interpolated one does not.
    other: usize,
    /// Pictures against `full`, dB: with stand-ins, with rays that were shot, and (to see that shooting is right) with the
    /// recorded rays shot again.
    psnr: [f64; 3],
}

impl Measured {
    /// Mean, median, 99th percentile and maximum of the angles; share of other objects.
    fn figures(&mut self, what: &str) -> [f64; 5] {
        self.degrees.sort_by(f64::total_cmp);
        let n = self.degrees.len();
        let at = |share: f64| self.degrees[((n - 1) as f64 * share) as usize];
        let mean = self.degrees.iter().sum::<f64>() / n as f64;
        let figures = [mean, at(0.5), at(0.99), at(1.0), self.other as f64 / (n + self.other) as f64];
        let [mean, median, most, max, other] = figures;
        println!(
            "{what}: {n} children on the same object, {:.2} % on another; angle mean {mean:.3}, median {median:.3}, 99 % \
             {most:.3}, max {max:.3} degrees; PSNR {:.2} dB with stand-ins, {:.2} dB with rays shot, {:.2} dB with the recorded ones",
            100.0 * other,
            self.psnr[0],
            self.psnr[1],
            self.psnr[2]
        );
        figures
    }
}

/// The hit that hardware has: the interpolated point and normal, and nothing of the triangle. New rays start off the surface
/// by `sag`, how far a chord of the surface may lie below it, beside the usual offset.
fn interpolated(eye: Vec3, hit: &Hit, front: bool, sag: f32) -> (Vec3, Surface) {
    let surface = hit.surface.unwrap();
    let (point, normal) = (Vec3::from(surface.position), Vec3::from(surface.normal));
    let to = point - eye;
    let direction = to.normalized();
    let mut normal = if front { normal } else { -normal };
    // As where a tracer takes the face normal, which hardware has not: the ray just passes.
    if normal.dot(direction) >= 0.0 {
        normal = (normal - direction * (normal.dot(direction) * 1.000_1)).normalized();
    }
    let offset = point.max_abs().max(to.length()) / 131_072.0 + sag;
    (direction, Surface { point, face: normal, normal, cosine: -normal.dot(direction), front, offset })
}

fn child(surface: &Surface, direction: Vec3, kind: RayKind, ior: f32) -> Option<Ray> {
    match kind {
        RayKind::Reflection => Some(rays::reflection(surface, direction)),
        _ => rays::refraction(surface, direction, ior),
    }
}

/// The colour that a ray brings: a camera whose only sample is this ray, and as wide as one of `frame`'s, so that textures
/// are filtered alike.
fn shoot(tracer: &Tracer<'_>, frame: &Camera, ray: &Ray) -> Vec3 {
    let spread = frame.down.length() / frame.corner.length();
    let (corner, down) = (ray.direction * (1.0 - 0.5 * spread), ray.direction * spread);
    let camera = Camera { eye: ray.origin, corner, right: Vec3::ZERO, down };
    tracer.colours(&camera, Rect { x: 0, y: 0, width: 1, height: 1 })[0]
}

/// The children directly below the primary hit of a sample that were traced: node, weight in the interpolated tree, and colour.
fn stand_ins(tile: &Tile, sample: usize, traced: &[Traced], hit: &Hit) -> Vec<(usize, Vec3, Vec3)> {
    let range = tile.tree.sample(sample);
    let firsts: Vec<_> = range.clone().filter(|&node| tile.tree.nodes[node].class.depth() == 1).collect();
    let weights = hit.below.iter().flatten().map(|(weight, _)| Vec3::from(*weight));
    let ends = firsts.iter().skip(1).copied().chain([range.end]);
    let all = firsts.iter().zip(ends).zip(weights).map(|((&node, end), weight)| {
        (node, weight, composite(&tile.tree.nodes[node..end], &tile.radiance[node..end]))
    });
    all.filter(|(node, ..)| traced[node - range.start].hit).collect()
}

fn measure(scene: &str, trace: &Trace, block: u32) -> Measured {
    let frame = trace.meta().first_frame;
    let camera = TileSource::camera(trace, frame).unwrap();
    let loaded = rayreel_scenes::load(scene).unwrap();
    let built = build(&loaded).unwrap();
    // A child has a bounce less before it.
    let tracer = Tracer::new(&loaded, &built, TraceSettings { max_depth: 3, ..TraceSettings::default() });
    let mut policy = preset("multirate", block);
    policy.sampling.stand_in = true;
    let outcome = reference::replay(trace, &policy, frame);
    let tiles: Vec<Tile> =
        (0..trace.meta().tile_count()).map(|i| trace.tile(frame, i, &Column::ALL).unwrap()).collect();
    let mut found = Measured::default();
    let mut colours = outcome.colours.clone();
    let mut control = outcome.colours.clone();
    for (at, hit) in &outcome.stand_ins {
        let (x, y) = ((at % outcome.width) as u32, (at / outcome.width) as u32);
        let columns = trace.meta().tile_grid().0;
        let tile = &tiles[(y / trace.meta().tile * columns + x / trace.meta().tile) as usize];
        let sample = ((y - tile.rect.y) * tile.rect.width + x - tile.rect.x) as usize;
        let primary = tile.hits[tile.tree.sample(sample).start];
        let ray = rays::primary(&camera, x, y);
        let recorded = rays::surface(&ray, primary.t, tracer.traversal().corners(primary.triangle), primary.normal);
        // As far as the stand-in's point is off: hardware would take a bound on it.
        let sag = (recorded.point - Vec3::from(hit.surface.unwrap().position)).length();
        let (direction, shot) = interpolated(camera.eye, hit, recorded.front, sag);
        let ior = trace.bvh().material(primary.triangle as usize).ior;
        let same = trace.object_of(primary.triangle) == hit.surface.unwrap().object;
        for (node, weight, colour) in stand_ins(tile, sample, &outcome.traced[*at], hit) {
            let kind = tile.tree.nodes[node].class.kind();
            let (Some(stands), Some(ray)) =
                (child(&recorded, ray.direction, kind, ior), child(&shot, direction, kind, ior))
            else {
                found.other += 1;
                continue;
            };
            if same {
                found.degrees.push(angle(stands.direction, ray.direction));
            } else {
                found.other += 1;
            }
            let again = Vec3::from(control[*at]) + weight.times(shoot(&tracer, &camera, &stands) - colour);
            control[*at] = again.to_array();
            let changed = Vec3::from(colours[*at]) + weight.times(shoot(&tracer, &camera, &ray) - colour);
            colours[*at] = changed.to_array();
        }
    }
    let full: Vec<_> = tiles_colours(&tiles, &outcome);
    found.psnr = [&outcome.colours, &colours, &control].map(|picture| compare(trace, &full, picture));
    found
}

/// The recorded colours, row by row over the grid.
fn tiles_colours(tiles: &[Tile], outcome: &Outcome) -> Vec<[f32; 3]> {
    let mut all = vec![[0.0; 3]; outcome.colours.len()];
    for tile in tiles {
        for sample in 0..tile.rect.len() {
            let (x, y) = (sample % tile.rect.width as usize, sample / tile.rect.width as usize);
            let range = tile.tree.sample(sample);
            all[(tile.rect.y as usize + y) * outcome.width + tile.rect.x as usize + x] =
                composite(&tile.tree.nodes[range.clone()], &tile.radiance[range]).to_array();
        }
    }
    all
}

/// PSNR of two lists of samples as pictures of 8 bits.
fn compare(trace: &Trace, a: &[[f32; 3]], b: &[[f32; 3]]) -> f64 {
    let (meta, width) = (trace.meta(), trace.meta().grid().0);
    let picture = |colours: &[[f32; 3]]| {
        let mut resolver = Resolver::new(meta.width, meta.height, meta.samples);
        (0u32..).zip(colours).for_each(|(i, colour)| resolver.add(i % width, i / width, (*colour).into()));
        encode(&resolver.finish())
    };
    let (a, b) = (picture(a), picture(b));
    let square = |(a, b): (&u8, &u8)| u64::from(a.abs_diff(*b)).pow(2);
    let sum: u64 = a.bytes().iter().zip(b.bytes()).map(square).sum();
    10.0 * (255.0f64.powi(2) * a.bytes().len() as f64 / sum as f64).log10()
}

fn angle(a: Vec3, b: Vec3) -> f64 {
    let (half, sum) = ((a - b).length(), (a + b).length());
    2.0 * f64::from(half).atan2(f64::from(sum)).to_degrees()
}

/// Small pictures of two scenes; `RAYREEL_STAND_IN_SIZE=256x128` measures all three at that size, for POLICIES.md.
#[test]
fn stand_ins_are_near_the_rays_they_stand_for() {
    let folder = tempfile::tempdir().unwrap();
    let size = std::env::var("RAYREEL_STAND_IN_SIZE").ok();
    let scenes: &[&str] = if size.is_some() { &["chess", "lab", "teapot"] } else { &["chess", "teapot"] };
    for scene in scenes {
        let file = folder.path().join(format!("{scene}.rtrace"));
        capture(scene, &format!("--size {} --samples 2x2", size.as_deref().unwrap_or("96x48")), &file);
        let mut found = measure(scene, &open(&file), 8);
        let [mean, median, _, _, other] = found.figures(scene);
        let [stand_ins, shot, again] = found.psnr;
        // The recorded rays shot again bring what was recorded, but for the weights at which trees are cut.
        assert!((again - stand_ins).abs() < 1.0, "{scene}: {stand_ins} and {again} dB");
        // Rays of hardware cost quality: if they cost more than this, the approximation hides too much.
        assert!(stand_ins - shot < 8.0, "{scene}: {stand_ins} and {shot} dB");
        assert!(mean < 9.0 && median < 1.5 && other < 0.02, "{scene}");
    }
}
