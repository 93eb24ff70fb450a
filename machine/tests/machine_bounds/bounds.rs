//! No run is faster than its busiest unit, and none moves more bytes than the DRAM can.

use rayreel_formats::tile::RayKind;
use rayreel_machine::config::{
    Block, Divergence, Interface, Kernel, MachineConfig, Pipeline, PrimaryVisibility, Processor,
};
use rayreel_machine::srp::{KERNELS, KernelId};
use rayreel_machine::stats::Stats;
use rayreel_machine::work::ops::OpKind;
use rayreel_machine::work::synthetic::Random;
use rayreel_machine::work::{NO_RAY, NO_TRIANGLE, TileWork};

use super::harness::{SHAPE, machine, random_machine, random_work, recorded, run_real};

/// What tiles ask for, counted from their rays and operations.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Demand {
    pub rays: u64,
    pub visits: u64,
    pub leaves: u64,
    pub tests: u64,
    pub pushes: u64,
    pub stack: u64,
    pub culled: u64,
    /// Rays whose stack is found empty at their end.
    pub ends: u64,
    /// Items by kernel, in the order of the report.
    pub items: [u64; KERNELS],
    /// Shadow rays beyond the first of their hit.
    pub lights: u64,
    /// Reflection and refraction rays.
    pub secondary: u64,
}

impl Demand {
    /// Of all tiles; primaries are left out of tracing where a rasteriser finds them.
    pub fn of(config: &MachineConfig, tiles: &[TileWork]) -> Self {
        let (mut sum, raster) = (Self::default(), config.gpu.primary_visibility == PrimaryVisibility::Raster);
        for tile in tiles {
            for (i, ray) in (0..).zip(&tile.rays) {
                let primary = ray.kind == RayKind::Primary;
                sum.items[0] += u64::from(primary && !raster);
                match (ray.kind, ray.triangle) {
                    (RayKind::Shadow, _) => sum.items[3] += 1,
                    (_, NO_TRIANGLE) => sum.items[2] += 1,
                    _ => {
                        sum.items[1] += 1;
                        sum.lights += u64::from((ray.shadows + ray.known_lights).saturating_sub(1));
                        sum.secondary += u64::from(ray.reflect != NO_RAY) + u64::from(ray.refract != NO_RAY);
                    }
                }
                if !(raster && primary) {
                    sum.rays += 1;
                    tile.path(i).iter().for_each(|op| sum.count(op.kind()));
                }
            }
            for round in &tile.rounds {
                let counts =
                    [round.tests, round.colours, round.interpolated, round.attributes, round.shaded, round.looked_back];
                sum.items[4..10].iter_mut().zip(counts).for_each(|(sum, count)| *sum += u64::from(count));
            }
            sum.items[5] += u64::from(tile.audited_samples);
            sum.items[KernelId::Resolve as usize] += tile.rect.len() as u64;
        }
        sum
    }

    fn count(&mut self, kind: OpKind) {
        match kind {
            OpKind::Visit { defers, .. } => {
                self.visits += 1;
                self.pushes += u64::from(defers);
            }
            OpKind::Leaf { tests, .. } => {
                self.leaves += 1;
                self.tests += u64::from(tests);
            }
            OpKind::Pop { .. } => self.stack += 1,
            OpKind::Cull { .. } => (self.stack, self.culled) = (self.stack + 1, self.culled + 1),
            OpKind::End => (self.stack, self.ends) = (self.stack + 1, self.ends + 1),
        }
    }

    /// Issue slots that one traversal unit would need, by stage.
    fn traversal(&self, config: &MachineConfig, restarts: u64) -> Vec<(&'static str, u64)> {
        let nodes = (self.visits + restarts) * u64::from(2 / config.ti.aabbs_per_cycle);
        match config.ti.pipeline {
            Pipeline::Parallel => vec![("inner nodes", nodes), ("leaves", self.leaves), ("stack", self.stack)],
            Pipeline::Single => vec![("pipeline", nodes + self.leaves + self.stack)],
            Pipeline::Unified => vec![("pipeline", nodes + self.tests + self.stack)],
            Pipeline::Gathering => {
                let [boxes, triangles] = [config.ti.gather_boxes, config.ti.gather_triangles].map(u64::from);
                vec![("boxes", self.visits.div_ceil(boxes)), ("triangles", self.tests.div_ceil(triangles))]
            }
            Pipeline::Software => self.instructions(config),
        }
    }

