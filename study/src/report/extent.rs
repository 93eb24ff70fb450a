//! What a report says of how much was simulated, where that is not every cycle.

use serde_json::{Map, Value};

use rayreel_replay::Detail;
use rayreel_replay::detail::{WHY_WHOLE, WhyWhole};

/// How much of a run was simulated.
#[derive(Clone, Debug, PartialEq)]
pub struct Extent<'a> {
    /// `full`, `all`, `sampled`, `precision` or `counts`.
    pub mode: &'a str,
    /// The share of the tiles that was simulated cycle by cycle.
    pub fraction: f64,
    /// Windows that were simulated.
    pub windows: u64,
    /// Frames that were simulated whole.
    pub whole_frames: u64,
    /// For which reasons, as far as that is known.
    pub whole_because: Vec<(WhyWhole, u64)>,
    /// Whether processors stand in the place of T&I units and of the SRPs' arrays.
    pub has_processors: bool,
}

impl<'a> Extent<'a> {
    /// That of a report as JSON; nothing without a machine.
    pub fn read(report: &'a Value) -> Option<Self> {
        let detail = &report["detail"];
        let number = |key: &str| detail[key].as_u64().unwrap_or(0);
        Some(Self {
            mode: detail["mode"].as_str()?,
            fraction: detail["fraction"].as_f64().unwrap_or(1.0),
            windows: number("windows"),
            whole_frames: number("whole_frames"),
            whole_because: reasons(detail["whole_because"].as_object()),
            has_processors: report["machine_config"]["ti.pipeline"]["value"] == "software",
        })
    }

    /// What was simulated, and what follows for the figures, clause by clause; nothing where that is all.
    pub fn clauses(&self) -> Vec<String> {
        let Self { mode, windows, .. } = self;
        let whole = match self.whole_frames {
            0 => String::new(),
            1 => format!("; 1 frame was simulated whole ({})", self.why()),
            n => format!("; {n} frames were simulated whole ({})", self.why()),
        };
        if *mode == Detail::Full.mode() {
            Vec::new()
        } else if *mode == Detail::Counts.mode() {
            let energies = if self.has_processors {
                "energies are those of caches and DRAM; what instructions cost, and so the sum, is not known"
            } else {
                "energies lack leakage, clocks and what waiting costs"
            };
            vec![format!("no cycle was simulated: work and misses are counted; {energies}")]
        } else if *windows > 0 {
            let share = 100.0 * self.fraction;
            vec![
                format!("estimates from {windows} windows with {share:.1} % of the tiles{whole}"),
                "a figure's 95 % interval reaches from - to + what stands behind it; counts of work are exact"
                    .to_owned(),
            ]
        } else {
            vec![format!("nothing is estimated{whole}")]
        }
    }

    /// Why frames were simulated whole. Reports of older builds do not say which of the reasons it was.
    fn why(&self) -> String {
        match self.whole_because.as_slice() {
            [] => WHY_WHOLE.to_owned(),
            [(why, _)] => why.words().to_owned(),
            several => {
                let each: Vec<_> = several.iter().map(|(why, frames)| format!("{frames}: {}", why.words())).collect();
                each.join("; ")
            }
        }
    }
}

/// The reasons in a report, with their frames.
pub(super) fn reasons(of_report: Option<&Map<String, Value>>) -> Vec<(WhyWhole, u64)> {
    let frames = |why: WhyWhole| of_report?.get(why.name())?.as_u64().map(|frames| (why, frames));
    WhyWhole::ALL.into_iter().filter_map(frames).collect()
}
