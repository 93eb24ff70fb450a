use super::*;
use crate::component::{Component, Tick};
use crate::config::{Bytes, Replacement};
use crate::memory::{IdealMemory, MemoryStats, Response};
use crate::time::When;

const REGION: Region = Region::Node;

fn l1(mshrs: u32) -> L1Cache {
    let config = config::L1 { size: Bytes(4 * 64), ways: 2, mshrs, latency_cycles: 2, replacement: Replacement::Lru };
    L1Cache::new(&config, 64, Port(9))
}

/// Takes nothing.
struct Deaf;

impl Memory for Deaf {
    fn request(&mut self, _: TiCycle, _: Request) -> bool {
        false
    }
}

impl Component for Deaf {
    type Report = MemoryStats;

    fn next_event(&self, _: TiCycle) -> When {
        When::NEVER
    }

    fn finish(&mut self, _: TiCycle) -> MemoryStats {
        MemoryStats::default()
    }
}

impl Tick<&mut Vec<Response>> for Deaf {
    fn tick(&mut self, _: TiCycle, _: &mut Vec<Response>) {}
}

#[test]
fn a_miss_merges_later_ones_and_wakes_all() {
    let (mut cache, mut memory) = (l1(2), IdealMemory::new(10));
    assert_eq!(cache.access(TiCycle(5), 8, REGION, 0, &mut memory), Access::Miss);
    assert_eq!(cache.access(TiCycle(6), 8, REGION, 127, &mut memory), Access::Merged);
    assert_eq!(cache.fetch(TiCycle(7), 8, REGION, &mut memory), Access::Merged);
    assert_eq!((memory.reads(), cache.outstanding()), (1, 1));
    let mut arrived = Vec::new();
    memory.tick(TiCycle(15), &mut arrived);
    assert_eq!(arrived, [Response { port: Port(9), line: 8 }]);
    assert_eq!(cache.fill(8), 1 << 127 | 1);
    assert_eq!(cache.access(TiCycle(16), 8, REGION, 3, &mut memory), Access::Hit);
    let c = cache.counters();
    assert_eq!((c.lookups, c.hits, c.misses, c.merges, c.full, c.fills), (4, 1, 1, 2, 0, 1));
}

#[test]
fn without_an_mshr_hits_and_merges_go_on() {
    let (mut cache, mut memory) = (l1(1), IdealMemory::new(10));
    cache.fetch(TiCycle(0), 1, REGION, &mut memory);
    assert_eq!(cache.fill(1), 0);
    assert_eq!(cache.access(TiCycle(1), 2, REGION, 0, &mut memory), Access::Miss);
    assert!(!cache.has_free_mshr());
    assert_eq!(cache.access(TiCycle(1), 3, REGION, 1, &mut memory), Access::Rejected);
    assert_eq!(cache.access(TiCycle(1), 2, REGION, 1, &mut memory), Access::Merged);
    assert_eq!(cache.access(TiCycle(1), 1, REGION, 1, &mut memory), Access::Hit);
    assert_eq!((memory.reads(), cache.counters().full, cache.counters().lookups), (2, 1, 4));
    assert_eq!(cache.fill(2), 0b11);
    assert_eq!(cache.access(TiCycle(2), 3, REGION, 1, &mut memory), Access::Miss);
}

#[test]
fn a_refusing_memory_changes_nothing() {
    let mut cache = l1(4);
    assert_eq!(cache.access(TiCycle(0), 1, REGION, 0, &mut Deaf), Access::Rejected);
    assert_eq!((cache.outstanding(), cache.counters().full, cache.counters().lookups), (0, 1, 0));
}

#[test]
fn lines_leave_by_age_and_by_invalidation() {
    let (mut cache, mut memory) = (l1(4), IdealMemory::new(10));
    // Two sets: even lines share one of two ways.
    for line in [0, 2, 4] {
        cache.fetch(TiCycle(0), line, REGION, &mut memory);
        cache.fill(line);
    }
    assert!(!cache.contains(0) && cache.contains(2) && cache.contains(4));
    assert_eq!(cache.counters().evictions, 1);
    cache.invalidate(2);
    cache.invalidate(2);
    assert!(!cache.contains(2));
    assert_eq!(cache.counters().invalidations, 1);
}

#[test]
fn a_line_invalidated_on_its_way_reaches_its_waiters_only() {
    let (mut cache, mut memory) = (l1(4), IdealMemory::new(10));
    cache.access(TiCycle(0), 6, REGION, 5, &mut memory);
    cache.invalidate(6);
    assert_eq!(cache.fill(6), 1 << 5);
    assert!(!cache.contains(6));
    assert_eq!((cache.counters().fills, cache.counters().dropped), (0, 1));
}
