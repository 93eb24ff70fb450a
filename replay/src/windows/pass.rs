//! One pass over the tiles of a frame: each goes through the functional machines, and the windows are simulated beside it.

use std::collections::BTreeMap;
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::time::Duration;

use rayon::Scope;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::functional::{CacheState, Checkpoint, Features, FunctionalMachine};
use rayreel_machine::srp::FrameShape;
use rayreel_machine::stats::Stats;
use rayreel_machine::work::TileWork;
use rayreel_machine::work::topology::Topology;

use super::places::{Place, Places};
use super::window::{Measured, Window};
use crate::error::{ReplayError, Result};
use crate::stop::Stop;

/// What came of a pass for one machine.
pub struct Passed {
    /// What the functional machine counted.
    pub counted: Stats,
    /// What was characteristic of the frame.
    pub features: Features,
    /// Sizes of the tiles, by tile number: operations, about.
    pub sizes: Vec<f64>,
    /// What windows measured, in the order in which they began.
    pub windows: Vec<Measured>,
    /// What the caches hold at the end, if the next frame begins with it.
    pub caches: Option<CacheState>,
}

/// A machine in a pass.
pub struct MachinePass<'a> {
    config: &'a MachineConfig,
    shape: FrameShape,
    functional: FunctionalMachine<'a>,
    /// Its caches were not empty at the beginning.
    is_warm: bool,
    places: &'a [Place],
    slots: usize,
    /// Tiles that were given.
    given: usize,
    /// Places that have begun.
    next: usize,
    /// Windows that have begun, but wait for tiles.
    open: Vec<OpenWindow>,
    windows: Arc<Mutex<BTreeMap<usize, Result<Measured>>>>,
}

/// A window whose tiles are coming.
struct OpenWindow {
    number: usize,
    place: Place,
    from: Option<Checkpoint>,
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
    pub slots: &'a WindowSlots,
}

/// Limits the windows that wait or run, and so the memory of their tiles.
pub struct WindowSlots {
    free: Mutex<usize>,
    freed: Condvar,
}

impl WindowSlots {
    /// Slots for so many windows.
    pub fn new(windows: usize) -> Self {
        Self { free: Mutex::new(windows), freed: Condvar::new() }
    }

    /// Waits for a place and takes it. A thread of the pool works on meanwhile: the window that it waits for may be its own to simulate.
    fn take(&self) {
        loop {
            let mut free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            if *free > 0 {
                *free -= 1;
                return;
            }
            drop(free);
            let longest = match rayon::yield_now() {
                None => Duration::from_secs(1),
                Some(rayon::Yield::Executed) => Duration::ZERO,
                Some(rayon::Yield::Idle) => Duration::from_millis(1),
            };
            let free = self.free.lock().unwrap_or_else(PoisonError::into_inner);
            let waited = self.freed.wait_timeout_while(free, longest, |free| *free == 0);
            drop(waited.unwrap_or_else(PoisonError::into_inner));
        }
    }

    fn give(&self) {
        *self.free.lock().unwrap_or_else(PoisonError::into_inner) += 1;
        self.freed.notify_one();
    }
}

/// Gives its place back, even where a window ends in a panic.
struct Occupied<'a>(&'a WindowSlots);

impl Drop for Occupied<'_> {
    fn drop(&mut self) {
        self.0.give();
    }
}

