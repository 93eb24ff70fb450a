//! Points that share a replay: machines that do the same work, each in its way.

use std::collections::BTreeMap;

use crate::sweep::plan::Plan;

/// Points of which one replay serves all.
pub(super) type Group = Vec<usize>;

/// Most points of a group. All of its machines are in memory at once, and a worker that is killed loses the group.
const MOST: usize = 8;

/// Groups for each thread, at least: with few of them, all but one thread would wait at the end.
const EACH: usize = 4;

/// `todo` in groups of points of which one replay serves all: the same trace, frames, policy with what the axes change of it, and
/// detail. Groups come in the order of their first points.
pub(super) fn groups(plan: &Plan, todo: &[usize], threads: usize) -> Vec<Group> {
    let most = (todo.len() / (EACH * threads.max(1))).clamp(1, MOST);
    let (mut groups, mut open): (Vec<Group>, BTreeMap<_, usize>) = (Vec::new(), BTreeMap::new());
    for &index in todo {
        let point = &plan.points[index];
        let shared = (point.trace, point.frames, point.policy, point.detail, plan.policy_overrides(point));
        match open.get(&shared).and_then(|group| groups.get_mut(*group)).filter(|group| group.len() < most) {
            Some(group) => group.push(index),
            None => {
                open.insert(shared, groups.len());
                groups.push(vec![index]);
            }
        }
    }
    groups
}
