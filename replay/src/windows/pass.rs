//! One pass over the tiles of a frame: each goes through the functional machines, and the windows are simulated beside it.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError};

use rayon::Scope;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::{Checkpoint, Features, FunctionalMachine};
use rayreel_machine::srp::FrameShape;
use rayreel_machine::stats::Stats;
use rayreel_machine::work::TileWork;
use rayreel_machine::work::topology::Topology;

use super::places::{Place, Places, Until};
use super::window::{Measured, Window};
use crate::error::Result;
use crate::stop::Stop;

/// A tile of so many times the operations of those before it on average, and of more than any of them, is simulated whether it
/// lies in a window or not: no other one can stand for it. Below a sky all of the ground takes more than the average, but only
/// the first of its tiles is new.
const HEAVY: f64 = 4.0;
/// The warm-up of a window that begins with such a tile, in tiles.
const HEAVY_WARM_UP: f64 = 0.25;
/// Work of an operation, before any tile is done.
const COST_OF_OPERATION: f64 = 0.9;

/// What came of a pass for one machine.
pub struct Passed {
    /// What the functional machine counted.
    pub counted: Stats,
    /// What was characteristic of each tile, by tile number.
    pub features: Vec<Features>,
    /// What windows measured, in the order in which they began.
    pub windows: Vec<Measured>,
}

/// A machine in a pass.
pub struct MachinePass<'a> {
    config: &'a MachineConfig,
    shape: FrameShape,
    functional: FunctionalMachine<'a>,
    places: &'a [Place],
    slots: usize,
    /// Operations of the tiles so far, their sum, and those of the largest.
    sizes: Vec<f64>,
    sum: f64,
    largest: f64,
    /// Places that have begun or were left out.
    next: usize,
    /// The work that was done when the next place would have begun without its delay.
    due: Option<f64>,
    /// Windows that have begun, but wait for tiles.
    open: Vec<OpenWindow>,
    begun: usize,
    windows: Arc<Mutex<BTreeMap<usize, Result<Measured>>>>,
}

/// A window whose tiles are coming.
struct OpenWindow {
    number: usize,
    place: Place,
    from: Option<Checkpoint>,
    /// Work of a tile around here.
    tile_cost: f64,
    /// Work done when it began.
    begin: f64,
    /// What was done at the end of its warm-up, and at its own.
    measured_from: Option<Features>,
    measured_to: Option<Features>,
    tiles: Vec<Arc<TileWork>>,
    /// Tiles that came after its end.
    spare: usize,
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
struct Occupied<'a>(&'a Room);

impl Drop for Occupied<'_> {
    fn drop(&mut self) {
        self.0.give();
    }
}

/// Where a pass is.
#[derive(Clone, Copy)]
struct Now {
    done: Features,
    /// Tiles that were given, and whether there is room for the next.
    tiles: usize,
    has_room: bool,
}

impl Now {
    /// Whether there is room for a tile after so many, or was.
    fn is_past(&self, tile: usize) -> bool {
        self.tiles > tile || self.tiles == tile && self.has_room
    }

    /// Whether something that began when the work `since` was done goes no further.
    fn ends(&self, until: Until, since: f64, tile_cost: f64) -> bool {
        match until {
            Until::Work(tiles) => (tiles == 0.0 || tile_cost > 0.0) && self.done.cost() >= since + tiles * tile_cost,
            Until::Tile(tile) => self.is_past(tile),
            Until::End => false,
        }
    }
}

impl<'a> MachinePass<'a> {
    /// A machine before the first tile. Without `places` nothing is simulated.
    pub fn new(config: &'a MachineConfig, tree: &'a Topology, shape: FrameShape, places: Option<&'a Places>) -> Self {
        Self {
            config,
            shape,
            functional: FunctionalMachine::new(config, tree, shape),
            places: places.map_or(&[], Places::list),
            slots: places.map_or(0, Places::slots),
            sizes: Vec::new(),
            sum: 0.0,
            largest: 0.0,
            next: 0,
            due: None,
            open: Vec::new(),
            begun: 0,
            windows: Arc::default(),
        }
    }

    /// Takes the next tile.
    pub fn take<'s>(&mut self, tile: &Arc<TileWork>, shared: Shared<'s>, scope: &Scope<'s>)
    where
        'a: 's,
    {
        self.make_room();
        let size = tile.operations() as f64;
        self.look(true);
        self.look_at_heavy(size);
        for open in &mut self.open {
            open.tiles.push(Arc::clone(tile));
            open.spare += usize::from(open.measured_to.is_some());
        }
        self.functional.feed(Arc::clone(tile));
        self.sizes.push(size);
        self.sum += size;
        self.largest = self.largest.max(size);
        // The simulation may have begun other tiles meanwhile, but never more than it has slots.
        while let Some(at) = self.open.iter().position(|open| open.spare >= self.slots) {
            let window = self.open.remove(at);
            self.simulate(window, false, shared, scope);
        }
    }

