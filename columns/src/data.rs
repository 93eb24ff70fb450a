//! A table of a trace as batches of columns.

use std::cell::Cell;
use std::sync::Arc;

use rayreel_formats::trace::Trace;
use rayreel_machine::NamedMachine;
use rayreel_machine::config::MachineConfig;
use rayreel_machine::memory::Recording;
use rayreel_machine::ports::tells_lookups;
use rayreel_machine::system::NoProbe;
use rayreel_machine::work::topology::Topology;
use rayreel_replay::simulate::simulate_in_front_of;
use rayreel_replay::{FrameReplay, NamedPolicy, Options, Replayer, Stop};

use crate::error::{ColumnsError, Result};
use crate::order::{Gathered, ROWS, ordered};
use crate::rows::{
    AddressRows, Addresses, HIT_COLOURS, HitRows, Hits, Made, NodeRows, RayRows, SAMPLE_COLOURS, SAMPLE_WORK,
    SampleRows, Samples, StepRows, TileRows, ancestors, nodes, triangle_words, triangles,
};
use crate::schema::{Batch, Head};
use crate::select::Selection;
use crate::simulated::{Intervals, Issue, TableProbe, TileTimes};
use crate::what::{Choice, What};

/// Length of the intervals of counters if none is asked for, T&I cycles.
pub const INTERVAL: u64 = 1000;

/// Nothing is replayed for its picture.
const NO_PICTURES: Options = Options { reference: false, perception: false, traced: false };

/// What to get out of a trace.
#[derive(Clone, Debug)]
pub struct Data<'a> {
    /// The trace.
    pub trace: &'a Trace,
    /// Which table.
    pub what: What,
    /// Of which frames and tiles; a choice is refused where the table has none.
    pub selection: Selection,
    /// The columns that are looked at, in this order, or all. Batches have all columns of the table, but what takes long to decode is 0
    /// where nobody looks at it.
    pub columns: Option<Vec<String>>,
    /// The policy: of samples only if there is one; simulated tables take `full` if there is none.
    pub policy: Option<&'a NamedPolicy>,
    /// The machine of tables that depend on one.
    pub machine: Option<&'a NamedMachine>,
    /// Length of the intervals of counters, T&I cycles: [`INTERVAL`] if there is none. Refused for other tables.
    pub interval: Option<u64>,
    /// Ends early what takes long.
    pub stop: Stop,
}

/// What becomes of batches: `make` is called in any thread, `take` in order with what it gave and how many tiles are done.
pub struct Use<'a, T> {
    /// Makes something of a batch.
    pub make: &'a (dyn Fn(Batch) -> Result<T> + Sync),
    /// Takes it.
    pub take: &'a mut (dyn FnMut(T, u64) -> Result<()> + Send),
}

impl<'a> Data<'a> {
    /// A table of all of a trace, without policy and machine.
    pub fn new(trace: &'a Trace, what: What) -> Self {
        let selection = Selection::all(trace.meta());
        Self { trace, what, selection, columns: None, policy: None, machine: None, interval: None, stop: Stop::never() }
    }

    /// The columns that are looked at, before the first row.
    ///
    /// # Errors
    /// As [`Data::check`] and [`Head::only`].
    pub fn head(&self) -> Result<Head> {
        self.check()?;
        let head = Head::new(self.what.table(), &self.empty()?);
        match &self.columns {
            Some(columns) => head.only(columns),
            None => Ok(head),
        }
    }

    /// Whether one of these columns is looked at.
    fn looks_at(&self, columns: &[&str]) -> bool {
        let looked_at = self.columns.as_ref();
        looked_at.is_none_or(|names| names.iter().any(|name| columns.contains(&name.as_str())))
    }

