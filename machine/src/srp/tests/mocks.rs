//! A T&I unit and a memory of fixed or seeded latency, and the loop around them.

use std::collections::VecDeque;

use rayreel_formats::scene::Rect;
use rayreel_formats::tile::RayKind;

use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::link::{RayMessage, RayRef, RayUnit};
use crate::memory::{Memory, MemoryStats, Port, Request, Response, Route};
use crate::srp::{FrameShape, Srp, SrpContext, SrpPorts};
use crate::time::{TiCycle, When};
use crate::work::PolicyReads;
use crate::work::layout::Layout;
use crate::work::{NO_RAY, NO_TRIANGLE, RayWork, Round, TileWork};

fn mix(seed: u64, value: u64) -> u64 {
    let x = (seed ^ value.wrapping_mul(0x9e37_79b9_7f4a_7c15)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x ^ (x >> 29)
}

/// A unit that holds `room` rays, each for `latency` cycles and up to `jitter` more.
#[derive(Clone, Debug, Default)]
pub struct Unit {
    pub room: usize,
    pub latency: u64,
    pub jitter: u64,
    pub seed: u64,
    pub inside: Vec<RayMessage>,
    pub results: VecDeque<RayMessage>,
    pub pushed: Vec<(u64, RayRef)>,
}

impl Unit {
    pub fn new(room: usize, latency: u64) -> Self {
        Self { room, latency, ..Self::default() }
    }

    fn tick(&mut self, now: TiCycle) {
        self.inside.sort_by_key(|ray| ray.at);
        while self.inside.first().is_some_and(|ray| ray.at <= now) {
            self.results.push_back(self.inside.remove(0));
        }
    }

    fn next_event(&self) -> When {
        When::from(self.inside.iter().map(|ray| ray.at).min())
    }
}

impl RayUnit for Unit {
    fn has_room(&self) -> bool {
        self.inside.len() < self.room
    }

    fn push(&mut self, now: TiCycle, ray: RayRef) {
        assert!(self.has_room());
        let late = if self.jitter > 0 { mix(self.seed, u64::from(ray.ray)) % self.jitter } else { 0 };
        self.inside.push(RayMessage { at: now + self.latency + late, ray });
        self.pushed.push((now.0, ray));
    }

    fn results(&mut self) -> &mut VecDeque<RayMessage> {
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
    pub latency: u64,
    pub jitter: u64,
    pub seed: u64,
    pub held: Vec<(TiCycle, Request)>,
    pub log: Vec<(u64, Request)>,
}

impl Mem {
    pub fn new(room: usize, latency: u64) -> Self {
        Self { room, latency, ..Self::default() }
    }
}

impl Memory for Mem {
    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        if self.held.len() >= self.room {
            return false;
        }
        let late = if self.jitter > 0 { mix(self.seed, request.line) % self.jitter } else { 0 };
        self.held.push((now + self.latency + late, request));
        self.log.push((now.0, request));
        true
    }
}

impl Component for Mem {
    type Report = MemoryStats;

    fn next_event(&self, _: TiCycle) -> When {
        When::from(self.held.iter().map(|(at, _)| *at).min())
    }

    fn finish(&mut self, _: TiCycle) -> MemoryStats {
        MemoryStats::default()
    }
}

impl Tick<&mut Vec<Response>> for Mem {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.held.sort_by_key(|(at, _)| *at);
        while self.held.first().is_some_and(|(at, _)| *at <= now) {
            let (_, request) = self.held.remove(0);
            if request.route != Route::Write {
                arrived.push(Response { port: request.port, line: request.line });
            }
        }
    }
}

pub const PORTS: SrpPorts = SrpPorts { l1: Port(3), dma: Port(4) };

pub fn srp(config: &MachineConfig) -> Srp {
    let shape = FrameShape {
        width_pixels: 1024,
        samples_per_axis: 2,
        pixel_bytes: config.layout.pixel_bytes,
        tile_bytes: 0,
        tile_samples: 1024,
        policy: PolicyReads::PAPER,
    };
    Srp::new(config, Layout::new(config), 0, PORTS, shape)
}

/// Runs tiles to the end and returns the cycle of the end. The accounts are closed.
pub fn run(srp: &mut Srp, tiles: Vec<TileWork>, unit: &mut Unit, memory: &mut Mem, skip: bool) -> u64 {
    let mut tiles = VecDeque::from(tiles);
    let mut arrived = Vec::new();
    let mut now = TiCycle(0);
    if let Some(tile) = tiles.pop_front() {
        srp.give_tile(now, tile.into());
    }
    loop {
        memory.tick(now, &mut arrived);
        arrived.drain(..).for_each(|response| srp.respond(now, response));
        unit.tick(now);
        srp.tick(now, SrpContext { unit: &mut *unit, memory: &mut *memory });
        if srp.is_done() && tiles.is_empty() {
            srp.finish(now);
            return now.0;
        }
        while srp.wants_tile()
            && let Some(tile) = tiles.pop_front()
        {
            srp.give_tile(now, tile.into());
        }
        let next = srp.next_event(now).min(unit.next_event()).min(memory.next_event(now)).after(now);
        let next = next.cycle().unwrap_or_else(|| panic!("nothing can happen after cycle {now}: deadlock"));
        now = if skip { next } else { now + 1 };
        assert!(now < TiCycle(10_000_000), "it never ends");
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
        known_lights: 0,
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
    TileWork::empty(0, tile, Rect { x: tile * width, y: 0, width, height })
}

/// A tile of one round of `n` equal samples.
pub fn uniform(tile: u32, n: usize, material: Option<u32>, shadows: u8) -> TileWork {
    let mut work = empty(tile, 2, 2);
    let primaries = (0..n).map(|_| sample(&mut work, material, shadows, false)).collect();
    work.rounds.push(Round { starts: primaries, ..Round::default() });
    work
}

/// A tile of two rounds with hits of several materials, misses, shadow and reflection rays.
pub fn mixed(tile: u32, n: usize, seed: u64) -> TileWork {
    let mut work = empty(tile, 16, 16);
    (work.border_samples, work.kept_samples) = (8, 8);
    for round in 0..2u32 {
        let primaries = (0..n as u64)
            .map(|i| {
                let r = mix(seed, u64::from(round) * 1000 + i);
                let material = (!r.is_multiple_of(4)).then_some((r >> 8) as u32 % 5);
                sample(&mut work, material, (r >> 16) as u8 % 3, r >> 24 & 1 == 1)
            })
            .collect();
        work.rounds.push(Round { tests: round * 40, interpolated: round * 30, starts: primaries, ..Round::default() });
    }
    work
}
