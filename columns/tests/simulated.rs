//! What a machine's tables say, against what the machine counts, and against what was recorded.

mod common;

use std::collections::BTreeMap;

use common::{Rows, trace};
use rayreel_columns::{Data, Selection, What};
use rayreel_formats::Trace;
use rayreel_machine::NamedMachine;
use rayreel_machine::counters::Activity;
use rayreel_machine::stats::Stats;
use rayreel_machine::system::NoProbe;
use rayreel_replay::simulate::simulate;
use rayreel_replay::{NamedPolicy, Options, PathSource, Replayer};

fn machine(name: &str, set: &[&str]) -> NamedMachine {
    NamedMachine::load(name, &set.iter().map(|text| text.to_string()).collect::<Vec<_>>()).unwrap()
}

/// What a machine counts in the first frame.
fn stats(trace: &Trace, policy: &NamedPolicy, machine: &NamedMachine) -> Stats {
    let mut replayer =
        Replayer::new(trace, &policy.policy, Options { reference: false, perception: false, ..Options::default() })
            .unwrap();
    let named = (machine.name.as_str(), &machine.config);
    simulate(&mut replayer, trace.meta().first_frame, &trace.topology(), named, &mut NoProbe).unwrap().stats
}

#[test]
fn addresses_are_what_a_machine_reads_of_all_rays() {
    let full = NamedPolicy::load("full", &[]).unwrap();
    for scene in ["cornell", "teapot"] {
        let trace = trace(scene);
        let machine = machine("sgrt-ti2", &["layout.node_bytes=80"]);
        let first = trace.meta().first_frame;
        let selection = Selection::all(trace.meta()).frames(first..first + 1).unwrap();
        let rows = Rows::of(&Data { machine: Some(&machine), selection, ..Data::new(&trace, What::Addresses) });
        let counted = stats(&trace, &full, &machine);
        let visits: u64 = counted.trv().map(|unit| unit.events.node_visits - unit.events.restart_visits).sum();
        let tests: u64 = counted.ist().map(|unit| unit.events.triangle_tests).sum();
        assert_eq!((rows.count("what", "node"), rows.count("what", "triangle")), (visits, tests));
        let (what, number) = (rows.words("what"), rows.integers("number"));
        let (address, bytes) = (rows.integers("address"), rows.integers("bytes"));
        for i in 0..rows.len() {
            let (region, size) = if what[i] == "node" { (1, 80) } else { (2, 48) };
            assert_eq!((address[i], bytes[i]), ((region << 40) + number[i] * size, size));
        }
    }
}

#[test]
fn lookups_are_the_addresses_of_the_rays_and_what_units_count() {
    let (trace, full) = (trace("cornell"), NamedPolicy::load("full", &[]).unwrap());
    for (name, set) in [
        ("sgrt-ti2", &["ti.stack_entries=0"][..]),
        ("sgrt-ti2", &["ti.stack_entries=2", "gpu.cores=2"]),
        ("sgrt-ti1", &[]),
        ("raycore", &[]),
    ] {
        let machine = machine(name, set);
        let rows = Rows::of(&Data { machine: Some(&machine), ..Data::new(&trace, What::Lookups) });
        let counted = stats(&trace, &full, &machine);
        let (words, units) = (rows.words("what"), rows.words("unit"));
        let cores = rows.integers("core");
        // Unit by unit: what each counts is what it looked for.
        for (core, stats) in counted.cores.iter().enumerate() {
            let count = |unit: &str, what: &str| {
                let is = |i: &usize| cores[*i] == core as i64 && units[*i] == unit && words[*i] == what;
                (0..rows.len()).filter(is).count() as u64
            };
            for (i, trv) in stats.ti.trv.iter().enumerate() {
                let unit = format!("TRV {i}");
                let found = (count(&unit, "node"), count(&unit, "triangle"));
                assert_eq!(found, (trv.events.node_visits, trv.events.triangle_tests), "{name} {unit}");
            }
            for (i, ist) in stats.ti.ist.iter().enumerate() {
                assert_eq!(count(&format!("IST {i}"), "triangle"), ist.events.triangle_tests, "{name} IST {i}");
            }
        }
        let cycles = rows.integers("cycle");
        assert!(cycles.is_sorted() && *cycles.last().unwrap() < counted.cycles as i64);
        // Ray by ray the same addresses in the same order, apart from nodes that are visited again.
        let again: u64 = counted.trv().map(|unit| unit.events.restart_visits).sum();
        assert_eq!(again > 0, set.contains(&"ti.stack_entries=2"), "the short stack loses children");
        let recorded = Rows::of(&Data { machine: Some(&machine), ..Data::new(&trace, What::Addresses) });
        if again == 0 {
            let streams = |rows: &Rows, ray: &str| {
                let (tile, ray, address) = (rows.integers("tile"), rows.integers(ray), rows.integers("address"));
                let mut streams: BTreeMap<(i64, i64), Vec<i64>> = BTreeMap::new();
                (0..rows.len()).for_each(|i| streams.entry((tile[i], ray[i])).or_default().push(address[i]));
                streams
            };
            assert_eq!(streams(&rows, "ray"), streams(&recorded, "index"), "{name}");
        } else {
            assert_eq!(rows.len() as u64, recorded.len() as u64 + again);
        }
    }
}

