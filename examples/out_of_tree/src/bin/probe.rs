//! A probe of another package, which sees what units ask of memory and how busy they are: `cargo run --release --bin probe`, here.
//!
//! `Reuse` stands between the machine and its memory. It is told of every node and triangle that a unit of this machine looks for (other
//! machines tell nothing: `rayreel_machine::ports::tells_lookups`), and passes requests on as they are, so the machine does what it
//! does without it. `Busy` looks at the units every 10000 cycles.

use std::collections::{BTreeMap, BTreeSet};

use rayreel_formats::{Limits, Trace};
use rayreel_machine::NamedMachine;
use rayreel_machine::component::{Component, Tick};
use rayreel_machine::memory::{Lookup, Memory, MemorySystem, Request, Response};
use rayreel_machine::ports::{askers, place};
use rayreel_machine::system::{Core, Probe};
use rayreel_machine::time::{TiCycle, When};
use rayreel_machine::work::layout::{Layout, Region};
use rayreel_replay::{NamedPolicy, Options, PathSource, ReplayError, Replayer, simulate::simulate_in_front_of};

/// How many lookups of a unit, and at how many lines of 64 bytes.
struct Reuse {
    behind: MemorySystem,
    layout: Layout,
    /// By port: how often it looked, and at which lines.
    looked: BTreeMap<usize, (u64, BTreeSet<u64>)>,
    requests: u64,
}

impl Memory for Reuse {
    /// Units tell what they look for only to memories that listen.
    const LISTENS: bool = true;

    fn looked_for(&mut self, _: TiCycle, lookup: Lookup) {
        let span = match lookup.region {
            Region::Node => self.layout.node_at(lookup.index),
            _ => self.layout.triangle_at(lookup.index),
        };
        let (count, lines) = self.looked.entry(place(lookup.port)).or_default();
        *count += 1;
        // What begins in one line may end in the next.
        lines.extend(span.address / 64..=(span.address + span.bytes - 1) / 64);
    }

    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        let taken = self.behind.request(now, request);
        self.requests += u64::from(taken);
        taken
    }

    fn is_idle(&self, now: TiCycle) -> bool {
        self.behind.is_idle(now)
    }

    fn bytes_moved(&self) -> u64 {
        self.behind.bytes_moved()
    }

    fn take_evicted(&mut self) -> Vec<u64> {
        self.behind.take_evicted()
    }
}

impl Component for Reuse {
    type Report = <MemorySystem as Component>::Report;

    fn next_event(&self, now: TiCycle) -> When {
        self.behind.next_event(now)
    }

    fn finish(&mut self, end: TiCycle) -> Self::Report {
        self.behind.finish(end)
    }
}

impl Tick<&mut Vec<Response>> for Reuse {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.behind.tick(now, arrived);
    }
}

/// Tiles that are done, and bytes from DRAM, every 10000 cycles.
struct Busy {
    due: u64,
    seen: Vec<(u64, u64, u64)>,
}

impl Probe for Busy {
    fn due(&self) -> When {
        When::at(TiCycle(self.due))
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        let tiles = cores.iter().map(|core| core.srp.tiles_done()).sum();
        self.seen.push((now.0, tiles, bytes));
        self.due = (now.0 / 10_000 + 1) * 10_000;
    }
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let trace = Trace::open("../../traces/v1_0_cornell.rtrace".as_ref(), Limits::default())?;
    let (policy, machine) = (NamedPolicy::load("adaptive", &[])?, NamedMachine::load("sgrt-ti2", &[])?);
    let mut replayer = Replayer::new(&trace, &policy, Options::default())?;
    let config = &machine.config;
    let reuse = |behind| Reuse { behind, layout: Layout::new(config), looked: BTreeMap::new(), requests: 0 };
    let (mut busy, mut looked, mut requests) = (Busy { due: 0, seen: Vec::new() }, BTreeMap::new(), 0);
    let frame = (trace.meta().first_frame, &trace.topology());
    let stats =
        simulate_in_front_of(&mut replayer, frame, (&machine.name, config), (reuse, &mut busy), |memory, _| {
            // After each tile, and at the end: what was written down so far.
            (looked, requests) = (memory.looked.clone(), memory.requests);
            Ok::<_, ReplayError>(())
        })?;
    println!("{} cycles, {requests} requests behind the L1s", stats.cycles);
    for (cycle, tiles, bytes) in busy.seen {
        println!("cycle {cycle:6}: {tiles:2} tiles done, {bytes:6} bytes to and from DRAM");
    }
    for (port, asker) in askers(config).into_iter().enumerate() {
        if let Some((count, lines)) = looked.get(&port) {
            println!("core {} {}: {count:6} lookups of {:4} lines", asker.core, asker.unit, lines.len());
        }
    }
    Ok(())
}
