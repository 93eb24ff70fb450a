//! When rows are closed, when a channel powers down, and where lines lie: worked out by hand, at the cycle before and at the cycle.

use std::collections::BTreeSet;

use super::super::AddressMap;
use super::{Bench, lpddr4};
use crate::config::{self, PagePolicy};
use crate::time::DramCycle;

fn with(page_policy: PagePolicy) -> config::Dram {
    config::Dram { page_policy, ..lpddr4() }
}

/// The commands after a read of row 1 at 10 and one of `row` of the same bank at `arrival`.
fn after_a_read(config: &config::Dram, arrival: u64, row: u64) -> Vec<String> {
    let mut b = Bench::new(config);
    b.read(10, 0, 1);
    b.run(arrival - 1);
    assert_eq!(b.commands(), ["ACT 0 @10", "RD 0 @39"]);
    b.read(arrival, 0, row);
    b.run(6000);
    b.commands().split_off(2)
}

#[test]
fn a_closed_page_is_ready_for_the_next_row() {
    // Open: PRE when the stranger comes, not before tRAS (10 + 68).
    assert_eq!(after_a_read(&lpddr4(), 100, 2), ["PRE 0 @100", "ACT 0 @129", "RD 0 @158"]);
    // Closed: as if PRE had been sent at 78, so ACT from 107 on.
    let closed = with(PagePolicy::Closed);
    assert_eq!(after_a_read(&closed, 60, 2), ["ACT 0 @107", "RD 0 @136"]);
    assert_eq!(after_a_read(&closed, 106, 2), ["ACT 0 @107", "RD 0 @136"]);
    assert_eq!(after_a_read(&closed, 108, 2), ["ACT 0 @108", "RD 0 @137"]);
    // Its own row must be opened again too.
    assert_eq!(after_a_read(&closed, 108, 1), ["ACT 0 @108", "RD 0 @137"]);
}

#[test]
fn a_closed_page_waits_for_requests_that_hit() {
    let mut b = Bench::new(&with(PagePolicy::Closed));
    [1, 1, 2].into_iter().for_each(|row| b.read(10, 0, row));
    b.run(6000);
    // The last burst of the second read at 63, tRTP 12: 75, tRAS 78; PRE to ACT 29.
    assert_eq!(b.commands(), ["ACT 0 @10", "RD 0 @39", "RD 0 @55", "ACT 0 @107", "RD 0 @136"]);
    let c = *b.channel.counters();
    assert_eq!((c.activates, c.precharges, c.closed, c.row_hits, c.row_closed), (2, 0, 2, 1, 2));
}

#[test]
fn a_timer_closes_a_row_nobody_asks_for() {
    // The last burst of the read goes out at 47; 200 later the row is closed.
    let timeout = with(PagePolicy::Timeout);
    assert_eq!(after_a_read(&timeout, 247, 1), ["RD 0 @247"]);
    assert_eq!(after_a_read(&timeout, 247, 2), ["PRE 0 @247", "ACT 0 @276", "RD 0 @305"]);
    // PRE at 247 by the timer, so ACT from 276 on.
    assert_eq!(after_a_read(&timeout, 248, 1), ["ACT 0 @276", "RD 0 @305"]);
    assert_eq!(after_a_read(&timeout, 276, 2), ["ACT 0 @276", "RD 0 @305"]);
    assert_eq!(after_a_read(&timeout, 277, 2), ["ACT 0 @277", "RD 0 @306"]);
}

#[test]
fn a_refresh_finds_no_row_whose_timer_is_over() {
    for (read_at, refresh) in [(5000, &["REF 0 @6246"][..]), (6100, &["PREab 0 @6246", "REF 0 @6282"])] {
        let mut b = Bench::new(&with(PagePolicy::Timeout));
        b.read(read_at, 0, 1);
        b.run(6400);
        assert_eq!(&b.commands()[2..], refresh, "a read at {read_at}");
        assert_eq!(b.channel.counters().closed, u64::from(refresh.len() == 1));
    }
}

#[test]
fn power_down_lasts_to_the_end_of_the_frame_or_to_a_refresh() {
    let mut b = Bench::new(&config::Dram { power_down_after: 128, ..lpddr4() });
    b.read(10, 0, 1);
    b.run(999);
    // Nothing to do since 47, so it is down from 175 on, and woken by the refresh at 6246.
    for (end, down) in [(100, 0), (175, 0), (176, 1), (1000, 825), (6246, 6071), (6300, 6071)] {
        assert_eq!(b.channel.counters_before(DramCycle(end)).powered_down, down, "before {end}");
    }
    assert_eq!(b.channel.counters().powered_down, 0);
}

#[test]
fn an_idle_channel_powers_down_and_wakes() {
    let config = config::Dram { power_down_after: 128, ..lpddr4() };
    // Nothing to do since 47. At 175 it would power down.
    assert_eq!(after_a_read(&config, 175, 1), ["RD 0 @175"]);
    assert_eq!(after_a_read(&config, 176, 1), ["RD 0 @188"], "tXP 12 after the request");
    let mut b = Bench::new(&config);
    b.read(10, 0, 1);
    b.run(999);
    b.read(1000, 0, 1);
    b.run(1100);
    assert_eq!(b.channel.counters().powered_down, 1000 - 175);
    // A refresh wakes it: due at 6246, sent tXP later, for the row is open a PREab before.
    b.run(6800);
    // RD at 1012, idle since 1020, down from 1148 to 6246.
    assert_eq!(b.channel.counters().powered_down, 1000 - 175 + 6246 - 1148);
    assert_eq!(b.commands()[3..], ["PREab 0 @6258", "REF 0 @6294"]);
}

#[test]
fn every_line_has_a_place_of_its_own() {
    for (hash, interleave_bytes) in [(false, 64), (true, 64), (false, 256), (true, 256), (true, 2048)] {
        let config = config::Dram { channels: 4, hash, interleave_bytes, ..lpddr4() };
        let map = AddressMap::new(&config, 64);
        let mut rows = std::collections::BTreeMap::<_, u64>::new();
        for line in 0..4 * 8 * 32 * 4 {
            let at = map.address(line);
            assert_eq!(at.channel, map.channel(line));
            *rows.entry((at.channel, at.bank, at.row)).or_default() += 1;
        }
        // Four rows of 32 lines in each of 8 banks of 4 channels, all full.
        assert_eq!(rows.len(), 4 * 8 * 4, "{hash} {interleave_bytes}");
        assert!(rows.values().all(|lines| *lines == 32));
    }
}

#[test]
fn neighbours_share_a_row_and_powers_of_two_spread() {
    let config = config::Dram { channels: 4, hash: true, interleave_bytes: 256, ..lpddr4() };
    let map = AddressMap::new(&config, 64);
    let places = |stride: u64| {
        (0..32).map(|i| map.address(i * stride)).map(|at| (at.channel, at.bank)).collect::<BTreeSet<_>>().len()
    };
    assert!((0..4).map(|line| map.address(line)).all(|at| at == map.address(0)), "256 bytes");
    assert_ne!(map.address(4).channel, map.address(3).channel);
    // Rows of a picture of 2048 pixels; borders of tiles; whole sets of banks.
    for stride in [128, 1024, 4096, 1 << 14] {
        assert!(places(stride) >= 8, "a stride of {stride} lines meets {} banks", places(stride));
    }
    let plain = AddressMap::new(&config::Dram { hash: false, ..config }, 64);
    assert!((0..32).all(|i| (plain.address(i << 14).channel, plain.address(i << 14).bank) == (0, 0)));
}
