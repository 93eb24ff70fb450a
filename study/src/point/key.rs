//! A point: one source, machine, policy and run of frames, what is wanted of it, and the keys of its results.

use std::collections::BTreeMap;
use std::sync::Arc;

use crate::point::version::{ESTIMATE_VERSION, MODEL_VERSION};
use crate::point::wanted::{Figures, Wanted};
use rayreel_machine::config::NamedMachine;
use rayreel_replay::Detail;
use rayreel_replay::policy::NamedPolicy;
use rayreel_settings::Sourced;

/// A key: 128 bits of BLAKE3, as 32 hexadecimal digits.
pub type Key = String;

/// Version of what [`crate::point::details::Details`] hold. It enters their keys: older ones are not found, and never misread.
pub const DETAILS_LAYOUT: u32 = 1;

/// A point with everything resolved.
#[derive(Clone, Debug)]
pub struct Point {
    /// What is replayed: the fingerprint of a trace ([`rayreel_formats::trace::Trace::fingerprint`]), or another text that is
    /// equal only for sources that hold the same.
    pub source: String,
    /// First frame and number of frames.
    pub frames: (u32, u32),
    /// The machine, if there is one.
    pub machine: Option<Arc<NamedMachine>>,
    /// The policy.
    pub policy: Arc<NamedPolicy>,
    /// How much of its frames the machine simulates cycle by cycle; of no meaning without one.
    pub detail: Detail,
    /// What is wanted of it.
    pub wanted: Wanted,
}

impl Point {
    /// A point of which the row is wanted, and nothing beside it; every cycle is simulated.
    pub fn plain(
        source: impl Into<String>,
        frames: (u32, u32),
        machine: Option<NamedMachine>,
        policy: NamedPolicy,
    ) -> Self {
        let (machine, policy) = (machine.map(Arc::new), Arc::new(policy));
        Self { source: source.into(), frames, machine, policy, detail: Detail::Full, wanted: Wanted::default() }
    }

    /// [`machine_json`] of its machine; empty without one.
    pub fn machine_config(&self) -> String {
        self.machine.as_deref().map(machine_json).unwrap_or_default()
    }

    /// Every value of the policy as JSON, as results keep it.
    pub fn policy_config(&self) -> String {
        policy_json(&self.policy)
    }

    /// The numbers of its frames.
    pub fn frame_numbers(&self) -> std::ops::Range<u32> {
        self.frames.0..self.frames.0 + self.frames.1
    }

    /// The key of its row, if one is wanted.
    pub fn row_key(&self) -> Option<Key> {
        let wanted = matches!(self.wanted.figures, Figures::Row);
        wanted.then(|| key(&self.source, self.frames, &self.machine_config(), &self.policy_config(), self.detail))
    }

    /// The key of its details, if some are wanted. The machine enters it only where a frame of them is simulated: pictures and
    /// tiles are the same on every machine.
    pub fn details_key(&self) -> Option<Key> {
        let text = format!("details {DETAILS_LAYOUT}\n{}", self.wanted.canonical()?);
        let machine = if self.wanted.figures.simulates_details() { self.machine_config() } else { String::new() };
        let (policy, estimated) = (self.policy_config(), estimated(&machine, self.detail));
        let texts = [&self.source, &machine, &policy, &text].into_iter().chain(&estimated).map(String::as_str);
        Some(hash(self.frames, &texts.collect::<Vec<_>>()))
    }

    /// Whether one replay serves both points: they differ in machines alone, and in what can be looked at.
    pub fn shares_replay(&self, other: &Self) -> bool {
        let rows = [self, other].iter().all(|point| matches!(point.wanted.figures, Figures::Row));
        rows && (&self.source, self.frames, self.detail) == (&other.source, other.frames, other.detail)
            && self.policy.policy == other.policy.policy
    }

    /// Whether a machine simulates a frame for its row.
    pub(crate) fn simulates_row(&self) -> bool {
        self.machine.is_some() && matches!(self.wanted.figures, Figures::Row)
    }
}

/// Every value of a machine as JSON by key, as results keep it: equal for equal machines, whatever they are called and however they
/// were put together.
pub fn machine_json(machine: &NamedMachine) -> String {
    values_json(&machine.values)
}

/// The same of the values themselves.
pub(crate) fn values_json(values: &[Sourced]) -> String {
    let values: BTreeMap<_, _> = values.iter().map(|sourced| (sourced.key, &sourced.value)).collect();
    serde_json::to_string(&values).expect("keys are words")
}

/// Every value of a policy as JSON, as results keep it.
pub fn policy_json(policy: &NamedPolicy) -> String {
    serde_json::to_string(&policy.policy).expect("keys are words")
}

