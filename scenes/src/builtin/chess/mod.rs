//! `chess`: the start position, glass against dark polished wood, on a reflecting board. 42,000
//! triangles.

mod foot;
mod knight;
mod men;

use glam::{DVec2, DVec3, Vec3};

use self::men::PieceKind;
use crate::{
    camera,
    error::SceneError,
    modelling::{
        Part, SceneBuilder, backdrop, block, builder,
        lathe::lathe,
        paint,
        profile::{c, s, sample},
    },
    scene::{Camera, Scene},
};

/// Frames of the turn round the board.
const FRAMES: u32 = 120;
/// How deep the feet of the pieces stand in the board.
const SUNK: f64 = 0.01;
/// Radius of the room, and where its panelling starts and ends.
const ROOM: f64 = 46.0;
const PANELLING: [f64; 2] = [-20.0, 16.0];
/// The pieces of the first rank, from the a-file.
const RANK: [PieceKind; 8] = {
    use PieceKind::{Bishop, King, Knight, Queen, Rook};
    [Rook, Knight, Bishop, Queen, King, Bishop, Knight, Rook]
};

/// The scene with its orbit; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("chess");
    room(&mut out);
    table(&mut out);
    board(&mut out);
    let glass = out.material(builder::glass("glass", [0.965, 0.985, 0.975], 1.5));
    let ebony = out.material(builder::polished("ebony", [0.075, 0.026, 0.018], 0.075, 220));
    side(&mut out, "glass", glass, 1.0);
    side(&mut out, "ebony", ebony, -1.0);
    out.point_light([5.0, 11.0, -3.5], [0.94, 0.87, 0.76]);
    out.point_light([-8.0, 8.0, 6.0], [0.36, 0.40, 0.46]);
    out.sky([0.05, 0.12, 0.32], [0.38, 0.50, 0.68], [0.13, 0.11, 0.10], 0.50);
    let hero =
        Camera { eye: Vec3::new(4.7, 4.3, 10.4), target: Vec3::new(-0.1, 0.2, 0.35), up: Vec3::Y, vfov_deg: 29.5 };
    out.finish(camera::orbit(hero, FRAMES, 0.8))
}

/// The sixteen pieces of one side; `front` is 1 for the side near the camera, whose pieces look
/// along -z.
fn side(out: &mut SceneBuilder, name: &str, material: u32, front: f64) {
    for (file, kind) in RANK.into_iter().enumerate() {
        let x = file as f64 - 3.5;
        let letter = char::from(b'a' + file as u8);
        let men = [(kind, 3.5), (PieceKind::Pawn, 2.5)];
        for (kind, rank) in men {
            let parts = men::piece(kind);
            // Knights look at the enemy, turned towards the middle; they are modelled looking along x.
            let inward = if x < 0.0 { -40.0 } else { 40.0 };
            let turn = if kind == PieceKind::Bishop {
                // The cut of the mitre towards the camera.
                -38.0
            } else if front > 0.0 {
                90.0 + inward
            } else {
                -90.0 - inward
            };
            // Glass on the very plane of the board would let rounding choose which of the two a ray meets first.
            let place = |part: &Part| part.clone().turned(turn).at(x, -SUNK, rank * front);
            let mut parts = parts.iter();
            if let Some(first) = parts.next() {
                out.object(&format!("{name} {} {letter}", kind.name()), &place(first), material);
            }
            parts.for_each(|part| out.extend(&place(part), material));
        }
    }
}

