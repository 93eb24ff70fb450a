//! Exact cycles of single rays, worked out by hand, and what the units promise about their accounts.

use rayreel_formats::bvh::Child;
use rayreel_formats::tile::{RayKind, step};

use super::{TiContext, TiStats, TiUnit};
use crate::component::{Component, Tick};
use crate::config::{MachineConfig, MissHandling, Pipeline};
use crate::link::{RayMessage, RayRef, RayUnit};
use crate::memory::{IdealMemory, Port};
use crate::test_config::machine as config;
use crate::time::TiCycle;
use crate::work::check::{PathCounts, walk};
use crate::work::layout::Layout;
use crate::work::synthetic::{self, Path};
use crate::work::topology::Topology;
use crate::work::{NO_TRIANGLE, TileWork};

/// The root has a leaf of two triangles and node 1; node 1 has two leaves of one.
fn small_tree() -> Topology {
    let children = vec![[Child::leaf(0, 2), Child::inner(1)], [Child::leaf(2, 1), Child::leaf(3, 1)]];
    Topology::from_children(children, 4)
}

/// A chain: node i has a leaf on the left and node i + 1 on the right.
fn chain(length: u32) -> Topology {
    let node = |i| [Child::leaf(i, 1), if i + 1 < length { Child::inner(i + 1) } else { Child::leaf(length, 1) }];
    Topology::from_children((0..length).map(node).collect(), length + 1)
}

fn tile(tree: &Topology, paths: &[(RayKind, &[u8])]) -> Vec<TileWork> {
    let mut work = synthetic::tile_of(0, 0, &[]);
    for &(kind, steps) in paths {
        let mut path = Path { steps: steps.to_vec(), ops: Vec::new(), hit: NO_TRIANGLE };
        walk(tree, steps, kind == RayKind::Shadow, &mut path.ops, &mut PathCounts::default()).unwrap();
        synthetic::push_ray(&mut work, &path, kind);
    }
    vec![work]
}

/// Feeds all rays as the ray buffer takes them; returns when each ray came out, by ray, and the accounts.
fn run(config: &MachineConfig, tree: &Topology, tiles: &Vec<TileWork>, latency: u64) -> (Vec<u64>, TiStats, u64) {
    let layout = Layout::new(config);
    let mut memory = IdealMemory::new(latency);
    let mut unit = TiUnit::new(config, Port(0));
    let (mut out, mut sent, mut now, mut arrived) = (vec![0; tiles[0].rays.len()], 0, TiCycle(0), Vec::new());
    loop {
        memory.tick(now, &mut arrived);
        arrived.drain(..).for_each(|r| unit.fill(now, r.port, r.line));
        while sent < out.len() && unit.has_room() {
            unit.push(now, RayRef { slot: 0, ray: sent as u32 });
            sent += 1;
        }
        unit.tick(now, TiContext { tree, layout: &layout, tiles, memory: &mut memory });
        while let Some(RayMessage { at, ray }) = unit.results().pop_front() {
            out[ray.ray as usize] = at.0;
        }
        match unit.next_event(now).min(memory.next_event(now)).after(now).cycle() {
            Some(at) => now = at,
            None if sent == out.len() && unit.rays_inside() == 0 => break,
            None => now += 1,
        }
    }
    (out, unit.finish(now + 1), (now + 1).0)
}

const PATH: &[u8] = &[step::LEFT_FIRST, step::MISS, step::HIT, step::POP, step::RIGHT, step::MISS];

#[test]
fn one_ray_alone_takes_the_sum_of_its_latencies() {
    let (config, tree) = (config(), small_tree());
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, PATH)]), 40);
    // Pushed in cycle 0, dispatched in 1.
    let setup = 1 + 17;
    let node = 40 + 10;
    // Two triangles: the second is looked up in the cycle after the first issued.
    let leaf_of_two = 5 + 2 + 40 + (1 + 40) + 30 + 2;
    let leaf_of_one = 5 + 2 + 40 + 30 + 2;
    // Last pop: finds the stack empty.
    assert_eq!(out, [setup + node + leaf_of_two + 3 + node + leaf_of_one + 3]);
    let events = stats.trv[0].events;
    assert_eq!((events.node_visits, events.box_tests, events.leaves, events.pushes), (2, 4, 2, 1));
    assert_eq!((events.stack_operations, events.restarts, stats.ist[0].events.triangle_tests), (2, 0, 3));
}

