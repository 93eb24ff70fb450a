//! What a unit did with its cycles, state by state: kernels, and the reasons for which it stood still.

use crate::counters::Activity;
use crate::system::Core;
use crate::time::TiCycle;

/// A state of a unit with the cycles that it was in.
pub struct State {
    /// The unit, and its stage if it has several.
    pub unit: String,
    /// The state, as counters name it.
    pub state: &'static str,
    /// Cycles so far.
    pub cycles: u64,
}

/// The states of all units of a core before cycle `now`, always in the same order: those of a unit follow one another.
pub fn of_core(core: &Core, now: TiCycle) -> Vec<State> {
    let (mut all, report) = (Vec::new(), core.report(now));
    let mut add = |unit: String, states: Vec<(&'static str, u64)>| {
        all.extend(states.into_iter().map(|(state, cycles)| State { unit: unit.clone(), state, cycles }));
    };
    let listed = |activity: &Activity| activity.list().iter().map(|state| (state.name, state.value)).collect();
    for (i, trv) in report.ti.trv.iter().enumerate() {
        trv.stages
            .iter()
            .for_each(|(stage, activity)| add(format!("TRV {i} {stage}").trim_end().into(), listed(activity)));
    }
    for (i, ist) in report.ti.ist.iter().enumerate() {
        add(format!("IST {i}"), listed(&ist.activity));
    }
    for (i, processor) in report.processors.iter().enumerate() {
        // What its warps did, most of them.
        let states = processor.counters.list().into_iter().filter(|counter| counter.unit == "warp cycles");
        add(format!("processor {i}"), states.map(|state| (state.name, state.value)).collect());
    }
    add("SRP".into(), report.srp.activity.list().iter().map(|state| (state.name, state.value)).collect());
    all
}

/// Runs of intervals whose main state is the same: begin, end, state. `grown` has for each interval how much each state grew; the first
/// of equals counts, and an interval in which none grew is in no run.
pub fn runs(times: &[TiCycle], grown: impl Iterator<Item = Vec<u128>>) -> Vec<(TiCycle, TiCycle, usize)> {
    let mut runs: Vec<(TiCycle, TiCycle, usize)> = Vec::new();
    for (ends, grown) in times.windows(2).zip(grown) {
        let most = grown.iter().copied().max().unwrap_or(0);
        let Some(state) = grown.iter().position(|cycles| *cycles == most && most > 0) else { continue };
        match runs.last_mut() {
            Some(last) if last.1 == ends[0] && last.2 == state => last.1 = ends[1],
            _ => runs.push((ends[0], ends[1], state)),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_neighbours_become_one_run() {
        let times: Vec<TiCycle> = [0, 10, 20, 30, 50].map(TiCycle).into();
        let grown = [vec![6, 4], vec![5, 5], vec![0, 0], vec![1, 19]];
        let run = |begin, end, state| (TiCycle(begin), TiCycle(end), state);
        assert_eq!(runs(&times, grown.into_iter()), [run(0, 20, 0), run(30, 50, 1)]);
    }
}
