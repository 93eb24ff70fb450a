//! Tiles that wait for the tiles beside them: to the cycle.

use rayreel_machine::component::{Component, Tick};
use rayreel_machine::memory::{IdealMemory, Memory, MemoryStats, Request, Response};
use rayreel_machine::time::{TiCycle, When};
use rayreel_machine::work::layout::Region;
use rayreel_machine::work::{Neighbour, Round, TileWork};

use crate::harness::{SHAPE, chain, machine, repeated, run_keeping};
use rayreel_formats::tile::step;

/// A memory that notes when border samples are asked for.
struct Noting {
    memory: IdealMemory,
    /// Cycle and line.
    borders: Vec<(u64, u64)>,
}

impl Memory for Noting {
    fn request(&mut self, now: TiCycle, request: Request) -> bool {
        if request.region == Region::Border {
            self.borders.push((now.0, request.line));
        }
        self.memory.request(now, request)
    }
}

impl Component for Noting {
    type Report = MemoryStats;

    fn next_event(&self, now: TiCycle) -> When {
        self.memory.next_event(now)
    }

    fn finish(&mut self, end: TiCycle) -> MemoryStats {
        self.memory.finish(end)
    }
}

impl Tick<&mut Vec<Response>> for Noting {
    fn tick(&mut self, now: TiCycle, arrived: &mut Vec<Response>) {
        self.memory.tick(now, arrived);
    }
}

/// When each of two tiles asks for border samples, which it does when its second round begins. The first traces `rays` rays in
/// its first round and the second one ray; they run on cores of their own.
fn second_rounds(rays: [usize; 2], neighbour: Option<Neighbour>) -> [u64; 2] {
    let tree = chain(3);
    let steps = [step::LEFT, step::MISS];
    let tile = |number: u32| -> TileWork {
        let mut work = repeated(&tree, &steps, rays[number as usize]);
        work.tile = number;
        work.rounds.push(Round { tests: 1, ..Round::default() });
        work.border_samples = 1;
        work
    };
    let second = TileWork { left: neighbour, ..tile(1) };
    let config = machine("sgrt-ti2", &["gpu.cores=2", "gpu.tiles_in_flight=1"]);
    let memory = Noting { memory: IdealMemory::new(20), borders: Vec::new() };
    let (_, memory) = run_keeping(&config, (&tree, &[tile(0), second]), SHAPE, memory);
    let mut borders = memory.borders;
    borders.sort_by_key(|(_, line)| *line);
    [borders[0].0, borders[1].0]
}

#[test]
fn a_tile_waits_for_its_neighbour_to_the_cycle() {
    let on_first = |rounds| Some(Neighbour { tile: 0, rounds, before: 1 });
    let [first, alone] = second_rounds([40, 1], None);
    assert!(alone + 10 < first, "the second tile is ready long before the first: {alone} and {first}");
    // The first tile's border read is asked for in the cycle in which its first round ends; the second goes on in the next.
    assert_eq!(second_rounds([40, 1], on_first(1)), [first, first + 1]);
    // A tile that has never been there is done.
    let never = Some(Neighbour { tile: 9, rounds: 1, before: 1 });
    assert_eq!(second_rounds([40, 1], never), [first, alone + 1]);
    // A tile that is far enough already is waited for, for one cycle, only to look.
    let [early, late] = second_rounds([1, 40], None);
    assert!(early < late);
    assert_eq!(second_rounds([1, 40], on_first(1)), [early, late + 1]);
    // All of its rounds: until it has left.
    let [_, after_all] = second_rounds([40, 1], on_first(9));
    assert!(after_all > first + 1, "{after_all}");
}