    /// A batch without rows.
    fn empty(&self) -> Result<Batch> {
        let bvh = self.trace.bvh();
        Ok(match self.what {
            What::Rays => RayRows::default().batch(),
            What::Hits => HitRows::default().batch(),
            What::Steps => StepRows::default().batch(),
            What::Addresses => AddressRows::default().batch(),
            What::Samples => SampleRows::default().batch(),
            What::Nodes => NodeRows::default().batch(),
            What::Triangles => triangles(bvh, triangle_words(bvh), 0..0).batch(),
            What::Lookups => Issue::new(self.config()?).lookups().batch(),
            What::Requests => Issue::new(self.config()?).requests().batch(),
            What::Counters => self.intervals()?.batch(),
            What::Tiles => TileTimes::default().batch(),
        })
    }

    /// Whether all that is asked for means something for the table, and goes together.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] that says what does not.
    pub fn check(&self) -> Result<()> {
        let (what, name) = (self.what, self.what.name());
        let refuse = |detail: String| Err(ColumnsError::Request(detail));
        if self.policy.is_some() && !what.takes_policy() {
            return refuse(format!(
                "table {name} is of what was recorded, whatever a policy makes of it; leave the policy out, or take {}",
                names(What::takes_policy)
            ));
        }
        if self.machine.is_some() && !what.takes_machine() {
            return refuse(format!(
                "table {name} is the same for every machine; leave the machine out, or take {}",
                names(What::takes_machine)
            ));
        }
        if self.machine.is_some_and(|machine| machine.config.gpu.warm_caches) && what.is_simulated() {
            return refuse(format!(
                "table {name} is of frames that begin with empty caches, and gpu.warm_caches is true; set it to false"
            ));
        }
        if what.takes_machine() && self.machine.is_none() {
            return refuse(format!("table {name} depends on a machine; name one"));
        }
        if what == What::Lookups && !tells_lookups(self.config()?) {
            let machine = self.machine.map_or("", |machine| &machine.name);
            return refuse(format!(
                "machine {machine} looks things up for several rays at once, so table lookups does not fit it; take requests, or \
                 a machine whose ti.pipeline is parallel, single or unified"
            ));
        }
        let meta = self.trace.meta();
        let choices = [
            (self.selection.chooses_frames(meta), Choice::Frames, "frames"),
            (self.selection.chooses_tiles(meta), Choice::Tiles, "tiles"),
            (self.interval.is_some(), Choice::Interval, "interval"),
        ];
        choices.iter().filter(|(made, ..)| *made).try_for_each(|(_, choice, option)| what.check(*choice, option))?;
        if self.interval == Some(0) {
            return refuse("an interval of 0 cycles never ends; take 1 or more".into());
        }
        Ok(())
    }

