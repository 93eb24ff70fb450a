//! A T&I unit and a memory of fixed or seeded latency, and the loop around them.

use std::collections::VecDeque;

use rayreel_formats::scene::Rect;
use rayreel_formats::tile::RayKind;

use crate::config::MachineConfig;
use crate::link::{RayRef, RayUnit};
use crate::memory::{Cycle, Memory, Port, Request, Response, Route};
use crate::srp::interface::earliest;
use crate::srp::{FrameShape, Srp, SrpPorts};
use crate::work::layout::Layout;
use crate::work::{NO_RAY, NO_TRIANGLE, RayWork, TileWork, Wave};

fn mix(seed: u64, value: u64) -> u64 {
    let x = (seed ^ value.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^ (x >> 29)
}

/// A unit that holds `room` rays, each for `latency` cycles and up to `jitter` more.
#[derive(Clone, Debug, Default)]
pub struct Unit {
    pub room: usize,
    pub latency: Cycle,
    pub jitter: u64,
    pub seed: u64,
    pub inside: Vec<(Cycle, RayRef)>,
    pub results: VecDeque<(Cycle, RayRef)>,
    pub pushed: Vec<(Cycle, RayRef)>,
}

impl Unit {
    pub fn new(room: usize, latency: Cycle) -> Self {
        Self { room, latency, ..Self::default() }
    }

    fn tick(&mut self, now: Cycle) {
        self.inside.sort_by_key(|(at, _)| *at);
        while self.inside.first().is_some_and(|(at, _)| *at <= now) {
            self.results.push_back(self.inside.remove(0));
        }
    }

    fn next_event(&self) -> Option<Cycle> {
        self.inside.iter().map(|(at, _)| *at).min()
    }
}

impl RayUnit for Unit {
    fn has_room(&self) -> bool {
        self.inside.len() < self.room
    }

    fn push(&mut self, now: Cycle, ray: RayRef) {
        assert!(self.has_room());
        let late = if self.jitter > 0 { mix(self.seed, u64::from(ray.ray)) % self.jitter } else { 0 };
        self.inside.push((now + self.latency + late, ray));
        self.pushed.push((now, ray));
    }

    fn results(&mut self) -> &mut VecDeque<(Cycle, RayRef)> {
        &mut self.results
    }

    fn rays_inside(&self) -> usize {
        self.inside.len()
    }
}

/// A memory that holds `room` requests, reads and writes, for `latency` cycles and up to `jitter` more.
#[derive(Clone, Debug, Default)]
pub struct Mem {
    pub room: usize,
    pub latency: Cycle,
    pub jitter: u64,
    pub seed: u64,
    pub held: Vec<(Cycle, Request)>,
    pub log: Vec<(Cycle, Request)>,
}

impl Mem {
    pub fn new(room: usize, latency: Cycle) -> Self {
        Self { room, latency, ..Self::default() }
    }
}

impl Memory for Mem {
    fn request(&mut self, now: Cycle, request: Request) -> bool {
        if self.held.len() >= self.room {
            return false;
        }
        let late = if self.jitter > 0 { mix(self.seed, request.line) % self.jitter } else { 0 };
        self.held.push((now + self.latency + late, request));
        self.log.push((now, request));
        true
    }

    fn tick(&mut self, now: Cycle, arrived: &mut Vec<Response>) {
        self.held.sort_by_key(|(at, _)| *at);
        while self.held.first().is_some_and(|(at, _)| *at <= now) {
            let (_, request) = self.held.remove(0);
            if request.route != Route::Write {
                arrived.push(Response { port: request.port, line: request.line });
            }
        }
    }

    fn next_event(&self) -> Option<Cycle> {
        self.held.iter().map(|(at, _)| *at).min()
    }
}

pub const PORTS: SrpPorts = SrpPorts { l1: Port(3), dma: Port(4) };

pub fn srp(config: &MachineConfig) -> Srp {
    let shape = FrameShape { width_pixels: 1024, samples_per_axis: 2, pixel_bytes: config.layout.pixel_bytes };
    Srp::new(config, Layout::new(config), 0, PORTS, shape)
}

/// Runs tiles to the end and returns the cycle of the end. The accounts are closed.
pub fn run(srp: &mut Srp, tiles: Vec<TileWork>, unit: &mut Unit, memory: &mut Mem, skip: bool) -> Cycle {
    let mut tiles = VecDeque::from(tiles);
    let mut arrived = Vec::new();
    let mut now = 0;
    if let Some(tile) = tiles.pop_front() {
        srp.give_tile(0, tile);
    }
    loop {
        memory.tick(now, &mut arrived);
        arrived.drain(..).for_each(|response| srp.respond(now, response));
        unit.tick(now);
        srp.tick(now, unit, memory);
        if srp.is_done() && tiles.is_empty() {
            srp.finish(now);
            return now;
        }
        while srp.wants_tile()
            && let Some(tile) = tiles.pop_front()
        {
            srp.give_tile(now, tile);
        }
        let next = earliest(earliest(srp.next_event(), unit.next_event()), memory.next_event());
        assert!(next.is_some(), "nothing can happen after cycle {now}: deadlock");
        now = if skip { next.map_or(now + 1, |n| n.max(now + 1)) } else { now + 1 };
        assert!(now < 10_000_000, "it never ends");
    }
}

/// One sample's rays: primary hitting `material` (`None`: a miss) with `shadows` shadow rays and, if wanted, a reflection ray
/// that leaves the scene. Returns the primary's index.
pub fn sample(work: &mut TileWork, material: Option<u32>, shadows: u8, reflects: bool) -> u32 {
    let first = work.rays.len() as u32;
    let base = RayWork {
        ops_start: 0,
        ops_len: 0,
        kind: RayKind::Primary,
        shadows: 0,
        triangle: NO_TRIANGLE,
        material: 0,
        reflect: NO_RAY,
        refract: NO_RAY,
        x: first * 7 % 32,
        y: first * 3 % 32,
        depth: 0,
    };
    let Some(material) = material else {
        work.rays.push(base);
        return first;
    };
    let reflect = if reflects { first + 1 + u32::from(shadows) } else { NO_RAY };
    work.rays.push(RayWork { shadows, triangle: first, material, reflect, ..base });
    work.rays.extend((0..shadows).map(|_| RayWork { kind: RayKind::Shadow, ..base }));
    if reflects {
        work.rays.push(RayWork { kind: RayKind::Reflection, depth: 1, ..base });
    }
    first
}

/// A tile of `width x height` samples without work.
pub fn empty(tile: u32, width: u32, height: u32) -> TileWork {
    TileWork {
        frame: 0,
        tile,
        rect: Rect { x: tile * width, y: 0, width, height },
        apron_samples: 0,
        border_samples: 0,
        secondary_hits: 0,
        rays: Vec::new(),
        ops: Vec::new(),
        waves: Vec::new(),
    }
}

/// A tile of one wave of `n` equal samples.
pub fn uniform(tile: u32, n: usize, material: Option<u32>, shadows: u8) -> TileWork {
    let mut work = empty(tile, 2, 2);
    let primaries = (0..n).map(|_| sample(&mut work, material, shadows, false)).collect();
    work.waves.push(Wave { starts: primaries, ..Wave::default() });
    work
}

/// A tile of two waves with hits of several materials, misses, shadow and reflection rays.
pub fn mixed(tile: u32, n: usize, seed: u64) -> TileWork {
    let mut work = empty(tile, 16, 16);
    work.border_samples = 8;
    for wave in 0..2u32 {
        let primaries = (0..n as u64)
            .map(|i| {
                let r = mix(seed, u64::from(wave) * 1000 + i);
                let material = (!r.is_multiple_of(4)).then_some((r >> 8) as u32 % 5);
                sample(&mut work, material, (r >> 16) as u8 % 3, r >> 24 & 1 == 1)
            })
            .collect();
        work.waves.push(Wave { tests: wave * 40, interpolated: wave * 30, starts: primaries });
    }
    work
}
