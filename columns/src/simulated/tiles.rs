//! When each tile was under way, where, and what it was.

use std::collections::BTreeMap;

use rayreel_formats::tile::RayKind;
use rayreel_machine::system::{Core, Probe};
use rayreel_machine::time::{TiCycle, When};
use rayreel_machine::work::TileWork;
use rayreel_machine::work::ops::OpKind;

use super::table_probe::TableProbe;
use crate::schema::{Batch, table};

table! {
    /// Tiles on a machine.
    pub struct TileTimeRows = "tiles", "a tile that a core worked on, in the order in which they were done" {
        frame: Vec<u32>, "", "frame number";
        tile: Vec<u32>, "", "tile in the frame";
        core: Vec<u16>, "", "core";
        slot: Vec<u16>, "", "tile slot of the core";
        begin: Vec<u64>, "T&I cycles", "first event of the machine that found it in the slot, from the beginning of the frame";
        end: Vec<u64>, "T&I cycles", "first event that found it gone, or the end of the frame";
        rays: Vec<u32>, "rays", "rays that are traced for it, those of samples in its neighbours' borders that it closes among them";
        shadow_rays: Vec<u32>, "rays", "shadow rays among them";
        node_visits: Vec<u32>, "events", "inner nodes that its rays visit";
        triangle_tests: Vec<u32>, "events", "triangles that its rays test";
        rounds: Vec<u32>, "", "rounds of the policy";
        interpolated: Vec<u32>, "", "hits and whole subtrees that are interpolated";
        similarity_tests: Vec<u32>, "events", "pairs of hits that the policy compares";
    }
}

/// What a tile is.
#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    tile: u32,
    begin: TiCycle,
    rays: u32,
    shadow_rays: u32,
    node_visits: u32,
    triangle_tests: u32,
    rounds: u32,
    interpolated: u32,
    similarity_tests: u32,
}

impl Sums {
    fn of(work: &TileWork, begin: TiCycle) -> Self {
        let mut sums = Self { tile: work.tile, begin, rays: work.rays.len() as u32, ..Self::default() };
        for (ray, about) in (0..).zip(&work.rays) {
            sums.shadow_rays += u32::from(about.kind == RayKind::Shadow);
            for op in work.path(ray) {
                match op.kind() {
                    OpKind::Visit { .. } => sums.node_visits += 1,
                    OpKind::Leaf { tests, .. } => sums.triangle_tests += u32::from(tests),
                    _ => {}
                }
            }
        }
        sums.rounds = work.rounds.len() as u32;
        for round in &work.rounds {
            sums.interpolated += round.interpolated;
            sums.similarity_tests += round.tests;
        }
        sums
    }
}

/// A probe that writes down when which tile was where. It looks whenever anything happens.
#[derive(Debug, Default)]
pub struct TileTimes {
    frame: u32,
    due: TiCycle,
    open: BTreeMap<(u16, u16), Sums>,
    rows: TileTimeRows,
}

impl TileTimes {
    fn close(&mut self, (core, slot): (u16, u16), sums: Sums, end: TiCycle) {
        let rows = &mut self.rows;
        rows.frame.push(self.frame);
        rows.tile.push(sums.tile);
        rows.core.push(core);
        rows.slot.push(slot);
        rows.begin.push(sums.begin.0);
        rows.end.push(end.0);
        rows.rays.push(sums.rays);
        rows.shadow_rays.push(sums.shadow_rays);
        rows.node_visits.push(sums.node_visits);
        rows.triangle_tests.push(sums.triangle_tests);
        rows.rounds.push(sums.rounds);
        rows.interpolated.push(sums.interpolated);
        rows.similarity_tests.push(sums.similarity_tests);
    }
}

impl TableProbe for TileTimes {
    fn rows(&self) -> usize {
        self.rows.frame.len()
    }

    fn batch(&mut self) -> Batch {
        std::mem::take(&mut self.rows).batch()
    }
}

impl Probe for TileTimes {
    fn begin(&mut self, frame: u32) {
        self.frame = frame;
        self.due = TiCycle(0);
    }

    fn due(&self) -> When {
        When::at(self.due)
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], _: u64) {
        self.due = now + 1;
        for (core, place) in (0..).zip(cores) {
            let gone = |(at, sums): (&(u16, u16), &Sums)| {
                let stays = || place.srp.held().any(|held| held == (usize::from(at.1), sums.tile));
                (at.0 == core && !stays()).then_some((*at, *sums))
            };
            let gone: Vec<_> = self.open.iter().filter_map(gone).collect();
            for (at, sums) in gone {
                self.open.remove(&at);
                self.close(at, sums, now);
            }
            for (slot, _) in place.srp.held() {
                self.open.entry((core, slot as u16)).or_insert_with(|| Sums::of(place.srp.work(slot as u8), now));
            }
        }
    }
}