#[test]
fn a_second_ray_finds_everything_in_the_caches() {
    let (mut config, tree) = (config(), small_tree());
    config.ti.rays_per_trv = 1;
    let rays = [(RayKind::Primary, PATH), (RayKind::Primary, PATH)];
    let (out, _, _) = run(&config, &tree, &tile(&tree, &rays), 40);
    let hit = |triangles: u64| 5 + 2 + triangles + triangles - 1 + 30 + 2;
    // Dispatched in the cycle after the first one left.
    assert_eq!(out[1] - out[0], 1 + 17 + 11 + hit(2) + 3 + 11 + hit(1) + 3);
}

#[test]
fn a_shadow_ray_ends_at_its_hit() {
    let (config, tree) = (config(), small_tree());
    let path = &[step::LEFT_FIRST, step::HIT];
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Shadow, path)]), 40);
    assert_eq!(out, [1 + 17 + 50 + 5 + 2 + 40 + 30 + 2]);
    assert_eq!((stats.ist[0].events.triangle_tests, stats.trv[0].events.stack_operations), (1, 0));
}

#[test]
fn one_box_a_cycle_takes_two_passes() {
    let (mut config, tree) = (config(), small_tree());
    config.ti.aabbs_per_cycle = 1;
    let path = &[step::NONE];
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, path)]), 40);
    assert_eq!(out, [1 + 17 + (40 + 10) + (1 + 10) + 3]);
    assert_eq!((stats.trv[0].events.node_visits, stats.trv[0].events.box_tests), (1, 2));
}

#[test]
fn a_single_pipeline_passes_all_stages_every_time() {
    let (mut config, tree) = (config(), small_tree());
    config.ti.pipeline = Pipeline::Single;
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, PATH)]), 40);
    let depth = 10 + 5 + 3;
    let node = 40 + depth;
    let (two, one) = (depth + 2 + 40 + (1 + 40) + 30 + 2, depth + 2 + 40 + 30 + 2);
    assert_eq!(out, [1 + 17 + node + two + depth + node + one + depth]);
    assert_eq!(stats.trv[0].stages.len(), 1);
}

#[test]
fn a_unified_pipeline_tests_triangles_itself() {
    let (mut config, tree) = (config(), small_tree());
    (config.ti.pipeline, config.ti.ist) = (Pipeline::Unified, 0);
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, PATH)]), 40);
    let depth = 10 + 5 + 3 + 30;
    assert_eq!(out, [1 + 17 + 5 * (40 + depth) + 2 * depth]);
    assert_eq!(stats.trv[0].events.triangle_tests, 3);
}

#[test]
fn a_short_stack_that_lost_a_child_walks_down_again() {
    let (mut config, tree) = (config(), chain(4));
    config.ti.stack_entries = 2;
    // Down the chain right first, deferring the leaf of each node; then the leaves are popped, the last deferred first.
    let mut path = vec![step::RIGHT_FIRST; 4];
    path.push(step::MISS);
    path.extend([step::POP, step::MISS].repeat(4));
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, &path)]), 1);
    let events = stats.trv[0].events;
    // Two leaves are still held. The third pop finds nothing and walks down to node 1 (nodes 0 and 1); this puts the leaf of
    // node 0 back, so the fourth is an ordinary pop.
    assert_eq!((events.restarts, events.restart_visits, events.node_visits), (1, 2, 6));
    // Four when deferred, and the leaf of node 0 again on the walk.
    assert_eq!((events.pushes, events.stack_operations), (5, 5));
    let leaf = 5 + 2 + 1 + 30 + 2;
    let (node, pop) = (11, 3);
    assert_eq!(out, [1 + 17 + 4 * node + 5 * leaf + 5 * pop + 2 * node]);

    config.ti.stack_entries = 0;
    let (_, full, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, &path)]), 1);
    assert_eq!((full.trv[0].events.restarts, full.trv[0].events.node_visits), (0, 4));
}

