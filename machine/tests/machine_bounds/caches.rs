//! An independent LRU cache gives the hits that the machine counts, on the recorded rays.

use rayreel_machine::config::MachineConfig;
use rayreel_machine::work::TileWork;
use rayreel_machine::work::layout::{Layout, Lines};
use rayreel_machine::work::ops::OpKind;

use super::harness::{Recorded, machine, recorded, run_unit};

/// Each set is a list of lines, the least recently used first.
struct Lru {
    sets: Vec<Vec<u64>>,
    ways: usize,
    hits: u64,
    lookups: u64,
}

impl Lru {
    fn new(lines: u64, ways: u32) -> Self {
        Self { sets: vec![Vec::new(); (lines / u64::from(ways)) as usize], ways: ways as usize, hits: 0, lookups: 0 }
    }

    fn read(&mut self, lines: Lines) {
        for line in lines.first..=lines.last {
            let sets = self.sets.len() as u64;
            let set = &mut self.sets[(line % sets) as usize];
            let found = set.iter().position(|&l| l == line);
            self.lookups += 1;
            self.hits += u64::from(found.is_some());
            match found {
                Some(place) => drop(set.remove(place)),
                None if set.len() == self.ways => drop(set.remove(0)),
                None => {}
            }
            set.push(line);
        }
    }
}

/// Hits and lookups of nodes and triangles, one ray after the other.
fn expected(config: &MachineConfig, tile: &TileWork) -> [(u64, u64); 2] {
    let layout = Layout::new(config);
    let cache = |l1: &rayreel_machine::config::L1| Lru::new(l1.size.0 / 64, l1.ways);
    let (mut nodes, mut triangles) = (cache(&config.ti.trv_l1), cache(&config.ti.ist_l1));
    for ray in 0..tile.rays.len() as u32 {
        for op in tile.path(ray) {
            match op.kind() {
                OpKind::Visit { node, .. } => nodes.read(layout.node(node)),
                OpKind::Leaf { triangle, tests } => {
                    (triangle..triangle + u32::from(tests)).for_each(|t| triangles.read(layout.triangle(t)));
                }
                _ => {}
            }
        }
    }
    [nodes, triangles].map(|cache| (cache.hits, cache.lookups))
}

/// The rays of some tiles, as one tile.
fn joined(work: &Recorded, tiles: usize) -> TileWork {
    let mut joined = work.tiles[0].clone();
    for tile in &work.tiles[1..tiles.min(work.tiles.len())] {
        let (first, ops) = (joined.rays.len(), joined.ops.len() as u32);
        joined.rays.extend_from_slice(&tile.rays);
        joined.ops.extend_from_slice(&tile.ops);
        joined.rays[first..].iter_mut().for_each(|ray| ray.ops_start += ops);
    }
    joined
}

#[test]
fn an_independent_lru_counts_the_same_hits() {
    for work in [&recorded()[0], &recorded()[3]] {
        let tile = joined(work, 4);
        for (size, ways) in [("1KiB", 1), ("1KiB", 4), ("4KiB", 16), ("16KiB", 4)] {
            // One ray at a time, so that the order of accesses is that of the paths; no restarts.
            let mut overrides: Vec<String> =
                ["gpu.cores=1", "ti.trv=1", "ti.rays_per_trv=1", "ti.stack_entries=0", "ti.miss_handling=reorder"]
                    .map(String::from)
                    .into();
            for l1 in ["trv_l1", "ist_l1"] {
                overrides.extend([format!("ti.{l1}.size={size}"), format!("ti.{l1}.ways={ways}")]);
            }
            let config = machine("sgrt-ti2", &overrides.iter().map(String::as_str).collect::<Vec<_>>());
            let (stats, _) = run_unit(&config, &work.tree, &vec![tile.clone()], 1);
            let found = [&stats.trv[0].l1, &stats.ist[0].l1].map(|l1| (l1.hits, l1.lookups));
            assert_eq!(found, expected(&config, &tile), "{}: {size}, {ways} ways", work.name);
            let teapot = work.name.contains("teapot");
            assert!(!teapot || size != "1KiB" || found[0].0 < found[0].1 * 95 / 100, "small caches miss: {found:?}");
        }
    }
}
