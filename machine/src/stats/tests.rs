use super::*;
use crate::config::NamedMachine;

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
        core.srp.activity.shade = 7;
    }
    stats.close_accounts(&config);
    assert!(stats.trv().all(|unit| unit.stages.iter().all(|(_, account)| account.total() == 1000)));
    assert!(stats.ist().all(|unit| unit.activity.idle == 1000));
    assert!(stats.cores.iter().all(|core| core.srp.activity.total() == core.srp_cycles && core.srp_cycles > 0));
    let first = &stats.cores[0].ti.trv[0].stages[0].1;
    assert_eq!((first.busy, first.memory), (332, 668));
}