/// The hash of all that a row depends on: the trace's fingerprint, the first frame and the number of frames, every value of
/// machine and policy, [`MODEL_VERSION`], and how much is simulated if that is not every cycle. Names, comments and the order of a
/// file do not enter.
pub fn key(fingerprint: &str, frames: (u32, u32), machine: &str, policy: &str, detail: Detail) -> Key {
    let estimated = estimated(machine, detail);
    let texts = [fingerprint, machine, policy].into_iter().chain(estimated.as_deref());
    hash(frames, &texts.collect::<Vec<_>>())
}

/// What stands in a key for the detail: nothing where every cycle is simulated, or none.
fn estimated(machine: &str, detail: Detail) -> Option<String> {
    let any = detail != Detail::Full && !machine.is_empty();
    any.then(|| format!("estimate {ESTIMATE_VERSION}\ndetail {detail}"))
}

/// The hash of a run of frames of this model version, and of some texts. Each stands behind its length, so lists of texts that
/// differ never look alike.
fn hash((first, count): (u32, u32), texts: &[&str]) -> Key {
    let mut hasher = blake3::Hasher::new();
    let head = format!("rayreel point 1\nmodel {MODEL_VERSION}\nframes {first} {count}\n");
    for part in [&head[..]].iter().chain(texts) {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
    }
    hasher.finalize().to_hex()[..32].to_owned()
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::point::wanted::{Compared, Kind, PictureWanted, Views};

    fn point(machine: &str) -> Point {
        let machine = NamedMachine::load("sgrt-ti2", &[machine.to_owned()]).unwrap();
        Point::plain("f", (0, 3), Some(machine), NamedPolicy::load("adaptive", &[]).unwrap())
    }

    #[test]
    fn a_row_has_one_key_whatever_is_wanted_beside_it() {
        let plain = point("ti.trv=4");
        assert_eq!(
            plain.row_key(),
            Some(key("f", (0, 3), &plain.machine_config(), &plain.policy_config(), Detail::Full))
        );
        assert_eq!(plain.details_key(), None);
        let mut shown = plain.clone();
        shown.wanted.views.tiles = true;
        assert_eq!(shown.row_key(), plain.row_key());
        assert!(shown.details_key().is_some() && shown.details_key() != plain.row_key());
    }

    #[test]
    fn pictures_are_those_of_every_machine_and_simulated_frames_are_not() {
        let [mut a, mut b] = ["ti.trv=4", "ti.trv=2"].map(point);
        let picture = PictureWanted { frame: 1, kind: Kind::Result, shrink: 1 };
        for point in [&mut a, &mut b] {
            point.wanted.views = Views { tiles: true, pictures: vec![picture] };
        }
        assert_ne!(a.row_key(), b.row_key());
        assert_eq!(a.details_key(), b.details_key());
        for (simulated, same) in [(Vec::new(), true), (vec![1], false)] {
            for point in [&mut a, &mut b] {
                let figures = Figures::Frames { compared: Compared::Valued, simulated: simulated.clone() };
                point.wanted.figures = figures;
            }
            assert_eq!((a.row_key(), b.row_key()), (None, None));
            assert_eq!(a.details_key() == b.details_key(), same, "{simulated:?}");
        }
    }

    #[test]
    fn detail_is_part_of_a_key_where_something_is_estimated() {
        let with = |detail: &str| Point { detail: detail.parse().unwrap(), ..point("ti.trv=4") };
        // The key of every cycle is older than estimates, and results of it are on disk.
        let plain = with("full");
        let machine = plain.machine_config();
        assert_eq!(plain.row_key(), Some(hash((0, 3), &["f", &machine, &plain.policy_config()])));
        let texts = ["full", "all", "counts", "0.1", "0.2", "precision 0.1"];
        let keys: BTreeSet<_> = texts.into_iter().map(|text| with(text).row_key()).collect();
        assert_eq!(keys.len(), texts.len());
        assert_eq!(with("10%").row_key(), with("0.1").row_key());
        let no_machine = |detail| Point { machine: None, ..with(detail) };
        assert_eq!(no_machine("full").row_key(), no_machine("0.1").row_key());

        let details = |detail, simulated: &[u32]| {
            let figures = Figures::Frames { compared: Compared::Valued, simulated: simulated.to_vec() };
            Point { wanted: Wanted { figures, views: Views::default() }, ..with(detail) }.details_key()
        };
        assert_ne!(details("full", &[1]), details("0.1", &[1]));
        assert_eq!(details("full", &[]), details("0.1", &[]), "nothing is estimated where nothing is simulated");
    }
}
