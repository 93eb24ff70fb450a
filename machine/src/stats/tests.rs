use super::*;
use crate::config::NamedMachine;
use crate::srp::KernelId;

fn shaped() -> (crate::config::MachineConfig, Stats) {
    let config = NamedMachine::load("sgrt-ti2", &["gpu.cores=2".to_owned()]).unwrap().config;
    let stats = Stats::shaped(&config);
    (config, stats)
}

#[test]
fn a_list_gives_the_same_counters_back() {
    let (_, mut stats) = shaped();
    let mut next = 0;
    stats.each_mut(|_, counter| {
        next += 1;
        *counter = next;
    });
    assert_eq!(Stats::default().list().len(), 2 + stats.memory.l2.list().len() + 22);
    assert_eq!(stats.with_list(&stats.list()), stats);
    assert!(stats.list().len() as u64 == next && next > 500);
}

#[test]
fn kinds_tell_counters_apart_and_units_not() {
    let (_, mut stats) = shaped();
    let mut of_a_unit = std::collections::BTreeMap::<usize, usize>::new();
    stats.each_mut(|kind, _| *of_a_unit.entry(kind).or_default() += 1);
    let units = (stats.cores.len() * stats.cores[0].ti.trv.len(), stats.cores.len() * stats.cores[0].ti.ist.len());
    let allowed = [1, stats.cores.len(), units.0, units.1, stats.memory.channels.len()];
    assert!(of_a_unit.values().all(|count| allowed.contains(count)), "{of_a_unit:?}");
}

#[test]
fn what_is_exact_is_made_exact_and_the_rest_stays() {
    let (_, shape) = shaped();
    let (mut estimated, mut exact, mut marks) = (shape.clone(), shape.clone(), shape);
    for (core, visits) in estimated.cores.iter_mut().zip([30, 60]) {
        core.ti.trv[0].events.node_visits = visits;
        core.ti.trv[1].events.node_visits = 10;
        core.ti.trv[0].events.bypasses = 5;
    }
    exact.cores[0].ti.trv[0].events.node_visits = 221;
    marks.cores[0].ti.trv[0].events.node_visits = 1;
    estimated.make_exact(&exact, &marks);
    let visits: Vec<u64> = estimated.trv().map(|unit| unit.events.node_visits).collect();
    assert_eq!(visits.iter().sum::<u64>(), 221);
    assert_eq!((visits[0], visits[1]), (60, 20));
    assert_eq!(estimated.trv().map(|unit| unit.events.bypasses).sum::<u64>(), 10);
}

#[test]
fn accounts_are_closed() {
    let (config, mut stats) = shaped();
    stats.cycles = 1000;
    for core in &mut stats.cores {
        (core.ti.trv[0].stages[0].1.busy, core.ti.trv[0].stages[0].1.memory) = (333, 670);
        (core.ti.trv[1].stages[0].1.busy, core.ti.trv[1].stages[0].1.memory) = (1200, 300);
        let srp = &mut core.srp.activity;
        (srp.shade, srp.inspector, srp.output, srp.unit) = (700, 40, 30, 10);
        (core.srp_l1.lookups, core.srp_l1.hits, core.srp_l1.misses) = (100, 30, 20);
    }
    stats.close_accounts(&config);
    assert!(stats.trv().all(|unit| unit.stages.iter().all(|(_, account)| account.total() == 1000)));
    assert!(stats.ist().all(|unit| unit.activity.idle == 1000));
    assert!(stats.cores.iter().all(|core| core.srp.activity.total() == core.srp_cycles && core.srp_cycles > 0));
    let [first, second] = [0, 1].map(|unit| &stats.cores[0].ti.trv[unit].stages[0].1);
    assert_eq!((first.busy, first.memory), (333, 667), "work stays, waits make up the rest");
    assert_eq!((second.busy, second.memory), (1000, 0), "no unit works more than always");
    let (core, total) = (&stats.cores[0], stats.cores[0].srp_cycles);
    let srp = &core.srp.activity;
    assert_eq!((srp.shade, srp.inspector, srp.output, srp.unit), (700, 40, (total - 740) * 3 / 4, (total - 740) / 4));
    assert_eq!(core.srp.kernels[KernelId::Shade as usize].cycles, 700);
    assert_eq!((core.srp_l1.hits, core.srp_l1.misses), (60, 40));
}

