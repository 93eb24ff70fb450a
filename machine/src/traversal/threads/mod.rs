//! Processors in the place of a T&I unit (`ti.pipeline = "software"`): threads that walk the tree by instructions, and run the
//! kernels of the SRP too.
//!
//! ```text
//!   rays  -> ray buffer -> warps of `lanes` rays  \
//!                                                  processors: places for warps, shared units, caches of code and data -> L2
//!   items -> queue      -> warps of `lanes` items /
//! ```
//!
//! A warp is started a cycle, on the processor with most free places, the first of equals: items first, for rays come from
//! them. Rays wait for others until they fill a warp, at most `warp_wait_cycles`. The machine's SRP keeps tiles, rounds, queues and
//! transfers, which are software here and cost what kernels and the blocks of the traversal say; it has no array.

mod events;
mod places;
mod processor;
mod program;
mod stats;
mod warp;

pub(crate) use program::CodeLayout;
pub use stats::{ProcessorCounters, ProcessorStats};

use std::collections::VecDeque;

use events::{Event, Events, What};
use processor::{Context, Processor};

use crate::component::{Component, Tick};
use crate::config::MachineConfig;
use crate::counters::StageBusy;
use crate::link::{Job, RayMessage, RayRef, RayUnit};
use crate::memory::{Memory, Port, Tags};
use crate::ti::{TiContext, TiStats, Tiles};
use crate::time::{TiCycle, When};
use crate::traversal::buffer::RayBuffer;
use crate::work::cost;

/// The processors of a core.
#[derive(Debug)]
pub struct ThreadUnit {
    lanes: usize,
    wait_cycles: u64,
    buffer: RayBuffer,
    jobs: VecDeque<(TiCycle, Job)>,
    processors: Vec<Processor>,
    first_port: u16,
    events: Events,
    finished_rays: VecDeque<RayRef>,
    finished_jobs: VecDeque<u32>,
}

impl ThreadUnit {
    /// The processors of a core. Their caches take the ports from `first_port` on: first those of data, then those of code;
    /// [`ThreadUnit::ports`] of them.
    pub fn new(config: &MachineConfig, first_port: Port) -> Self {
        let ti = &config.ti;
        let port = |i: u32| Port(first_port.0 + i as u16);
        Self {
            lanes: config.processor.lanes as usize,
            wait_cycles: config.processor.warp_wait_cycles.into(),
            buffer: RayBuffer::new(ti.ray_fifo_entries),
            jobs: VecDeque::new(),
            processors: (0..ti.trv).map(|i| Processor::new(config, i as u8, port(i), port(ti.trv + i))).collect(),
            first_port: first_port.0,
            events: Events::default(),
            finished_rays: VecDeque::new(),
            finished_jobs: VecDeque::new(),
        }
    }

    /// Caches, and so ports, of the processors of a core.
    pub fn ports(config: &MachineConfig) -> u16 {
        2 * config.ti.trv as u16
    }

    /// A line arrived at `port` in cycle `now`.
    pub fn fill(&mut self, now: TiCycle, port: Port, line: u64) {
        let (cache, count) = (usize::from(port.0 - self.first_port), self.processors.len());
        self.processors[cache % count].fill(now, line, cache >= count, &mut self.events);
    }

    /// Fills the empty caches.
    pub(crate) fn warm(&mut self, data: &[Tags]) {
        self.processors.iter_mut().zip(data).for_each(|(processor, tags)| processor.warm(tags));
    }

    /// What the data caches hold.
    pub(crate) fn tags(&self) -> Vec<Tags> {
        self.processors.iter().map(|processor| processor.tags().clone()).collect()
    }

    /// A line left an inclusive L2.
    pub fn invalidate(&mut self, line: u64) {
        self.processors.iter_mut().for_each(|processor| processor.invalidate(line));
    }

    /// Busy cycles of each processor so far, for a timeline.
    pub fn busy(&self, mut see: impl FnMut(StageBusy)) {
        for (index, processor) in self.processors.iter().enumerate() {
            see(StageBusy { unit: "processor", index, stage: "", cycles: processor.busy() });
        }
    }

    /// What is inside, for the message about a machine that stands still.
    pub fn describe(&self) -> String {
        let free: Vec<_> = self.processors.iter().map(Processor::free).collect();
        let (buffer, items) = (self.buffer.describe(), self.jobs.len());
        format!("{buffer}, warps of items that wait {items}, free places of processors {free:?}")
    }

