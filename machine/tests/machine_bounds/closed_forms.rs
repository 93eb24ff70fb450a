//! With an ideal memory the machine is as fast as its busiest unit allows, within 2 %.

use rayreel_formats::bvh::{Child, MAX_LEAF_TRIANGLES};
use rayreel_formats::tile::step;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::memory::IdealMemory;
use rayreel_machine::stats::{CoreStats, Stats};
use rayreel_machine::work::TileWork;
use rayreel_machine::work::topology::Topology;

use super::bounds::Demand;
use super::harness::{SHAPE, chain, machine, repeated, run, run_unit};

/// Memory answers within the depth of any pipeline, so misses of the first rays cost nothing to speak of.
const LATENCY: u64 = 4;

fn assert_near(what: &str, unit: &str, cycles: u64, bounds: &[(&'static str, u64)]) {
    let (busiest, least) = *bounds.iter().max_by_key(|b| b.1).unwrap();
    assert_eq!(busiest, unit, "{what} is bound by something else: {bounds:?}");
    assert!(cycles >= least, "{what}: {cycles} cycles, below {least} of {unit}");
    assert!(cycles * 100 <= least * 102, "{what}: {cycles} cycles, more than 2 % above {least} of {unit}");
}

/// The whole system, and the T&I unit of one core alone.
fn assert_bound_by(unit: &str, overrides: &[&str], tree: &Topology, tile: TileWork) {
    for miss_handling in ["retry", "accumulate", "reorder"] {
        let handling = format!("ti.miss_handling={miss_handling}");
        let triangles = format!("ti.ist_miss_handling={miss_handling}");
        let overrides = [&["gpu.cores=1", "srp.ideal=true", handling.as_str(), triangles.as_str()], overrides].concat();
        let config = machine("sgrt-ti2", &overrides);
        let what = format!("{unit} {miss_handling}");
        let tiles = vec![tile.clone()];
        let demand = Demand::of(&config, &tiles);
        let stats = run(&config, (tree, &tiles), SHAPE, IdealMemory::new(LATENCY));
        assert_near(&what, unit, stats.cycles, &demand.bounds(&config, &stats));
        let (ti, cycles) = run_unit(&config, tree, &tiles, LATENCY);
        let alone = Stats { cycles, cores: vec![CoreStats { ti, ..CoreStats::default() }], ..Stats::default() };
        assert_near(&format!("{what}, unit alone"), unit, cycles, &demand.bounds(&config, &alone));
    }
}

/// Down a chain of 32 nodes and out.
fn walker(rays: usize) -> (Topology, TileWork) {
    let tree = chain(32);
    let steps = [vec![step::RIGHT; 31], vec![step::NONE]].concat();
    let tile = repeated(&tree, &steps, rays);
    (tree, tile)
}

/// One node, with two leaves of `triangles`.
fn twig(triangles: u32) -> Topology {
    Topology::from_children(vec![[Child::leaf(0, triangles), Child::leaf(triangles, triangles)]], 2 * triangles)
}

#[test]
fn inner_nodes() {
    let (tree, tile) = walker(2000);
    assert_bound_by("inner nodes", &[], &tree, tile);
}

#[test]
fn inner_nodes_of_one_box_a_cycle() {
    let (tree, tile) = walker(1200);
    assert_bound_by("inner nodes", &["ti.aabbs_per_cycle=1"], &tree, tile);
}

#[test]
fn a_single_pipeline() {
    let (tree, tile) = walker(2000);
    assert_bound_by("pipeline", &["ti.pipeline=single"], &tree, tile);
}

#[test]
fn a_unified_pipeline() {
    // Nodes, triangles and pops: root, leaf, pop, leaf, end.
    let tree = twig(MAX_LEAF_TRIANGLES);
    let leaf = vec![step::MISS; MAX_LEAF_TRIANGLES as usize];
    let tile = repeated(&tree, &[vec![step::LEFT_FIRST], leaf.clone(), vec![step::POP], leaf].concat(), 5000);
    let overrides = ["ti.pipeline=unified", "ti.ist=0", "ti.trv_lines_per_cycle=2", "ti.trv=2"];
    assert_bound_by("pipeline", &overrides, &tree, tile);
}

#[test]
fn triangles() {
    let tree = twig(MAX_LEAF_TRIANGLES);
    let steps = [vec![step::LEFT], vec![step::MISS; MAX_LEAF_TRIANGLES as usize]].concat();
    assert_bound_by("triangles", &[], &tree, repeated(&tree, &steps, 4000));
    assert_bound_by("triangles", &["ti.ist=2"], &tree, repeated(&tree, &steps, 8000));
}

#[test]
fn stack() {
    // A visit, a test, a culled child, the end: two stack operations for one of everything else.
    let tree = twig(1);
    let tile = repeated(&tree, &[step::LEFT_FIRST, step::HIT, step::CULLED], 5000);
    assert_bound_by("stack", &["ti.trv=1"], &tree, tile);
}

#[test]
fn dispatcher() {
    let tree = twig(1);
    assert_bound_by("dispatcher", &[], &tree, repeated(&tree, &[step::NONE], 8000));
}

/// Cheap rays, and the SRP as it is: raygen, miss and resolve, no prologue.
#[test]
fn srp() {
    let tree = twig(1);
    let prologues: Vec<_> = ["raygen", "miss", "resolve"].map(|k| format!("srp.kernels.{k}.prologue_cycles=0")).into();
    let mut overrides = vec!["gpu.cores=1"];
    overrides.extend(prologues.iter().map(String::as_str));
    let config: MachineConfig = machine("sgrt-ti2", &overrides);
    let tiles = vec![repeated(&tree, &[step::NONE], 1000); 8];
    let stats = run(&config, (&tree, &tiles), SHAPE, IdealMemory::new(LATENCY));
    assert_near("SRP", "SRP", stats.cycles, &Demand::of(&config, &tiles).bounds(&config, &stats));
}

/// A link of a byte a cycle: 32 cycles a ray.
#[test]
fn interface() {
    let (tree, overrides) = (twig(1), ["gpu.cores=1", "gpu.interface_bytes_per_cycle=1"]);
    let config = machine("sgrt-ti2", &overrides);
    let tiles = vec![repeated(&tree, &[step::NONE], 500); 2];
    let stats = run(&config, (&tree, &tiles), SHAPE, IdealMemory::new(LATENCY));
    assert_near("interface", "interface", stats.cycles, &Demand::of(&config, &tiles).bounds(&config, &stats));
}
