//! Machines, work and runs that the tests share.

use std::path::Path;
use std::sync::OnceLock;

use rayreel_formats::Limits;
use rayreel_formats::bvh::Child;
use rayreel_formats::tile::RayKind;
use rayreel_formats::trace::Trace;
use rayreel_machine::component::{Component, Tick};
use rayreel_machine::config::{MachineConfig, MissHandling, NamedMachine, Pipeline};
use rayreel_machine::link::{RayRef, RayUnit};
use rayreel_machine::memory::{IdealMemory, Memory, MemorySystem, Port};
use rayreel_machine::srp::FrameShape;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::{NoProbe, System};
use rayreel_machine::ti::{TiContext, TiStats, TiUnit};
use rayreel_machine::time::TiCycle;
use rayreel_machine::work::check::{PathCounts, walk};
use rayreel_machine::work::history::{HistorySpan, HistoryWork};
use rayreel_machine::work::layout::Layout;
use rayreel_machine::work::synthetic::{self, Random, balanced_topology, random_tile};
use rayreel_machine::work::topology::Topology;
use rayreel_machine::work::{NO_TRIANGLE, PolicyReads, TileWork};
use rayreel_replay::{NamedPolicy, Options, Replayer, TileSource};

/// A preset with overrides.
pub fn machine(name: &str, overrides: &[&str]) -> MachineConfig {
    let overrides: Vec<_> = overrides.iter().map(ToString::to_string).collect();
    NamedMachine::load(name, &overrides).unwrap().config
}

/// The frame of made-up tiles.
pub const SHAPE: FrameShape = FrameShape {
    width_pixels: 64,
    samples_per_axis: 1,
    pixel_bytes: 4,
    tile_bytes: 0,
    tile_samples: 1024,
    policy: PolicyReads::PAPER,
};

/// Tiles through the machine, with any memory.
pub fn run<M: Memory>(config: &MachineConfig, work: (&Topology, &[TileWork]), shape: FrameShape, memory: M) -> Stats {
    run_keeping(config, work, shape, memory).0
}

/// The same; the memory is given back.
pub fn run_keeping<M: Memory>(
    config: &MachineConfig,
    (tree, tiles): (&Topology, &[TileWork]),
    shape: FrameShape,
    memory: M,
) -> (Stats, M) {
    let mut system = System::with_memory(config, tree, shape, memory);
    tiles.iter().for_each(|tile| system.feed(tile.clone(), &mut NoProbe).unwrap());
    system.finish(&mut NoProbe).unwrap()
}

/// The same with the memory system of the machine, whose counters are part of the result.
pub fn run_real(config: &MachineConfig, work: (&Topology, &[TileWork]), shape: FrameShape) -> Stats {
    run(config, work, shape, MemorySystem::new(config))
}

/// All rays of tile 0 through a T&I unit alone, as fast as its ray buffer takes them: accounts, cycles.
pub fn run_unit(config: &MachineConfig, tree: &Topology, tiles: &Vec<TileWork>, latency: u64) -> (TiStats, u64) {
    let layout = Layout::new(config);
    let (mut memory, mut unit) = (IdealMemory::new(latency), TiUnit::new(config, Port(0)));
    let (rays, mut sent, mut now, mut arrived) = (tiles[0].rays.len() as u32, 0, TiCycle(0), Vec::new());
    loop {
        memory.tick(now, &mut arrived);
        arrived.drain(..).for_each(|r| unit.fill(now, r.port, r.line));
        while sent < rays && unit.has_room() {
            unit.push(now, RayRef { slot: 0, ray: sent });
            sent += 1;
        }
        unit.tick(now, TiContext { tree, layout: &layout, tiles, memory: &mut memory });
        unit.results().clear();
        if sent == rays && unit.rays_inside() == 0 {
            return (unit.finish(now + 1), (now + 1).0);
        }
        let next = unit.next_event(now).min(memory.next_event(now)).after(now).cycle();
        now = next.filter(|_| sent == rays || !unit.has_room()).unwrap_or(now + 1);
    }
}

/// The path of these steps.
pub fn path(tree: &Topology, steps: &[u8]) -> synthetic::Path {
    let mut path = synthetic::Path { steps: steps.to_vec(), ops: Vec::new(), hit: 0 };
    path.hit = walk(tree, steps, false, &mut path.ops, &mut PathCounts::default()).unwrap().hit;
    path
}

/// `rays` primary rays of the same path, all of one sample: one pixel to store, and all the rest is tracing.
pub fn repeated(tree: &Topology, steps: &[u8], rays: usize) -> TileWork {
    let mut tile = synthetic::tile_of(0, 0, &vec![path(tree, steps); rays]);
    (tile.rect.width, tile.rect.height) = (1, 1);
    tile
}

/// A chain: node i has a leaf of one triangle on the left and node i + 1 on the right.
pub fn chain(length: u32) -> Topology {
    let node = |i| [Child::leaf(i, 1), if i + 1 < length { Child::inner(i + 1) } else { Child::leaf(length, 1) }];
    Topology::from_children((0..length).map(node).collect(), length + 1)
}

/// Recorded work: a golden trace under a policy.
pub struct Recorded {
    pub name: String,
    pub tree: Topology,
    pub shape: FrameShape,
    pub tiles: Vec<TileWork>,
    pub paths: PathCounts,
}

impl Recorded {
    pub fn work(&self) -> (&Topology, &[TileWork]) {
        (&self.tree, &self.tiles)
    }

    pub fn real(&self, config: &MachineConfig) -> Stats {
        run_real(config, self.work(), self.shape)
    }
}

