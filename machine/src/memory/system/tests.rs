use super::*;
use crate::config::{Bytes, Replacement};
use crate::memory::dram::tests::{Dice, lpddr4};
use crate::memory::tags::Tags;
use crate::work::layout::Region;

fn l2() -> config::L2 {
    config::L2 {
        size: Bytes(64 << 10),
        ways: 8,
        banks: 4,
        request_bytes: 8,
        queue_entries: 8,
        mshrs: 32,
        latency_cycles: 10,
        replacement: Replacement::Lru,
        inclusive: false,
        line_bytes: 64,
    }
}

fn system() -> MemorySystem {
    MemorySystem::of(500, &l2(), &lpddr4())
}

fn cached(port: u16, line: u64) -> Request {
    Request { port: Port(port), line, region: Region::Node, route: Route::Cached }
}

/// Lines that arrive at exactly `now`, and none before.
#[track_caller]
fn assert_arrive(memory: &mut MemorySystem, now: u64, expected: &[(u16, u64)]) {
    let mut arrived = Vec::new();
    memory.tick(TiCycle(now - 1), &mut arrived);
    assert_eq!(arrived, [], "at {}", now - 1);
    memory.tick(TiCycle(now), &mut arrived);
    let arrived: Vec<_> = arrived.iter().map(|r| (r.port.0, r.line)).collect();
    assert_eq!(arrived, expected, "at {now}");
}

#[test]
fn a_miss_takes_l2_and_dram_and_a_hit_the_l2() {
    let mut memory = system();
    assert!(memory.request(TiCycle(5), cached(1, 77)));
    // Lookup at 6, leaves at 16; in DRAM cycles: 51.2, so 52, synchroniser 54, half controller 78, ACT; RD at 107, second burst
    // 115, data 155, half controller 179; in T&I cycles 55.9, so 56, synchroniser 58.
    assert_arrive(&mut memory, 58, &[(1, 77)]);
    assert!(memory.is_idle(TiCycle(58)));
    assert!(memory.request(TiCycle(100), cached(1, 77)));
    assert_arrive(&mut memory, 111, &[(1, 77)]);
    let c = memory.l2_counters();
    assert_eq!((c.lookups, c.hits, c.misses, c.fills), (2, 1, 1, 1));
    assert_eq!((memory.traffic().read[0], memory.traffic().total()), (64, 64));
}

#[test]
fn other_clocks_meet_at_their_edges() {
    let mut memory = MemorySystem::of(533, &l2(), &lpddr4());
    assert!(memory.request(TiCycle(5), cached(1, 77)));
    // Leaves at 16: 48.03 DRAM cycles, so 49, 51, 75; data 152, 176: 58.6 T&I cycles, so 59, 61.
    assert_arrive(&mut memory, 61, &[(1, 77)]);
}

#[test]
fn a_read_past_the_l2_leaves_at_once_and_is_not_kept() {
    let mut memory = system();
    let request = Request { route: Route::Read, region: Region::Sample, ..cached(2, 77) };
    assert!(memory.request(TiCycle(5), request));
    // Leaves at 5: DRAM cycle 16, 18, 42; data 119, 143; 44.7, so 45, 47.
    assert_arrive(&mut memory, 47, &[(2, 77)]);
    assert!(!memory.l2().contains(77));
    assert_eq!(memory.traffic().read[Region::Sample as usize], 64);
}

#[test]
fn writes_get_no_answer_but_reach_the_dram() {
    let mut memory = system();
    let request = Request { route: Route::Write, region: Region::Framebuffer, ..cached(2, 77) };
    assert!(memory.request(TiCycle(5), request));
    let mut now = TiCycle(5);
    while let Some(next) = memory.next_event(now).cycle() {
        let mut arrived = Vec::new();
        memory.tick(next, &mut arrived);
        now = next;
        assert_eq!(arrived, []);
    }
    assert_eq!((memory.dram_counters().writes, memory.traffic().written[8]), (2, 64));
}

#[test]
fn misses_of_a_line_merge_and_are_answered_together_in_order() {
    let mut memory = system();
    for port in [3, 1, 2] {
        assert!(memory.request(TiCycle(5), cached(port, 77)));
    }
    assert_arrive(&mut memory, 58, &[(3, 77), (1, 77), (2, 77)]);
    let c = memory.l2_counters();
    assert_eq!((c.misses, c.merges, memory.dram_counters().reads), (1, 2, 2));
}

