//! More of anything does not make the machine slower.
//!
//! Two exceptions are no faults of the model. On several cores, which core takes which tile depends on when it has a free slot;
//! with few tiles of unequal work a faster machine may assign them worse (Graham's anomaly of list scheduling): the 15 tiles of
//! the Cornell box on four cores differ by up to 38 %. So the tests here run on one core. There a few per cent are left:
//! the SRP batches what has come back, and other arrival times make other batches, some of them smaller, each with a prologue.
//! Caches and units are therefore measured with an SRP that takes no time, and once with it.

use rayreel_machine::config::MachineConfig;
use rayreel_machine::stats::Stats;

use super::harness::{Recorded, machine, recorded, run_real};

/// Runs the work with `key` set to each of `values`, the smallest machine first, and asserts that time does not rise by more than
/// `percent` from one to the next, and falls from the first to the last by at least `gain` per cent.
fn assert_never_slower(work: &Recorded, key: &str, values: &[&str], percent: u128, gain: u128) {
    assert_never_slower_on("srp.ideal=true", work, key, values, percent, gain);
}

/// The same with the SRP as it is.
fn assert_whole_never_slower(work: &Recorded, key: &str, values: &[&str], percent: u128, gain: u128) {
    assert_never_slower_on("srp.ideal=false", work, key, values, percent, gain);
}

fn assert_never_slower_on(srp: &str, work: &Recorded, key: &str, values: &[&str], percent: u128, gain: u128) {
    let time = |value: &&str| {
        let config = machine("sgrt-ti2", &["gpu.cores=1", srp, &format!("{key}={value}")]);
        // In millionths of a cycle at 1 MHz, so that clocks can be compared.
        u128::from(some(work, &config).cycles) * 1_000_000 / u128::from(config.ti.clock_mhz)
    };
    let times: Vec<_> = values.iter().map(time).collect();
    for (pair, value) in times.windows(2).zip(&values[1..]) {
        assert!(pair[1] * 100 <= pair[0] * (100 + percent), "{}: {key} up to {value}: {times:?}", work.name);
    }
    let (first, last) = (times[0], times[times.len() - 1]);
    assert!(gain == 0 || last * 100 <= first * (100 - gain), "{}: {key} {values:?}: {times:?}", work.name);
}

/// Four tiles of the Cornell box, or the one of the teapot.
fn some(work: &Recorded, config: &MachineConfig) -> Stats {
    let tiles = if work.tiles.len() > 9 { &work.tiles[5..9] } else { &work.tiles[..] };
    run_real(config, (&work.tree, tiles), work.shape)
}

/// The Cornell box under both policies, and the teapot under the adaptive one.
fn works() -> [&'static Recorded; 3] {
    [0, 1, 3].map(|i| &recorded()[i])
}

#[test]
fn more_cache() {
    let [full, adaptive, teapot] = works();
    assert_never_slower(full, "ti.trv_l1.size", &["1KiB", "16KiB"], 4, 0);
    assert_never_slower(full, "ti.ist_l1.size", &["1KiB", "4KiB", "16KiB", "64KiB"], 4, 2);
    assert_never_slower(adaptive, "ti.ist_l1.size", &["1KiB", "4KiB", "16KiB", "64KiB"], 4, 2);
    assert_never_slower(teapot, "ti.trv_l1.size", &["1KiB", "64KiB"], 4, 1);
    assert_never_slower(teapot, "l2.size", &["16KiB", "256KiB"], 4, 20);
}

#[test]
fn more_units() {
    for work in &works()[..2] {
        assert_never_slower(work, "ti.trv", &["1", "2", "4", "8"], 4, 5);
        assert_never_slower(work, "ti.ist", &["1", "2"], 4, 0);
        assert_never_slower(work, "ti.rays_per_trv", &["4", "16", "64"], 4, 30);
    }
    assert_never_slower(works()[2], "ti.ist", &["1", "2"], 4, 20);
}

#[test]
fn more_units_before_a_real_srp() {
    for work in &works()[..2] {
        // On one core a tile waits for the one before it, whatever the units.
        assert_whole_never_slower(work, "ti.trv", &["1", "2", "4", "8"], 8, 2);
        assert_whole_never_slower(work, "ti.ist", &["1", "2"], 8, 0);
    }
}

#[test]
fn more_cores() {
    let work = works()[0];
    let cycles = ["1", "2", "4"].map(|n| work.real(&machine("sgrt-ti2", &[&format!("gpu.cores={n}")])).cycles);
    // Fifteen tiles of unequal work on the eight slots of four cores: who gets the last ones decides.
    assert!(cycles[1] * 10 < cycles[0] * 6 && cycles[2] * 10 < cycles[1] * 7, "{cycles:?}");
}

/// Fifteen tiles on four cores: filling core after core leaves cores without tiles, and more slots make that worse.
#[test]
fn more_slots() {
    let work = works()[0];
    let cycles = |dispatch: &str, slots: u32| {
        let overrides = [format!("gpu.tile_dispatch={dispatch}"), format!("gpu.tiles_in_flight={slots}")];
        work.real(&machine("sgrt-ti2", &overrides.each_ref().map(String::as_str))).cycles
    };
    let [fill, spread] = ["fill", "spread"].map(|dispatch| [1, 4, 16].map(|slots| cycles(dispatch, slots)));
    assert_eq!(fill[0], spread[0], "with one slot both are one");
    assert!(spread[1] < fill[1] && spread[2] * 2 < fill[2] && spread[2] < spread[0], "{fill:?} {spread:?}");
}

#[test]
fn faster_clocks() {
    for work in &works()[..2] {
        assert_whole_never_slower(work, "ti.clock_mhz", &["250", "500", "1000"], 4, 15);
        assert_whole_never_slower(work, "srp.clock_mhz", &["250", "500", "1000"], 4, 30);
        assert_whole_never_slower(work, "dram.clock_mhz", &["800", "1600", "2133"], 4, 2);
    }
    assert_whole_never_slower(works()[2], "ti.clock_mhz", &["250", "1000"], 4, 50);
}