/// Twice the visits that were estimated, half the tests, and a third more resolved samples.
#[test]
fn what_follows_from_work_is_as_much_as_the_work() {
    let (config, shape) = shaped();
    let (mut estimated, mut exact) = (shape.clone(), shape);
    let resolve = KernelId::Resolve as usize;
    for stats in [&mut estimated, &mut exact] {
        let core = &mut stats.cores[0];
        (core.ti.trv[0].events.node_visits, core.ti.ist[0].events.triangle_tests) = (100, 80);
        (core.ti.trv[1].events.leaves, core.srp.kernels[resolve].items) = (7, 300);
    }
    let core = &mut exact.cores[0];
    (core.ti.trv[0].events.node_visits, core.ti.ist[0].events.triangle_tests) = (200, 40);
    core.srp.kernels[resolve].items = 400;
    estimated.cycles = 1000;
    let core = &mut estimated.cores[0];
    (core.srp_cycles, core.srp.activity.resolve, core.srp.activity.unit) = (2000, 900, 1100);
    core.srp.kernels[resolve].batches = 12;
    let trv = &mut core.ti.trv[0];
    (trv.l1.lookups, trv.l1.hits, trv.l1.misses, trv.buffer.record_reads) = (100, 60, 40, 110);
    let inner = &mut trv.stages[0].1;
    (inner.busy, inner.fetch, inner.starved) = (100, 600, 300);
    let ist = &mut core.ti.ist[0];
    (ist.l1.misses, ist.activity.busy, ist.activity.idle) = (20, 80, 920);
    let l2 = &mut estimated.memory.l2;
    (l2.lookups, l2.hits, l2.merges, l2.misses) = (60, 35, 10, 15);

    estimated.follow_work(&exact);
    let core = &estimated.cores[0];
    let (trv, ist) = (&core.ti.trv[0], &core.ti.ist[0]);
    assert_eq!((trv.l1.lookups, trv.l1.hits, trv.l1.misses, trv.buffer.record_reads), (200, 120, 80, 220));
    let inner = trv.stages[0].1;
    assert_eq!((inner.busy, inner.fetch, inner.starved), (200, 533, 267), "waits share what is left");
    assert_eq!((ist.l1.misses, ist.activity.busy, ist.activity.idle), (10, 40, 960));
    assert_eq!(core.srp.kernels[resolve].batches, 16);
    assert_eq!((core.srp.activity.resolve, core.srp.activity.unit), (1200, 800));
    // 90 misses of L1s for 60; what is read from DRAM stays.
    let l2 = &estimated.memory.l2;
    assert_eq!((l2.lookups, l2.misses, l2.merges, l2.hits), (90, 15, 15, 60));
    let followed = estimated.clone();
    estimated.make_exact(&exact, &crate::functional::exact_counters(&config));
    estimated.follow_work(&exact);
    assert_eq!(estimated.trv().map(|unit| unit.l1.lookups).sum::<u64>(), 200, "what is exact moves nothing");
    assert_eq!(estimated.memory.l2, followed.memory.l2);
}

#[test]
fn no_unit_is_busier_than_always() {
    let (_, shape) = shaped();
    let (mut estimated, mut exact) = (shape.clone(), shape);
    estimated.cores[0].ti.ist[0].events.triangle_tests = 90;
    exact.cores[0].ti.ist[0].events.triangle_tests = 120;
    (estimated.cores[0].ti.ist[0].activity.busy, estimated.cores[0].ti.ist[0].activity.fetch) = (90, 10);
    estimated.follow_work(&exact);
    assert_eq!((estimated.cores[0].ti.ist[0].activity.busy, estimated.cores[0].ti.ist[0].activity.fetch), (100, 0));
}
