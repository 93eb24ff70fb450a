//! How long turns take, about: what a core's T&I unit and its SRP do meanwhile decides which rays are out together, and so what
//! the caches find.

use crate::config::{MachineConfig, Pipeline};

/// What a T&I unit did in a turn.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Turned {
    /// Rays that took part.
    pub rays: u64,
    /// Operations of the traversal unit that issued most.
    pub issued: u64,
    pub visits: u64,
    pub leaves: u64,
    pub tests: u64,
    pub stack_operations: u64,
    /// Lookups that missed in the L1s, and lines from DRAM.
    pub misses: u64,
    pub lines: u64,
}

/// Depths of pipelines and latencies of memories, in cycles of the T&I unit.
#[derive(Clone, Debug)]
pub(super) struct Pace {
    ist: f64,
    visit: f64,
    leaf: f64,
    stack: f64,
    miss: f64,
    line: f64,
    /// T&I cycles of a SRP cycle, 0 where the SRP takes no time.
    srp: f64,
}

impl Pace {
    pub fn new(config: &MachineConfig) -> Self {
        let (ti, l2, dram) = (&config.ti, &config.l2, &config.dram);
        let cycles = |sum: u32| f64::from(sum);
        // A row of a bank that is closed is opened and read; a burst follows.
        let read = dram.controller_cycles + dram.trcd + dram.rl + dram.tccd;
        let apart = if ti.pipeline == Pipeline::Parallel { 2 * ti.crossbar_cycles } else { 0 };
        Self {
            ist: cycles(ti.ist.max(1)),
            visit: cycles(ti.inner_cycles + ti.trv_l1.latency_cycles),
            leaf: cycles(ti.leaf_cycles + apart + ti.ist_cycles + ti.ist_l1.latency_cycles),
            stack: cycles(ti.stack_cycles),
            miss: cycles(l2.latency_cycles),
            line: cycles(read) * cycles(ti.clock_mhz) / cycles(dram.clock_mhz.max(1)),
            srp: if config.srp.ideal { 0.0 } else { cycles(ti.clock_mhz) / cycles(config.srp.clock_mhz.max(1)) },
        }
    }

    /// T&I cycles of a turn: as long as the busiest unit issues, or as a ray takes for its part where there are too few to hide that.
    pub fn of_turn(&self, turned: &Turned) -> f64 {
        let of = |events: u64, cycles: f64| events as f64 * cycles;
        let latency = of(turned.visits, self.visit)
            + of(turned.leaves, self.leaf)
            + of(turned.stack_operations, self.stack)
            + of(turned.misses, self.miss)
            + of(turned.lines, self.line);
        let ray = latency / turned.rays.max(1) as f64;
        ray.max(turned.issued as f64).max(turned.tests as f64 / self.ist)
    }

    /// T&I cycles of so many of the SRP.
    pub fn of_srp(&self, cycles: f64) -> f64 {
        cycles * self.srp
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::NamedMachine;

    /// Pipelines of 10 and 30 cycles, L1s of 2, a crossbar of 2 each way.
    #[test]
    fn many_rays_hide_what_few_wait_for() {
        let pace = Pace::new(&NamedMachine::load("sgrt-ti2", &[]).unwrap().config);
        let visits = |rays| Turned { rays, issued: 64, visits: 256, ..Turned::default() };
        assert_eq!(pace.of_turn(&visits(256)), 64.0, "one a cycle in each of four units");
        assert_eq!(pace.of_turn(&visits(16)), 16.0 * 12.0, "sixteen visits of each ray, one after the other");
        let tests = Turned { rays: 256, tests: 700, ..visits(256) };
        assert_eq!(pace.of_turn(&tests), 700.0, "one intersection unit tests them all");
        let leaf = Turned { rays: 1, leaves: 1, tests: 1, misses: 1, lines: 1, ..Turned::default() };
        // 56 + 29 + 34 + 8 cycles of 0.625 ns in the memory are 39.7 of 2 ns.
        assert_eq!(pace.of_turn(&leaf), f64::from(4 + 4 + 30 + 2 + 10) + 127.0 * 500.0 / 1600.0);
        assert_eq!(pace.of_srp(10.0), 5.0, "1000 MHz beside 500");
    }
}
