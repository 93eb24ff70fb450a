//! A ray in a packet does what it does alone: same hit, same steps, whoever walks beside it.

mod support;

use rayreel_formats::math::Vec3;
use rayreel_formats::rays::Ray;
use rayreel_scenes::Scene;
use rayreel_tracer::build;
use rayreel_tracer::traverse::{LANES, PacketRays, PacketScratch, RayHit, TraversalBvh, TraversalScratch};
use support::{Draws, Random, builtin, cutout};

const PACKETS: u64 = 20_000;

/// Rays that start and point more or less alike: from a bundle of parallel ones to eight strangers. Some run along an
/// axis, some end early.
fn random_packet(random: &mut Random, low: Vec3, high: Vec3) -> PacketRays {
    let size = (high - low).max_component();
    let (around, apart) = ([0.0, 0.001, 0.03, 1.0][random.index(4)], [0.0, 0.001, 0.05, 1.0][random.index(4)]);
    let (origin, direction) = (random.point(low, high), random.direction());
    let one = Vec3::splat(1.0);
    let mut ray = || {
        let start = origin + random.point(-one, one) * (size * around);
        let mut to = direction + random.point(-one, one) * apart;
        if random.index(6) == 0 {
            (to.x, to.y) = ([0.0, -0.0][random.index(2)], if random.index(2) == 0 { 0.0 } else { to.y });
        }
        let to = if to.length() > 1e-3 { to.normalized() } else { direction };
        let t_max = if random.index(3) == 0 { random.unit() * size } else { f32::MAX };
        Ray { origin: start, direction: to, t_max }
    };
    let rays = [(); LANES].map(|()| ray());
    PacketRays { rays, mask: if random.index(3) == 0 { random.index(256) as u8 } else { u8::MAX } }
}

/// Whether a ray passes a triangle: about one in four does, and neither lane nor order has a say.
fn passes(seed: u64, triangle: u32, u: f32, v: f32) -> bool {
    let mix = seed ^ u64::from(triangle) << 32 ^ u64::from(u.to_bits() ^ v.to_bits().rotate_left(16));
    (mix.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 62) == 0
}

fn bits(hit: Option<RayHit>) -> Option<(u32, [u32; 3])> {
    hit.map(|h| (h.triangle, [h.t, h.u, h.v].map(f32::to_bits)))
}

/// Walks random packets of a scene; gives how many steps were compared, and how many rays hit.
fn check<const ANY_HIT: bool>(name: &str, scene: &Scene) -> (u64, u64) {
    let built = build(scene).expect("bvh");
    let bvh = TraversalBvh::new(&built.bvh);
    let bounds = built.bvh.bounds();
    let (mut packets, mut other, mut alone) =
        (PacketScratch::default(), PacketScratch::default(), TraversalScratch::default());
    let (mut steps, mut hits) = (0, 0);
    for seed in 0..PACKETS {
        let packet = random_packet(&mut Random(seed << 20), bounds.min, bounds.max);
        let found = bvh.packet::<true, ANY_HIT>(&packet, &mut packets, |_, t, u, v| passes(seed, t, u, v));
        let silent = bvh.packet::<false, ANY_HIT>(&packet, &mut other, |_, t, u, v| passes(seed, t, u, v));
        let anywhere = bvh.packet_anywhere::<true, ANY_HIT>(&packet, &mut other, |_, t, u, v| passes(seed, t, u, v));
        for lane in 0..LANES {
            assert_eq!(bits(found[lane]), bits(silent[lane]), "{name}, packet {seed}, ray {lane}: recording");
            assert_eq!(bits(found[lane]), bits(anywhere[lane]), "{name}, packet {seed}, ray {lane}: processor");
            assert_eq!(packets.steps(lane), other.steps(lane), "{name}, packet {seed}, ray {lane}: processor");
            if packet.mask >> lane & 1 == 0 {
                assert_eq!((found[lane], packets.steps(lane)), (None, &[][..]), "{name}, packet {seed}: no ray {lane}");
                continue;
            }
            alone.steps.clear();
            let (ray, pass) = (&packet.rays[lane], |t, u, v| passes(seed, t, u, v));
            let hit = if ANY_HIT {
                bvh.any_hit::<true>(ray, &mut alone, pass)
            } else {
                bvh.closest_hit::<true>(ray, &mut alone, pass)
            };
            assert_eq!(packets.steps(lane), alone.steps, "{name}, packet {seed}, ray {lane}: {ray:?}");
            assert_eq!(bits(found[lane]), bits(hit), "{name}, packet {seed}, ray {lane}: {ray:?}");
            steps += alone.steps.len() as u64;
            hits += u64::from(hit.is_some());
        }
    }
    (steps, hits)
}

#[test]
fn rays_walk_as_they_do_alone() {
    for scene in [builtin("cornell"), builtin("teapot"), builtin("chess"), cutout::scene(1)] {
        let (closest, any) = (check::<false>(&scene.name, &scene), check::<true>(&scene.name, &scene));
        for (steps, hits) in [closest, any] {
            assert!(steps > 10 * PACKETS && hits > PACKETS, "{}: {steps} steps, {hits} hits show little", scene.name);
        }
    }
}
