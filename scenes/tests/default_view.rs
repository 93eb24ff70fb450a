//! Where the camera stands before a model whose file has none: in a room, and in front of everything else.

use std::fmt::Write;
use std::time::{Duration, Instant};

use glam::Vec3;
use rayreel_scenes::{Camera, Light, LoadOptions, Scene, load, load_with};

/// Quads as OBJ text, each an object, each turned so that its front looks towards or away from a point.
#[derive(Default)]
struct Quads {
    text: String,
    count: usize,
}

impl Quads {
    /// The six sides of a box, with their fronts inside or outside; `without` leaves out the side with the largest z.
    fn sides(mut self, low: [f32; 3], high: [f32; 3], inside: bool, without: bool) -> Self {
        for (axis, end) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
            if without && (axis, end) == (2, 1) {
                continue;
            }
            let corner = |u: usize, v: usize| {
                let pick = |a: usize| [end, u, v][(a + 3 - axis) % 3];
                std::array::from_fn::<f32, 3, _>(|a| if pick(a) == 0 { low[a] } else { high[a] })
            };
            // From outside of the high end these go counter-clockwise.
            let mut corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
            if inside == (end == 1) {
                corners.reverse();
            }
            writeln!(self.text, "o side{}", self.count).expect("writes");
            corners.iter().for_each(|[x, y, z]| writeln!(self.text, "v {x} {y} {z}").expect("writes"));
            let at = self.count * 4;
            writeln!(self.text, "f {} {} {} {}", at + 1, at + 2, at + 3, at + 4).expect("writes");
            self.count += 1;
        }
        self
    }

    fn load(&self) -> Scene {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("a.obj");
        std::fs::write(&path, &self.text).expect("writes");
        load(path.to_str().expect("UTF-8")).unwrap_or_else(|e| panic!("{e}"))
    }
}

/// Whether the corners of a box from (-4, 0, -1) to (4, 1, 1) are in a picture.
fn sees(Camera { eye, target, up, vfov_deg }: Camera, aspect: f32) -> bool {
    let forward = (target - eye).normalize();
    let right = forward.cross(up).normalize();
    let slope = (vfov_deg.to_radians() / 2.0).tan();
    (0..8).all(|corner| {
        let at = |bit: u32, low: f32, high: f32| if corner >> bit & 1 == 0 { low } else { high };
        let arm = Vec3::new(at(0, -4.0, 4.0), at(1, 0.0, 1.0), at(2, -1.0, 1.0)) - eye;
        let depth = arm.dot(forward) * slope;
        arm.dot(right).abs() < depth * aspect && arm.dot(right.cross(forward)).abs() < depth
    })
}

/// Below 2.3 degrees the camera came no nearer to where it sees the model whole.
#[test]
fn the_whole_model_is_in_a_narrow_view() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let wide = Quads::default().sides([-4.0, 0.0, -1.0], [4.0, 1.0, 1.0], false, false);
    std::fs::write(folder.path().join("a.obj"), &wide.text).expect("writes");
    let path = folder.path().join("s.toml");
    for vfov_deg in [0.01, 1.0, 2.0, 35.0] {
        std::fs::write(&path, format!("model = \"a.obj\"\n[camera]\nvfov_deg = {vfov_deg}\n")).expect("writes");
        let camera = load(path.to_str().expect("UTF-8")).unwrap_or_else(|e| panic!("{e}")).cameras[0];
        assert!(camera.vfov_deg == vfov_deg && sees(camera, 2.0), "{camera:?}");
    }
}

/// A tall picture shows the whole model, and a wide one is as it was for 2:1.
#[test]
fn the_whole_model_is_in_a_picture_of_any_shape() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("a.obj");
    let wide = Quads::default().sides([-4.0, 0.0, -1.0], [4.0, 1.0, 1.0], false, false);
    std::fs::write(&path, &wide.text).expect("writes");
    let camera = |aspect: f64| {
        let options = LoadOptions { aspect, ..LoadOptions::default() };
        load_with(path.to_str().expect("UTF-8"), &options).unwrap_or_else(|e| panic!("{e}")).cameras[0]
    };
    for aspect in [0.25, 0.5, 1.0, 1.5, 2.0, 3.0] {
        assert!(sees(camera(aspect), aspect as f32), "{aspect}");
    }
    assert_eq!(camera(3.0), camera(2.0));
    assert_eq!(camera(2.0), wide.load().cameras[0]);
}

fn stands_inside(scene: &Scene) -> bool {
    let (low, high) = scene.bounds();
    let eye = scene.cameras[0].eye;
    eye.cmpgt(low).all() && eye.cmplt(high).all()
}

