//! A point: one trace, machine, policy and run of frames, and the key of its result.

use std::collections::BTreeMap;

use crate::point::version::MODEL_VERSION;
use rayreel_machine::config::NamedMachine;
use rayreel_replay::policy::NamedPolicy;

/// A key: 128 bits of BLAKE3, as 32 hexadecimal digits.
pub type Key = String;

/// A point with everything resolved.
#[derive(Clone, Debug)]
pub struct Point {
    /// Index of the trace in the plan.
    pub trace: usize,
    /// The machine, if there is one.
    pub machine: Option<NamedMachine>,
    /// The policy.
    pub policy: NamedPolicy,
    /// First frame and number of frames.
    pub frames: (u32, u32),
}

impl Point {
    /// [`machine_json`] of its machine; empty without one.
    pub fn machine_config(&self) -> String {
        self.machine.as_ref().map(machine_json).unwrap_or_default()
    }

    /// Every value of the policy as JSON, as results keep it.
    pub fn policy_config(&self) -> String {
        serde_json::to_string(&self.policy.policy).unwrap_or_default()
    }

    /// The key of its result on the trace of this fingerprint.
    pub fn key(&self, fingerprint: &str) -> Key {
        key(fingerprint, self.frames, &self.machine_config(), &self.policy_config())
    }
}

/// Every value of a machine as JSON by key, as results keep it: equal for equal machines, whatever they are called and however they
/// were put together.
pub fn machine_json(machine: &NamedMachine) -> String {
    let values: BTreeMap<_, _> = machine.values.iter().map(|own| (own.key, &own.value)).collect();
    // Keys are words and numbers finite: this cannot fail.
    serde_json::to_string(&values).unwrap_or_default()
}

/// The hash of all that a result depends on: the trace's fingerprint, the first frame and the number of frames, every value of
/// machine and policy, and [`MODEL_VERSION`]. Names, comments and the order of a file do not enter.
pub fn key(fingerprint: &str, (first, count): (u32, u32), machine: &str, policy: &str) -> Key {
    let mut hasher = blake3::Hasher::new();
    let head = format!("rayreel point 1\nmodel {MODEL_VERSION}\nframes {first} {count}\n");
    for part in [&head, fingerprint, machine, policy] {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part.as_bytes());
    }
    hasher.finalize().to_hex()[..32].to_owned()
}
