//! The six chessmen, each a list of closed solids. A square is one unit wide; the knight looks along x.

use glam::{DVec2, DVec3};

use crate::{
    builtin::chess::{foot::foot, knight},
    modelling::{
        Part, block,
        lathe::{lathe, lathe_with, sphere},
        part::sin_cos,
        profile::{Knot, c, s, sample},
    },
};

/// A kind of chessman.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PieceKind {
    /// Eight of them.
    Pawn,
    /// With battlements.
    Rook,
    /// With a horse's head.
    Knight,
    /// With a cut mitre.
    Bishop,
    /// With a coronet.
    Queen,
    /// With a cross.
    King,
}

impl PieceKind {
    /// Lower-case English name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Pawn => "pawn",
            Self::Rook => "rook",
            Self::Knight => "knight",
            Self::Bishop => "bishop",
            Self::Queen => "queen",
            Self::King => "king",
        }
    }
}

/// The solids of a piece, standing on y = 0.
pub fn piece(kind: PieceKind) -> Vec<Part> {
    match kind {
        PieceKind::Pawn => vec![pawn()],
        PieceKind::Rook => vec![rook()],
        PieceKind::Knight => knight::parts(),
        PieceKind::Bishop => vec![bishop()],
        PieceKind::Queen => queen(),
        PieceKind::King => king(),
    }
}

fn turned(knots: &[Knot], step: f64, segments: usize) -> Part {
    lathe(&sample(knots, step), segments)
}

fn pawn() -> Part {
    let mut knots = foot(0.31, 0.50);
    knots.extend([c(0.125, 0.54), s(0.205, 0.565), s(0.20, 0.59), c(0.115, 0.615)]);
    knots.extend([s(0.155, 0.655), s(0.178, 0.735), s(0.150, 0.825), s(0.08, 0.885), c(0.0, 0.90)]);
    turned(&knots, 0.085, 17)
}

/// Six merlons; the wall between them drops to the platform behind.
fn rook() -> Part {
    const MERLONS: usize = 6;
    let mut knots = foot(0.345, 0.62);
    knots.extend([c(0.15, 0.66), s(0.245, 0.70), c(0.255, 0.74), c(0.255, 0.80)]);
    let mut profile = sample(&knots, 0.10);
    let wall = profile.len();
    // Wall up, across, down inside, floor.
    profile.extend([DVec2::new(0.27, 0.96), DVec2::new(0.185, 0.96), DVec2::new(0.18, 0.82), DVec2::new(0.0, 0.80)]);
    // Columns: each merlon has four, each gap two more; where they meet two columns share an angle,
    // which makes upright cheeks.
    let per = 6;
    Part::grid(profile.len(), MERLONS * per, true, |row, column| {
        let (merlon, k) = (column / per, column % per);
        let at = [0.0, 0.21, 0.42, 0.62, 0.62, 1.0][k];
        let gap = k >= 4;
        // The last column of a gap stands where the next merlon begins.
        let index = if k == 5 { (merlon + 1) % MERLONS } else { merlon };
        let turn = (index as f64 + if k == 5 { 0.0 } else { at }) / MERLONS as f64;
        let (sin, cos) = sin_cos(std::f64::consts::TAU * turn);
        let mut p = profile[row];
        if gap && (row == wall || row == wall + 1) {
            p = DVec2::new(if row == wall { 0.258 } else { 0.182 }, 0.86);
        }
        DVec3::new(p.x * sin, p.y, p.x * cos)
    })
}

/// The mitre's outline: radius by height.
const MITRE: [Knot; 8] = [
    s(0.125, 0.87),
    s(0.168, 0.925),
    s(0.192, 0.99),
    s(0.190, 1.06),
    s(0.170, 1.135),
    s(0.133, 1.21),
    s(0.078, 1.275),
    s(0.046, 1.302),
];
/// Heights of the mitre's rows at the axis. At the two doubled heights are the lips and, further
/// in, the bottom of the cut.
const MITRE_ROWS: [f64; 13] = [0.90, 0.935, 0.97, 1.005, 1.04, 1.075, 1.075, 1.115, 1.115, 1.155, 1.20, 1.245, 1.28];