#[test]
fn a_culled_child_of_a_walk_down_again_is_not_visited() {
    let (mut config, tree) = (config(), chain(3));
    config.ti.stack_entries = 1;
    // The child deferred last is held.
    let mut path = vec![step::RIGHT_FIRST; 3];
    path.extend([step::HIT, step::POP, step::MISS, step::CULLED, step::CULLED]);
    let (_, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, &path)]), 1);
    let events = stats.trv[0].events;
    // The leaf of node 2 is held. That of node 1 was lost: nodes 0 and 1 again, where its box is found to lie behind the hit;
    // the leaf of node 0 was put back on the way.
    assert_eq!((events.restarts, events.restart_visits, events.culled), (1, 2, 2));
}

#[test]
fn every_cycle_of_every_stage_is_in_one_class() {
    let tree = small_tree();
    let rays = vec![(RayKind::Primary, PATH); 300];
    for mode in [MissHandling::Reorder, MissHandling::Retry, MissHandling::Accumulate] {
        for pipeline in [Pipeline::Parallel, Pipeline::Single, Pipeline::Unified] {
            let mut config = config();
            (config.ti.miss_handling, config.ti.pipeline) = (mode, pipeline);
            config.ti.ist = u32::from(pipeline != Pipeline::Unified);
            let (out, stats, cycles) = run(&config, &tree, &tile(&tree, &rays), 40);
            assert!(out.iter().all(|&at| at > 0), "{mode:?} {pipeline:?}");
            for (name, stage) in &stats.trv[0].stages {
                assert_eq!(stage.total(), cycles, "{mode:?} {pipeline:?} {name}");
            }
            stats.ist.iter().for_each(|ist| assert_eq!(ist.activity.total(), cycles, "{mode:?} {pipeline:?}"));
            let tests = stats.trv[0].events.triangle_tests + stats.ist.first().map_or(0, |i| i.events.triangle_tests);
            assert_eq!((stats.trv[0].events.rays, tests), (300, 900), "{mode:?} {pipeline:?}");
            assert_eq!(stats.trv[0].events.node_visits, 600);
        }
    }
}

#[test]
fn a_retried_operation_passes_the_pipeline_as_a_bypass() {
    let (mut config, tree) = (config(), small_tree());
    config.ti.miss_handling = MissHandling::Retry;
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, &[step::NONE])]), 40);
    // Looked up in 18, issued in 19, back in 29; again in 29, 40, 51; the line came in 58: the lookup in 62 hits.
    assert_eq!(out, [62 + 1 + 10 + 3]);
    assert_eq!(stats.trv[0].events.bypasses, 4);
    assert_eq!(stats.trv[0].stages[0].1.bypass, 4);
}

#[test]
fn throughput_is_one_node_a_cycle() {
    let (mut config, tree) = (config(), small_tree());
    config.ti.rays_per_trv = 64;
    let rays = vec![(RayKind::Primary, &[step::NONE][..]); 5000];
    let (_, stats, cycles) = run(&config, &tree, &tile(&tree, &rays), 1);
    assert_eq!(stats.trv[0].stages[0].1.busy, 5000);
    assert!((5000..5100).contains(&cycles), "{cycles}");
}

#[test]
fn a_hit_passes_a_miss() {
    let (tree, none) = (chain(2), &[step::NONE][..]);
    for mode in [MissHandling::Reorder, MissHandling::Retry, MissHandling::Accumulate] {
        let mut config = config();
        (config.ti.miss_handling, config.ti.rays_per_trv) = (mode, 2);
        let rays =
            [(RayKind::Primary, &[step::RIGHT, step::NONE][..]), (RayKind::Primary, none), (RayKind::Primary, none)];
        let (out, _, _) = run(&config, &tree, &tile(&tree, &rays), 40);
        match mode {
            // Both wait for node 0 until 58 and issue in 58 and 59. The first then waits for node 1 from 68 to 108; the third
            // ray comes in 73, finds node 0 in 90, and is out before.
            MissHandling::Reorder | MissHandling::Accumulate => assert_eq!(out, [121, 72, 104], "{mode:?}"),
            MissHandling::Retry => assert!(out[2] < out[0], "{mode:?}: {out:?}"),
        }
    }
}

