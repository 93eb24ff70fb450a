//! `plan.json`: a plan as bytes, with a checksum in front, and what is looked at before one is believed.
//!
//! ```text
//! {"checksum":"128 bits of BLAKE3 over all that follows the comma","layout":2,...}
//! ```
//!
//! The checksum finds what a disk or an editor did. It is no signature, so the key of every point is computed again from the
//! configuration that the plan holds: a plan cannot put the results of one configuration under the name of another.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::machines::{Machines, Variant};
use super::{LAYOUT, Plan, PointRef, is_machine_override};
use crate::error::{Result, StudyError};
use crate::point::key::{key, policy_json};
use crate::point::version::MODEL_VERSION;
use rayreel_replay::Detail;

/// What stands before the checksum.
const HEAD: &[u8] = b"{\"checksum\":\"";

/// What stands behind it.
const NEXT: &[u8] = b"\",";

/// What to do with a plan that is not what it was.
const AGAIN: &str = "make it again from its plan file, in another folder";

/// The checksum of what stands behind it.
fn checksum(rest: &[u8]) -> String {
    blake3::hash(rest).to_hex()[..32].to_owned()
}

/// What stands behind the checksum, if it is the right one.
fn checked(bytes: &[u8]) -> Option<&[u8]> {
    let (sum, rest) = bytes.strip_prefix(HEAD)?.split_at_checked(32)?;
    let rest = rest.strip_prefix(NEXT)?;
    (sum == checksum(rest).as_bytes()).then_some(rest)
}

impl Plan {
    /// The plan of `plan.json`.
    ///
    /// # Errors
    /// Not a plan; a plan of another layout or model; one that was changed or damaged; one whose points are not what their keys say.
    pub fn from_json(bytes: &[u8]) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Head {
            layout: u32,
            model: u32,
        }
        let head: Head = serde_json::from_slice(bytes).map_err(|e| format!("not a plan of a sweep: {e}"))?;
        if head.layout != LAYOUT {
            return Err(format!("the plan has layout {}, this program writes {LAYOUT}; {AGAIN}", head.layout));
        }
        if head.model != MODEL_VERSION {
            let (old, new) = (head.model, MODEL_VERSION);
            return Err(format!(
                "the plan was made for model version {old}, this program is version {new}: use the program that made it, or make \
                 a new plan in a new folder"
            ));
        }
        if checked(bytes).is_none() {
            return Err(format!(
                "the plan does not have the checksum that it was written with: it was changed or damaged; {AGAIN}"
            ));
        }
        let plan: Self = serde_json::from_slice(bytes).map_err(|e| format!("not a plan of a sweep: {e}"))?;
        plan.check()?;
        plan.check_keys()?;
        Ok(plan)
    }

    /// Refuses indices that point nowhere.
    fn check(&self) -> Result<(), String> {
        let end = |(first, count): (u32, u32)| first.checked_add(count).filter(|end| *end > first);
        let good = |p: &PointRef| {
            let values = p.values.iter().zip(&self.axes);
            let trace = self.traces.get(p.trace).and_then(|trace| Some((trace.frames.0, end(trace.frames)?)));
            let inside = |(first, last)| end(p.frames).is_some_and(|end| p.frames.0 >= first && end <= last);
            trace.is_some_and(inside)
                && p.machine < self.machines.len()
                && p.policy < self.policies.len()
                && p.detail < self.details.len()
                && p.values.len() == self.axes.len()
                && values.into_iter().all(|(value, axis)| value.is_none_or(|value| value < axis.values.len()))
        };
        if let Some(wrong) = self.details.iter().find(|text| text.parse::<Detail>().is_err()) {
            return Err(format!("not a plan of a sweep: {wrong:?} is no detail"));
        }
        match self.points.iter().position(|p| !good(p)) {
            Some(at) => Err(format!("not a plan of a sweep: point {at} points nowhere")),
            None => Ok(()),
        }
    }

    /// Refuses a point whose key is not that of its configuration. Each machine and each policy is put together once. Whether a machine
    /// can be built shows when a point of it is computed.
    fn check_keys(&self) -> Result<(), String> {
        let of = |point: &PointRef| {
            let (machine, policy) =
                self.overrides(&point.values).into_iter().partition(|text| is_machine_override(text));
            ((point.machine, machine), (point.policy, policy))
        };
        let variants: Vec<(Variant, Variant)> = self.points.iter().map(of).collect();
        let distinct: BTreeSet<&Variant> = variants.iter().map(|(machine, _)| machine).collect();
        let machines = Machines::new(self).all(distinct.into_iter().cloned().collect());
        let mut policies: BTreeMap<&Variant, String> = BTreeMap::new();
        for (at, (point, (machine, policy))) in self.points.iter().zip(&variants).enumerate() {
            let unusable = |e: &StudyError| format!("point {at} of the plan cannot be resolved: {e}; {AGAIN}");
            let machine = machines[machine].as_ref().map_err(unusable)?;
            let policy: &mut String = match policies.entry(policy) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(slot) => {
                    let found = self.policy(policy.0, &policy.1).map_err(|e| unusable(&e))?;
                    slot.insert(policy_json(&found))
                }
            };
            let detail = self.detail(point).map_err(|e| unusable(&e))?;
            let right = key(&self.traces[point.trace].fingerprint, point.frames, machine, policy, detail);
            if right != point.key {
                return Err(format!(
                    "point {at} of the plan ({}) has the key {}, and what it is to compute has the key {right}: the plan was \
                     changed, or made by another build; {AGAIN}",
                    self.describe(at),
                    point.key,
                ));
            }
        }
        Ok(())
    }

    /// The plan as `plan.json` holds it: the same bytes for the same plan.
    ///
    /// # Errors
    /// Never for a plan that was made by [`Plan::new`]: numbers are finite.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        let body = serde_json::to_vec(self).map_err(StudyError::json)?;
        let rest = body.strip_prefix(b"{").unwrap_or(&body);
        Ok([HEAD, checksum(rest).as_bytes(), NEXT, rest].concat())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_flipped_bit_passes() {
        let rest = b"\"layout\":2}";
        let whole = [HEAD, checksum(rest).as_bytes(), NEXT, rest].concat();
        assert_eq!(checked(&whole), Some(&rest[..]));
        for at in 0..8 * whole.len() {
            let mut changed = whole.clone();
            changed[at / 8] ^= 1 << (at % 8);
            assert_eq!(checked(&changed), None, "bit {at}");
        }
        assert!((0..whole.len()).all(|end| checked(&whole[..end]).is_none()));
    }
}
