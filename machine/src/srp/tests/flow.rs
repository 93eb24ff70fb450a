//! Rounds, tiles, back-pressure, accounts.

use std::collections::BTreeSet;

use super::mocks::{Mem, Unit, empty, mixed, run, sample, srp, uniform};
use crate::memory::Route;
use crate::srp::{KernelId, Needs, missing_kernels};
use crate::test_config::machine;
use crate::time::TiCycle;
use crate::work::Round;
use crate::work::layout::Region;

fn two_rounds() -> crate::work::TileWork {
    let mut work = empty(0, 4, 4);
    let first = (0..4).map(|_| sample(&mut work, Some(1), 1, true)).collect();
    work.rounds.push(Round { starts: first, ..Round::default() });
    let second = vec![sample(&mut work, None, 0, false)];
    work.rounds.push(Round { tests: 3, interpolated: 2, starts: second, ..Round::default() });
    work
}

#[test]
fn a_round_waits_for_the_one_before() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(64, 100), Mem::new(64, 10));
    let work = two_rounds();
    let second = work.rounds[1].starts[0];
    run(&mut s, vec![work], &mut unit, &mut memory, true);
    assert_eq!(unit.pushed.len(), 13);
    let (at, last) = unit.pushed[12];
    assert_eq!(last.ray, second);
    let before = unit.pushed[11].0;
    // The last ray of round 0 is back 102 cycles later; then its item, the tests (3 + 20 + 6) and raygen (25) run.
    assert!(at >= before + 102 + (29 + 25) / 2, "{at} after {before}");
    let stats = s.stats();
    assert_eq!(stats.kernels[KernelId::Similarity as usize].cycles, 26);
    assert_eq!(stats.kernels[KernelId::Interpolate as usize].cycles, 24);
    assert_eq!(stats.activity.inspector, 4 + 3);
    assert_eq!(stats.kernels[KernelId::Resolve as usize].items, 16);
}

#[test]
fn a_tile_is_resolved_and_stored_when_its_last_item_is_done() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(64, 100), Mem::new(64, 10));
    let end = run(&mut s, vec![uniform(0, 1, None, 0)], &mut unit, &mut memory, true);
    // The hit is here at 117, SRP cycle 234; miss takes 22 SRP cycles, resolving 4 samples 24: SRP cycle 280.
    let stored: Vec<_> = memory.log.iter().map(|(at, r)| (*at, r.region)).collect();
    assert_eq!(stored, [(140, Region::Framebuffer)]);
    assert_eq!(end, 141, "the slot is free a cycle after memory took the last line");
}

#[test]
fn two_tiles_overlap() {
    let tiles = || vec![uniform(0, 32, Some(0), 1), uniform(1, 32, Some(0), 1)];
    let mut config = machine();
    let mut time = |slots| {
        config.gpu.tiles_in_flight = slots;
        let mut unit = Unit::new(64, 400);
        (run(&mut srp(&config), tiles(), &mut unit, &mut Mem::new(64, 10), true), unit)
    };
    let ((one, alone), (two, together)) = (time(1), time(2));
    assert!(two * 4 < one * 3, "{two} against {one}");
    assert_eq!(alone.pushed.iter().filter(|(_, r)| r.slot == 1).count(), 0);
    let first_of_second = together.pushed.iter().position(|(_, r)| r.slot == 1);
    assert!(first_of_second.is_some_and(|p| p < 64), "the second tile begins before the first is done");
}

#[test]
fn every_ray_is_sent_once_whatever_the_room() {
    for (room, latency) in [(1, 50), (3, 7), (500, 1)] {
        let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(room, latency), Mem::new(4, 30));
        let tiles: Vec<_> = (0..3).map(|t| mixed(t, 60, u64::from(t) + 1)).collect();
        let rays: usize = tiles.iter().map(|t| t.rays.len()).sum();
        let end = run(&mut s, tiles, &mut unit, &mut memory, true);
        assert_eq!(unit.pushed.len(), rays);
        let stats = s.stats();
        assert_eq!((stats.interface.rays, stats.interface.hits), (rays as u64, rays as u64));
        assert_eq!(stats.interface.hit_bytes, rays as u64 * 16);
        assert_eq!(stats.local.tiles, 3);
        assert_eq!(stats.activity.total(), s.cycles(TiCycle(end)), "every SRP cycle in one class");
        let busy: u64 = stats.kernels.iter().map(|k| k.cycles).sum();
        let a = stats.activity;
        assert_eq!(busy, a.raygen + a.shade + a.miss + a.shadow_result + a.similarity + a.interpolate + a.resolve);
    }
}

#[test]
fn no_ray_of_a_tile_is_sent_twice() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(20, 30), Mem::new(8, 30));
    let work = mixed(0, 100, 9);
    let rays = work.rays.len();
    run(&mut s, vec![work], &mut unit, &mut memory, true);
    let each: BTreeSet<u32> = unit.pushed.iter().map(|(_, r)| r.ray).collect();
    assert_eq!((unit.pushed.len(), each.len()), (rays, rays));
}

#[test]
fn a_full_unit_stalls_the_array() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(1, 50), Mem::new(64, 10));
    let end = run(&mut s, vec![uniform(0, 64, None, 0)], &mut unit, &mut memory, true);
    // The room of one ray: one ray each 50 cycles.
    assert!(unit.pushed.windows(2).all(|w| w[1].0 - w[0].0 >= 50));
    assert!(s.stats().activity.output > 2 * 20 * 50, "{:?}", s.stats().activity);
    assert_eq!(s.stats().activity.total(), s.cycles(TiCycle(end)));
}

#[test]
fn the_pixels_of_a_tile_are_written_row_by_row() {
    let (mut s, mut unit, mut memory) = (srp(&machine()), Unit::new(64, 10), Mem::new(64, 10));
    let mut work = uniform(1, 4, None, 0);
    (work.rect.x, work.rect.y, work.rect.width, work.rect.height) = (32, 64, 32, 16);
    run(&mut s, vec![work], &mut unit, &mut memory, true);
    let lines: Vec<u64> =
        memory.log.iter().filter(|(_, r)| r.region == Region::Framebuffer).map(|(_, r)| r.line).collect();
    let expected: Vec<u64> = (32..40).map(|y| (Region::Framebuffer.base() + (y * 1024 + 16) * 4) / 64).collect();
    assert_eq!(lines, expected);
    assert!(memory.log.iter().all(|(_, r)| r.route == Route::Write || r.region != Region::Framebuffer));
    assert_eq!(s.stats().dma.framebuffer_written, 8 * 64);
}

#[test]
fn a_machine_without_a_kernel_says_so() {
    let mut config = machine();
    let needs = Needs::of(&two_rounds());
    assert_eq!(needs, Needs { similarity: true, interpolate: true, look_back: false });
    assert!(missing_kernels(&config, &needs).is_empty());
    config.srp.kernels.similarity.stages = 0;
    assert_eq!(missing_kernels(&config, &needs), ["similarity"]);
    assert!(missing_kernels(&config, &Needs::default()).is_empty());
    let mut work = uniform(1, 4, None, 0);
    work.rounds[0].looked_back = 1;
    config.srp.kernels.look_back.stages = 0;
    assert_eq!(missing_kernels(&config, &Needs::of(&work)), ["look_back"]);
}