#[test]
fn a_full_row_holds_up_the_queue() {
    let (mut config, tree) = (config(), chain(2));
    (config.ti.miss_handling, config.ti.accumulate_rays_per_row) = (MissHandling::Accumulate, 1);
    let rays = [(RayKind::Primary, &[step::NONE][..]); 3];
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &rays), 40);
    // The first is parked in 18. The second is refused from 19 on; the line comes in 58, and it hits then; the third in 59.
    assert_eq!(out, [58 + 10 + 3, 59 + 10 + 3, 60 + 10 + 3]);
    let trv = &stats.trv[0];
    assert_eq!((trv.buffer.parked, trv.l1.misses, trv.l1.merges, trv.l1.hits), (1, 1, 0, 2));
    assert_eq!(trv.l1.full, 58 - 19);
}

#[test]
fn mshrs_run_out() {
    let (mut config, tree) = (config(), chain(4));
    config.ti.trv_l1.mshrs = 1;
    config.ti.rays_per_trv = 2;
    // Both see node 0. The second goes on to node 1 after the first did, and node 1 is on its way by then.
    let rays = [
        (RayKind::Primary, &[step::RIGHT, step::RIGHT, step::NONE][..]),
        (RayKind::Primary, &[step::RIGHT, step::NONE]),
    ];
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &rays), 40);
    assert_eq!(out, [18 + 3 * 50 + 3, 18 + 41 + 10 + 40 + 10 + 3]);
    assert_eq!((stats.trv[0].l1.misses, stats.trv[0].l1.merges), (3, 2));
}

#[test]
fn data_that_straddle_lines_take_a_cycle_more_with_one_bank() {
    let (mut config, tree) = (config(), chain(2));
    (config.layout.node_bytes, config.ti.rays_per_trv) = (128, 1);
    let rays = [(RayKind::Primary, &[step::NONE][..]); 2];
    let second = |config: &MachineConfig| {
        let (out, stats, _) = run(config, &tree, &tile(&tree, &rays), 40);
        assert_eq!(stats.trv[0].l1.lookups, 4);
        out[1] - out[0]
    };
    assert_eq!(second(&config), 1 + 17 + 2 + 10 + 3);
    config.ti.trv_lines_per_cycle = 2;
    assert_eq!(second(&config), 1 + 17 + 1 + 10 + 3);
}

#[test]
fn every_line_of_a_retried_operation_is_kept() {
    let (mut config, tree) = (config(), chain(2));
    (config.layout.node_bytes, config.ti.miss_handling) = (12 * 64, MissHandling::Retry);
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &[(RayKind::Primary, &[step::NONE])]), 40);
    // Twelve lines a pass, one a cycle: looked up in 18, 40 and 62; all lines came in 58.
    assert_eq!(out, [62 + 12 + 10 + 3]);
    assert_eq!((stats.trv[0].events.bypasses, stats.trv[0].buffer.late_reads), (2, 12));
}

#[test]
fn a_free_entry_goes_to_who_waits_longest() {
    let (mut config, tree) = (config(), small_tree());
    (config.ti.ist_entries, config.ti.trv) = (1, 2);
    // Three shadow rays that end in the same leaf. The second is in the other unit, whose cold L1 makes it the last to get there.
    let rays = [(RayKind::Shadow, &[step::LEFT, step::HIT][..]); 3];
    let (out, stats, _) = run(&config, &tree, &tile(&tree, &rays), 40);
    assert!(out[0] < out[2] && out[2] < out[1], "{out:?}");
    // Granted in the cycle after the entry became free, leaf pipe, crossbar, hit, triangle pipe, crossbar.
    assert_eq!(out[1] - out[2], 1 + 5 + 2 + 1 + 30);
    assert!(stats.trv.iter().map(|trv| trv.stages[1].1.blocked).sum::<u64>() > 0);
}
