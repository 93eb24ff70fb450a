//! The controller: sequences worked out by hand, with lines of two bursts.

use super::{Bench, Dice, lpddr4};
use crate::config;
use crate::time::{DramCycle, When};

#[test]
fn one_read_opens_its_row() {
    let mut b = Bench::new(&lpddr4());
    b.read(10, 3, 5);
    assert_eq!(b.channel.next_event(), When::at(DramCycle(10)));
    b.run(9);
    assert!(b.commands().is_empty());
    b.run(6000);
    assert_eq!(b.commands(), ["ACT 3 @10", "RD 3 @39"]);
    // Second burst at 47, its data 32 later, 8 long.
    assert_eq!(b.done, [(87, 0)]);
    assert!(b.channel.next_event().is_never());
}

#[test]
fn hits_then_a_conflict() {
    let mut b = Bench::new(&lpddr4());
    [1, 1, 2].into_iter().for_each(|row| b.read(10, 0, row));
    b.run(6000);
    // PRE: tRAS (10 + 68) is later than tRTP after the last burst (63 + 12).
    let expected = ["ACT 0 @10", "RD 0 @39", "RD 0 @55", "PRE 0 @78", "ACT 0 @107", "RD 0 @136"];
    assert_eq!(b.commands(), expected);
    let c = *b.channel.counters();
    assert_eq!((c.row_closed, c.row_hits, c.row_conflicts), (1, 1, 1));
    assert_eq!((c.activates, c.precharges, c.reads, c.bus_busy), (2, 1, 6, 48));
    assert_eq!(c.read_latency, (87 - 10) + (103 - 10) + (184 - 10));
}

#[test]
fn a_younger_hit_goes_first_and_keeps_the_row_open() {
    let mut b = Bench::new(&lpddr4());
    [1, 2, 1].into_iter().for_each(|row| b.read(10, 0, row));
    b.run(6000);
    assert_eq!(b.done.iter().map(|d| d.1).collect::<Vec<_>>(), [0, 2, 1]);
    assert_eq!(b.channel.counters().precharges, 1);
}

#[test]
fn banks_open_in_parallel() {
    let mut b = Bench::new(&lpddr4());
    (0..5).for_each(|bank| b.read(10, bank, 1));
    b.run(6000);
    let expected = [
        "ACT 0 @10",
        "ACT 1 @26",
        "RD 0 @39",
        "ACT 2 @43",
        "RD 1 @55",
        "ACT 3 @59",
        "RD 2 @72",
        "ACT 4 @76",
        "RD 3 @88",
        "RD 4 @105",
    ];
    // ACT 2 would be legal at 42 by tRRD, but RD 0 holds the bus from 39 to 42; fifth ACT: tFAW from 10 is 74, its fourth is at
    // 59, and the bus is taken by RD 2 from 72 to 75.
    assert_eq!(b.commands(), expected);
}

#[test]
fn five_activates_wait_for_the_window() {
    let mut b = Bench::new(&config::Dram { trrd: 6, ..lpddr4() });
    (0..5).for_each(|bank| b.read(10, bank, 1));
    b.run(6000);
    let activates: Vec<_> = b.commands().into_iter().filter(|c| c.starts_with("ACT")).collect();
    // 74 = 10 + tFAW; RD 2 holds the bus from 71 to 74.
    assert_eq!(activates, ["ACT 0 @10", "ACT 1 @16", "ACT 2 @22", "ACT 3 @28", "ACT 4 @75"]);
}

#[test]
fn writes_wait_for_reads_and_turn_the_bus() {
    let mut b = Bench::new(&lpddr4());
    b.write(10, 0, 1);
    b.read(10, 0, 1);
    b.run(6000);
    // WR after the last RD (47): RL 32 + burst 8 + 2 - WL 14 = 28.
    assert_eq!(b.commands(), ["ACT 0 @10", "RD 0 @39", "WR 0 @75"]);
    b.read(6000, 0, 1);
    b.run(6100);
    assert_eq!(b.commands()[3], "RD 0 @6000");
}

#[test]
fn a_read_after_a_write_waits_for_its_data() {
    let mut b = Bench::new(&lpddr4());
    b.write(10, 0, 1);
    b.read(40, 0, 1);
    b.run(6000);
    // WR at 39, its last burst at 47; WL 14 + burst 8 + tWTR 16.
    assert_eq!(b.commands(), ["ACT 0 @10", "WR 0 @39", "RD 0 @85"]);
}

#[test]
fn writes_drain_from_the_high_to_the_low_mark() {
    let mut b = Bench::new(&config::Dram { write_high: 6, write_low: 2, ..lpddr4() });
    (0..5).for_each(|_| b.write(10, 0, 1));
    (0..8).for_each(|_| b.read(10, 0, 1));
    b.write(50, 0, 1);
    b.run(6000);
    let order: String = b.commands().iter().filter(|c| !c.starts_with("ACT")).map(|c| &c[..1]).collect();
    // One read went out at 39; at 50 the sixth write arrives: four writes down to 2, then the reads, then the rest.
    assert_eq!(order, "RWWWWRRRRRRRWW");
}