/// A lathe whose rows tilt with the cut, so that its lips are clean.
fn bishop() -> Part {
    let mut knots = foot(0.335, 0.72);
    knots.extend([c(0.135, 0.76), s(0.225, 0.79), s(0.215, 0.82), c(0.13, 0.845), c(0.125, 0.87)]);
    let mut profile = sample(&knots, 0.10);
    let first = profile.len();
    profile.extend(MITRE_ROWS.map(|y| DVec2::new(0.0, y)));
    profile.extend(
        [(0.046, 1.302), (0.064, 1.33), (0.062, 1.36), (0.04, 1.383), (0.0, 1.39)].map(|(r, y)| DVec2::new(r, y)),
    );
    let outline = sample(&MITRE, 0.01);
    lathe_with(profile.len(), 24, |row, angle, _| {
        let Some(at) = row.checked_sub(first).filter(|at| *at < MITRE_ROWS.len()) else {
            return profile[row];
        };
        let (_, cos) = sin_cos(angle - std::f64::consts::FRAC_PI_2);
        // Full tilt at the cut, none at the ends; gentle enough that rows never cross.
        let away = (profile[row].y - 1.095) / 0.225;
        let y = profile[row].y + 0.085 * cos * (1.0 - away * away).max(0.0);
        let inside = (at == 6 || at == 7) && cos > -0.25;
        DVec2::new(radius_at(&outline, y) * if inside { 0.4 } else { 1.0 }, y)
    })
}

/// The radius of an outline at a height, by straight pieces.
fn radius_at(outline: &[DVec2], y: f64) -> f64 {
    let above = outline.iter().position(|p| p.y >= y).unwrap_or(outline.len() - 1).max(1);
    let (a, b) = (outline[above - 1], outline[above]);
    a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)).clamp(0.0, 1.0)
}

fn queen() -> Vec<Part> {
    let mut knots = foot(0.37, 0.98);
    knots.extend([c(0.155, 1.01), s(0.245, 1.04), s(0.24, 1.07), c(0.155, 1.10), s(0.16, 1.13), s(0.19, 1.24)]);
    let mut profile = sample(&knots, 0.10);
    let first = profile.len();
    profile.extend(
        [(0.215, 1.32), (0.245, 1.41), (0.21, 1.395), (0.165, 1.34), (0.15, 1.345), (0.11, 1.395), (0.0, 1.415)]
            .map(|(r, y)| DVec2::new(r, y)),
    );
    let points = 9.0;
    let crown = lathe_with(profile.len(), 36, |row, angle, _| {
        let mut p = profile[row];
        let (_, cos) = sin_cos(angle * points);
        match row.wrapping_sub(first) {
            1 => p += DVec2::new(0.012, 0.038) * cos,
            2 => p += DVec2::new(0.008, 0.030) * cos,
            _ => {}
        }
        p
    });
    vec![crown.crease(50.0), sphere(DVec3::new(0.0, 1.462, 0.0), 0.06, 14)]
}

fn king() -> Vec<Part> {
    let mut knots = foot(0.385, 1.08);
    knots.extend([c(0.165, 1.12), s(0.26, 1.155), s(0.255, 1.185), c(0.165, 1.215), s(0.165, 1.25), s(0.195, 1.36)]);
    knots.extend([
        c(0.235, 1.50),
        s(0.215, 1.53),
        s(0.13, 1.57),
        c(0.06, 1.585),
        s(0.07, 1.61),
        s(0.04, 1.635),
        c(0.0, 1.64),
    ]);
    // A cross pattee: narrow in the middle, wide at the ends; counter-clockwise.
    let (a, b, w) = (0.022, 0.115, 0.05);
    let arm = [(b, -w), (b, w), (a, a)];
    let outline: Vec<DVec2> = (0..4)
        .flat_map(|turn| arm.map(|(x, y)| (0..turn).fold(DVec2::new(x, y), |p, _| DVec2::new(-p.y, p.x))))
        .map(|p| p + DVec2::ZERO)
        .collect();
    // The cross faces the players, who sit along the direction that knights look in.
    let cross = block::prism(&outline, 0.028).turned(90.0).at(0.0, 1.735, 0.0);
    vec![turned(&knots, 0.10, 28), cross]
}
