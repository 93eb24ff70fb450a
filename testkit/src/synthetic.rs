//! Frames made up in memory: objects with curved normals, shadows, reflections and refractions, or plain noise.

use rayreel_formats::Error;
use rayreel_formats::half::Half3;
use rayreel_formats::math::{Vec3, vec3};
use rayreel_formats::oct::Oct;
use rayreel_formats::scene::{Camera, Light, Meta};
use rayreel_formats::tile::{Hit, Paths, Radiance, RayClass, RayNode, ShadowState, Shadows, Tile, Tree};
use rayreel_replay::TileSource;

use crate::random::Random;
use crate::trees;

/// The kind of picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// Discs on a striped ground below a sky: coherent, with edges.
    Discs,
    /// Every sample by chance from few values: all cases meet.
    Noise,
    /// One flat object.
    Flat,
    /// Two flat objects: the second from this column on.
    Edge(u32),
    /// Trees of several bounces with smooth colours and an edge here and there, at every depth.
    Trees,
}

/// A source of synthetic frames.
#[derive(Clone, Debug)]
pub struct Synthetic {
    /// Size, tiles and frames; made up but for what `new` was told.
    pub meta: Meta,
    /// What every frame shows.
    pub look: Look,
    /// Frames of one seed are the same every time.
    pub seed: u64,
}

impl Synthetic {
    /// Frames 5 to 7 of `width` by `height` pixels of `samples` by `samples` samples, in tiles of `tile` samples a side.
    pub fn new(look: Look, (width, height): (u32, u32), samples: u32, tile: u32, seed: u64) -> Self {
        let meta = Meta {
            tool: "test".into(),
            scene: "synthetic".into(),
            scene_hash: [0; 32],
            width,
            height,
            samples,
            tile,
            first_frame: 5,
            frames: 3,
            max_depth: 4,
            min_weight: 0.01,
            lights: vec![Light::Directional { to_light: vec3(0.0, 1.0, 0.0), colour: Vec3::ONE }; 2],
        };
        Self { meta, look, seed }
    }

    fn sample(&self, frame: u32, x: u32, y: u32) -> Sample {
        let mut random = Random(self.seed ^ u64::from(frame) << 48 ^ u64::from(y) << 24 ^ u64::from(x));
        random.next();
        match self.look {
            Look::Discs => self.discs(frame, x, y, &mut random),
            Look::Noise => noise(&mut random),
            Look::Flat => flat(1),
            Look::Edge(column) => flat(1 + u32::from(x >= column)),
            Look::Trees => unreachable!("trees are pushed as such"),
        }
    }

    fn discs(&self, frame: u32, x: u32, y: u32, random: &mut Random) -> Sample {
        let (w, h) = self.meta.grid();
        let (u, v) = (x as f32 / w as f32, y as f32 / h as f32);
        let shift = frame as f32 * 0.01;
        for (i, (cx, cy, r)) in [(0.3 + shift, 0.4, 0.25), (0.7, 0.6, 0.2), (0.5, 0.2, 0.07)].into_iter().enumerate() {
            let (dx, dy) = (u - cx, v - cy);
            let k = 1.0 - (dx * dx + dy * dy) / (r * r);
            if k > 0.0 {
                let normal = vec3(dx / r, -dy / r, k.sqrt()).normalized();
                let lit = if dx > dy { 0b0110 } else { 0b0101 };
                return Sample { hit: true, object: 1 + i as u32, normal, t: 3.0 - k, lit, children: i as u32 };
            }
        }
        let hit = v > 0.35;
        let lit = [0b1001, 0b0101, 0b0101][((u + v) * 9.0) as usize % 3];
        let bump = (random.unit() - 0.5) * 0.02;
        Sample { hit, object: 9, normal: vec3(bump, 1.0, 0.0).normalized(), t: 2.0 / (v + 0.1), lit, children: 0 }
    }
}

/// What a sample is made of before it is coded.
struct Sample {
    hit: bool,
    object: u32,
    normal: Vec3,
    t: f32,
    lit: u32,
    /// 0 none, 1 a reflection, 2 a reflection and a refraction, 3 a refraction.
    children: u32,
}