    /// Cycles that one processor would need, by class of instructions: all lanes at work, and every unit in every cycle.
    fn instructions(&self, config: &MachineConfig) -> Vec<(&'static str, u64)> {
        let Processor { units, code, lanes, issue, vector, kernel_mix, .. } = &config.processor;
        let times =
            [(code.ray, self.rays), (code.visit, self.visits), (code.triangle, self.tests), (code.pop, self.stack)];
        let sum = |of: fn(&Block) -> u32| times.iter().map(|(block, times)| u64::from(of(block)) * times).sum::<u64>();
        let kernels: u64 = self.items.iter().zip(intervals_and_ops(config)).map(|(n, k)| n * k.1).sum();
        // Shares are rounded down item by item, and so by less than an operation each.
        let shared = |percent: u32| (kernels * u64::from(percent) / 100).saturating_sub(self.items.iter().sum());
        let all = [
            ("adders", sum(|b| b.add) + shared(kernel_mix.add_percent), units.add),
            ("multipliers", sum(|b| b.multiply) + shared(kernel_mix.multiply_percent), units.multiply),
            ("comparators", sum(|b| b.compare) + shared(kernel_mix.compare_percent), units.compare),
            ("integer units", sum(|b| b.integer) + shared(kernel_mix.integer_percent), units.integer),
            ("reciprocals", sum(|b| b.special) + shared(kernel_mix.special_percent), units.special),
            ("banks", sum(|b| b.memory) + shared(kernel_mix.memory_percent), units.memory),
        ];
        let issued: u64 = all.iter().map(|(_, operations, _)| operations).sum();
        let issue = ("issue", issued / u64::from(lanes * vector * issue));
        all.map(|(name, operations, units)| (name, operations / u64::from(units))).into_iter().chain([issue]).collect()
    }

    /// SRP cycles of all items, without prologues.
    fn kernels(&self, config: &MachineConfig) -> u64 {
        let (k, srp) = (&config.srp.kernels, &config.srp);
        let items: u64 = self.items.iter().zip(intervals_and_ops(config)).map(|(n, k)| n * k.0).sum();
        let sorted = if srp.divergence == Divergence::Inspector { self.items[1] + self.items[4] } else { 0 };
        items
            + self.lights * u64::from(k.light.ii_cycles)
            + self.secondary * u64::from(k.secondary.ii_cycles)
            + sorted * u64::from(srp.inspector_cycles)
    }

    /// Least T&I cycles of a run, unit by unit.
    pub fn bounds(&self, config: &MachineConfig, stats: &Stats) -> Vec<(&'static str, u64)> {
        let (ti, cores) = (&config.ti, u64::from(config.gpu.cores));
        let restarts = stats.cores.iter().flat_map(|c| &c.ti.trv).map(|t| t.events.restart_visits).sum();
        let units = cores * u64::from(ti.trv);
        let mut all: Vec<_> =
            self.traversal(config, restarts).into_iter().map(|(n, x)| (n, x.div_ceil(units))).collect();
        all.push(("dispatcher", self.rays.div_ceil(cores)));
        if ti.ist > 0 {
            all.push(("triangles", self.tests.div_ceil(cores * u64::from(ti.ist))));
        }
        if !config.srp.ideal && ti.pipeline != Pipeline::Software {
            let cycles = self.kernels(config).div_ceil(cores);
            all.push(("SRP", cycles * u64::from(ti.clock_mhz) / u64::from(config.srp.clock_mhz)));
            let message = |bytes: u32| u64::from(bytes.div_ceil(config.gpu.interface_bytes_per_cycle));
            let longest = message(config.gpu.ray_message_bytes).max(message(config.gpu.hit_message_bytes));
            let direct = config.gpu.interface == Interface::Direct;
            all.push(("interface", self.rays.div_ceil(cores) * if direct { longest } else { 1 }));
        }
        let dram = &config.dram;
        for channel in &stats.memory.channels {
            let busy = (channel.reads + channel.writes) * u64::from(dram.tccd);
            all.push(("DRAM channel", busy * u64::from(ti.clock_mhz) / u64::from(dram.clock_mhz)));
        }
        all
    }
}