#[test]
fn requests_are_the_misses_of_the_caches_and_the_bytes_at_the_dram() {
    let trace = trace("cornell");
    for (name, policy) in [("sgrt-ti2", "multirate"), ("external-buffers", "adaptive"), ("mimd-trax", "full")] {
        let (machine, policy) = (machine(name, &[]), NamedPolicy::load(policy, &[]).unwrap());
        let data = Data { machine: Some(&machine), policy: Some(&policy), ..Data::new(&trace, What::Requests) };
        let (rows, counted) = (Rows::of(&data), stats(&trace, &policy, &machine));
        let (route, region, bytes) = (rows.words("route"), rows.words("region"), rows.integers("bytes"));
        let misses: u64 = counted
            .cores
            .iter()
            .map(|core| {
                let ti =
                    core.ti.trv.iter().map(|unit| unit.l1.misses).chain(core.ti.ist.iter().map(|unit| unit.l1.misses));
                ti.chain(core.processors.iter().map(|unit| unit.code_l1.misses)).sum::<u64>() + core.srp_l1.misses
            })
            .sum();
        assert_eq!(rows.count("route", "cached"), misses, "{name}");
        for region_of in rayreel_machine::work::layout::Region::ALL {
            let sum = |wanted: &str| -> i64 {
                let is = |i: &usize| route[*i] == wanted && region[*i] == region_of.name();
                (0..rows.len()).filter(is).map(|i| bytes[i]).sum()
            };
            let written = counted.memory.traffic.written[region_of as usize] as i64;
            assert_eq!(sum("write"), written, "{name}: bytes of {} that are written", region_of.name());
            // What goes through the L2 is read from the DRAM where that misses.
            let cached = (0..rows.len()).any(|i| route[i] == "cached" && region[i] == region_of.name());
            let read = counted.memory.traffic.read[region_of as usize] as i64;
            assert!(
                if cached { sum("read") <= read } else { sum("read") == read },
                "{name}: reads of {}",
                region_of.name()
            );
        }
        assert!(rows.count("route", "write") > 0);
    }
}

#[test]
fn every_tile_is_somewhere_for_a_while() {
    let trace = trace("cornell");
    for (machine_name, policy) in [("sgrt-ti2", "full"), ("sgrt-ti2", "multirate"), ("mimd-trax", "full")] {
        let (policy, machine) = (NamedPolicy::load(policy, &[]).unwrap(), machine(machine_name, &[]));
        let data = Data { machine: Some(&machine), policy: Some(&policy), ..Data::new(&trace, What::Tiles) };
        let (rows, counted) = (Rows::of(&data), stats(&trace, &policy, &machine));
        let mut tiles = rows.integers("tile");
        tiles.sort_unstable();
        assert_eq!(tiles, (0..i64::from(trace.meta().tile_count())).collect::<Vec<_>>());
        let (begin, end) = (rows.integers("begin"), rows.integers("end"));
        assert!((0..rows.len()).all(|i| begin[i] < end[i]) && end.is_sorted());
        let last = counted.cycles as i64 - end[rows.len() - 1];
        assert!((0..=1).contains(&last), "the frame ends {last} cycles after the last tile");
        let sum = |name: &str| rows.integers(name).iter().sum::<i64>() as u64;
        if machine_name == "sgrt-ti2" {
            assert_eq!(sum("rays"), counted.rays());
            assert_eq!(sum("triangle_tests"), counted.ist().map(|unit| unit.events.triangle_tests).sum::<u64>());
        }
        // No slot holds two at a time.
        let (core, slot) = (rows.integers("core"), rows.integers("slot"));
        for i in 0..rows.len() {
            let earlier = (0..i).filter(|j| (core[*j], slot[*j]) == (core[i], slot[i]));
            assert!(earlier.map(|j| end[j]).max().is_none_or(|before| before <= begin[i]));
        }
    }
}