#[test]
fn a_bank_looks_up_one_a_cycle_and_banks_work_side_by_side() {
    let mut memory = system();
    let lines = [0, 4, 8, 1, 2];
    for line in lines {
        assert!(memory.request(TiCycle(0), cached(0, line)));
    }
    memory.tick(TiCycle(500), &mut Vec::new());
    for line in lines {
        assert!(memory.request(TiCycle(500), cached(0, line)));
    }
    // The bank that looks first at cycle 501 is 1.
    assert_arrive(&mut memory, 511, &[(0, 1), (0, 2), (0, 0)]);
    assert_arrive(&mut memory, 512, &[(0, 4)]);
    assert_arrive(&mut memory, 513, &[(0, 8)]);
}

#[test]
fn a_full_bank_refuses() {
    let mut memory = MemorySystem::of(500, &config::L2 { queue_entries: 2, ..l2() }, &lpddr4());
    assert!(memory.request(TiCycle(0), cached(0, 0)) && memory.request(TiCycle(0), cached(0, 4)));
    assert!(!memory.request(TiCycle(0), cached(0, 8)));
    assert!(memory.request(TiCycle(0), cached(0, 1)));
    assert!(memory.request(TiCycle(1), cached(0, 8)), "the lookup of cycle 1 freed an entry");
    assert_eq!(memory.l2_counters().full, 1);
}

#[test]
fn without_an_mshr_the_head_waits_and_its_bank_with_it() {
    let mut memory = MemorySystem::of(500, &config::L2 { mshrs: 1, ..l2() }, &lpddr4());
    assert!(memory.request(TiCycle(5), cached(0, 77)) && memory.request(TiCycle(5), cached(0, 4)));
    assert!(memory.request(TiCycle(5), cached(0, 77 + 4)) && memory.request(TiCycle(5), cached(0, 77)));
    // Bank 0 looks before bank 1 at cycle 6: line 4 takes the MSHR and comes at 58, as if alone; then line 77, the head of bank 1
    // since 6, takes it. Line 81 waits for that, and the second 77 behind it finds its line there.
    assert_arrive(&mut memory, 58, &[(0, 4)]);
    assert_eq!((memory.l2_counters().misses, memory.l2_counters().blocked), (2, 52));
    let mut arrived = Vec::new();
    memory.tick(TiCycle(1000), &mut arrived);
    assert_eq!(arrived.iter().map(|r| r.line).collect::<Vec<_>>(), [77, 77, 81]);
}

#[test]
fn an_inclusive_l2_reports_what_leaves() {
    let small = config::L2 { size: Bytes(2 * 64), ways: 2, banks: 1, inclusive: true, ..l2() };
    let mut memory = MemorySystem::of(500, &small, &lpddr4());
    for line in 0..4 {
        assert!(memory.request(TiCycle(line * 1000), cached(0, line)));
        memory.tick(TiCycle(line * 1000 + 999), &mut Vec::new());
    }
    assert_eq!((memory.take_evicted(), memory.take_evicted()), (vec![0, 1], vec![]));
}

#[test]
fn hits_are_those_of_the_tags_alone() {
    let mut memory = system();
    let mut tags = Tags::new(64 << 10, 8, 64, Replacement::Lru);
    let mut dice = Dice(3);
    let (mut now, mut hits) = (0, 0);
    for _ in 0..5000 {
        let line = dice.roll(2000);
        hits += u64::from(tags.touch(line) || tags.insert(line).is_some_and(|_| false));
        assert!(memory.request(TiCycle(now), cached(0, line)));
        while let Some(TiCycle(next)) = memory.next_event(TiCycle(now)).cycle() {
            now = next;
            memory.tick(TiCycle(now), &mut Vec::new());
        }
        now += 1;
    }
    assert_eq!((memory.l2_counters().hits, memory.l2_counters().lookups), (hits, 5000));
    assert!(hits > 1000);
}

/// What happened: at each cycle which request of which port was taken, or which line came.
type Log = Vec<(u64, bool, u16, u64)>;

