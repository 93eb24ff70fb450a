//! Unit activity over time, as a Chrome trace: open it in ui.perfetto.dev or chrome://tracing.
//!
//! The counters of every unit are looked at from time to time; what is written is how busy each was in between. When there are
//! too many looks, every second one is forgotten and the distance doubles, so memory and file stay small however long the run,
//! and no busy cycle is lost. The SRP books items when they are done, T&I stages when an issue is certain, and the DRAM a burst when its
//! command is sent. So more may be booked between two looks than fits: what does not is shown as done before that, by an SRP, or after
//! it, by all others; at the end of a frame, where the DRAM sends what is left to write, before it too.
//!
//! Frames follow one another in time. Of each core there is a counter for every issue stage, in percent of its cycles, and the
//! number of rays in its T&I unit; the DRAM's is in percent of its peak bandwidth. Slices show which tile each slot of a core held
//! (right to the first distance), and for each unit what it mostly did between two looks: the kernel of an SRP, or why it stood still.

mod share;
mod states;
#[cfg(test)]
mod tests;
mod tiles;

use std::fmt::Write as _;

use crate::config::MachineConfig;
use crate::counters::StageBusy;
use crate::link::RayUnit;
use crate::system::{Core, Probe};
use crate::time::{TiCycle, When};
use share::{Share, spread};
use states::{of_core, runs};
use tiles::Stays;

/// Looks kept at most; half of them remain after thinning. Even, so that the last look stays.
const LOOKS_MAX: usize = 2048;
/// First distance of looks, cycles.
const DISTANCE_CYCLES: u64 = 128;
/// Numbers of the tracks of a core's tiles, and of its units' states; they stand in this order.
const TILES_TID: usize = 1;
const STATES_TID: usize = 1000;
/// How the tracks of an SRP begin.
const SRP: &str = "SRP";

/// How a value changes, and so how it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// It grows by at most `.0 / .1` a T&I cycle: shown in percent of that. It is booked before it is done, or then.
    Grows(u64, u64),
    /// As that, but booked when the last of it is done.
    GrewBefore(u64, u64),
    /// It goes up and down: shown as it is.
    Level,
    /// Cycles in a state of the unit with this number in its core: the state that grows most is shown.
    State(usize),
}

#[derive(Clone, Debug, PartialEq, Eq)]
struct Track {
    /// Core; nothing for what the cores share.
    core: Option<usize>,
    name: String,
    kind: Kind,
}

/// Values of all tracks at a time. Those that grow go on growing from frame to frame.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Look {
    at: TiCycle,
    values: Vec<u64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct FrameBegin {
    frame: u32,
    at: TiCycle,
}

/// The activity of all units over time, of all frames; a probe that looks at the machine.
#[derive(Clone, Debug)]
pub struct Timeline {
    clock_mhz: u64,
    srp: Kind,
    dram: Kind,
    distance_cycles: u64,
    due: When,
    /// When the values are looked at again; tiles are looked at each time.
    due_values: TiCycle,
    tracks: Vec<Track>,
    looks: Vec<Look>,
    /// The last look of the frame before, which this frame goes on from.
    before: Option<Look>,
    /// When each frame began.
    frames: Vec<FrameBegin>,
    tiles: Stays,
}