fn room() -> Quads {
    Quads::default().sides([-3.0, 0.0, -2.0], [3.0, 2.5, 2.0], true, false)
}

/// A ball of quads with its fronts inside or outside.
fn ball(inside: bool) -> Quads {
    const STEPS: usize = 24;
    let mut quads = Quads::default();
    let at = |row: usize, column: usize| {
        let [up, around] =
            [row as f32 / STEPS as f32, column as f32 / STEPS as f32 * 2.0].map(|x| x * std::f32::consts::PI);
        Vec3::new(up.sin() * around.sin(), up.cos(), up.sin() * around.cos()) * 4.0
    };
    for (row, column) in (0..STEPS).flat_map(|row| (0..STEPS).map(move |column| (row, column))) {
        let mut corners = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        if inside {
            corners.reverse();
        }
        corners.iter().for_each(|v| writeln!(quads.text, "v {} {} {}", v.x, v.y, v.z).expect("writes"));
        let first = quads.count * 4 + 1;
        writeln!(quads.text, "f {} {} {} {}", first, first + 1, first + 2, first + 3).expect("writes");
        quads.count += 1;
    }
    quads
}

/// Half of the box of a ball is outside of it.
#[test]
fn a_ball_is_a_room_if_its_fronts_are_inside() {
    assert!(stands_inside(&ball(true).load()));
    assert!(!stands_inside(&ball(false).load()));
}

#[test]
fn a_room_is_seen_and_lit_from_inside() {
    let table = |quads: Quads| quads.sides([-2.0, 0.0, -1.0], [0.5, 0.8, 0.0], false, false);
    for (name, quads) in [
        ("empty", room()),
        ("with a table", table(room())),
        ("without a wall", table(Quads::default().sides([-3.0, 0.0, -2.0], [3.0, 2.5, 2.0], true, true))),
    ] {
        let scene = quads.load();
        assert!(stands_inside(&scene), "{name}: {:?}", scene.cameras[0]);
        let (low, high) = scene.bounds();
        for light in &scene.lights {
            let Light::Point { position, .. } = light else { panic!("{name}: {light:?}") };
            assert!(position.cmpgt(low).all() && position.cmplt(high).all(), "{name}: {position}");
        }
        let camera = scene.cameras[0];
        assert_eq!((camera.vfov_deg, camera.up), (50.0, Vec3::Y), "{name}");
        assert!((camera.target - camera.eye).length() > 1.0, "{name}: the view is long: {camera:?}");
    }
    assert_eq!(room().load().cameras, room().load().cameras);
}

#[test]
fn objects_are_seen_from_outside() {
    let floor = |quads: Quads| quads.sides([-9.0, -0.1, -9.0], [9.0, 0.0, 9.0], false, false);
    let body = |quads: Quads| quads.sides([-1.0, 0.0, -1.0], [1.0, 2.0, 1.0], false, false);
    // A thick wall has two sides: what it encloses is a room only for who stands in it, and the whole a house.
    for (name, quads) in [
        ("a box", body(Quads::default())),
        ("a box on a floor", floor(body(Quads::default()))),
        ("a floor", floor(Quads::default())),
    ] {
        let scene = quads.load();
        assert!(!stands_inside(&scene), "{name}: {:?}", scene.cameras[0]);
        assert_eq!(scene.cameras[0].vfov_deg, 35.0, "{name}");
    }
}

#[test]
fn a_room_of_many_triangles_takes_no_second_more() {
    // A wavy floor of 200,000 triangles in a room.
    let mut quads = room();
    let (steps, base) = (316_usize, quads.count * 4);
    for k in 0..steps * steps {
        let (x, z) = ((k % steps) as f32 / (steps - 1) as f32, (k / steps) as f32 / (steps - 1) as f32);
        let y = 0.2 + 0.05 * ((k % 7) as f32 / 7.0);
        writeln!(quads.text, "v {} {y} {}", 5.8 * x - 2.9, 3.8 * z - 1.9).expect("writes");
    }
    for k in (0..steps * (steps - 1)).filter(|k| k % steps + 1 < steps) {
        let a = base + k + 1;
        writeln!(quads.text, "f {a} {} {} {}", a + steps, a + steps + 1, a + 1).expect("writes");
    }
    let start = Instant::now();
    let scene = quads.load();
    let taken = start.elapsed();
    assert!(scene.mesh.triangles.len() > 198_000 && stands_inside(&scene));
    // Reading takes most of it; a search over all triangles for each ray would take minutes.
    assert!(taken < Duration::from_secs(60), "{taken:?}");
}
