//! The camera and lights of a scene whose file has none: in front of an object, inside a room.
//!
//! A room is told by rays. From points all over the box of a model most of what can be seen of a room is its surfaces, from
//! their front, in nearly all directions. Beside an object rays leave the box; within one they meet its surfaces from
//! behind. In a room the camera stands where it sees most, clear of all surfaces, and looks where the view is longest.

mod grid;

use std::collections::BTreeSet;

use glam::{DVec3, Vec3};

use self::grid::{Grid, Hit};
use crate::{
    defaults::{self, framing_camera},
    scene::{Camera, Light, Mesh, Scene},
};

/// Vertical field of view inside a room, degrees: a room is seen whole from no place in it.
const ROOM_VFOV_DEG: f32 = 50.0;
/// Mean part of all directions in which something is met, from free points of the box of a room. An open box has 0.8.
const ROOM_CLOSED: f64 = 0.75;
/// Part of what a point sees from its front, below which the point is inside of something.
const FREE_FRONT: f64 = 0.6;
/// Points along each axis when the box is looked at.
const COARSE: usize = 4;
/// Points along each axis when a place is looked for.
const FINE: usize = 6;

/// What a file leaves open: who looks from where, and the light.
pub(crate) struct View {
    room: Option<Room>,
    /// The box that a camera should frame.
    bounds: (Vec3, Vec3),
    /// Width over height of the picture.
    aspect: f64,
}

/// A place in a room.
struct Room {
    eye: DVec3,
    target: DVec3,
    /// Places below the ceiling, over the camera and over what it looks at.
    lamps: Vec<DVec3>,
}

impl View {
    /// Looks at a mesh, for a picture of this width over height.
    pub fn of(mesh: &Mesh, aspect: f64) -> Self {
        let grid = Grid::new(mesh);
        let room = if is_room(&grid) { room(&grid) } else { None };
        Self { room, bounds: defaults::main_bounds(&mesh.positions), aspect }
    }

    /// The same, of a mesh that moves within a box.
    pub fn within(self, bounds: (Vec3, Vec3)) -> Self {
        Self { bounds, ..self }
    }

    /// A camera with the field of view that was asked for, in degrees, or one that suits the place.
    pub fn camera(&self, vfov_deg: Option<f32>) -> Camera {
        let Some(room) = &self.room else {
            return framing_camera(self.bounds, vfov_deg.unwrap_or(defaults::DEFAULT_VFOV_DEG), self.aspect);
        };
        let vfov_deg = vfov_deg.unwrap_or(ROOM_VFOV_DEG);
        Camera { eye: room.eye.as_vec3(), target: room.target.as_vec3(), up: Vec3::Y, vfov_deg }
    }

    /// The lamps of the model, else lights where they reach what the camera sees.
    pub fn lights(&self, scene: &Scene) -> Vec<Light> {
        match &self.room {
            Some(room) if !room.lamps.is_empty() && !defaults::has_lamps(scene) => {
                let colours = [Vec3::new(0.62, 0.6, 0.56), Vec3::new(0.51, 0.53, 0.55)];
                let light = |(place, colour): (&DVec3, Vec3)| Light::Point { position: place.as_vec3(), colour };
                room.lamps.iter().zip(colours).map(light).collect()
            }
            _ => defaults::lights(scene, self.bounds),
        }
    }
}

/// Directions spread evenly over the sphere.
fn directions(count: u32) -> Vec<DVec3> {
    // The golden angle.
    let turn = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let direction = |k: u32| {
        let y = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
        let radius = (1.0 - y * y).sqrt();
        let angle = turn * f64::from(k);
        DVec3::new(radius * libm::cos(angle), y, radius * libm::sin(angle))
    };
    (0..count).map(direction).collect()
}

/// What is seen around a point.
struct Around {
    /// Part of the directions in which something is met.
    closed: f64,
    /// Part of that which is met from its front.
    front: f64,
    nearest: f64,
}

