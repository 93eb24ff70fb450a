//! What is computed at a time: points of all kinds, as threads are free, or several policies side by side through one large trace.

use rayreel_replay::Detail;

use super::groups::{Group, groups};
use crate::point::convoy::{self, Convoy};
use crate::sweep::plan::Plan;

/// Memory for what is decoded that lets another group go side by side, bytes: 1 GiB is for four, which leave a quarter of the decoding. All are
/// in memory at once, and a worker that is killed loses them.
const MEMORY: usize = 256 << 20;

/// Groups of points that are computed before the next stage begins.
pub(super) struct Stage {
    /// With their numbers.
    pub groups: Vec<(usize, Group)>,
    /// All of them run at a time, side by side through one trace.
    pub convoy: Option<Convoy>,
}

impl Stage {
    /// Threads that run its groups: one for each that goes side by side with others. Then the convoy lets no more of them work at a time
    /// than there are `threads`.
    pub fn threads(&self, threads: usize) -> usize {
        if self.convoy.is_some() { self.groups.len() } else { threads }
    }

    /// How many of them read each tile of the trace; without limit where they come one after the other.
    pub fn readers(&self) -> usize {
        if self.convoy.is_some() { self.groups.len() } else { usize::MAX }
    }
}

/// `todo` in stages, with so many bytes of memory. With one thread one group runs after the other. Groups go side by side where more of them may
/// than there are threads: else the thread of a cheap policy would have nothing to do while it waits for a dear one.
pub(super) fn stages(plan: &Plan, todo: &[usize], (threads, memory): (usize, usize)) -> Vec<Stage> {
    let most = memory / MEMORY;
    let mut lists: Vec<Vec<Group>> = Vec::new();
    let mut alone = Vec::new();
    let trace_of = |group: &Group| (plan.points[group[0]].trace, plan.points[group[0]].frames);
    for group in groups(plan, todo, threads) {
        if threads == 1 || most <= threads || !goes_side_by_side(plan, &group) {
            alone.push(group);
            continue;
        }
        let has_room = |list: &&mut Vec<Group>| trace_of(&list[0]) == trace_of(&group) && list.len() < most;
        match lists.iter_mut().find(has_room) {
            Some(list) => list.push(group),
            None => lists.push(vec![group]),
        }
    }
    let (single, several): (Vec<_>, Vec<_>) = lists.into_iter().partition(|list| list.len() == 1);
    alone.extend(single.into_iter().flatten());
    let convoys = several.into_iter().map(|list| {
        let convoy = Convoy::new(list.len(), threads);
        (list, Some(convoy))
    });
    let stages = std::iter::once((alone, None)).chain(convoys).filter(|(list, _)| !list.is_empty());
    stages.map(|(list, convoy)| Stage { groups: (0..).zip(list).collect(), convoy }).collect()
}

/// Whether a group may go side by side with others. Those of which every cycle is simulated do not: decoding is little of what they take.
fn goes_side_by_side(plan: &Plan, group: &Group) -> bool {
    let point = &plan.points[group[0]];
    let trace = &plan.traces[point.trace];
    let is_simulated = |point: &usize| !plan.machines[plan.points[*point].machine].toml.is_empty();
    group.iter().any(is_simulated)
        && plan.detail(point).is_ok_and(|detail| detail != Detail::Full)
        && convoy::is_worth(trace.size, trace.samples)
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use rayreel_formats::{Limits, Trace};

    use super::*;
    use crate::sweep::plan::Sources;
    use crate::sweep::plan::locate::Text;

    /// A plan over the golden trace as if its frames were of this size: 4 policies, of one of them 3 kinds, on 2 machines and on none.
    fn plan(size: (u32, u32), detail: &str) -> Plan {
        let trace = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace");
        let text = format!(
            "traces = [{trace:?}]\nmachines = [\"sgrt-ti2\", \"sgrt-ti1\", \"none\"]\ndetail = [{detail:?}]\n\
             policies = [\"full\", \"adaptive\", \"paper-ss\", \"multirate\"]\n\
             [[axis]]\nname = \"start\"\nkey = \"start\"\nvalues = [2, 4, 8]\nonly = [\"multirate\"]\n"
        );
        let open = |file: &str| Trace::open(file.as_ref(), Limits::default()).map_err(|e| e.to_string());
        let text = Text { name: "plan", text: &text };
        let sources = Sources { text, folder: Path::new(""), traces: None, detail: None, stem: "plan", open: &open };
        let mut plan = Plan::new(&sources).unwrap();
        plan.traces[0].size = size;
        plan
    }

    /// Which points each stage has, and whether they go side by side.
    fn shape(plan: &Plan, threads: usize, memory: usize) -> Vec<(bool, usize)> {
        let todo: Vec<usize> = (0..plan.points.len()).collect();
        let stages = stages(plan, &todo, (threads, memory));
        let points = |stage: &Stage| stage.groups.iter().flat_map(|(_, group)| group.clone()).collect::<Vec<_>>();
        let mut all: Vec<usize> = stages.iter().flat_map(points).collect();
        all.sort_unstable();
        assert_eq!(all, todo);
        for stage in &stages {
            assert!(stage.groups.iter().map(|(number, _)| *number).eq(0..stage.groups.len()));
        }
        stages.iter().map(|stage| (stage.convoy.is_some(), points(stage).len())).collect()
    }

    #[test]
    fn policies_go_side_by_side_through_large_frames_of_which_a_part_is_simulated() {
        let samples = plan((1, 1), "5%").traces[0].samples;
        let large = (1024 / samples, 512 / samples);
        let shape_of = |threads, memory: usize| shape(&plan(large, "5%"), threads, memory << 20);
        assert_eq!(shape_of(2, 1024), [(false, 6), (true, 8), (true, 4)]);
        assert_eq!(shape_of(2, 2048), [(false, 6), (true, 12)]);
        assert_eq!(shape_of(4, 2048), [(false, 6), (true, 8), (true, 4)]);
        for (threads, memory) in [(2, 512), (4, 1024), (16, 1024)] {
            assert_eq!(shape_of(threads, memory), [(false, 18)]);
        }
        for (size, detail, threads) in [(large, "5%", 1), (large, "full", 2), ((64, 64), "5%", 2)] {
            assert_eq!(shape(&plan(size, detail), threads, 1 << 30), [(false, 18)]);
        }
    }
}
