//! The wheels of `car`: tyre, rim with spokes, brake disc.

use glam::{DVec2, DVec3};

use crate::modelling::{
    Part,
    lathe::lathe,
    part::sin_cos,
    profile::{c, s, sample},
    rounded::axis_to_z,
    sweep,
};

/// Spokes of a wheel.
const SPOKES: usize = 8;
/// Segments round tyre and rim.
const ROUND: usize = 38;

/// The parts of one right-hand wheel about its middle; the outside looks along +z.
pub struct Wheel {
    /// Rubber.
    pub tyre: Part,
    /// Polished lip and hub cap.
    pub chrome: Part,
    /// Spokes and barrel.
    pub alloy: Part,
    /// Brake disc and its bell.
    pub disc: Part,
}

/// Makes a wheel, its spokes turned by `degrees`.
pub fn wheel(degrees: f64) -> Wheel {
    let tyre = [
        c(0.206, -0.080),
        s(0.225, -0.090),
        s(0.270, -0.097),
        s(0.300, -0.088),
        c(0.313, -0.068),
        c(0.315, -0.034),
        c(0.305, -0.030),
        c(0.315, -0.026),
        c(0.315, 0.026),
        c(0.305, 0.030),
        c(0.315, 0.034),
        c(0.313, 0.068),
        s(0.300, 0.088),
        s(0.270, 0.097),
        s(0.225, 0.090),
        c(0.206, 0.080),
    ];
    let lip = [s(0.209, 0.076), s(0.210, 0.090), s(0.203, 0.095), s(0.196, 0.090), s(0.190, 0.070), c(0.183, 0.052)];
    let cap = [c(0.050, 0.045), s(0.050, 0.074), s(0.040, 0.084), s(0.018, 0.088), c(0.0, 0.088)];
    let barrel = [c(0.184, 0.054), c(0.178, -0.080)];
    let disc = [c(0.150, 0.004), c(0.150, 0.022), c(0.080, 0.022), c(0.072, 0.044), c(0.0, 0.044)];
    let turn = |profile: &[crate::modelling::profile::Knot], step: f64, segments: usize| {
        axis_to_z(lathe(&sample(profile, step), segments))
    };
    Wheel {
        tyre: turn(&tyre, 0.04, ROUND),
        chrome: turn(&lip, 0.04, ROUND).with(turn(&cap, 0.03, 16)),
        alloy: turn(&barrel, 1.0, ROUND).with(spokes(degrees)),
        disc: turn(&disc, 1.0, 32),
    }
}

fn spokes(degrees: f64) -> Part {
    let spoke = |i: usize| {
        let (sin, cos) = sin_cos(degrees.to_radians() + std::f64::consts::TAU * i as f64 / SPOKES as f64);
        let path: Vec<DVec3> = [(0.035, 0.062), (0.075, 0.064), (0.120, 0.056), (0.160, 0.050), (0.188, 0.056)]
            .map(|(r, z)| DVec3::new(r * cos, r * sin, z))
            .to_vec();
        sweep::bar(&path, DVec3::Z, DVec2::new(0.021, 0.013), 7)
    };
    (0..SPOKES).map(spoke).fold(Part::default(), Part::with)
}