#[test]
fn intervals_add_up_to_the_run() {
    let (trace, policy) = (trace("cornell"), NamedPolicy::load("full", &[]).unwrap());
    // Units that wait long book cycles as starved that turn out to be of another class later.
    for (interval, name) in [(50, "sgrt-ti2-rob"), (500, "sgrt-ti2"), (7777, "sgrt-ti2"), (10_000_000, "sgrt-ti2")] {
        let machine = machine(name, &[]);
        let data = Data { machine: Some(&machine), interval: Some(interval), ..Data::new(&trace, What::Counters) };
        let (rows, counted) = (Rows::of(&data), stats(&trace, &policy, &machine));
        let (unit, counter, change) = (rows.words("unit"), rows.words("counter"), rows.integers("change"));
        let sum = |of: &str, name: &str| -> u64 {
            let is = |i: &usize| unit[*i].starts_with(of) && counter[*i] == name;
            (0..rows.len()).filter(is).map(|i| change[i]).sum::<i64>().try_into().unwrap()
        };
        let trv = |value: fn(&rayreel_machine::ti::TrvStats) -> u64| counted.trv().map(value).sum::<u64>();
        assert_eq!(sum("TRV", "node_visits"), trv(|unit| unit.events.node_visits));
        assert_eq!(sum("TRV", "l1/lookups"), trv(|unit| unit.l1.lookups));
        assert_eq!(sum("TRV", "inner/busy"), trv(|unit| unit.stages[0].1.busy));
        for (stage, name) in ["inner", "leaf", "stack"].into_iter().enumerate() {
            let activity =
                |class: fn(&Activity) -> u64| counted.trv().map(|unit| class(&unit.stages[stage].1)).sum::<u64>();
            assert_eq!(sum("TRV", &format!("{name}/starved")), activity(|a| a.starved), "{name} every {interval}");
            assert_eq!(sum("TRV", &format!("{name}/idle")), activity(|a| a.idle), "{name} every {interval}");
        }
        assert_eq!(sum("IST", "triangle_tests"), counted.ist().map(|unit| unit.events.triangle_tests).sum::<u64>());
        assert_eq!(sum("dispatcher", "rays"), counted.rays());
        assert_eq!(sum("SRP", "l1/misses"), counted.cores.iter().map(|core| core.srp_l1.misses).sum::<u64>());
        let (begin, end) = (rows.integers("begin"), rows.integers("end"));
        assert_eq!(end.iter().max(), Some(&(counted.cycles as i64)));
        assert!((0..rows.len()).all(|i| begin[i] < end[i] && change[i] != 0));
    }
}

#[test]
fn what_does_not_fit_is_said() {
    let trace = trace("cornell");
    let (full, machine) = (NamedPolicy::load("full", &[]).unwrap(), machine("sgrt-ti2", &[]));
    let error = |data: Data<'_>| data.head().unwrap_err().to_string();
    let with_policy = Data { policy: Some(&full), ..Data::new(&trace, What::Rays) };
    assert!(error(with_policy).contains("take samples, lookups, requests, counters, tiles"));
    let with_machine = Data { machine: Some(&machine), ..Data::new(&trace, What::Steps) };
    assert!(error(with_machine).contains("the same for every machine"));
    assert!(error(Data::new(&trace, What::Addresses)).contains("depends on a machine; name one"));
    let never = Data { interval: Some(0), machine: Some(&machine), ..Data::new(&trace, What::Counters) };
    assert!(error(never).contains("take 1 or more"));
    let threads = NamedMachine::load("mimd-trax", &[]).unwrap();
    let lookups = Data { machine: Some(&threads), ..Data::new(&trace, What::Lookups) };
    assert!(error(lookups).contains("take requests"));
}

#[test]
fn a_choice_that_means_nothing_is_refused() {
    let (trace, machine) = (trace("cornell"), machine("sgrt-ti2", &[]));
    let all = || Selection::all(trace.meta());
    for what in What::ALL {
        let data = || Data { machine: what.takes_machine().then_some(&machine), ..Data::new(&trace, what) };
        let said = |data: Data<'_>| data.check().err().map(|error| error.to_string());
        assert_eq!(said(data()), None);
        // The trace has one frame: the choice is refused, though all are chosen.
        let frames = said(Data { selection: all().frames(0..1).unwrap(), ..data() });
        let the_same = format!("table {} is the same for all frames; leave frames out", what.name());
        assert_eq!(frames, (!what.takes_frames()).then_some(the_same));
        let tiles = said(Data { selection: all().tiles("0..15").unwrap(), ..data() });
        let why = if what.is_simulated() { "a machine works on whole frames" } else { "it is not of tiles" };
        let no_tiles = format!("table {} takes no tiles: {why}; leave it out", what.name());
        assert_eq!(tiles, (!what.takes_tiles()).then_some(no_tiles.clone()));
        // By hand.
        let mut fewer = all();
        fewer.tiles.pop();
        assert_eq!(said(Data { selection: fewer, ..data() }), (!what.takes_tiles()).then_some(no_tiles));
        let interval = said(Data { interval: Some(7), ..data() });
        let counters = format!("interval is for table counters, not for {}; leave it out", what.name());
        assert_eq!(interval, (what != What::Counters).then_some(counters));
    }
}