/// No unit works faster than it can, and the DRAM's bandwidth is never above its peak.
pub fn assert_bounds(what: &str, config: &MachineConfig, tiles: &[TileWork], stats: &Stats) {
    for (unit, least) in Demand::of(config, tiles).bounds(config, stats) {
        assert!(stats.cycles >= least, "{what}: {} cycles, but {unit} alone needs {least}", stats.cycles);
    }
    let (dram, total) = (&config.dram, stats.memory.dram());
    let moved = (total.reads + total.writes) * u64::from(dram.burst_bytes);
    // Peak: a burst every tCCD of the DRAM's clock in each channel.
    let peak =
        u64::from(dram.channels) * u64::from(dram.burst_bytes) * u64::from(dram.clock_mhz) / u64::from(dram.tccd);
    assert!(
        moved * u64::from(config.ti.clock_mhz) <= peak * stats.cycles,
        "{what}: {moved} B in {} cycles",
        stats.cycles
    );
    // What was accepted is what was moved, but for writes that wait in the queues at the end.
    let lines = u64::from(config.l2.line_bytes);
    let waiting = u64::from(dram.channels) * u64::from(dram.write_queue_entries) * lines;
    let accepted = stats.memory.traffic.total();
    assert!(moved <= accepted && accepted <= moved + waiting, "{what}: {accepted} B accepted, {moved} B moved");
}

#[test]
fn recorded_work_is_never_faster_than_its_busiest_unit() {
    for work in recorded() {
        for name in ["sgrt-ti2", "hybrid-raster", "gr6500", "mimd-trax", "simt-mimd", "simt-mimd-vector"] {
            let config = machine(name, &[]);
            assert_bounds(&format!("{}, {name}", work.name), &config, &work.tiles, &work.real(&config));
        }
    }
}

#[test]
fn random_machines_are_never_faster_than_their_busiest_unit() {
    for seed in 0..40 {
        let (tree, tiles) = random_work(seed);
        let config = random_machine(&mut Random(seed + 1000));
        let stats = run_real(&config, (&tree, &tiles), SHAPE);
        assert_bounds(&format!("seed {seed}"), &config, &tiles, &stats);
    }
}

/// A machine that only waits for memory comes near the peak, so the bound above is no empty one.
#[test]
fn the_dram_can_be_driven_to_its_peak() {
    use rayreel_machine::component::Tick;
    use rayreel_machine::memory::{Memory, MemorySystem, Port, Request, Route};
    use rayreel_machine::time::TiCycle;
    use rayreel_machine::work::layout::Region;
    let config = machine("sgrt-ti2", &["dram.trefi=1000000"]);
    let (mut memory, mut now, mut line, mut arrived) = (MemorySystem::new(&config), TiCycle(0), 0, Vec::new());
    while line < 12_000 {
        let request = Request { port: Port(0), line, region: Region::Sample, route: Route::Read };
        if memory.request(now, request) {
            line += 1;
        } else {
            now += 1;
            memory.tick(now, &mut arrived);
        }
    }
    let dram = &config.dram;
    let peak = u64::from(dram.channels * dram.burst_bytes) * u64::from(dram.clock_mhz) / u64::from(dram.tccd);
    let reached = arrived.len() as u64 * 64 * u64::from(config.ti.clock_mhz) / now.0;
    assert!(reached <= peak && reached * 100 >= peak * 97, "{reached} of {peak} MB/s");
}

/// Interval and operations of an item of each kernel, under the paper's tests.
pub fn intervals_and_ops(config: &MachineConfig) -> [(u64, u64); KERNELS] {
    let (k, test, mix) = (&config.srp.kernels, &config.srp.test_ops, &config.srp.mix_ops);
    let fixed = |k: Kernel| (u64::from(k.ii_cycles), u64::from(k.ops));
    let made = |ops: u32| (u64::from(ops.div_ceil(config.srp.ops_per_cycle)).max(1), u64::from(ops));
    [
        fixed(k.raygen),
        fixed(k.shade),
        fixed(k.miss),
        fixed(k.update),
        made(k.similarity.ops + test.object + test.normal + test.shadow),
        made(k.colour.ops),
        made(k.interpolate.ops),
        made(k.attributes.ops + mix.identity + mix.normal),
        fixed(k.shade),
        made(k.look_back.ops),
        made(k.control.ops),
        fixed(k.resolve),
    ]
}