impl<'a> MachinePass<'a> {
    /// A machine before the first tile, with what its caches hold if they are not empty. Without `places` nothing is simulated.
    pub fn new(
        (config, caches): (&'a MachineConfig, Option<CacheState>),
        tree: &'a Topology,
        shape: FrameShape,
        places: Option<&'a Places>,
    ) -> Self {
        let (cold, is_warm) = (FunctionalMachine::new(config, tree, shape), caches.is_some());
        let functional = match caches {
            Some(caches) => cold.with_caches(caches),
            None => cold,
        };
        Self {
            config,
            shape,
            functional,
            is_warm,
            places: places.map_or(&[], Places::list),
            slots: places.map_or(0, Places::slots),
            given: 0,
            next: 0,
            open: Vec::new(),
            windows: Arc::default(),
        }
    }

    /// Takes the next tile.
    pub fn take<'s>(&mut self, tile: &Arc<TileWork>, shared: Shared<'s>, scope: &Scope<'s>)
    where
        'a: 's,
    {
        self.look();
        while !self.functional.has_room() {
            self.functional.take_turn();
            self.look();
        }
        for open in &mut self.open {
            open.tiles.push(Arc::clone(tile));
            open.spare += usize::from(open.measured_to.is_some());
        }
        self.functional.feed(Arc::clone(tile));
        self.given += 1;
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
        while self.functional.take_turn() {
            self.look();
        }
        for mut window in std::mem::take(&mut self.open) {
            let is_last = window.place.to.is_infinite();
            if is_last {
                window.measured_to = Some(*self.functional.done());
            }
            self.simulate(window, is_last, shared, scope);
        }
    }

    /// Looks which windows begin or end here.
    fn look(&mut self) {
        let (progress, done) = (self.functional.progress(), *self.functional.done());
        while let Some(&place) = self.places.get(self.next).filter(|place| progress >= place.begin) {
            self.open.push(OpenWindow {
                number: self.next,
                place,
                from: (self.given > 0 || self.is_warm).then(|| self.functional.checkpoint()),
                begin: done.size(),
                measured_from: None,
                measured_to: None,
                tiles: Vec::new(),
                spare: 0,
            });
            self.next += 1;
        }
        for open in &mut self.open {
            if open.measured_from.is_none() && progress >= open.place.from {
                open.measured_from = Some(done);
            }
            if open.measured_from.is_some() && open.measured_to.is_none() && progress >= open.place.to {
                open.measured_to = Some(done);
            }
        }
    }

    fn simulate<'s>(
        &self,
        window: OpenWindow,
        is_last: bool,
        Shared { tree, stop, slots }: Shared<'s>,
        scope: &Scope<'s>,
    ) where
        'a: 's,
    {
        let OpenWindow { number, place, from, begin, measured_from, measured_to, tiles, .. } = window;
        let (Some(measured_from), Some(measured_to)) = (measured_from, measured_to) else {
            // A sample less is no harm; but what stands for itself is part of the frame.
            if place.is_certain {
                let missed = ReplayError::Usage { detail: format!("window {number} of a frame was not reached") };
                self.windows.lock().unwrap_or_else(PoisonError::into_inner).insert(number, Err(missed));
            }
            return;
        };
        let mut features = measured_to;
        features.add_part(&measured_from, -1.0);
        let warm_up = measured_from.size() - begin;
        let window = Window { from, tiles, warm_up, features, is_last, is_certain: place.is_certain };
        let (config, shape, windows) = (self.config, self.shape, Arc::clone(&self.windows));
        slots.take();
        scope.spawn(move |_| {
            let _occupied = Occupied(slots);
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
            features: *self.functional.done(),
            sizes: self.functional.sizes().to_vec(),
            windows: windows.into_values().collect::<Result<_>>()?,
            caches: self.config.gpu.warm_caches.then(|| self.functional.caches().clone()),
        })
    }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;

    /// The only thread of a pool waits for windows that nobody else could simulate.
    #[test]
    fn who_waits_for_room_works_meanwhile() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
        let (slots, done) = (WindowSlots::new(1), AtomicUsize::new(0));
        pool.install(|| {
            rayon::in_place_scope(|scope| {
                for _ in 0..3 {
                    slots.take();
                    scope.spawn(|_| {
                        let _occupied = Occupied(&slots);
                        done.fetch_add(1, Ordering::Relaxed);
                    });
                }
            });
        });
        assert_eq!(done.into_inner(), 3);
    }
}