impl Timeline {
    /// An empty timeline of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let (clock_mhz, dram) = (u64::from(config.ti.clock_mhz), &config.dram);
        let bytes = [dram.channels, dram.burst_bytes, dram.clock_mhz].map(u64::from).iter().product();
        Self {
            clock_mhz,
            srp: Kind::GrewBefore(config.srp.clock_mhz.into(), clock_mhz),
            dram: Kind::Grows(bytes, u64::from(dram.tccd) * clock_mhz),
            distance_cycles: DISTANCE_CYCLES,
            due: When::at(TiCycle(0)),
            due_values: TiCycle(0),
            tracks: Vec::new(),
            looks: Vec::new(),
            before: None,
            frames: Vec::new(),
            tiles: Stays::new(),
        }
    }

    /// The trace, in the JSON object form of the Chrome trace event format. Times are microseconds of simulated time. `about` is a JSON
    /// object that says what it is of.
    pub fn to_json(&self, about: &str) -> String {
        let mut events = self.names();
        events.extend(self.slices());
        for i in (0..self.tracks.len()).filter(|i| !matches!(self.tracks[*i].kind, Kind::State(_))) {
            self.counter(i, &mut events);
        }
        self.tile_slices(&mut events);
        self.state_slices(&mut events);
        let events = events.join(",\n");
        format!("{{\"displayTimeUnit\":\"ns\",\"otherData\":{about},\"traceEvents\":[\n{events}\n]}}\n")
    }

    /// Process number of a track: cores first, then what they share.
    fn process(&self, core: Option<usize>) -> usize {
        core.unwrap_or_else(|| self.tracks.iter().filter_map(|t| t.core).max().map_or(0, |core| core + 1))
    }

    fn names(&self) -> Vec<String> {
        let shared = self.process(None);
        let name = |pid: usize| if pid < shared { format!("core {pid}") } else { "memory and frames".to_owned() };
        let event = |pid: usize| {
            let name = name(pid);
            format!("{{\"ph\":\"M\",\"pid\":{pid},\"name\":\"process_name\",\"args\":{{\"name\":\"{name}\"}}}}")
        };
        (0..=shared).map(event).collect()
    }

    /// The last look's cycle.
    fn end(&self) -> TiCycle {
        self.looks.last().map_or(TiCycle(0), |look| look.at)
    }

    /// Each frame from its beginning to the next one's.
    fn slices(&self) -> Vec<String> {
        let (pid, last) = (self.process(None), self.end());
        let ends = self.frames.iter().skip(1).map(|f| f.at).chain([last]);
        let event = |(&FrameBegin { frame, at }, end): (&FrameBegin, TiCycle)| {
            let (ts, dur) = (self.microseconds(at.0), self.microseconds(end - at));
            format!("{{\"ph\":\"X\",\"pid\":{pid},\"tid\":0,\"name\":\"frame {frame}\",\"ts\":{ts},\"dur\":{dur}}}")
        };
        self.frames.iter().zip(ends).map(event).collect()
    }

    /// A track of slices, under its name.
    fn thread(
        &self,
        pid: usize,
        tid: usize,
        name: &str,
        slices: &[(TiCycle, TiCycle, String)],
        events: &mut Vec<String>,
    ) {
        if slices.is_empty() {
            return;
        }
        let head = format!("\"pid\":{pid},\"tid\":{tid},\"name\":");
        events.push(format!("{{\"ph\":\"M\",{head}\"thread_name\",\"args\":{{\"name\":\"{name}\"}}}}"));
        events.push(format!("{{\"ph\":\"M\",{head}\"thread_sort_index\",\"args\":{{\"sort_index\":{tid}}}}}"));
        for (begin, end, text) in slices {
            let (ts, dur) = (self.microseconds(begin.0), self.nanoseconds(end.0) - self.nanoseconds(begin.0));
            events.push(format!("{{\"ph\":\"X\",{head}\"{text}\",\"ts\":{ts},\"dur\":{}}}", thousandths(dur)));
        }
    }

    /// A track for each slot of a core: its tiles.
    fn tile_slices(&self, events: &mut Vec<String>) {
        let stays = self.tiles.done();
        for in_slot in stays.chunk_by(|a, b| a.place == b.place) {
            let (core, slot) = in_slot[0].place;
            let slices: Vec<_> = in_slot.iter().map(|s| (s.begin, s.end, format!("tile {}", s.tile))).collect();
            self.thread(core, TILES_TID + slot, &format!("tiles in slot {slot}"), &slices, events);
        }
    }

    /// A track for each unit of a core: its states.
    fn state_slices(&self, events: &mut Vec<String>) {
        let times: Vec<TiCycle> = self.looks.iter().map(|look| look.at).collect();
        let mut first = 0;
        for of_unit in self.tracks.chunk_by(|a, b| (a.core, a.kind) == (b.core, b.kind)) {
            let places = first..first + of_unit.len();
            first = places.end;
            let (Kind::State(unit), Some(core)) = (of_unit[0].kind, of_unit[0].core) else { continue };
            let kind = if of_unit[0].name.starts_with(SRP) { self.srp } else { Kind::State(unit) };
            let states: Vec<Vec<Share>> = places.map(|i| self.shares(i, kind)).collect();
            let steps = 0..times.len().saturating_sub(1);
            let grown = steps.map(|step| states.iter().map(|shares| shares[step].part).collect());
            let state = |i: usize| of_unit[i].name.split_once(": ").map_or("", |(_, state)| state).to_owned();
            let slices: Vec<_> =
                runs(&times, grown).into_iter().map(|(begin, end, i)| (begin, end, state(i))).collect();
            let name = of_unit[0].name.split_once(": ").map_or("", |(unit, _)| unit);
            self.thread(core, STATES_TID + unit, name, &slices, events);
        }
    }

    /// One event wherever the value changes: a counter keeps its value until its next event.
    fn counter(&self, i: usize, events: &mut Vec<String>) {
        let track = &self.tracks[i];
        let (pid, name) = (self.process(track.core), &track.name);
        let mut last = None;
        let mut event = |at: TiCycle, value: String| {
            if last.as_ref() != Some(&value) {
                let unit = if track.kind == Kind::Level { "rays" } else { "%" };
                let mut text =
                    format!("{{\"ph\":\"C\",\"pid\":{pid},\"name\":\"{name}\",\"ts\":{}", self.microseconds(at.0));
                let _ = write!(text, ",\"args\":{{\"{unit}\":{value}}}}}");
                events.push(text);
                last = Some(value);
            }
        };
        for (look, value) in self.looks.iter().zip(self.shown(i)) {
            event(look.at, value);
        }
        if let Some(end) = self.looks.last() {
            event(end.at, if track.kind == Kind::Level { "0" } else { "0.00" }.into());
        }
    }

    /// What a counter shows from each look to the next.
    fn shown(&self, i: usize) -> Vec<String> {
        match self.tracks[i].kind {
            Kind::Level => self.looks.windows(2).map(|pair| pair[0].values[i].to_string()).collect(),
            kind => self.shares(i, kind).iter().map(Share::percent).collect(),
        }
    }

    /// How much a value grew from each look to the next, as one of this kind.
    fn shares(&self, i: usize, kind: Kind) -> Vec<Share> {
        let (most, per) = match kind {
            Kind::Grows(most, per) | Kind::GrewBefore(most, per) => (most, per),
            Kind::Level | Kind::State(_) => (1, 1),
        };
        // A stage takes back what it took for idle and was not.
        let step = |pair: &[Look]| Share {
            part: u128::from(pair[1].values[i].saturating_sub(pair[0].values[i])) * u128::from(per),
            full: u128::from(pair[1].at - pair[0].at) * u128::from(most),
        };
        let mut shares: Vec<Share> = self.looks.windows(2).map(step).collect();
        // What is done for a frame is done in it.
        let mut rest = &mut shares[..];
        for end in self.ends_of_frames() {
            let (of_frame, others) = rest.split_at_mut(end.min(rest.len()));
            match kind {
                Kind::Grows(..) => spread(of_frame, false),
                Kind::GrewBefore(..) => spread(of_frame, true),
                Kind::Level | Kind::State(_) => {}
            }
            rest = others;
        }
        shares
    }

    /// How many steps from look to look each frame has.
    fn ends_of_frames(&self) -> Vec<usize> {
        let frame_of = |look: &Look| self.frames.partition_point(|frame| frame.at <= look.at);
        let steps = &self.looks[..self.looks.len().saturating_sub(1)];
        steps.chunk_by(|a, b| frame_of(a) == frame_of(b)).map(<[Look]>::len).collect()
    }

    /// Cycles as microseconds with three digits.
    fn microseconds(&self, cycles: u64) -> String {
        thousandths(self.nanoseconds(cycles))
    }

    fn nanoseconds(&self, cycles: u64) -> u64 {
        cycles * 1000 / self.clock_mhz
    }

    /// Keeps every second look.
    fn thin(&mut self) {
        let mut keep = false;
        self.looks.retain(|_| {
            keep = !keep;
            keep
        });
        self.distance_cycles *= 2;
    }

    fn read(&self, now: TiCycle, cores: &[Core], bytes: u64) -> (Vec<Track>, Vec<u64>) {
        let (mut tracks, mut values) = (Vec::new(), Vec::new());
        let mut add = |core, name: String, kind, value| {
            tracks.push(Track { core, name, kind });
            values.push(value);
        };
        for (i, core) in cores.iter().enumerate() {
            core.ti.busy(|StageBusy { unit, index, stage, cycles }| {
                add(Some(i), format!("{unit} {index} {stage}").trim_end().into(), Kind::Grows(1, 1), cycles);
            });
            let activity = core.srp.activity();
            add(Some(i), SRP.into(), self.srp, activity.busy_cycles());
            add(Some(i), "rays in T&I".into(), Kind::Level, core.ti.rays_inside() as u64);
        }
        add(None, "DRAM".into(), self.dram, bytes);
        for (i, core) in cores.iter().enumerate() {
            let states = of_core(core, now);
            for (unit, of_unit) in states.chunk_by(|a, b| a.unit == b.unit).enumerate() {
                for state in of_unit {
                    add(Some(i), format!("{}: {}", state.unit, state.state), Kind::State(unit), state.cycles);
                }
            }
        }
        (tracks, values)
    }
}

