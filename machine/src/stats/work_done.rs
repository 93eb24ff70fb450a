//! Counters of an estimate that follow from work which is known exactly.
//!
//! A window goes on from where a pass without cycles has left the machine, and for some time it does more of one kind of work and
//! less of another than the frame: traversal goes ahead of the tiles' ends, say. So lookups and busy cycles would be too many
//! for the visits that are known, and those of the SRP too few. Here each is as many as its work.

use super::Stats;
use crate::srp::KERNELS;
use crate::ti::TrvStats;

/// How many times more of each kind of work there is than was estimated.
struct Factors {
    /// By issue stage of a traversal unit.
    stages: Vec<f64>,
    /// Lookups of traversal units and of intersection units, and those of the SRPs.
    trv: f64,
    ist: f64,
    srp_l1: f64,
    /// Items of kernels, and of all together.
    kernels: [f64; KERNELS],
    items: f64,
}

impl Stats {
    /// Lets what follows from work, in all units alike, be as much as the work of `exact` takes.
    pub fn follow_work(&mut self, exact: &Self) {
        let factors = Factors::new(self, exact);
        let misses = self.l1_misses();
        for core in &mut self.cores {
            for unit in &mut core.ti.trv {
                for ((_, account), factor) in unit.stages.iter_mut().zip(&factors.stages) {
                    follow(account, |class| (class < ISSUES).then_some(*factor), |a, visit| a.each_mut(visit));
                }
                unit.events.bypasses = times(unit.events.bypasses, factors.trv);
                unit.buffer.each_mut(|_, counter| *counter = times(*counter, factors.trv));
                unit.l1.each_mut(|_, counter| *counter = times(*counter, factors.trv));
            }
            for unit in &mut core.ti.ist {
                let of = |class| (class < ISSUES).then_some(factors.ist);
                follow(&mut unit.activity, of, |a, visit| a.each_mut(visit));
                unit.events.bypasses = times(unit.events.bypasses, factors.ist);
                unit.buffer.each_mut(|_, counter| *counter = times(*counter, factors.ist));
                unit.l1.each_mut(|_, counter| *counter = times(*counter, factors.ist));
            }
            follow(&mut core.srp.activity, |class| factors.of_srp(class), |a, visit| a.each_mut(visit));
            for (kernel, factor) in core.srp.kernels.iter_mut().zip(factors.kernels) {
                kernel.each_mut(|_, counter| *counter = times(*counter, factor));
            }
            core.srp_l1.each_mut(|_, counter| *counter = times(*counter, factors.srp_l1));
        }
        // What the L2 reads from DRAM is known otherwise.
        let factor = ratio(self.l1_misses(), misses);
        let l2 = &mut self.memory.l2;
        (l2.lookups, l2.merges) = (times(l2.lookups, factor), times(l2.merges, factor));
        l2.hits = l2.lookups.saturating_sub(l2.misses + l2.merges);
    }

    /// Lines that L1s ask the L2 for.
    fn l1_misses(&self) -> u64 {
        let units = self.trv().map(|unit| unit.l1.misses).chain(self.ist().map(|unit| unit.l1.misses));
        units.sum::<u64>() + self.cores.iter().map(|core| core.srp_l1.misses).sum::<u64>()
    }
}

/// The first classes of an [`Activity`](crate::counters::Activity), in which something issues: busy and bypass.
pub(super) const ISSUES: usize = 2;
/// The first classes of [`SrpActivity`](crate::srp::SrpActivity), in which the SRP works: kernels come first, then the inspector.
pub(super) const SRP_WORK: usize = KERNELS + 1;

impl Factors {
    fn new(estimated: &Stats, exact: &Stats) -> Self {
        let of = |sum: &dyn Fn(&Stats) -> u64| ratio(sum(exact), sum(estimated));
        let trv = |count: fn(&TrvStats) -> u64| of(&|stats| stats.trv().map(count).sum());
        let stages = match estimated.trv().next().map_or(0, |unit| unit.stages.len()) {
            3 => vec![
                trv(|unit| unit.events.node_visits),
                trv(|unit| unit.events.leaves),
                trv(|unit| unit.events.stack_operations),
            ],
            stages => {
                vec![trv(|TrvStats { events, .. }| events.node_visits + events.leaves + events.triangle_tests); stages]
            }
        };
        let items = |stats: &Stats, kernel: usize| stats.cores.iter().map(|core| core.srp.kernels[kernel].items).sum();
        Self {
            stages,
            trv: trv(|unit| unit.events.node_visits + unit.events.triangle_tests),
            ist: of(&|stats| stats.ist().map(|unit| unit.events.triangle_tests).sum()),
            srp_l1: of(&|stats| stats.cores.iter().map(|core| core.srp_l1.lookups).sum()),
            kernels: std::array::from_fn(|kernel| of(&|stats| items(stats, kernel))),
            items: of(&|stats| (0..KERNELS).map(|kernel| -> u64 { items(stats, kernel) }).sum()),
        }
    }

    /// That of a class of [`SrpActivity`](crate::srp::SrpActivity), unless the SRP waits in it.
    fn of_srp(&self, class: usize) -> Option<f64> {
        self.kernels.get(class).copied().or((class < SRP_WORK).then_some(self.items))
    }
}

fn ratio(exact: u64, estimated: u64) -> f64 {
    if exact > 0 && estimated > 0 { exact as f64 / estimated as f64 } else { 1.0 }
}

fn times(counter: u64, factor: f64) -> u64 {
    (counter as f64 * factor).round() as u64
}

/// Scales the classes of an account that have a factor; the others, in which the unit waits, share what is left of its cycles.
fn follow<A>(
    account: &mut A,
    factor: impl Fn(usize) -> Option<f64>,
    each: impl Fn(&mut A, &mut dyn FnMut(usize, &mut u64)),
) {
    let (mut total, mut worked, mut waited) = (0.0, 0.0, 0.0);
    each(account, &mut |class, cycles| {
        let cycles = *cycles as f64;
        total += cycles;
        match factor(class) {
            Some(factor) => worked += factor * cycles,
            None => waited += cycles,
        }
    });
    // More work than cycles is left out: a unit cannot be busier than always.
    let fits = if worked > total { total / worked } else { 1.0 };
    let left = if waited > 0.0 { (total - fits * worked) / waited } else { 1.0 };
    each(account, &mut |class, cycles| *cycles = times(*cycles, factor(class).map_or(left, |factor| factor * fits)));
}