    fn config(&self) -> Result<&'a MachineConfig> {
        let none = || ColumnsError::Request(format!("table {} depends on a machine; name one", self.what.name()));
        self.machine.map(|machine| &machine.config).ok_or_else(none)
    }

    fn intervals(&self) -> Result<Intervals> {
        Ok(Intervals::new(self.config()?, self.interval.unwrap_or(INTERVAL)))
    }

    /// How many tiles [`Data::run`] goes through.
    pub fn tiles(&self) -> u64 {
        let frames = self.selection.frames.len() as u64;
        let tiles =
            if self.what.is_simulated() { self.trace.meta().tile_count() as usize } else { self.selection.tiles.len() };
        if self.what.takes_frames() { frames * tiles as u64 } else { 1 }
    }

    /// All batches, in order; the same for any number of threads. Each has [`ROWS`] rows at most, and one at least: only a table without
    /// rows is one batch without rows.
    ///
    /// # Errors
    /// As [`Data::head`]; a trace that lacks a tile or is damaged; what the use of a batch returns.
    pub fn run<T: Send>(&self, Use { make, take }: Use<'_, T>) -> Result<()> {
        self.head()?;
        let mut any = false;
        let mut note = |made, tiles| {
            any = true;
            take(made, tiles)
        };
        self.rows(Use { make, take: &mut note })?;
        if any { Ok(()) } else { take(make(self.empty()?)?, self.tiles()) }
    }

    /// As [`Data::run`], without a batch for a table without rows.
    fn rows<T: Send>(&self, to: Use<'_, T>) -> Result<()> {
        let (trace, bvh) = (self.trace, self.trace.bvh());
        match self.what {
            What::Rays => self.tile_rows::<RayRows, T>(to, |_| Ok(())),
            What::Hits => {
                let colours = self.looks_at(&HIT_COLOURS);
                self.tile_rows::<HitRows, T>(to, |_| Ok(Hits { colours }))
            }
            What::Steps => {
                let tree = Arc::new(Topology::new(bvh));
                self.tile_rows::<StepRows, T>(to, |_| Ok(Arc::clone(&tree)))
            }
            What::Addresses => {
                let with = Arc::new(Addresses::new(trace, self.config()?));
                self.tile_rows::<AddressRows, T>(to, |_| Ok(Arc::clone(&with)))
            }
            What::Samples => self.samples(to),
            What::Nodes => {
                let above = ancestors(bvh);
                chunks(to, bvh.nodes.len(), |range| nodes(bvh, &above, range).batch())
            }
            What::Triangles => {
                let words = triangle_words(bvh);
                chunks(to, bvh.triangles.len(), |range| triangles(bvh, words.clone(), range).batch())
            }
            What::Lookups | What::Requests => self.issue(to),
            What::Counters => self.probed(self.intervals()?, to),
            What::Tiles => self.probed(TileTimes::default(), to),
        }
    }

    /// All rows at once, for those who have the memory.
    ///
    /// # Errors
    /// As [`Data::run`].
    pub fn collect(&self) -> Result<Batch> {
        let mut all = self.empty()?;
        let mut take = |batch: Batch, _| {
            all.columns.iter_mut().zip(batch.columns).for_each(|(to, from)| to.extend(from));
            Ok(())
        };
        self.run(Use { make: &Ok, take: &mut take })?;
        Ok(all)
    }

    /// A table that tiles add to; `prepare` gives what it needs of each frame.
    fn tile_rows<R: TileRows, T: Send>(
        &self,
        Use { make, take }: Use<'_, T>,
        mut prepare: impl FnMut(u32) -> Result<R::With>,
    ) -> Result<()> {
        let edge = self.trace.meta().tile as usize;
        let tiles = (ROWS / (edge * edge * R::ROWS_A_SAMPLE as usize)).max(1);
        let groups: Vec<&[u32]> = self.selection.tiles.chunks(tiles).collect();
        let mut done = 0;
        for frame in self.selection.frames.clone() {
            let with = prepare(frame)?;
            let one = |group: usize| {
                self.stop.check()?;
                let mut rows = R::default();
                groups[group].iter().try_for_each(|&tile| rows.add(self.trace, &with, (frame, tile)))?;
                // How many rows the tiles have was a guess.
                let made: Result<Vec<T>> = rows.into_batch().parts(ROWS).into_iter().map(make).collect();
                Ok((made?, groups[group].len() as u64))
            };
            ordered(groups.len(), one, &mut |(made, tiles)| {
                done += tiles;
                made.into_iter().try_for_each(|made| take(made, done))
            })?;
        }
        Ok(())
    }

    fn samples<T: Send>(&self, to: Use<'_, T>) -> Result<()> {
        let colours = self.looks_at(&SAMPLE_COLOURS);
        let work = self.looks_at(&SAMPLE_WORK).then(|| Arc::new(Topology::new(self.trace.bvh())));
        let mut replayer = match self.policy {
            Some(policy) => {
                let options = Options { traced: true, ..NO_PICTURES };
                Some(Replayer::new(self.trace, &policy.policy, options)?.with_stop(self.stop.clone()))
            }
            None => None,
        };
        self.tile_rows::<SampleRows, T>(to, |frame| {
            let replayed = replayer.as_mut().map(|replayer| replayer.frame(frame)).transpose()?;
            let made = replayed.and_then(|FrameReplay { states, blocks, traced, .. }| {
                Some(Arc::new(Made { states, blocks, traced: traced? }))
            });
            Ok(Samples { colours, work: work.clone(), made })
        })
    }

    /// What the simulated tables have in common: the frames one after the other under the policy.
    fn each_frame(
        &self,
        mut simulate: impl FnMut(&mut Replayer<'_, Trace>, u32, &Topology) -> Result<()>,
    ) -> Result<()> {
        let tree = Topology::new(self.trace.bvh());
        let full;
        let policy = match self.policy {
            Some(policy) => policy,
            None => {
                full = NamedPolicy::load("full", &[])?;
                &full
            }
        };
        let mut replayer = Replayer::new(self.trace, &policy.policy, NO_PICTURES)?.with_stop(self.stop.clone());
        self.selection.frames.clone().try_for_each(|frame| simulate(&mut replayer, frame, &tree))
    }

    fn named(&self) -> Result<(&'a str, &'a MachineConfig)> {
        Ok((self.machine.map_or("", |machine| &machine.name), self.config()?))
    }

    /// The tables of what is issued.
    fn issue<T: Send>(&self, Use { make, take }: Use<'_, T>) -> Result<()> {
        let (machine, issue) = (self.named()?, Issue::new(self.config()?));
        let lookups = self.what == What::Lookups;
        let record = |memory| if lookups { Recording::of_lookups(memory) } else { Recording::of_requests(memory) };
        let fed = Cell::new(0);
        let mut take = |made| take(made, fed.get());
        let mut gathered = Gathered::new(make, &mut take);
        let (mut looked, mut asked) = (issue.lookups(), issue.requests());
        self.each_frame(|replayer, frame, tree| {
            simulate_in_front_of(replayer, (frame, tree), machine, (record, &mut NoProbe), |memory, _| {
                for lookup in memory.take_lookups() {
                    issue.add_lookup(&mut looked, frame, lookup);
                }
                for request in memory.take_requests() {
                    issue.add_request(&mut asked, frame, request);
                }
                if looked.frame.len() >= ROWS {
                    gathered.add(std::mem::replace(&mut looked, issue.lookups()).batch())?;
                }
                if asked.frame.len() >= ROWS {
                    gathered.add(std::mem::replace(&mut asked, issue.requests()).batch())?;
                }
                fed.set(fed.get() + 1);
                Ok::<_, ColumnsError>(())
            })?;
            Ok(())
        })?;
        gathered.add(if lookups { looked.batch() } else { asked.batch() })?;
        gathered.flush()
    }

    /// A table that a probe makes while a machine works.
    fn probed<T: Send>(&self, mut probe: impl TableProbe, Use { make, take }: Use<'_, T>) -> Result<()> {
        let (machine, fed) = (self.named()?, Cell::new(0));
        let mut take = |made| take(made, fed.get());
        let mut gathered = Gathered::new(make, &mut take);
        self.each_frame(|replayer, frame, tree| {
            simulate_in_front_of(replayer, (frame, tree), machine, (|memory| memory, &mut probe), |_, probe| {
                if probe.rows() >= ROWS {
                    gathered.add(probe.batch())?;
                }
                fed.set(fed.get() + 1);
                Ok::<_, ColumnsError>(())
            })?;
            Ok(())
        })?;
        gathered.add(probe.batch())?;
        gathered.flush()
    }
}

/// The names of the tables of which `fits` is true.
fn names(fits: fn(What) -> bool) -> String {
    let names: Vec<_> = What::ALL.into_iter().filter(|what| fits(*what)).map(What::name).collect();
    names.join(", ")
}

/// A table of `count` rows that are known by number.
fn chunks<T: Send>(
    Use { make, take }: Use<'_, T>,
    count: usize,
    rows: impl Fn(std::ops::Range<usize>) -> Batch + Sync,
) -> Result<()> {
    let one = |chunk: usize| make(rows(chunk * ROWS..count.min((chunk + 1) * ROWS)));
    ordered(count.div_ceil(ROWS), one, &mut |made| take(made, 1))
}
