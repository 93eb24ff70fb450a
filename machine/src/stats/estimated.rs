//! Counters that were estimated, put right: what is known exactly is exact, and accounts are closed.

use std::collections::BTreeMap;

use super::Stats;
use super::work_done::{ISSUES, SRP_WORK};
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
    /// Cycles of work, which follow from what is known exactly, stay as they are; those in which a unit waits make up the rest.
    pub fn close_accounts(&mut self, config: &MachineConfig) {
        let cycles = self.cycles;
        for core in &mut self.cores {
            core.srp_cycles = srp_cycles(config, TiCycle(cycles));
            for unit in &mut core.ti.trv {
                for (_, account) in &mut unit.stages {
                    close(account, cycles, ISSUES, |a, visit| a.each_mut(visit));
                }
            }
            for unit in &mut core.ti.ist {
                close(&mut unit.activity, cycles, ISSUES, |a, visit| a.each_mut(visit));
            }
            let l1s =
                core.ti.trv.iter_mut().map(|unit| &mut unit.l1).chain(core.ti.ist.iter_mut().map(|unit| &mut unit.l1));
            l1s.chain([&mut core.srp_l1]).for_each(close_lookups);
            close(&mut core.srp.activity, core.srp_cycles, SRP_WORK, |a, visit| a.each_mut(visit));
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
    close(l1, lookups, 0, found);
}

/// Makes the classes of an account add up to a total. The first `work` of them stay as they are, unless they are more than that
/// alone; the others are scaled to what is left, and the last one takes it all if they are 0.
fn close<A>(account: &mut A, total: u64, work: usize, each: impl Fn(&mut A, &mut dyn FnMut(usize, &mut u64))) {
    let mut classes = Vec::new();
    each(account, &mut |_, class| classes.push(*class));
    let (worked, waited) = classes.split_at_mut(work);
    let busy = worked.iter().sum::<u64>().min(total);
    share_out(worked, busy);
    share_out(waited, total - busy);
    each(account, &mut |place, class| *class = classes[place]);
}

/// Scales numbers so that they add up to a total; the largest takes what rounding leaves over, the last one all if all are 0.
fn share_out(numbers: &mut [u64], total: u64) {
    let sum: u64 = numbers.iter().sum();
    let Some(rest) = (0..numbers.len()).max_by_key(|&place| numbers[place]) else { return };
    let part = |number: u64| (u128::from(number) * u128::from(total) / u128::from(sum.max(1))) as u64;
    numbers.iter_mut().for_each(|number| *number = part(*number));
    numbers[rest] += total - numbers.iter().sum::<u64>();
}
