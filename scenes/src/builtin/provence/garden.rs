//! Where things grow: the field, the grove, cypresses, grass, far trees.

use glam::{DVec2, DVec3};

use crate::{
    builtin::provence::{
        land::{self, FIELD, ground},
        materials::Materials,
        path, plants,
    },
    modelling::{
        SceneBuilder, paint,
        part::sin_cos,
        scatter::{Cluster, Rng, upright},
    },
};

/// Distance of lavender rows.
const ROW: f64 = 1.75;
/// Distance of bushes in a row.
const BUSH: f64 = 0.72;

/// Lavender in rows that run south; near the flight every spike of a bush is modelled.
pub fn lavender(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(101);
    let near: Vec<Cluster> = (0..4).map(|i| plants::lavender(34, 110 + i)).collect();
    let middle: Vec<Cluster> = (0..4).map(|i| plants::lavender_far(28, 120 + i)).collect();
    let far: Vec<Cluster> = (0..3).map(|i| plants::lavender_far(19, 130 + i)).collect();
    let eyes = path::eyes();
    let [west, north, east, south] = FIELD;
    let rows = libm::floor((east - west - 1.6) / ROW) as usize;
    for row in 0..=rows {
        let x = west + 0.9 + row as f64 * ROW;
        let mut cluster = Cluster::default();
        let count = libm::floor((south - north - 1.4) / BUSH) as usize;
        for i in 0..count {
            let z = north + 0.9 + i as f64 * BUSH + rng.between(-0.08, 0.08);
            let bx = x + rng.between(-0.07, 0.07);
            let (size, turn, shade) = (rng.between(0.85, 1.18), rng.between(0.0, 360.0), rng.unit());
            let pick = |set: &[Cluster]| (row * 7 + i * 3) % set.len();
            let plant = match path::distance(&eyes, bx, z) {
                d if d < 4.5 => &near[pick(&near)],
                d if d < 10.0 => &middle[pick(&middle)],
                _ => &far[pick(&far)],
            };
            let scale = DVec3::new(size * 1.12, size * rng.between(0.92, 1.1), size * 1.12);
            cluster.stamp(plant, &upright(ground(bx, z), turn, scale), DVec2::new(shade, 0.0));
        }
        out.cluster(&format!("lavender row {row}"), &cluster, m.lavender);
    }
}

/// Cypresses by the house and along the road.
pub fn cypresses(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(201);
    let kinds: Vec<Cluster> = (0..3).map(|i| plants::cypress(500, 210 + i)).collect();
    let places = [
        (-14.5, 6.5, 10.5),
        (-17.2, 3.0, 12.0),
        (-19.0, 8.8, 9.0),
        (12.2, -5.5, 11.5),
        (10.6, -9.5, 9.5),
        (24.8, 22.0, 9.0),
        (24.9, 33.0, 10.0),
        (22.2, 44.0, 9.4),
        (18.2, 56.0, 10.4),
        (19.2, -20.0, 10.0),
        (-24.0, -14.0, 11.0),
    ];
    for (i, (x, z, tall)) in places.into_iter().enumerate() {
        let wide = tall * rng.between(0.85, 1.05);
        let place = upright(ground(x, z) - DVec3::Y * 0.3, rng.between(0.0, 360.0), DVec3::new(wide, tall, wide));
        let mut tree = Cluster::default();
        tree.stamp(&kinds[i % kinds.len()], &place, DVec2::new(rng.unit(), 0.0));
        out.cluster(&format!("cypress {i}"), &tree, m.cypress);
    }
}

/// The olive grove east of the road, and single trees by the house.
pub fn olives(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(301);
    let kinds: Vec<(Cluster, Cluster)> = (0..3).map(|i| plants::olive(1600, 310 + i * 5)).collect();
    let mut places = vec![(-12.5, 14.8), (15.2, 8.2), (4.5, -14.0)];
    for row in 0..5 {
        for column in 0..4 {
            let (x, z) = (27.5 + 6.2 * f64::from(column), 8.0 + 8.5 * f64::from(row));
            places.push((x + rng.between(-0.9, 0.9), z + rng.between(-0.9, 0.9)));
        }
    }
    for (i, (x, z)) in places.into_iter().enumerate() {
        let size = rng.between(0.85, 1.15);
        let place = upright(ground(x, z), rng.between(0.0, 360.0), DVec3::splat(size));
        let (wood, leaves) = &kinds[i % kinds.len()];
        let (mut trunk, mut crown) = (Cluster::default(), Cluster::default());
        trunk.stamp(wood, &place, DVec2::ZERO);
        crown.stamp(leaves, &place, DVec2::new(rng.unit(), 0.0));
        out.cluster(&format!("olive trunk {i}"), &trunk, m.bark);
        out.cluster(&format!("olive {i}"), &crown, m.olive);
    }
}

