//! Exact cycles. The test machine: SRP at twice the T&I clock, raygen 20 + 5, shade 1 + 40 + 22 + 8 a further light.

use super::mocks::{Mem, Unit, run, sample, srp, uniform};
use crate::component::Tick;
use crate::config::Divergence;
use crate::link::RayRef;
use crate::srp::{KernelId, SrpContext};
use crate::test_config::machine;
use crate::time::TiCycle;
use crate::work::Round;

fn pushes(unit: &Unit) -> Vec<u64> {
    unit.pushed.iter().map(|(at, _)| *at).collect()
}

#[test]
fn one_raygen_item_takes_prologue_interval_and_link() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(8, 100), Mem::new(64, 10));
    s.give_tile(TiCycle(0), uniform(0, 1, None, 0).into());
    for cycle in 0..=14 {
        s.tick(TiCycle(cycle), SrpContext { unit: &mut unit, memory: &mut memory });
        assert!(unit.pushed.is_empty(), "no ray at {cycle}");
    }
    // 25 SRP cycles end within T&I cycle 12; one cycle on the link and one of latency.
    s.tick(TiCycle(15), SrpContext { unit: &mut unit, memory: &mut memory });
    assert_eq!(unit.pushed, [(15, RayRef { slot: 0, ray: 0 })]);
}

#[test]
fn a_batch_is_pipelined() {
    let (mut unit, mut memory) = (Unit::new(8, 100), Mem::new(64, 10));
    run(&mut srp(&machine()), vec![uniform(0, 4, None, 0)], &mut unit, &mut memory, true);
    // Complete after 25, 30, 35, 40 SRP cycles: 13, 15, 18, 20 T&I cycles.
    assert_eq!(pushes(&unit), [15, 17, 20, 22]);
}

#[test]
fn shade_costs_the_inspector_and_each_further_light() {
    let (mut unit, mut memory) = (Unit::new(8, 100), Mem::new(64, 10));
    run(&mut srp(&machine()), vec![uniform(0, 1, Some(0), 2)], &mut unit, &mut memory, true);
    // The hit leaves the unit at 115 and is here at 117, SRP cycle 234; 71 SRP cycles later is T&I cycle 153.
    assert_eq!(pushes(&unit), [15, 155, 156]);
}

#[test]
fn shade_waits_for_its_reads() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(8, 100), Mem::new(64, 100));
    run(&mut s, vec![uniform(0, 1, Some(0), 2)], &mut unit, &mut memory, true);
    // Attributes and texel are asked for at 117 and here at 217, SRP cycle 434 instead of 305.
    assert_eq!(pushes(&unit), [15, 219, 220]);
    assert_eq!(s.stats().activity.memory, 434 - 305);
}

#[test]
fn an_l1_that_hits_does_not_delay() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(8, 100), Mem::new(64, 100));
    run(&mut s, vec![uniform(0, 1, Some(0), 2), uniform(1, 1, Some(0), 2)], &mut unit, &mut memory, true);
    assert_eq!(s.stats().kernels[KernelId::Shade as usize].items, 2);
    let reads = memory.log.iter().filter(|(_, r)| r.port == super::mocks::PORTS.l1).count();
    assert_eq!(reads, 2, "the second tile finds both lines");
}

#[test]
fn inspector_sorts_and_naive_pays_for_all() {
    let mut config = machine();
    (config.ti.ray_fifo_entries, config.ti.rays_per_trv) = (0, 0); // never low on rays: full batches only
    let run_it = |config: &crate::config::MachineConfig| {
        let mut s = srp(config);
        let mut work = super::mocks::empty(0, 2, 2);
        let primaries = (0..16).map(|i| sample(&mut work, Some(i % 2), 0, false)).collect();
        work.rounds.push(Round { starts: primaries, ..Round::default() });
        run(&mut s, vec![work], &mut Unit::new(64, 10), &mut Mem::new(64, 10), true);
        let shade = s.stats().kernels[KernelId::Shade as usize];
        (shade.batches, shade.cycles, s.stats().activity.inspector)
    };
    assert_eq!(run_it(&config), (2, 2 * 40 + 16 * 22, 16));
    config.srp.divergence = Divergence::Naive;
    assert_eq!(run_it(&config), (1, 40 + 2 * 16 * 22, 0));
}

#[test]
fn a_slower_srp_is_converted_exactly() {
    let mut config = machine();
    config.srp.clock_mhz = 300; // 5 T&I cycles are 3 SRP cycles
    let (mut unit, mut memory) = (Unit::new(8, 100), Mem::new(64, 10));
    run(&mut srp(&config), vec![uniform(0, 2, None, 0)], &mut unit, &mut memory, true);
    // 25 and 30 SRP cycles are 41.67 and 50 T&I cycles.
    assert_eq!(pushes(&unit), [44, 52]);
}

#[test]
fn ideal_answers_in_the_cycle_of_the_hit() {
    let mut config = machine();
    config.srp.ideal = true;
    let (mut s, mut unit, mut memory) = (srp(&config), Unit::new(8, 100), Mem::new(64, 10));
    run(&mut s, vec![uniform(0, 1, Some(0), 2)], &mut unit, &mut memory, true);
    assert_eq!(pushes(&unit), [0, 100, 100]);
    assert_eq!(s.stats().interface.ray_bytes, 3 * 32);
    assert_eq!(s.stats().activity.shade, 0);
    assert_eq!(s.l1().counters().lookups, 2, "its reads are made");
}
