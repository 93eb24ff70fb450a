//! Unit activity over time, as a Chrome trace: open it in ui.perfetto.dev or chrome://tracing.
//!
//! The counters of every unit are looked at from time to time; what is written is how busy each was in between. When there are
//! too many looks, every second one is forgotten and the distance doubles, so memory and file stay small however long the run,
//! and no busy cycle is lost. The SRP books items when they are done, T&I stages when an issue is certain, and the DRAM a burst when its
//! command is sent, so over a short distance a value can come out above 100 %.
//!
//! Frames follow one another in time. Of each core there is a counter for every issue stage, in percent of its cycles, and the
//! number of rays in its T&I unit; the DRAM's is in percent of its peak bandwidth.

use std::fmt::Write as _;

use crate::config::MachineConfig;
use crate::counters::StageBusy;
use crate::link::RayUnit;
use crate::system::{Core, Probe};
use crate::time::{TiCycle, When};

/// Looks kept at most; half of them remain after thinning. Even, so that the last look stays.
const LOOKS_MAX: usize = 2048;
/// First distance of looks, cycles.
const DISTANCE_CYCLES: u64 = 128;

/// How a value changes, and so how it is shown.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    /// It grows by at most `.0 / .1` a T&I cycle: shown in percent of that.
    Grows(u64, u64),
    /// It goes up and down: shown as it is.
    Level,
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
    tracks: Vec<Track>,
    looks: Vec<Look>,
    /// The last look of the frame before, which this frame goes on from.
    before: Option<Look>,
    /// When each frame began.
    frames: Vec<FrameBegin>,
}

impl Timeline {
    /// An empty timeline of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let (clock_mhz, dram) = (u64::from(config.ti.clock_mhz), &config.dram);
        let bytes = [dram.channels, dram.burst_bytes, dram.clock_mhz].map(u64::from).iter().product();
        Self {
            clock_mhz,
            srp: Kind::Grows(config.srp.clock_mhz.into(), clock_mhz),
            dram: Kind::Grows(bytes, u64::from(dram.tccd) * clock_mhz),
            distance_cycles: DISTANCE_CYCLES,
            due: When::at(TiCycle(0)),
            tracks: Vec::new(),
            looks: Vec::new(),
            before: None,
            frames: Vec::new(),
        }
    }

    /// The trace, in the JSON object form of the Chrome trace event format. Times are microseconds of simulated time.
    pub fn to_json(&self) -> String {
        let mut events = self.names();
        events.extend(self.slices());
        for i in 0..self.tracks.len() {
            self.counter(i, &mut events);
        }
        format!("{{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n{}\n]}}\n", events.join(",\n"))
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
        for pair in self.looks.windows(2) {
            let (from, to) = (&pair[0], &pair[1]);
            event(from.at, shown(track.kind, to.at - from.at, from.values[i], to.values[i]));
        }
        if let Some(end) = self.looks.last() {
            event(end.at, if track.kind == Kind::Level { "0" } else { "0.00" }.into());
        }
    }

    /// Cycles as microseconds with three digits.
    fn microseconds(&self, cycles: u64) -> String {
        let nanoseconds = cycles * 1000 / self.clock_mhz;
        format!("{}.{:03}", nanoseconds / 1000, nanoseconds % 1000)
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

    fn read(&self, cores: &[Core], bytes: u64) -> (Vec<Track>, Vec<u64>) {
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
            add(Some(i), "SRP".into(), self.srp, activity.busy_cycles());
            add(Some(i), "rays in T&I".into(), Kind::Level, core.ti.rays_inside() as u64);
        }
        add(None, "DRAM".into(), self.dram, bytes);
        (tracks, values)
    }
}

/// A value over some cycles, as text: in hundredths of a percent, rounded, so that it is the same everywhere.
fn shown(kind: Kind, cycles: u64, before: u64, after: u64) -> String {
    let Kind::Grows(most, per) = kind else { return before.to_string() };
    let full = u128::from(cycles) * u128::from(most);
    let part = u128::from(after - before) * u128::from(per) * 10_000;
    let hundredths = (part + full / 2).checked_div(full).unwrap_or(0);
    format!("{}.{:02}", hundredths / 100, hundredths % 100)
}

impl Probe for Timeline {
    fn begin(&mut self, frame: u32) {
        self.before = self.looks.last().cloned();
        self.due = When::at(TiCycle(0));
        self.frames.push(FrameBegin { frame, at: self.end() });
    }

    fn due(&self) -> When {
        self.due
    }

    fn look(&mut self, now: TiCycle, cores: &[Core], bytes: u64) {
        let (tracks, mut values) = self.read(cores, bytes);
        let mut at = now;
        if let Some(before) = &self.before {
            at += before.at.0;
            for ((track, value), old) in tracks.iter().zip(&mut values).zip(&before.values) {
                *value += if track.kind == Kind::Level { 0 } else { *old };
            }
        }
        self.tracks = tracks;
        self.due = When::at(now + self.distance_cycles);
        // A frame begins where the one before has ended.
        if self.looks.last().is_some_and(|last| last.at >= at) {
            return;
        }
        self.looks.push(Look { at, values });
        if self.looks.len() > LOOKS_MAX {
            self.thin();
            self.due = When::at(now + self.distance_cycles);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_of_the_peak_and_levels_are_as_they_are() {
        assert_eq!(shown(Kind::Grows(1, 1), 200, 10, 110), "50.00");
        // An array that runs two of its cycles a T&I cycle; a bus that moves 51.2 bytes a T&I cycle.
        assert_eq!(shown(Kind::Grows(1000, 500), 200, 0, 300), "75.00");
        assert_eq!(shown(Kind::Grows(256, 5), 100, 0, 512), "10.00");
        assert_eq!(shown(Kind::Grows(1, 1), 3, 0, 2), "66.67");
        assert_eq!(shown(Kind::Level, 7, 3, 9), "3");
    }

    #[test]
    fn thinning_keeps_the_first_and_the_last_look() {
        let config = crate::config::NamedMachine::load("sgrt-ti2", &[]).unwrap().config;
        let mut timeline = Timeline::new(&config);
        let looks = LOOKS_MAX as u64 * 4 + 1;
        for at in 0..looks {
            timeline.look(TiCycle(at * DISTANCE_CYCLES), &[], at);
        }
        assert!(timeline.looks.len() <= LOOKS_MAX && timeline.distance_cycles > DISTANCE_CYCLES);
        let ends = [timeline.looks.first(), timeline.looks.last()].map(|look| look.unwrap().values.clone());
        assert_eq!(ends, [vec![0], vec![looks - 1]]);
    }
}
