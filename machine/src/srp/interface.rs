//! The way of rays and hits between SRP and T&I unit.
//!
//! * Direct link: a ray occupies its direction for `ceil(ray_message_bytes / interface_bytes_per_cycle)` T&I cycles, a hit
//!   likewise, never less than one: at most one message a cycle and direction. A message that starts at cycle t and takes n
//!   cycles is there `interface_latency_cycles` after t + n. While the unit has no room, the ray at the end of the link waits and no other starts. (The
//!   direct link: paper; width and latency: estimate.)
//! * Memory: rays and hits are streams of lines (see `stream`); a ray enters the unit, and a hit the SRP, one a cycle. The SRP
//!   does not begin new lines while `stream_unwritten_lines` wait for memory.
//! * A result never waits for the SRP: its item goes into local memory at once. So the unit always drains, rays that wait for
//!   room always enter in the end, and there is no deadlock.
//! * `srp.ideal`: the direct link takes no time; its bytes are counted.

use std::collections::VecDeque;

use super::context::{SrpContext, SrpPorts};
use super::stats::{DmaCounters, InterfaceCounters};
use super::stream::Stream;
use crate::component::{Component, Tick};
use crate::config::{Interface as Kind, MachineConfig};
use crate::link::{RayMessage, RayRef, RayUnit};
use crate::memory::Memory;
use crate::time::{TiCycle, When};
use crate::work::layout::Region;

/// One direction of the direct link.
#[derive(Clone, Debug, Default)]
struct Lane {
    message_cycles: u64,
    latency_cycles: u64,
    free_at: TiCycle,
    messages: VecDeque<RayMessage>,
}

impl Lane {
    #[inline]
    fn start(&mut self, at: TiCycle, ray: RayRef) {
        let start = at.max(self.free_at);
        self.free_at = start + self.message_cycles;
        self.messages.push_back(RayMessage { at: self.free_at + self.latency_cycles, ray });
    }

    /// When the first message is there.
    #[inline]
    fn next(&self) -> When {
        When::from(self.messages.front().map(|message| message.at))
    }

    #[inline]
    fn arrived(&self, now: TiCycle) -> bool {
        self.next().is_due(now)
    }
}

#[derive(Clone, Debug)]
enum Way {
    Ideal {
        hits: VecDeque<RayRef>,
    },
    Direct {
        rays: Lane,
        hits: Lane,
    },
    /// New lines are begun while fewer than `unwritten_max` wait to be written.
    Memory {
        rays: Box<Stream>,
        hits: Box<Stream>,
        unwritten_max: u64,
    },
}

/// Both directions between SRP and T&I unit.
#[derive(Clone, Debug)]
pub struct Interface {
    way: Way,
    ray_bytes: u64,
    hit_bytes: u64,
    entered_at: Option<TiCycle>,
    taken_at: Option<TiCycle>,
    blocked: bool,
    counters: InterfaceCounters,
}

impl Interface {
    /// The interface of core `core`.
    pub fn new(config: &MachineConfig, core: u32, ports: SrpPorts) -> Self {
        let gpu = &config.gpu;
        let (ray_bytes, hit_bytes) = (u64::from(gpu.ray_message_bytes), u64::from(gpu.hit_message_bytes));
        let width = u64::from(gpu.interface_bytes_per_cycle.max(1));
        let latency_cycles = gpu.interface_latency_cycles.into();
        let lane =
            |bytes: u64| Lane { message_cycles: bytes.div_ceil(width).max(1), latency_cycles, ..Lane::default() };
        let stream = |half: u64, bytes: u64| {
            let address = Region::Ray.base() + (u64::from(core) << 32) + (half << 31);
            Box::new(Stream::new(config, ports.dma, (Region::Ray, address), bytes))
        };
        let way = match gpu.interface {
            Kind::Memory => Way::Memory {
                rays: stream(0, ray_bytes),
                hits: stream(1, hit_bytes),
                unwritten_max: gpu.stream_unwritten_lines.into(),
            },
            Kind::Direct if config.srp.ideal => Way::Ideal { hits: VecDeque::new() },
            Kind::Direct => Way::Direct { rays: lane(ray_bytes), hits: lane(hit_bytes) },
        };
        let counters = InterfaceCounters::default();
        Self { way, ray_bytes, hit_bytes, entered_at: None, taken_at: None, blocked: false, counters }
    }

    /// The next hit that has reached the SRP.
    #[inline]
    pub fn take_hit(&mut self, now: TiCycle) -> Option<RayRef> {
        match &mut self.way {
            Way::Ideal { hits } => hits.pop_front(),
            Way::Direct { hits, .. } if hits.arrived(now) => hits.messages.pop_front().map(|message| message.ray),
            Way::Memory { hits, .. } if self.taken_at != Some(now) => {
                let hit = hits.pop();
                self.taken_at = hit.map(|_| now).or(self.taken_at);
                hit
            }
            _ => None,
        }
    }

