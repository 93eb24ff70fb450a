//! The shell of `car` above the belt as one closed form, from which roof, pillars and windows are cut.

use glam::{DVec2, DVec3};

use crate::{
    builtin::car::body,
    modelling::{
        curve::{lerp, reach},
        part::sin_cos,
    },
};

/// Plan of the cabin at the belt and at the roof: rear, front, half the width, in metres.
const BELT: [f64; 3] = [-1.58, 0.80, 0.665];
const EAVES: [f64; 3] = [-0.74, 0.13, 0.525];
/// Exponent of the plan's rounded rectangle.
const SQUARE: f64 = 3.1;
/// Where the side begins to turn into the roof, as a parameter of [`Shell::point`].
pub const TURN: f64 = 0.9;
/// Where the turn has become the roof.
pub const ROOF: f64 = 1.28;
/// Entries of the tables.
const PIECES: usize = 720;
const PI: f64 = std::f64::consts::PI;

/// The shell, with tables of what would take long to compute for each point.
pub struct Shell {
    /// Lengths along the belt up to each of [`PIECES`] even angles from front to rear.
    lengths: Vec<f64>,
    /// Heights of the body under the belt at these angles.
    heights: Vec<f64>,
}

/// The plan at height share `h` and angle `t` from the front.
fn plan(t: f64, h: f64) -> DVec2 {
    let bulge = libm::sin(PI * h.min(1.0));
    let [rear, front, half]: [f64; 3] = std::array::from_fn(|i| lerp(BELT[i], EAVES[i], h));
    let (rear, front, half) = (rear - 0.035 * bulge, front + 0.03 * bulge, half + 0.022 * bulge);
    let (sin, cos) = sin_cos(t);
    let power = |v: f64| if v.abs() < 1e-12 { 0.0 } else { libm::copysign(libm::pow(v.abs(), 2.0 / SQUARE), v) };
    DVec2::new((front + rear) / 2.0 + (front - rear) / 2.0 * power(cos), half * power(sin))
}

/// Height of the eaves; the roof is highest over the driver.
fn eaves(x: f64) -> f64 {
    let d = (x + 0.12) / 0.6;
    1.225 - 0.075 * d * d
}

/// Half the width of the opening in the body at `x`, a few centimetres inside the belt.
pub fn opening(x: f64) -> f64 {
    let (rear, front) = (BELT[0] + 0.05, BELT[1] - 0.05);
    if x <= rear || x >= front {
        return 0.0;
    }
    let middle = (front + rear) / 2.0;
    let t = reach(0.0, PI, -x, |t| (middle - plan(t, 0.0).x) * 0.958 - middle);
    (plan(t, 0.0).y - 0.03).max(0.01)
}

impl Shell {
    /// Measures the belt.
    pub fn new() -> Self {
        let belt: Vec<DVec2> = (0..=PIECES).map(|i| plan(PI * i as f64 / PIECES as f64, 0.0)).collect();
        let mut lengths = vec![0.0];
        let mut length = 0.0;
        for pair in belt.windows(2) {
            length += (pair[1] - pair[0]).length();
            lengths.push(length);
        }
        Self { lengths, heights: belt.iter().map(|p| body::top(p.x, p.y)).collect() }
    }

    /// The angle at a share of the belt's half circumference, 0 in front.
    pub fn angle_at(&self, share: f64) -> f64 {
        if share <= 0.0 || share >= 1.0 {
            return if share <= 0.0 { 0.0 } else { PI };
        }
        let wanted = share * self.lengths[PIECES];
        let i = self.lengths.partition_point(|l| *l < wanted).clamp(1, PIECES);
        let t = (wanted - self.lengths[i - 1]) / (self.lengths[i] - self.lengths[i - 1]);
        PI * (i as f64 - 1.0 + t) / PIECES as f64
    }

    /// Height of the body under the belt.
    fn base(&self, t: f64) -> f64 {
        let t = if t > PI { 2.0 * PI - t } else { t.abs() };
        let place = t / PI * PIECES as f64;
        let i = (place as usize).min(PIECES - 1);
        lerp(self.heights[i], self.heights[i + 1], place - i as f64)
    }

    /// The point at angle `t` (0 in front, a quarter turn on the right) and `r`: from the belt (0) over the
    /// turn to the middle of the roof (2).
    pub fn point(&self, t: f64, r: f64) -> DVec3 {
        // The shell starts a little under the skin of the body.
        let base = self.base(t) - 0.02;
        let eaves_here = eaves(plan(t, 1.0).x);
        let side = |h: f64| {
            let p = plan(t, h);
            DVec3::new(p.x, lerp(base, eaves_here, h), p.y)
        };
        let roof = |k: f64| {
            let (p, middle) = (plan(t, 1.0), (EAVES[0] + EAVES[1]) / 2.0);
            let x = lerp(middle, p.x, k);
            DVec3::new(x, eaves(x) + 0.055 * (1.0 - k * k), p.y * k)
        };
        if r <= TURN {
            side(r)
        } else if r >= ROOF {
            roof(2.0 - r)
        } else {
            // A curve from the side to the roof tangent to both.
            let u = (r - TURN) / (ROOF - TURN);
            side(TURN) * ((1.0 - u) * (1.0 - u)) + side(1.0) * (2.0 * u * (1.0 - u)) + roof(2.0 - ROOF) * (u * u)
        }
    }

    /// A point `depth` inside the shell, measured across it.
    pub fn inside(&self, t: f64, r: f64, depth: f64) -> DVec3 {
        let step = 1e-4;
        let around = self.point(t + step, r) - self.point(t - step, r);
        let up = self.point(t, r + step) - self.point(t, r - step);
        self.point(t, r) + around.cross(up).normalize_or_zero() * depth
    }

    /// The ring of the belt, shrunk by `inset` and lowered by `drop`, from the front over the right round to
    /// the front again.
    pub fn belt(&self, points: usize, inset: f64, drop: f64) -> Vec<DVec3> {
        let (middle, half) = ((BELT[0] + BELT[1]) / 2.0, (BELT[1] - BELT[0]) / 2.0);
        (0..points)
            .map(|i| {
                let share = 2.0 * i as f64 / points as f64;
                let (t, side) =
                    if share <= 1.0 { (self.angle_at(share), 1.0) } else { (self.angle_at(2.0 - share), -1.0) };
                let p = plan(t, 0.0);
                let x = middle + (p.x - middle) * (1.0 - inset / half);
                DVec3::new(x, self.base(t) - drop, p.y * (1.0 - inset / BELT[2]) * side)
            })
            .collect()
    }
}
