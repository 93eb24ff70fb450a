//! `provence`: a farmhouse in the evening sun between lavender, olives and cypresses, with a pool.
//! 600,000 triangles, and a flight of 700 frames.

mod garden;
mod house;
mod joinery;
mod land;
mod masonry;
mod materials;
mod path;
mod plan;
mod plants;
mod roof;
mod terrain;
mod yard;

use glam::DVec3;

use crate::{
    builtin::provence::plan::{House, door, window},
    error::SceneError,
    modelling::{SceneBuilder, scatter::Rng},
    scene::Scene,
};

/// The scene with its flight; frame 0 is the hero view.
pub fn scene() -> Result<Scene, SceneError> {
    let mut out = SceneBuilder::new("provence");
    let m = materials::add(&mut out);
    terrain::add(&mut out);
    let mut rng = Rng::new(1);
    for house in houses() {
        house::add(&mut out, &m, &house, &mut rng);
    }
    out.object("chimneys", &house::chimney(DVec3::new(-5.6, 8.3, -1.0), 0.75), m.stone);
    masonry::pool(&mut out, &m);
    yard::add(&mut out, &m);
    garden::lavender(&mut out, &m);
    garden::cypresses(&mut out, &m);
    garden::olives(&mut out, &m);
    masonry::wall(&mut out, &m);
    garden::meadow(&mut out, &m);
    garden::far_trees(&mut out, &m);
    out.sun([-0.88, 0.46, 0.46], [1.72, 1.30, 0.86]);
    out.sun([0.55, 0.80, 0.25], [0.07, 0.09, 0.14]);
    out.sky([0.10, 0.28, 0.74], [0.86, 0.75, 0.63], [0.34, 0.27, 0.19], 0.41);
    out.finish(path::cameras())
}

/// Main house, wing and barn.
fn houses() -> [House; 3] {
    [
        House {
            name: "house",
            at: DVec3::new(-2.0, 0.0, 0.0),
            degrees: 0.0,
            size: DVec3::new(12.4, 6.2, 7.2),
            rise: 1.75,
            openings: [
                vec![
                    window(-4.3, 0.95, 1.15, 1.6),
                    door(-1.2, 1.3, 2.35),
                    window(1.5, 0.95, 1.15, 1.6),
                    window(4.3, 0.95, 1.15, 1.6),
                    window(-4.3, 3.9, 1.0, 1.35),
                    window(-1.2, 3.9, 1.0, 1.35),
                    window(1.5, 3.9, 1.0, 1.35),
                    window(4.3, 3.9, 1.0, 1.35),
                ],
                vec![],
                vec![window(-3.0, 0.95, 1.15, 1.6), window(2.0, 3.9, 1.0, 1.35)],
                vec![window(1.4, 4.2, 0.9, 1.2)],
            ],
        },
        House {
            name: "wing",
            at: DVec3::new(7.2, 0.0, -1.0),
            degrees: 0.0,
            size: DVec3::new(6.0, 3.7, 5.4),
            rise: 1.3,
            openings: [
                vec![window(-1.5, 0.95, 1.1, 1.4), door(1.2, 1.1, 2.2)],
                vec![window(0.3, 0.95, 1.1, 1.4)],
                vec![],
                vec![],
            ],
        },
        House {
            name: "barn",
            at: DVec3::new(-12.4, 0.0, -1.4),
            degrees: 90.0,
            size: DVec3::new(9.0, 3.9, 5.6),
            rise: 1.5,
            openings: [vec![], vec![door(0.0, 2.3, 2.8)], vec![], vec![window(0.0, 1.2, 1.0, 1.2)]],
        },
    ]
}
