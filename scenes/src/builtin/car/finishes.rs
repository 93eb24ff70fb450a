//! The materials of `car`.

use crate::{
    modelling::{SceneBuilder, builder},
    scene::Material,
};

/// Material numbers that several parts of the car share.
pub struct Finishes {
    /// Red under a clear coat.
    pub paint: u32,
    /// Bumpers, strips, lips.
    pub chrome: u32,
    /// Gaps, arches and floor.
    pub black: u32,
    /// Tyres.
    pub rubber: u32,
    /// Windows and lenses.
    pub glass: u32,
    /// Seats and lining.
    pub leather: u32,
    /// Rims and spokes.
    pub alloy: u32,
    /// Brake discs.
    pub steel: u32,
    /// Tub, dashboard and steering wheel.
    pub dark: u32,
}

impl Finishes {
    /// Adds the materials to a scene.
    pub fn new(out: &mut SceneBuilder) -> Self {
        let mut add = |material: Material| out.material(material);
        Self {
            paint: add(builder::polished("paint", [0.34, 0.006, 0.010], 0.055, 400)),
            chrome: add(builder::mirror("chrome", [0.03; 3], [0.80, 0.82, 0.84], 500)),
            black: add(builder::matte("black", [0.012; 3])),
            rubber: add(builder::matte("rubber", [0.022, 0.022, 0.024])),
            glass: add(builder::glass("glass", [0.955, 0.972, 0.965], 1.5)),
            leather: add(builder::polished("leather", [0.40, 0.215, 0.105], 0.025, 30)),
            alloy: add(builder::mirror("alloy", [0.26, 0.26, 0.27], [0.36, 0.36, 0.37], 90)),
            steel: add(builder::mirror("steel", [0.14; 3], [0.22; 3], 60)),
            dark: add(builder::polished("trim", [0.025, 0.022, 0.02], 0.03, 60)),
        }
    }
}
