//! What a house is before it is built: its size, its walls' openings, and what closes them.

use glam::DVec3;

/// How deep a window or door stands back in the wall.
pub const REVEAL: f64 = 0.28;

/// What closes an opening.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Closing {
    /// A glazed window with shutters beside it.
    Window,
    /// A wooden door.
    Door,
}

/// A hole in a wall: centre, sill, width, height in metres.
#[derive(Clone, Copy, Debug)]
pub struct Opening {
    /// Centre along the wall.
    pub x: f64,
    /// Height of the sill.
    pub y: f64,
    /// Width.
    pub width: f64,
    /// Height.
    pub height: f64,
    /// What closes it.
    pub closing: Closing,
}

/// A window.
#[must_use]
pub const fn window(x: f64, y: f64, width: f64, height: f64) -> Opening {
    Opening { x, y, width, height, closing: Closing::Window }
}

/// A door.
#[must_use]
pub const fn door(x: f64, width: f64, height: f64) -> Opening {
    Opening { x, y: 0.0, width, height, closing: Closing::Door }
}

/// A house under a gabled roof whose ridge runs along its width.
#[derive(Clone, Debug)]
pub struct House {
    /// Name of its objects.
    pub name: &'static str,
    /// Middle of the floor.
    pub at: DVec3,
    /// Turn about the vertical axis; the front faces south at 0.
    pub degrees: f64,
    /// Width, height of the eaves, depth.
    pub size: DVec3,
    /// Rise of the ridge over the eaves.
    pub rise: f64,
    /// Openings of front, right, back and left wall.
    pub openings: [Vec<Opening>; 4],
}