/// Ports that ask in order, each request not before its time, and again until it is taken.
fn drive(memory: &mut MemorySystem, mut ports: Vec<Vec<(u64, Request)>>, step: bool) -> Log {
    let (mut log, mut now, mut arrived) = (Log::new(), 0, Vec::new());
    ports.iter_mut().for_each(|port| port.reverse());
    loop {
        memory.tick(TiCycle(now), &mut arrived);
        log.extend(arrived.drain(..).map(|r| (now, false, r.port.0, r.line)));
        for port in &mut ports {
            while let Some(&(at, request)) = port.last()
                && at <= now
                && memory.request(TiCycle(now), request)
            {
                port.pop();
                log.push((now, true, request.port.0, request.line));
            }
        }
        let heads = ports.iter().filter_map(|port| port.last()).map(|&(at, _)| at).filter(|&at| at > now);
        let event = memory.next_event(TiCycle(now)).cycle().map(|at| at.0);
        let Some(next) = heads.chain(event).min() else { break };
        assert!(next > now, "an event of the past");
        now = if step { now + 1 } else { next };
    }
    assert!(ports.iter().all(Vec::is_empty), "a request was never taken");
    log
}

fn traffic(seed: u64) -> Vec<Vec<(u64, Request)>> {
    let mut dice = Dice(seed);
    let (span, lines) = ([1, 3, 40, 400][seed as usize % 4], [100, 3000, 100_000][seed as usize % 3]);
    let mut port = |port: u16| {
        let mut at = 0;
        let mut request = |_| {
            at += dice.roll(span);
            let route = [Route::Cached, Route::Cached, Route::Cached, Route::Read, Route::Write][dice.roll(5) as usize];
            let region = Region::ALL[dice.roll(9) as usize];
            (at, Request { port: Port(port), line: dice.roll(lines), region, route })
        };
        (0..250).map(&mut request).collect()
    };
    (0..6).map(&mut port).collect()
}

#[test]
fn skipping_and_stepping_are_the_same_and_each_read_is_answered_once() {
    for seed in 0..48 {
        let small = config::L2 { mshrs: 1 + seed as u32 % 7, queue_entries: 1 + seed as u32 % 5, ..l2() };
        let entries = 1 + seed as u32 % 6;
        let dram = config::Dram {
            channels: 1 + seed as u32 % 3,
            read_queue_entries: entries,
            write_queue_entries: entries + 2,
            write_high: entries,
            write_low: entries / 2,
            sync_cycles: seed as u32 % 3,
            controller_cycles: seed as u32 % 2 * 30,
            ..lpddr4()
        };
        let clock = [500, 533, 1600][seed as usize % 3];
        let [skipped, stepped] = [false, true].map(|step| {
            let mut memory = MemorySystem::of(clock, &small, &dram);
            let log = drive(&mut memory, traffic(seed), step);
            (log, memory)
        });
        assert!(skipped.0 == stepped.0, "seed {seed}");
        let bursts = |m: &MemorySystem| (m.dram_counters().reads, m.dram_counters().writes, *m.traffic());
        assert_eq!(bursts(&skipped.1), bursts(&stepped.1));
        let counts = |m: &MemorySystem| L2Counters { full: 0, ..*m.l2_counters() };
        assert_eq!(counts(&skipped.1), counts(&stepped.1));
        answered_once(&skipped.0, traffic(seed));
        let c = skipped.1.dram_counters();
        assert_eq!(skipped.1.traffic().total(), 32 * (c.reads + c.writes));
    }
}

fn answered_once(log: &Log, traffic: Vec<Vec<(u64, Request)>>) {
    let asked = traffic.iter().flatten().filter(|(_, r)| r.route != Route::Write);
    let mut asked: Vec<_> = asked.map(|(_, r)| (r.port.0, r.line)).collect();
    let mut got: Vec<_> = log.iter().filter(|entry| !entry.1).map(|&(_, _, port, line)| (port, line)).collect();
    asked.sort_unstable();
    got.sort_unstable();
    assert_eq!(asked, got);
}

#[test]
fn bandwidth_comes_near_the_peak_and_never_above() {
    let dram = config::Dram { channels: 4, read_queue_entries: 64, controller_cycles: 8, ..lpddr4() };
    let mut memory = MemorySystem::of(500, &config::L2 { mshrs: 256, queue_entries: 64, ..l2() }, &dram);
    let stream = |port: u16| (0..4000).map(|i| (0, Request { route: Route::Read, ..cached(port, i) })).collect();
    let log = drive(&mut memory, vec![stream(0)], false);
    let cycles = log.last().expect("lines came").0;
    // 4 channels x 2 B x 3.2 G/s at 500 MHz: 51.2 B a T&I cycle.
    let peak = cycles * 512 / 10;
    let bytes = memory.traffic().total();
    assert!(bytes <= peak && bytes * 10 > peak * 8, "{bytes} of {peak}");
}