impl Timeline {
    fn look_at_values(&mut self, now: TiCycle, at: TiCycle, cores: &[Core], bytes: u64) {
        let (tracks, mut values) = self.read(now, cores, bytes);
        if let Some(before) = &self.before {
            for ((track, value), old) in tracks.iter().zip(&mut values).zip(&before.values) {
                *value += if track.kind == Kind::Level { 0 } else { *old };
            }
        }
        self.tracks = tracks;
        // A frame begins where the one before has ended.
        if self.looks.last().is_some_and(|last| last.at >= at) {
            return;
        }
        self.looks.push(Look { at, values });
        if self.looks.len() > LOOKS_MAX {
            self.thin();
            self.due_values = now + self.distance_cycles;
        }
    }
}

/// A number of thousandths with three digits.
fn thousandths(number: u64) -> String {
    format!("{}.{:03}", number / 1000, number % 1000)
}

impl Probe for Timeline {
    fn begin(&mut self, frame: u32) {
        self.before = self.looks.last().cloned();
        (self.due, self.due_values) = (When::at(TiCycle(0)), TiCycle(0));
        self.frames.push(FrameBegin { frame, at: self.end() });
    }

    fn due(&self) -> When {
        self.due
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        let begin = self.before.as_ref().map_or(0, |before| before.at.0);
        let at = now + begin;
        let held =
            cores.iter().enumerate().flat_map(|(i, core)| core.srp.held().map(move |(slot, tile)| ((i, slot), tile)));
        self.tiles.look(at, held);
        self.due = When::at(now + DISTANCE_CYCLES);
        let over = cores.iter().all(|core| core.srp.is_done());
        if now >= self.due_values || over {
            self.due_values = now + self.distance_cycles;
            self.look_at_values(now, at, cores, bytes);
        }
    }
}
