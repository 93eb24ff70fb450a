//! Unit activity over time, as a Chrome trace (open it in ui.perfetto.dev or chrome://tracing).
//!
//! The counters of every unit are looked at from time to time; what is written is how busy each was in between. When there are
//! too many looks, every second one is forgotten and the distance doubles, so memory and file stay small however long the run.

use std::fmt::Write as _;

use super::memory::Cycle;
use super::system::{Core, Probe};

/// Looks kept at most; half of them remain after thinning.
const LOOKS_MAX: usize = 4096;
/// First distance of looks, cycles.
const DISTANCE_CYCLES: Cycle = 128;

/// One value that grows with time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Track {
    /// Core; `None` for what the cores share.
    pub core: Option<usize>,
    /// What is busy.
    pub name: &'static str,
    /// Number of the unit of that name.
    pub unit: usize,
    /// Growth per T&I cycle at full activity.
    pub full: u64,
}

/// See the module.
#[derive(Clone, Debug)]
pub struct Timeline {
    clock_mhz: u64,
    distance: Cycle,
    due: Cycle,
    tracks: Vec<Track>,
    looks: Vec<(Cycle, Vec<u64>)>,
}

impl Timeline {
    /// An empty timeline of a machine whose T&I clock is `clock_mhz`.
    pub fn new(clock_mhz: u32) -> Self {
        Self {
            clock_mhz: clock_mhz.into(),
            distance: DISTANCE_CYCLES,
            due: 0,
            tracks: Vec::new(),
            looks: Vec::new(),
        }
    }

    /// The trace: one counter a unit, percent of its peak, in microseconds of simulated time.
    pub fn to_json(&self) -> String {
        let mut text = String::from("{\"displayTimeUnit\":\"ns\",\"traceEvents\":[\n");
        let cores = self.tracks.iter().filter_map(|t| t.core).max().map_or(0, |core| core + 1);
        for pid in 0..=cores {
            let name = if pid < cores { format!("core {pid}") } else { "memory".to_owned() };
            let _ = writeln!(
                text,
                "{{\"ph\":\"M\",\"pid\":{pid},\"name\":\"process_name\",\"args\":{{\"name\":\"{name}\"}}}},"
            );
        }
        for (i, track) in self.tracks.iter().enumerate() {
            self.counter(&mut text, i, track, cores);
        }
        text.truncate(text.trim_end_matches([',', '\n']).len());
        text.push_str("\n]}\n");
        text
    }

    fn counter(&self, text: &mut String, i: usize, track: &Track, cores: usize) {
        let pid = track.core.unwrap_or(cores);
        let mut last = None;
        for pair in self.looks.windows(2) {
            let ((from, before), (to, after)) = (&pair[0], &pair[1]);
            let full = (to - from) * track.full;
            // Per mille, rounded, so that the text is the same everywhere.
            let mille = ((after[i] - before[i]) * 1000 + full / 2).checked_div(full).unwrap_or(0);
            if last == Some(mille) {
                continue;
            }
            last = Some(mille);
            let _ = writeln!(
                text,
                "{{\"ph\":\"C\",\"pid\":{pid},\"name\":\"{} {}\",\"ts\":{},\"args\":{{\"busy %\":{}.{}}}}},",
                track.name,
                track.unit,
                self.microseconds(*from),
                mille / 10,
                mille % 10
            );
        }
        if let Some((end, _)) = self.looks.last() {
            let _ = writeln!(
                text,
                "{{\"ph\":\"C\",\"pid\":{pid},\"name\":\"{} {}\",\"ts\":{},\"args\":{{\"busy %\":0.0}}}},",
                track.name,
                track.unit,
                self.microseconds(*end)
            );
        }
    }

    /// Cycles as microseconds with three digits.
    fn microseconds(&self, cycle: Cycle) -> String {
        let nanoseconds = cycle * 1000 / self.clock_mhz;
        format!("{}.{:03}", nanoseconds / 1000, nanoseconds % 1000)
    }
}

impl Probe for Timeline {
    fn due(&self) -> Cycle {
        self.due
    }

    fn look(&mut self, now: Cycle, cores: &[Core], shared: &[(Track, u64)]) {
        if self.looks.last().is_some_and(|last| last.0 >= now) {
            return;
        }
        let own = cores.iter().enumerate().flat_map(|(i, core)| core.tracks(i));
        let (tracks, values) = own.chain(shared.iter().copied()).unzip();
        self.tracks = tracks;
        self.looks.push((now, values));
        if self.looks.len() > LOOKS_MAX {
            let mut keep = false;
            self.looks.retain(|_| {
                keep = !keep;
                keep
            });
            self.distance *= 2;
        }
        self.due = now + self.distance;
    }
}