/// Woods and hedges on the hills around.
pub fn far_trees(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(401);
    let trees: Vec<Cluster> = (0..3).map(|i| plants::bush(150, 0.20, 410 + i)).collect();
    let slim = plants::cypress(18, 420);
    let eyes = path::eyes();
    let (mut woods, mut flames) = (Cluster::default(), Cluster::default());
    let mut placed = 0;
    while placed < 225 {
        let (sin, cos) = sin_cos(rng.between(0.0, std::f64::consts::TAU));
        let far = 62.0 + 300.0 * rng.unit() * rng.unit();
        let (x, z) = (sin * far, 10.0 + cos * far);
        let open = land::in_field(x, z, -4.0) || (x > 9.0 && x < 52.0 && z > 0.0 && z < 60.0);
        if open || land::road_distance(x, z) < 6.0 || path::distance(&eyes, x, z) < 40.0 {
            continue;
        }
        placed += 1;
        let tall = rng.between(2.6, 5.2) * (1.0 + far / 250.0);
        let at = ground(x, z) - DVec3::Y * 0.4;
        let (turn, shade) = (rng.between(0.0, 360.0), DVec2::new(rng.unit(), 0.0));
        if placed % 6 == 0 {
            flames.stamp(&slim, &upright(at, turn, DVec3::new(tall * 2.0, tall * 2.4, tall * 2.0)), shade);
        } else {
            let kind = &trees[rng.pick(trees.len())];
            woods.stamp(kind, &upright(at, turn, DVec3::new(tall, tall * 0.85, tall)), shade);
        }
    }
    out.cluster("woods", &woods, m.leaf);
    out.cluster("far cypresses", &flames, m.cypress);
}

/// A place on the verge of the road.
fn by_the_road(rng: &mut Rng) -> DVec2 {
    let (p, d) = land::road(rng.between(0.12, 0.80));
    let side = if rng.unit() < 0.5 { -1.0 } else { 1.0 };
    let away = land::ROAD_HALF - 0.15 + 5.0 * rng.unit() * rng.unit();
    p + DVec2::new(-d.y, d.x) * (side * away)
}

/// A place in the grass between house and field, off the road.
fn in_the_yard(rng: &mut Rng) -> DVec2 {
    let p = DVec2::new(rng.between(-20.0, 15.0), rng.between(5.0, 24.6));
    if land::road_distance(p.x, p.y) < land::ROAD_HALF { by_the_road(rng) } else { p }
}

/// Grass by the road and round the yard, with poppies.
pub fn meadow(out: &mut SceneBuilder, m: &Materials) {
    let mut rng = Rng::new(501);
    let tufts: Vec<Cluster> = (0..4).map(|i| plants::grass(9, 510 + i)).collect();
    let poppies: Vec<(Cluster, Cluster)> = (0..3).map(|i| plants::poppy(520 + i)).collect();
    let (mut grass, mut stalks, mut cups) = (Cluster::default(), Cluster::default(), Cluster::default());
    let mut placed = 0;
    while placed < 3000 {
        let p = if placed % 3 == 0 { in_the_yard(&mut rng) } else { by_the_road(&mut rng) };
        let patchy = paint::noise(p.x / 2.3, p.y / 2.3, 530) > 0.42 || placed % 5 == 0;
        if !patchy || land::in_field(p.x, p.y, 0.4) || land::is_built(p.x, p.y) {
            continue;
        }
        placed += 1;
        let at = ground(p.x, p.y);
        let (turn, size, shade) = (rng.between(0.0, 360.0), rng.between(0.7, 1.4), DVec2::new(rng.unit(), 0.0));
        grass.stamp(&tufts[rng.pick(tufts.len())], &upright(at, turn, DVec3::splat(size)), shade);
        if placed % 6 == 0 {
            let place = upright(at + DVec3::new(0.15, 0.0, 0.1), turn, DVec3::splat(rng.between(0.9, 1.3)));
            let (stalk, cup) = &poppies[rng.pick(poppies.len())];
            stalks.stamp(stalk, &place, shade);
            cups.stamp(cup, &place, DVec2::ZERO);
        }
    }
    out.cluster("grass", &grass, m.grass);
    out.cluster("poppies", &cups, m.poppy);
    out.scatter(&stalks, m.leaf);
}