#[test]
fn refresh_is_not_postponed() {
    let mut b = Bench::new(&lpddr4());
    b.read(6240, 2, 1);
    b.run(7000);
    // Due at 6246: PREab after tRAS, REF after tRPab, ACT after tRFC, and the read starts anew.
    let expected = ["ACT 2 @6240", "PREab 0 @6308", "REF 0 @6344", "ACT 2 @6792", "RD 2 @6821"];
    assert_eq!(b.commands(), expected);
    let c = *b.channel.counters();
    assert_eq!((c.row_closed, c.row_hits, c.row_conflicts, c.refreshes, c.precharges_all), (1, 0, 0, 1, 1));
    b.run(6246 * 10);
    assert_eq!(b.channel.counters().refreshes, 10);
}

#[test]
fn a_refresh_starts_at_its_due_cycle() {
    let mut b = Bench::new(&lpddr4());
    b.run(6245);
    assert!(b.commands().is_empty());
    b.run(6246);
    assert_eq!(b.commands(), ["REF 0 @6246"]);
}

#[test]
fn nothing_else_is_sent_at_the_due_cycle_of_a_refresh() {
    let mut b = Bench::new(&lpddr4());
    b.read(6217, 2, 1);
    b.run(6500);
    // RD would be legal at 6246.
    assert_eq!(b.commands(), ["ACT 2 @6217", "PREab 0 @6285", "REF 0 @6321"]);
}

#[test]
fn a_request_is_seen_in_the_cycle_in_which_it_enters() {
    for (arrival, then) in [(78, "RD 0 @78"), (79, "PRE 0 @78")] {
        let mut b = Bench::new(&lpddr4());
        b.read(10, 0, 1);
        b.read(10, 0, 2);
        b.read(arrival, 0, 1);
        b.run(200);
        assert_eq!(b.commands()[2], then);
    }
}

#[test]
fn the_oldest_request_does_not_starve() {
    let mut b = Bench::new(&config::Dram { trefi: 0, ..lpddr4() });
    b.read(0, 0, 1);
    assert!(b.push(1, 0, 2, false, 999));
    for at in 2..20_000 {
        b.run(at - 1);
        if b.channel.taken() < 16 {
            assert!(b.push(at, 0, 1, false, 1));
        }
    }
    let (end, _) = *b.done.iter().find(|d| d.1 == 999).expect("it was served");
    let fastest = 1 + 4096 + 29 + 29 + 48;
    assert!((fastest..fastest + 200).contains(&end), "{end}");
}

#[test]
fn full_queues_refuse() {
    let mut b = Bench::new(&lpddr4());
    for _ in 0..32 {
        b.read(10, 0, 1);
        b.write(10, 0, 1);
    }
    assert!(!b.push(10, 0, 1, false, 0) && !b.push(10, 0, 1, true, 0));
    b.run(38);
    assert!(!b.channel.has_read_room());
    assert_eq!((b.channel.counters().refused_reads, b.channel.counters().refused_writes), (1, 1));
    b.run(39 + 1000);
    assert!(b.channel.has_read_room());
}

#[test]
fn a_stream_of_row_hits_fills_the_bus() {
    let mut b = Bench::new(&config::Dram { trefi: 0, ..lpddr4() });
    let mut sent = 0;
    for at in 0..20_000 {
        b.run(at);
        while sent < 1000 && b.push(at + 1, 0, 4, false, sent) {
            sent += 1;
        }
    }
    let last = b.done.last().expect("reads were served").0;
    assert_eq!(b.done.len(), 1000);
    // Entered at 1, tRCD 29, 1000 lines of 16, RL 32: nothing is lost, and nothing gained.
    assert_eq!(last, 1 + 29 + 16 * 1000 + 32);
}

#[test]
fn skipping_and_stepping_are_the_same() {
    for seed in 0..20 {
        let traffic: Vec<_> = {
            let mut dice = Dice(seed);
            let mut at = 0;
            let span = [2, 30, 400][seed as usize % 3];
            let mut next = |_| {
                at += dice.roll(span);
                (at, dice.roll(8) as u8, dice.roll(3), dice.roll(3) == 0)
            };
            (0..2000).map(&mut next).collect()
        };
        let histories = [true, false].map(|step| {
            let mut b = Bench::new(&config::Dram { read_queue_entries: 9999, write_queue_entries: 9999, ..lpddr4() });
            let mut now = 0;
            for (token, &(at, bank, row, write)) in traffic.iter().enumerate() {
                while step && now < at {
                    b.run(now);
                    now += 1;
                }
                b.run(at);
                assert!(b.push(at + 1, bank, row, write, token as u32));
            }
            b.run(1_000_000);
            assert_eq!(b.channel.taken(), 0);
            let mut tokens: Vec<_> = b.done.iter().map(|d| d.1).collect();
            tokens.sort_unstable();
            tokens.dedup();
            assert_eq!(tokens.len(), traffic.iter().filter(|t| !t.3).count(), "each read once");
            (b.commands(), b.done, *b.channel.counters())
        });
        assert!(histories[0] == histories[1], "seed {seed}");
    }
}