/// Sixty-four squares, one object each, in a frame.
fn board(out: &mut SceneBuilder) {
    let maple = out.texture(paint::paint("maple", 256, |u, v| {
        paint::wood(u, v, 1.0, DVec3::new(0.50, 0.32, 0.16), DVec3::new(0.80, 0.62, 0.38))
    }));
    let walnut = out.texture(paint::paint("walnut", 256, |u, v| {
        paint::wood(u, v, 1.0, DVec3::new(0.045, 0.02, 0.012), DVec3::new(0.16, 0.075, 0.038))
    }));
    let square = |out: &mut SceneBuilder, name: &str, map: usize| {
        let mut material = builder::mirror(name, [1.0; 3], [0.17, 0.17, 0.18], 300);
        material.diffuse_map = Some(map);
        out.material(material)
    };
    let squares = [square(out, "dark square", walnut), square(out, "light square", maple)];
    for rank in 0..8 {
        for file in 0..8 {
            let (x, z) = (f64::from(file) - 4.0, 4.0 - f64::from(rank));
            let mut part = block::rectangle(DVec3::new(x, 0.0, z), DVec3::X, DVec3::NEG_Z);
            // Each square is cut from another place of the plank.
            let shift = DVec2::new(
                f64::from(file) * 0.37 + f64::from(rank) * 0.61,
                f64::from(rank) * 0.23 + f64::from(file) * 0.41,
            );
            part.uvs.iter_mut().for_each(|uv| *uv = *uv * DVec2::new(0.9, 0.45) + shift);
            let name = format!("square {}{}", char::from(b'a' + file as u8), rank + 1);
            out.object(&name, &part, squares[usize::from((file + rank) % 2 != 0)]);
        }
    }
    let frame = out.material(builder::polished("frame", [0.105, 0.034, 0.018], 0.06, 160));
    out.object("frame", &frame_part(), frame);
}

/// A square ring with rounded edges: the profile's radius is the distance from the middle of the board.
fn frame_part() -> Part {
    let knots = [
        c(4.58, -0.34),
        s(4.66, -0.30),
        s(4.68, -0.14),
        s(4.60, 0.01),
        s(4.50, 0.035),
        s(4.12, 0.035),
        s(4.03, 0.02),
        c(4.0, -0.02),
    ];
    let profile = sample(&knots, 0.08);
    Part::grid(profile.len(), 4, true, |row, column| {
        let (r, y) = (profile[row].x, profile[row].y);
        let [x, z] = [[-r, r], [r, r], [r, -r], [-r, -r]][column];
        DVec3::new(x, y, z)
    })
}

/// The panelled wall of the room round the table.
fn room(out: &mut SceneBuilder) {
    let panels = out.texture(paint::paint("panelling", 512, |u, v| {
        // One tall panel: its field stands back behind a moulding that is lit from above.
        let (x, y) = (u.min(1.0 - u) - 0.13, v.min(1.0 - v) - 0.10);
        let depth = x.min(y * 1.5) / 0.045;
        let light = if depth <= 0.0 || depth >= 1.0 {
            if depth <= 0.0 { 1.0 } else { 0.86 }
        } else if y * 1.5 < x {
            if v < 0.5 { 2.0 } else { 0.4 }
        } else if u < 0.5 {
            0.6
        } else {
            1.3
        };
        let worn = paint::cloud(u * 5.0, v * 9.0, 4, 23);
        DVec3::new(0.031, 0.064, 0.055) * (light * (0.8 + 0.4 * worn))
    }));
    let mut wall = builder::matte("panelling", [1.0; 3]);
    wall.diffuse_map = Some(panels);
    let wall = out.material(wall);
    out.object("wall", &backdrop::ring(ROOM, PANELLING, 72, DVec2::new(24.0, 3.0)), wall);
}

/// A round wooden table.
fn table(out: &mut SceneBuilder) {
    let planks = out.texture(paint::paint("oak", 1024, |u, v| {
        paint::wood(u * 2.0, v, 13.0, DVec3::new(0.075, 0.034, 0.016), DVec3::new(0.25, 0.125, 0.058))
    }));
    let mut top = builder::polished("table", [1.0; 3], 0.035, 60);
    top.diffuse_map = Some(planks);
    let top = out.material(top);
    let edge = out.material(builder::polished("table edge", [0.16, 0.08, 0.04], 0.04, 60));
    let at = |part: Part| part.at(0.0, -0.34, 0.0);
    let disc = lathe(&[DVec2::new(10.6, 0.0), DVec2::new(0.0, 0.0)], 72).planar_uv(DVec2::ZERO, 21.6);
    out.object("table", &at(disc), top);
    let rim = [c(0.0, -0.7), c(9.8, -0.7), s(10.7, -0.5), s(10.85, -0.2), s(10.75, 0.0), c(10.6, 0.0)];
    out.extend(&at(lathe(&sample(&rim, 0.4), 72)), edge);
}
