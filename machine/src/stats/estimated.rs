//! Counters that were estimated, put right: what is known exactly is exact, and accounts are closed.

use std::collections::BTreeMap;

use super::Stats;
use crate::config::MachineConfig;
use crate::memory::CacheCounters;
use crate::srp::{KernelId, srp_cycles};
use crate::time::TiCycle;

impl Stats {
    /// Makes the sum over all units of each counter that `is_exact` marks (with anything but 0) that of `exact`; how the units
    /// share it stays as it is.
    pub fn make_exact(&mut self, exact: &Self, is_exact: &Self) {
        let sums = |stats: &Self| {
            let mut sums = BTreeMap::<usize, u64>::new();
            stats.clone().each_mut(|kind, counter| *sums.entry(kind).or_default() += *counter);
            sums
        };
        let (marks, wanted, estimated) = (sums(is_exact), sums(exact), sums(self));
        // What rounding leaves over goes to the next unit.
        let mut carried = BTreeMap::<usize, (f64, u64)>::new();
        self.each_mut(|kind, counter| {
            if marks[&kind] == 0 {
                return;
            }
            let (wanted, estimated) = (wanted[&kind], estimated[&kind]);
            let (seen, given) = carried.entry(kind).or_default();
            *seen += *counter as f64;
            let upto = if estimated == 0 { wanted as f64 } else { *seen * wanted as f64 / estimated as f64 };
            *counter = (upto.round() as u64).min(wanted).saturating_sub(*given);
            *given += *counter;
        });
    }

    /// Closes the accounts: the classes of each unit's cycles add up to the cycles of the run, and what lookups found to the lookups.
    pub fn close_accounts(&mut self, config: &MachineConfig) {
        let cycles = self.cycles;
        for core in &mut self.cores {
            core.srp_cycles = srp_cycles(config, TiCycle(cycles));
            for unit in &mut core.ti.trv {
                unit.stages.iter_mut().for_each(|(_, account)| close(account, cycles, |a, visit| a.each_mut(visit)));
            }
            core.ti.ist.iter_mut().for_each(|unit| close(&mut unit.activity, cycles, |a, visit| a.each_mut(visit)));
            let l1s =
                core.ti.trv.iter_mut().map(|unit| &mut unit.l1).chain(core.ti.ist.iter_mut().map(|unit| &mut unit.l1));
            l1s.chain([&mut core.srp_l1]).for_each(close_lookups);
            close(&mut core.srp.activity, core.srp_cycles, |a, visit| a.each_mut(visit));
            for kernel in KernelId::ALL {
                core.srp.kernels[kernel as usize].cycles = core.srp.activity.in_kernel(kernel);
            }
        }
    }
}

/// Scales what lookups found to the lookups.
fn close_lookups(l1: &mut CacheCounters) {
    let found = |l1: &mut CacheCounters, visit: &mut dyn FnMut(usize, &mut u64)| {
        [&mut l1.hits, &mut l1.misses, &mut l1.merges].into_iter().enumerate().for_each(|(i, class)| visit(i, class));
    };
    let lookups = l1.lookups;
    close(l1, lookups, found);
}

/// Scales the classes of an account to a total; the largest takes what rounding leaves over, the last one all if all are 0.
fn close<A>(account: &mut A, total: u64, each: impl Fn(&mut A, &mut dyn FnMut(usize, &mut u64))) {
    let mut classes = Vec::new();
    each(account, &mut |_, class| classes.push(*class));
    let sum: u64 = classes.iter().sum();
    let Some(rest) = (0..classes.len()).max_by_key(|&place| classes[place]) else { return };
    let part = |class: u64| (u128::from(class) * u128::from(total) / u128::from(sum.max(1))) as u64;
    classes.iter_mut().for_each(|class| *class = part(*class));
    classes[rest] += total - classes.iter().sum::<u64>();
    each(account, &mut |place, class| *class = classes[place]);
}