pub fn golden(name: &str) -> Trace {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&path, Limits::default()).unwrap()
}

/// The golden traces under the policies full and adaptive.
pub fn recorded() -> &'static [Recorded] {
    static ALL: OnceLock<Vec<Recorded>> = OnceLock::new();
    ALL.get_or_init(|| {
        let mut all = Vec::new();
        for name in ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"] {
            for policy in ["full", "adaptive"] {
                all.push(record(name, policy));
            }
        }
        all
    })
}

fn record(name: &str, policy: &str) -> Recorded {
    let trace = golden(name);
    let (tree, mut tiles) = (Topology::new(trace.bvh()), Vec::new());
    let policy = NamedPolicy::load(policy, &[]).unwrap();
    let mut replayer = Replayer::new(&trace, &policy.policy, Options::default()).unwrap();
    let keep = |work| {
        tiles.push(work);
        Ok(())
    };
    let meta = TileSource::meta(&trace);
    let (_, paths) = replayer.frame_with(meta.first_frame, &tree, keep).unwrap();
    let shape = FrameShape {
        width_pixels: meta.width,
        samples_per_axis: meta.samples,
        pixel_bytes: 4,
        tile_bytes: 0,
        tile_samples: meta.tile * meta.tile,
        policy: PolicyReads::PAPER,
    };
    Recorded { name: format!("{name}, {}", policy.name), tree, shape, tiles, paths }
}

/// Made-up work of a seed: a tree and some tiles.
pub fn random_work(seed: u64) -> (Topology, Vec<TileWork>) {
    let mut random = Random(seed);
    let tree = balanced_topology(3 + random.below(8), random.below(4));
    let mut tiles: Vec<_> = (0..3).map(|i| random_tile(&tree, i, 16 + random.below(64), 2, &mut random)).collect();
    tiles.iter_mut().for_each(|tile| remember(tile, &mut random));
    (tree, tiles)
}

/// Gives a tile a history: entries that it reads and keeps, and hits that know lights.
fn remember(tile: &mut TileWork, random: &mut Random) {
    let span = |below: bool, first: u32, count: u32| HistorySpan { tile: first % 3, below, first, count };
    let count = random.below(4);
    let reads = (0..count).map(|i| span(i % 2 == 1, 100 * i, 1 + random.below(40))).collect();
    tile.history = HistoryWork { reads, kept: random.below(65), kept_below: random.below(30) };
    tile.rounds[0].looked_back = random.below(50);
    for ray in tile.rays.iter_mut().filter(|ray| ray.kind != RayKind::Shadow && ray.triangle != NO_TRIANGLE) {
        ray.known_lights = random.below(3) as u8;
    }
}

/// A machine of a seed: everything that is a rule of the units varies.
pub fn random_machine(random: &mut Random) -> MachineConfig {
    let mut config = machine("sgrt-ti2", &[]);
    let mut of = |list: &[u32]| list[random.below(list.len() as u32) as usize];
    let ti = &mut config.ti;
    ti.pipeline = [Pipeline::Parallel, Pipeline::Single, Pipeline::Unified][of(&[0, 1, 2]) as usize];
    let modes = [MissHandling::Retry, MissHandling::Accumulate, MissHandling::Reorder];
    (ti.miss_handling, ti.ist_miss_handling) = (modes[of(&[0, 1, 2]) as usize], modes[of(&[0, 1, 2]) as usize]);
    (ti.trv, ti.aabbs_per_cycle, ti.stack_entries) = (of(&[1, 2, 4]), of(&[1, 2]), of(&[0, 1, 2, 4, 8]));
    (ti.rays_per_trv, ti.ray_fifo_entries, ti.ist_entries) =
        (of(&[1, 4, 16, 64, 128]), of(&[1, 8, 32]), of(&[1, 8, 32]));
    (ti.setup_cycles, ti.inner_cycles, ti.leaf_cycles) = (of(&[1, 7, 20]), of(&[1, 5, 10]), of(&[1, 3, 4]));
    (ti.stack_cycles, ti.ist_cycles, ti.crossbar_cycles) = (of(&[1, 3, 4]), of(&[1, 12, 30]), of(&[1, 2, 3]));
    (ti.trv_lines_per_cycle, ti.ist_lines_per_cycle) = (of(&[1, 2]), of(&[1, 2]));
    ti.ist = if ti.pipeline == Pipeline::Unified { 0 } else { of(&[1, 2]) };
    for l1 in [&mut ti.trv_l1, &mut ti.ist_l1] {
        (l1.mshrs, l1.latency_cycles) = (of(&[1, 4, 16]), of(&[1, 2, 4]));
    }
    config.gpu.cores = of(&[1, 2, 4]);
    config.gpu.tiles_in_flight = of(&[1, 2, 3]);
    config.gpu.interface_bytes_per_cycle = of(&[8, 16, 32]);
    config.gpu.interface_latency_cycles = of(&[1, 2, 5]);
    (config.srp.output_rays, config.srp.gather_entries) = (of(&[1, 8, 32]), of(&[1, 16, 128]));
    config.srp.dma_reads = of(&[1, 16]);
    (config.srp.output_high_percent, config.srp.rays_low_percent) = (of(&[0, 50, 100]), of(&[0, 50, 100]));
    config.srp.clock_mhz = of(&[500, 1000]);
    (config.layout.node_bytes, config.layout.triangle_bytes) = (of(&[40, 64, 256]), of(&[36, 48, 64, 200]));
    config.check().unwrap();
    config
}