    /// Puts a ray that has reached the unit into it, one a cycle.
    #[inline]
    pub fn enter<U: RayUnit>(&mut self, now: TiCycle, unit: &mut U) {
        let waiting = match &self.way {
            Way::Ideal { .. } => false,
            Way::Direct { rays, .. } => rays.arrived(now),
            Way::Memory { rays, .. } => rays.has_ready(),
        };
        self.blocked = false;
        if !waiting || self.entered_at == Some(now) {
            return;
        }
        if !unit.has_room() {
            self.blocked = true;
            return;
        }
        let ray = match &mut self.way {
            Way::Ideal { .. } => None,
            Way::Direct { rays, .. } => rays.messages.pop_front().map(|message| message.ray),
            Way::Memory { rays, .. } => rays.pop(),
        };
        if let Some(ray) = ray {
            unit.push(now, ray);
            self.entered_at = Some(now);
        }
    }

    /// Starts messages of the SRP's output queue. Returns whether the queue has drained.
    #[inline]
    pub fn send<U: RayUnit>(&mut self, now: TiCycle, output: &mut VecDeque<RayRef>, unit: &mut U) -> bool {
        let before = output.len();
        while !output.is_empty() && self.can_send(now, unit) {
            let Some(ray) = output.pop_front() else { break };
            self.counters.rays += 1;
            self.counters.ray_bytes += self.ray_bytes;
            match &mut self.way {
                Way::Ideal { .. } => unit.push(now, ray),
                Way::Direct { rays, .. } => {
                    rays.start(now, ray);
                    self.counters.ray_busy += rays.message_cycles;
                }
                Way::Memory { rays, .. } => rays.push(now, ray),
            }
        }
        before != output.len()
    }

    #[inline]
    fn can_send<U: RayUnit>(&mut self, now: TiCycle, unit: &U) -> bool {
        match &self.way {
            Way::Ideal { .. } => {
                self.blocked = !unit.has_room();
                !self.blocked
            }
            Way::Direct { rays, .. } => rays.free_at <= now && !rays.arrived(now),
            Way::Memory { rays, unwritten_max, .. } => rays.unwritten_lines() < *unwritten_max,
        }
    }

    /// A line of a stream arrived; `false` if it belongs to none.
    pub fn respond(&mut self, line: u64) -> bool {
        let Way::Memory { rays, hits, .. } = &mut self.way else { return false };
        let Some(stream) = [rays, hits].into_iter().find(|s| s.owns(line)) else { return false };
        stream.respond(line);
        true
    }

    /// Whether a ray waits for room in the unit.
    #[inline]
    pub fn blocked(&self) -> bool {
        self.blocked
    }

    /// Whether memory refused a request of a stream.
    pub fn refused(&self) -> bool {
        matches!(&self.way, Way::Memory { rays, hits, .. } if rays.refused() || hits.refused())
    }

    /// What went through so far.
    pub fn counters(&self) -> &InterfaceCounters {
        &self.counters
    }

    /// What its streams moved so far.
    pub fn traffic(&self) -> DmaCounters {
        let Way::Memory { rays, hits, .. } = &self.way else { return DmaCounters::default() };
        let mut sum = *rays.counters();
        sum += *hits.counters();
        sum
    }

    /// When a ray of the SRP's output queue can start.
    #[inline]
    pub fn next_send(&self, now: TiCycle) -> When {
        match &self.way {
            Way::Direct { rays, .. } if !rays.arrived(now) => When::at(rays.free_at).after(now),
            _ => When::NEVER,
        }
    }

    /// Takes the unit's results that are due.
    #[inline]
    fn take_results<U: RayUnit>(&mut self, now: TiCycle, unit: &mut U) {
        let results = unit.results();
        while results.front().is_some_and(|result| result.at <= now) {
            let Some(RayMessage { at, ray }) = results.pop_front() else { break };
            self.counters.hits += 1;
            self.counters.hit_bytes += self.hit_bytes;
            match &mut self.way {
                Way::Ideal { hits } => hits.push_back(ray),
                Way::Direct { hits, .. } => {
                    hits.start(at, ray);
                    self.counters.hit_busy += hits.message_cycles;
                }
                Way::Memory { hits, .. } => hits.push(now, ray),
            }
        }
    }
}

impl Component for Interface {
    type Report = InterfaceCounters;

    /// Rays that wait in the SRP's output queue have an event of their own: [`Interface::next_send`].
    #[inline]
    fn next_event(&self, now: TiCycle) -> When {
        match &self.way {
            Way::Ideal { .. } => When::NEVER,
            Way::Direct { rays, hits } => {
                let enter = if self.blocked { When::NEVER } else { rays.next() };
                hits.next().min(enter).after(now)
            }
            Way::Memory { rays, hits, .. } => {
                let ready = (rays.has_ready() && !self.blocked) || hits.has_ready();
                let moved = rays.next_event(now).min(hits.next_event(now));
                moved.min(When::only_if(ready, now + 1))
            }
        }
    }

    fn finish(&mut self, _: TiCycle) -> InterfaceCounters {
        self.counters
    }
}

impl<U: RayUnit, M: Memory> Tick<SrpContext<'_, U, M>> for Interface {
    /// Takes the unit's results and moves lines of streams.
    fn tick(&mut self, now: TiCycle, SrpContext { unit, memory }: SrpContext<'_, U, M>) {
        self.take_results(now, unit);
        if let Way::Memory { rays, hits, .. } = &mut self.way {
            rays.tick(now, &mut *memory);
            hits.tick(now, memory);
        }
    }
}
