//! Time may be walked or jumped through, and threads are no input.

use rayreel_machine::component::{Component, Tick};
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::memory::{Memory, MemoryStats, MemorySystem, Request, Response};
use rayreel_machine::stats::Stats;
use rayreel_machine::system::NoProbe;
use rayreel_machine::time::{TiCycle, When};
use rayreel_machine::work::synthetic::Random;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::simulate::simulate;
use rayreel_replay::{NamedPolicy, Options, Replayer, TileSource};

use super::harness::{SHAPE, golden, machine, random_machine, random_work, run_keeping, run_real};

/// A memory that has something to say in every cycle.
struct EveryCycle {
    inner: MemorySystem,
    ticks: u64,
}

impl Memory for EveryCycle {
    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        self.inner.request(now, request)
    }

    fn is_idle(&self, now: TiCycle) -> bool {
        self.inner.is_idle(now)
    }

    fn bytes_moved(&self) -> u64 {
        self.inner.bytes_moved()
    }

    fn take_evicted(&mut self) -> Vec<u64> {
        self.inner.take_evicted()
    }
}

impl Component for EveryCycle {
    type Report = MemoryStats;

    fn next_event(&self, now: TiCycle) -> When {
        When::at(now + 1)
    }

    fn finish(&mut self, end: TiCycle) -> MemoryStats {
        self.inner.finish(end)
    }
}

impl Tick<&mut Vec<Response>> for EveryCycle {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.ticks += 1;
        self.inner.tick(now, arrived);
    }
}

#[test]
fn every_cycle_or_from_event_to_event() {
    for seed in 0..24 {
        let (tree, tiles) = random_work(seed);
        let mut config = random_machine(&mut Random(seed));
        if let Some(name) = ["gr6500", "mimd-trax", "simt-mimd", "simt-mimd-vector"].get(seed as usize) {
            config = machine(name, &[]);
        }
        config.l2.inclusive = seed % 2 == 0;
        let memory = EveryCycle { inner: MemorySystem::new(&config), ticks: 0 };
        let (walked, memory) = run_keeping(&config, (&tree, &tiles), SHAPE, memory);
        // And a few more until the last writes are out.
        assert!(memory.ticks >= walked.cycles, "seed {seed} was walked");
        assert_eq!(walked, run_real(&config, (&tree, &tiles), SHAPE), "seed {seed}");
    }
}

fn with_threads(threads: usize) -> Vec<(Stats, EnergyReport)> {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    pool.install(|| {
        let (trace, config) = (golden("v1_0_teapot.rtrace"), machine("sgrt-ti2", &[]));
        let tree = Topology::new(trace.bvh());
        let one = |policy: &str| {
            let policy = NamedPolicy::load(policy, &[]).unwrap();
            let mut replayer = Replayer::new(&trace, &policy.policy, Options::default()).unwrap();
            let frame = TileSource::meta(&trace).first_frame;
            let machine = ("sgrt-ti2", &config);
            let frame = simulate(&mut replayer, frame, &tree, machine, &mut NoProbe).unwrap();
            (frame.stats, frame.energy)
        };
        ["full", "adaptive"].map(one).into()
    })
}

#[test]
fn threads_and_repetition_change_nothing() {
    let one = with_threads(1);
    assert_eq!(one, with_threads(3));
    assert_eq!(one, with_threads(1));
}