    /// The work that is done, as [`cost`] counts it.
    pub(crate) fn done(&self) -> f64 {
        let sum = |sum: (u64, u64), processor: &Processor| {
            let (visits, tests) = processor.work_done();
            (sum.0 + visits, sum.1 + tests)
        };
        let (visits, tests) = self.processors.iter().fold((0, 0), sum);
        cost(visits, tests, self.buffer.rays())
    }

    /// What was counted before cycle `end`; processors stand in the list of traversal units.
    pub fn report(&self, end: TiCycle) -> TiStats {
        TiStats {
            dispatch: self.buffer.counters_before(end, self.free()),
            trv: self.processors.iter().map(|processor| processor.report(end)).collect(),
            ist: Vec::new(),
        }
    }

    /// Instructions and warps of each processor before cycle `end`.
    pub fn processor_report(&self, end: TiCycle) -> Vec<ProcessorStats> {
        self.processors.iter().map(|processor| processor.processor_report(end)).collect()
    }

    /// Free places of all processors.
    fn free(&self) -> usize {
        self.processors.iter().map(Processor::free).sum()
    }

    /// When the next warp can start; its place is free.
    fn next_warp(&self) -> When {
        let job = When::from(self.jobs.front().map(|(at, _)| *at));
        let full = self.buffer.taken_from(self.lanes - 1);
        let late = self.buffer.taken_from(0).cycle().map(|at| at + self.wait_cycles);
        job.min(full).min(When::from(late))
    }

    /// Starts a warp, if one is ready and has a place.
    fn dispatch<T: Tiles, M: Memory>(
        &mut self,
        now: TiCycle,
        TiContext { layout, tiles, memory, .. }: TiContext<'_, T, M>,
    ) {
        if !self.next_warp().is_due(now) {
            return;
        }
        let Self { processors, events, finished_rays: rays, finished_jobs: jobs, .. } = self;
        let mut best = 0;
        for i in 1..processors.len() {
            if processors[i].free() > processors[best].free() {
                best = i;
            }
        }
        if processors[best].free() == 0 {
            return;
        }
        let mut context = Context { now, layout, tiles, memory, events, rays, jobs };
        if self.jobs.front().is_some_and(|(at, _)| *at <= now)
            && let Some((_, job)) = self.jobs.pop_front()
        {
            return processors[best].start_job(job, &mut context);
        }
        processors[best].start_rays(self.buffer.take(now, self.lanes), &mut context);
    }
}

impl Component for ThreadUnit {
    type Report = TiStats;

    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        let warp = if self.free() > 0 { self.next_warp().after(now) } else { When::NEVER };
        self.events.next().min(warp)
    }

    fn finish(&mut self, end: TiCycle) -> TiStats {
        self.report(end)
    }
}

impl<T: Tiles, M: Memory> Tick<TiContext<'_, T, M>> for ThreadUnit {
    /// Runs cycle `now`, after the lines of this cycle were filled.
    fn tick(&mut self, now: TiCycle, TiContext { tree, layout, tiles, memory }: TiContext<'_, T, M>) {
        self.buffer.account(now, self.free());
        let Self { processors, events, finished_rays: rays, finished_jobs: jobs, .. } = self;
        while let Some(Event { processor, what }) = events.take(now) {
            let mut context = Context {
                now,
                layout,
                tiles,
                memory: &mut *memory,
                events: &mut *events,
                rays: &mut *rays,
                jobs: &mut *jobs,
            };
            let processor = &mut processors[usize::from(processor)];
            match what {
                What::Done(warp) => processor.done(warp, &mut context),
                What::Retry => processor.retry(&mut context),
            }
        }
        self.buffer.finish(now, &mut self.finished_rays);
        self.dispatch(now, TiContext { tree, layout, tiles, memory });
    }
}

impl RayUnit for ThreadUnit {
    #[inline]
    fn has_room(&self) -> bool {
        self.buffer.has_room()
    }

    fn push(&mut self, now: TiCycle, ray: RayRef) {
        self.buffer.account(now, self.free());
        self.buffer.push(now, ray);
    }

    #[inline]
    fn results(&mut self) -> &mut VecDeque<RayMessage> {
        self.buffer.results()
    }

    #[inline]
    fn rays_inside(&self) -> usize {
        self.buffer.inside()
    }

    fn job_room(&self) -> usize {
        self.free().saturating_sub(self.jobs.len())
    }

    fn push_job(&mut self, now: TiCycle, job: Job) {
        self.jobs.push_back((now + 1, job));
    }

    fn finished_job(&mut self) -> Option<u32> {
        self.finished_jobs.pop_front()
    }

    fn has_finished_jobs(&self) -> bool {
        !self.finished_jobs.is_empty()
    }
}