fn around(grid: &Grid<'_>, point: DVec3, directions: &[DVec3]) -> Around {
    let hits: Vec<Hit> = directions.iter().filter_map(|direction| grid.cast(point, *direction)).collect();
    let front = hits.iter().filter(|hit| hit.front).count() as f64;
    Around {
        closed: hits.len() as f64 / directions.len() as f64,
        front: front / hits.len().max(1) as f64,
        nearest: hits.iter().fold(f64::INFINITY, |nearest, hit| nearest.min(hit.distance)),
    }
}

/// Points in a box, away from its sides.
fn points((low, high): (DVec3, DVec3), steps: usize) -> impl Iterator<Item = DVec3> {
    let at = move |k: usize| (k as f64 + 0.5) / steps as f64;
    (0..steps * steps * steps)
        .map(move |k| low + (high - low) * DVec3::new(at(k % steps), at(k / steps % steps), at(k / steps / steps)))
}

/// Whether the free points of the box are in a room.
fn is_room(grid: &Grid<'_>) -> bool {
    let directions = directions(96);
    let all: Vec<Around> = points(grid.bounds(), COARSE).map(|point| around(grid, point, &directions)).collect();
    let free: Vec<&Around> = all.iter().filter(|around| around.front >= FREE_FRONT).collect();
    let closed = free.iter().map(|around| around.closed).sum::<f64>() / free.len().max(1) as f64;
    // A hollow shell that looks outwards has no free point, or a few near gaps.
    // Of the box of a ball, or of a dome, half of the points are inside.
    free.len() * 2 >= all.len() && closed >= ROOM_CLOSED
}

/// The place with the best view of a room.
fn room(grid: &Grid<'_>) -> Option<Room> {
    let directions = directions(96);
    let (low, high) = grid.bounds();
    let clear = 0.05 * (high - low).min_element();
    let mut best: Option<(f64, DVec3, DVec3)> = None;
    for eye in points((low, high), FINE) {
        // As a person stands: neither on the floor nor below the ceiling.
        let height = (eye.y - low.y) / (high.y - low.y);
        let around = around(grid, eye, &directions);
        if !(0.3..0.7).contains(&height) || around.nearest < clear || around.front < 0.85 || around.closed < 0.6 {
            continue;
        }
        for view in 0..32 {
            let (angle, down) = (std::f64::consts::TAU * f64::from(view / 2) / 16.0, f64::from(view % 2));
            let forward = DVec3::new(libm::sin(angle), -0.1 - 0.2 * down, -libm::cos(angle)).normalize();
            let seen = seen(grid, eye, forward);
            if best.is_none_or(|(most, ..)| seen > most) {
                best = Some((seen, eye, forward));
            }
        }
    }
    let (_, eye, forward) = best?;
    let far = grid.cast(eye, forward).map_or((high - low).length() / 2.0, |hit| hit.distance);
    let target = eye + forward * far * 0.6;
    let below = |point: DVec3| grid.cast(point, DVec3::Y).map(|hit| point + DVec3::Y * hit.distance * 0.8);
    Some(Room { eye, target, lamps: [eye, target].into_iter().filter_map(below).collect() })
}

/// How much a view shows: how far it reaches on the whole, and of how many objects. What it misses counts nothing, and what
/// it sees from behind counts against it.
fn seen(grid: &Grid<'_>, eye: DVec3, forward: DVec3) -> f64 {
    let right = forward.cross(DVec3::Y).normalize();
    let up = right.cross(forward);
    let mut reach = 0.0;
    let mut objects = BTreeSet::new();
    for row in -2..=2 {
        for column in -4..=4 {
            let direction = forward + up * (f64::from(row) * 0.2) + right * (f64::from(column) * 0.2);
            let Some(hit) = grid.cast(eye, direction.normalize()) else { continue };
            reach += if hit.front { hit.distance } else { -hit.distance };
            objects.insert(hit.object);
        }
    }
    reach * (objects.len() as f64).sqrt()
}