fn flat(object: u32) -> Sample {
    Sample { hit: true, object, normal: vec3(0.0, 0.0, 1.0), t: 4.0, lit: 1, children: 0 }
}

fn noise(random: &mut Random) -> Sample {
    let angle = [0.0f32, 0.1, 0.3][random.remainder(3) as usize];
    Sample {
        hit: random.remainder(5) > 0,
        object: random.remainder(8) / 6,
        normal: vec3(angle, 0.0, 1.0).normalized(),
        t: 1.0 + random.unit(),
        lit: [0b0101, 0b0101, 0b0101, 0b0010][random.remainder(4) as usize],
        children: random.remainder(4),
    }
}

impl TileSource for Synthetic {
    fn meta(&self) -> &Meta {
        &self.meta
    }

    /// Four triangles an object.
    fn object_of(&self, triangle: u32) -> u32 {
        triangle / 4
    }

    fn camera(&self, frame: u32) -> rayreel_formats::Result<Camera> {
        let eye = vec3(frame as f32 * 0.1, 0.5, 3.0);
        let (w, h) = self.meta.grid();
        let (right, down) = (vec3(2.0 / w as f32, 0.0, 0.0), vec3(0.0, -2.0 / h as f32, 0.0));
        Ok(Camera { eye, corner: vec3(-1.0, 1.0, -1.5), right, down })
    }

    fn tile(&self, frame: u32, index: u32) -> Result<Tile, Error> {
        let rect = self.meta.tile_rect(index);
        let mut tile = Tile {
            frame,
            index,
            rect,
            tree: Tree::default(),
            hits: Vec::new(),
            radiance: Vec::new(),
            paths: Paths::default(),
        };
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                tile.tree.first.push(tile.tree.nodes.len() as u32);
                let mut random = Random(self.seed.wrapping_add(77) ^ u64::from(y) << 20 ^ u64::from(x));
                match self.look {
                    Look::Trees => trees::push(&mut tile, self.seed, self.meta.grid(), (frame, x, y)),
                    _ => push(&mut tile, &self.sample(frame, x, y), &mut random),
                }
            }
        }
        tile.tree.first.push(tile.tree.nodes.len() as u32);
        Ok(tile)
    }
}

/// Appends the ray tree of a sample: its primary ray and, a bounce deep, its children.
fn push(tile: &mut Tile, sample: &Sample, random: &mut Random) {
    let (reflect, refract) = match (sample.hit, sample.children) {
        (true, 1) => (true, false),
        (true, 2) => (true, true),
        (true, 3) => (false, true),
        _ => (false, false),
    };
    let class = RayClass::PRIMARY;
    let shadows = Shadows(if sample.hit { sample.lit } else { 0 });
    tile.tree.nodes.push(RayNode { class, hit: sample.hit, reflect, refract, shadows });
    let triangle = sample.object * 4 + random.remainder(4);
    let normal = Oct::encode(sample.normal);
    tile.hits.push(if sample.hit { Hit { triangle, t: sample.t, normal } } else { Hit::MISS });
    let colour = |random: &mut Random| Half3::from_vec3(vec3(random.unit(), random.unit(), random.unit() * 2.0));
    let weight = |on, random: &mut Random| if on { colour(random) } else { Half3::ZERO };
    let (local, reflection, refraction) = (colour(random), weight(reflect, random), weight(refract, random));
    tile.radiance.push(Radiance { local, reflect: reflection, refract: refraction });
    for class in
        [(reflect, class.reflection()), (refract, class.refraction())].into_iter().filter_map(|(on, c)| on.then_some(c))
    {
        let hit = random.remainder(2) == 0;
        let mut shadows = Shadows::default();
        if hit {
            shadows.set(random.remainder(2) as usize, ShadowState::Lit);
        }
        tile.tree.nodes.push(RayNode { class, hit, reflect: false, refract: false, shadows });
        tile.hits.push(if hit { Hit { triangle: random.remainder(40), t: 1.0, normal } } else { Hit::MISS });
        let local = colour(random);
        tile.radiance.push(Radiance { local, ..Radiance::default() });
    }
}
