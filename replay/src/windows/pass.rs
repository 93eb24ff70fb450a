//! One pass over the tiles of a frame: each goes through the functional machines, and the windows are simulated beside it.

use std::collections::BTreeMap;
use std::collections::VecDeque;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use rayon::Scope;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::{Checkpoint, Features, FunctionalMachine};
use rayreel_machine::srp::FrameShape;
use rayreel_machine::stats::Stats;
use rayreel_machine::work::TileWork;
use rayreel_machine::work::topology::Topology;

use super::blocks::Blocks;
use super::window::{Measured, Window};
use crate::error::Result;
use crate::stop::Stop;

/// A block that takes so many times what the blocks before it take on average, and more than any of them, is simulated whether
/// it was chosen or not: no other one can stand for it. Below a sky all of the ground takes more than the average, but only
/// the first of its blocks is new.
const HEAVY: f64 = 4.0;

/// What came of a pass for one machine.
pub struct Passed {
    /// What the functional machine counted.
    pub counted: Stats,
    /// Of each tile, by tile number.
    pub features: Vec<Features>,
    /// Blocks that were simulated because they are heavy.
    pub heavy: Vec<usize>,
    /// What windows measured, by block.
    pub windows: BTreeMap<usize, Measured>,
}

/// A machine in a pass.
pub struct MachinePass<'a> {
    config: &'a MachineConfig,
    blocks: Option<&'a Blocks>,
    functional: FunctionalMachine<'a>,
    /// Operations of the tiles so far.
    sizes: Vec<f64>,
    /// Blocks that have begun: their warm-up, or they themselves.
    open: VecDeque<OpenBlock>,
    heavy: Vec<usize>,
    /// Mean operations of a tile in the block that took most so far.
    largest: f64,
    windows: Arc<Mutex<BTreeMap<usize, Result<Measured>>>>,
}

/// A block whose tiles are coming.
struct OpenBlock {
    block: usize,
    from: Option<Checkpoint>,
    tiles: Vec<Arc<TileWork>>,
}

/// What all machines of a pass share.
#[derive(Clone, Copy)]
pub struct Shared<'a> {
    /// The tree.
    pub tree: &'a Topology,
    /// Ends windows early.
    pub stop: &'a Stop,
    /// How many windows may be under way.
    pub room: &'a Room,
}

/// Limits the windows that wait or run, and so the memory of their tiles.
pub struct Room {
    free: Mutex<usize>,
    freed: Condvar,
}

impl Room {
    /// Room for so many windows.
    pub fn new(windows: usize) -> Self {
        Self { free: Mutex::new(windows), freed: Condvar::new() }
    }

    fn take(&self) {
        let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
        let mut free = self.freed.wait_while(free, |free| *free == 0).unwrap_or_else(PoisonError::into_inner);
        *free -= 1;
    }

    fn give(&self) {
        *self.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.freed.notify_one();
    }
}

/// Gives its place back, even where a window ends in a panic.
struct Place<'a>(&'a Room);

impl Drop for Place<'_> {
    fn drop(&mut self) {
        self.0.give();
    }
}

impl<'a> MachinePass<'a> {
    /// A machine before the first tile. Without `blocks` nothing is simulated.
    pub fn new(config: &'a MachineConfig, tree: &'a Topology, shape: FrameShape, blocks: Option<&'a Blocks>) -> Self {
        Self {
            config,
            blocks,
            functional: FunctionalMachine::new(config, tree, shape),
            sizes: Vec::new(),
            open: VecDeque::new(),
            heavy: Vec::new(),
            largest: 0.0,
            windows: Arc::default(),
        }
    }

    /// Takes the next tile.
    pub fn take<'s>(&mut self, tile: &Arc<TileWork>, shape: FrameShape, shared: Shared<'s>, scope: &Scope<'s>)
    where
        'a: 's,
    {
        let number = self.sizes.len();
        self.functional.make_room();
        self.open_blocks(number);
        self.open.iter_mut().for_each(|open| open.tiles.push(Arc::clone(tile)));
        self.functional.feed(Arc::clone(tile));
        self.sizes.push(tile.operations() as f64);
        let Some(blocks) = self.blocks else { return };
        while self.open.front().is_some_and(|open| blocks.tiles(open.block).end == number + 1) {
            let Some(open) = self.open.pop_front() else { break };
            let heavy = self.is_heavy(open.block, blocks) && !blocks.is_edge(open.block);
            self.heavy.extend(heavy.then_some(open.block));
            if heavy || blocks.is_chosen(open.block) {
                self.simulate(open, blocks, shape, shared, scope);
            }
        }
    }

    /// Begins the blocks whose warm-up begins with this tile.
    fn open_blocks(&mut self, number: usize) {
        let Some(blocks) = self.blocks else { return };
        let next = self.open.back().map_or_else(|| blocks.block_of(number), |open| open.block + 1);
        for block in next..blocks.len() {
            if blocks.warm_up(block) > number {
                break;
            }
            if blocks.warm_up(block) == number {
                let from = (number > 0).then(|| self.functional.checkpoint());
                self.open.push_back(OpenBlock { block, from, tiles: Vec::new() });
            }
        }
    }

    /// Whether a block that is complete has far more to do than those before it. To be asked of every block, in order.
    fn is_heavy(&mut self, block: usize, blocks: &Blocks) -> bool {
        let range = blocks.tiles(block);
        let mean = |sizes: &[f64]| sizes.iter().sum::<f64>() / sizes.len().max(1) as f64;
        let size = mean(&self.sizes[range.clone()]);
        let heavy = size > self.largest && size > HEAVY * mean(&self.sizes[..range.start]);
        self.largest = self.largest.max(size);
        heavy
    }

    fn simulate<'s>(
        &self,
        open: OpenBlock,
        blocks: &Blocks,
        shape: FrameShape,
        Shared { tree, stop, room }: Shared<'s>,
        scope: &Scope<'s>,
    ) where
        'a: 's,
    {
        let OpenBlock { block, from, tiles } = open;
        let warm_up = blocks.tiles(block).start - blocks.warm_up(block);
        let window = Window { tiles, warm_up, from, last: block + 1 == blocks.len() };
        let (config, windows) = (self.config, Arc::clone(&self.windows));
        room.take();
        scope.spawn(move |_| {
            let _place = Place(room);
            let measured = window.simulate(config, tree, shape, stop);
            windows.lock().unwrap_or_else(PoisonError::into_inner).insert(block, measured);
        });
    }

    /// What came of it, once all windows are done.
    ///
    /// # Errors
    /// The error of the first window that failed.
    pub fn finish(mut self) -> Result<Passed> {
        self.functional.finish();
        let windows = std::mem::take(&mut *self.windows.lock().unwrap_or_else(PoisonError::into_inner));
        let windows: Result<_> = windows.into_iter().map(|(block, measured)| Ok((block, measured?))).collect();
        Ok(Passed {
            counted: self.functional.stats(),
            features: self.functional.features().to_vec(),
            heavy: self.heavy,
            windows: windows?,
        })
    }
}