    /// All tiles were given.
    pub fn close<'s>(&mut self, shared: Shared<'s>, scope: &Scope<'s>)
    where
        'a: 's,
    {
        self.make_room();
        self.look(true);
        while self.functional.take_turn() {
            self.look(false);
        }
        for mut window in std::mem::take(&mut self.open) {
            let is_last = window.place.end == Until::End;
            if is_last {
                window.measured_to = Some(*self.functional.done());
            }
            self.simulate(window, is_last, shared, scope);
        }
    }

    fn make_room(&mut self) {
        while !self.functional.has_room() {
            self.functional.take_turn();
            self.look(false);
        }
    }

    /// Looks which windows begin or end here.
    fn look(&mut self, has_room: bool) {
        if self.places.is_empty() {
            return;
        }
        let now = Now { done: *self.functional.done(), tiles: self.sizes.len(), has_room };
        while let Some(&place) = self.places.get(self.next).filter(|place| now.is_past(place.begin)) {
            let due = *self.due.get_or_insert(now.done.cost());
            if now.done.cost() < due + place.delay * self.tile_cost() {
                break;
            }
            (self.next, self.due) = (self.next + 1, None);
            // What a certain window measures, no other one measures again.
            let measured = self.open.iter().any(|open| open.place.is_certain && open.measured_to.is_none());
            if place.is_certain || !measured {
                self.begin(place);
            }
        }
        // At the beginning it turns out with the first tiles how much a tile has.
        let tile_cost = if now.tiles >= self.slots { self.tile_cost() } else { 0.0 };
        for open in &mut self.open {
            if open.tile_cost == 0.0 {
                open.tile_cost = tile_cost;
            }
            if open.measured_from.is_none() && now.ends(open.place.warm_up, open.begin, open.tile_cost) {
                open.measured_from = Some(now.done);
            }
            if let (Some(from), None) = (open.measured_from, open.measured_to)
                && now.ends(open.place.end, from.cost(), open.tile_cost)
            {
                open.measured_to = Some(now.done);
            }
        }
    }

    /// Begins a window if the next tile is far larger than those before it.
    fn look_at_heavy(&mut self, size: f64) {
        let tiles = self.sizes.len();
        if self.places.iter().all(|place| place.is_certain) || tiles < self.slots {
            return;
        }
        let certain = self.open.iter().any(|open| open.place.is_certain);
        if !certain && size > self.largest && size > HEAVY * self.sum / tiles as f64 {
            let length = size * self.cost_of_operation() / self.tile_cost().max(1.0);
            self.begin(Place {
                begin: tiles,
                delay: 0.0,
                warm_up: Until::Work(HEAVY_WARM_UP),
                end: Until::Work(length),
                is_certain: true,
            });
        }
    }

    fn begin(&mut self, place: Place) {
        self.open.push(OpenWindow {
            number: self.begun,
            place,
            from: (!self.sizes.is_empty()).then(|| self.functional.checkpoint()),
            tile_cost: self.tile_cost(),
            begin: self.functional.done().cost(),
            measured_from: None,
            measured_to: None,
            tiles: Vec::new(),
            spare: 0,
        });
        self.begun += 1;
    }

    /// Work of a tile: the mean of those that came last.
    fn tile_cost(&self) -> f64 {
        let last = &self.sizes[self.sizes.len().saturating_sub(self.slots)..];
        last.iter().sum::<f64>() / last.len().max(1) as f64 * self.cost_of_operation()
    }

    /// Work of an operation: the mean of those that are done, about.
    fn cost_of_operation(&self) -> f64 {
        let waiting: f64 = self.sizes[self.sizes.len().saturating_sub(self.slots)..].iter().sum();
        // Of the tiles in the slots about half is done.
        let done = self.sum - waiting / 2.0;
        if self.sizes.len() <= 2 * self.slots || done <= 0.0 {
            return COST_OF_OPERATION;
        }
        self.functional.done().cost() / done
    }

    fn simulate<'s>(
        &self,
        window: OpenWindow,
        is_last: bool,
        Shared { tree, stop, room }: Shared<'s>,
        scope: &Scope<'s>,
    ) where
        'a: 's,
    {
        let OpenWindow { number, place, from, begin, measured_from, measured_to, tiles, .. } = window;
        let (Some(measured_from), Some(measured_to)) = (measured_from, measured_to) else { return };
        let mut features = measured_to;
        features.add_part(&measured_from, -1.0);
        let warm_up = measured_from.cost() - begin;
        let window = Window { from, tiles, warm_up, features, is_last, is_certain: place.is_certain };
        let (config, shape, windows) = (self.config, self.shape, Arc::clone(&self.windows));
        room.take();
        scope.spawn(move |_| {
            let _occupied = Occupied(room);
            let measured = window.simulate(config, tree, shape, stop);
            windows.lock().unwrap_or_else(PoisonError::into_inner).insert(number, measured);
        });
    }

    /// What came of it, once all windows are done.
    ///
    /// # Errors
    /// The error of the first window that failed.
    pub fn finish(self) -> Result<Passed> {
        let windows = std::mem::take(&mut *self.windows.lock().unwrap_or_else(PoisonError::into_inner));
        Ok(Passed {
            counted: self.functional.stats(),
            features: self.functional.features().to_vec(),
            windows: windows.into_values().collect::<Result<_>>()?,
        })
    }
}
