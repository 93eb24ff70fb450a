//! Skipping from event to event gives what ticking every cycle gives.

use super::mocks::{Mem, Unit, mixed, run, srp};
use crate::config::{Divergence, GeometryBuffer, Interface, MachineConfig, PrimaryVisibility};
use crate::test_config::machine;
use crate::time::TiCycle;

fn both_ways(name: &str, config: &MachineConfig) {
    for seed in 0..6u64 {
        let outcome = |skip| {
            let mut unit = Unit { jitter: 60, seed, ..Unit::new(1 + (seed as usize * 13) % 40, 3 + seed * 20) };
            let mut memory = Mem { jitter: 40, seed, ..Mem::new(1 + (seed as usize * 7) % 24, 1 + seed * 9) };
            let tiles = (0..4).map(|t| mixed(t, 40, seed * 10 + u64::from(t))).collect();
            let mut s = srp(config);
            let end = run(&mut s, tiles, &mut unit, &mut memory, skip);
            assert_eq!(s.stats().activity.total(), s.cycles(TiCycle(end)), "{name} {seed}");
            (end, unit.pushed, memory.log, s.stats())
        };
        let (skipped, ticked) = (outcome(true), outcome(false));
        assert_eq!(skipped.1, ticked.1, "{name} {seed}: rays");
        assert_eq!(skipped.2, ticked.2, "{name} {seed}: requests");
        assert_eq!((skipped.0, skipped.3), (ticked.0, ticked.3), "{name} {seed}: end and counters");
    }
}

#[test]
fn skipping_changes_nothing() {
    both_ways("plain", &machine());
    let change = |name: &str, act: fn(&mut MachineConfig)| {
        let mut config = machine();
        act(&mut config);
        both_ways(name, &config);
    };
    change("ideal", |c| c.srp.ideal = true);
    change("memory", |c| c.gpu.interface = Interface::Memory);
    change("ideal through memory", |c| (c.srp.ideal, c.gpu.interface) = (true, Interface::Memory));
    change("external", |c| c.gpu.geometry_buffer = GeometryBuffer::External);
    change("raster", |c| c.gpu.primary_visibility = PrimaryVisibility::Raster);
    change("naive", |c| c.srp.divergence = Divergence::Naive);
    change("odd clock", |c| c.srp.clock_mhz = 733);
    change("slow clock", |c| c.srp.clock_mhz = 210);
    change("narrow link", |c| c.gpu.interface_bytes_per_cycle = 6);
    change("one slot", |c| c.gpu.tiles_in_flight = 1);
    change("few MSHRs", |c| c.srp.l1.mshrs = 2);
}
