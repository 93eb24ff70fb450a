//! `plan.json`: a plan as bytes, with a checksum in front, and what is looked at before one is believed.
//!
//! ```text
//! {"checksum":"128 bits of BLAKE3 over all that follows the comma","layout":2,...}
//! ```
//!
//! The checksum finds what a disk or an editor did. It is no signature, so the key of every point is computed again from the
//! configuration that the plan holds: a plan cannot put the results of one configuration under the name of another.

use std::collections::{BTreeMap, BTreeSet};

use serde::Deserialize;

use super::machines::{BLOCK, Machines, REMEMBERED, Variant};
use super::{LAYOUT, Plan, PointRef, is_machine_override};
use crate::error::{Result, StudyError};
use crate::point::key::{key, policy_json};
use crate::point::version::MODEL_VERSION;
use rayreel_replay::Detail;

/// Machines or policies, as keys have them.
type Resolved = BTreeMap<Variant, Result<String>>;

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
        let plan = Self::stored(bytes)?;
        match plan.strangers().into_iter().next() {
            Some((_, detail)) => Err(detail),
            None => Ok(plan),
        }
    }

    /// As [`Plan::from_json`], for a plan whose rows are wanted and which is not to be carried out; and the keys of those points that are not
    /// what their keys say: a preset has other values now, or the plan was changed. Nobody can tell which, so their rows are no good.
    ///
    /// # Errors
    /// Not a plan; a plan of another layout or model; one that was changed or damaged.
    pub fn for_its_rows(bytes: &[u8]) -> Result<(Self, BTreeSet<String>), String> {
        let plan = Self::stored(bytes)?;
        let strangers = plan.strangers().into_iter().map(|(at, _)| plan.points[at].key.clone()).collect();
        Ok((plan, strangers))
    }

    /// The plan as it was written, whatever its keys say.
    fn stored(bytes: &[u8]) -> Result<Self, String> {
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

    /// The points whose keys are not those of their configurations, and what to say of each. Machines and policies are put together once
    /// each, as far as they are remembered. Whether a machine can be built shows when a point of it is computed.
    fn strangers(&self) -> Vec<(usize, String)> {
        let of = |point: &PointRef| -> (Variant, Variant) {
            let (machine, policy) =
                self.overrides(&point.values).into_iter().partition(|text| is_machine_override(text));
            ((point.machine, machine), (point.policy, policy))
        };
        let resolver = Machines::new(self);
        let (mut machines, mut policies) = (Resolved::new(), Resolved::new());
        let mut strangers = Vec::new();
        for (block, first) in self.points.chunks(BLOCK).zip((0..).step_by(BLOCK)) {
            for known in [&mut machines, &mut policies] {
                if known.len() > REMEMBERED {
                    known.clear();
                }
            }
            let variants: Vec<(Variant, Variant)> = block.iter().map(of).collect();
            let new: BTreeSet<&Variant> = variants
                .iter()
                .map(|(machine, _)| machine)
                .filter(|machine| !machines.contains_key(*machine))
                .collect();
            machines.extend(resolver.all(new.into_iter().cloned().collect()));
            for (_, policy) in &variants {
                if !policies.contains_key(policy) {
                    let json = self.policy(policy.0, &policy.1).map(|found| policy_json(&found));
                    policies.insert(policy.clone(), json);
                }
            }
            for ((at, point), (machine, policy)) in (first..).zip(block).zip(&variants) {
                strangers.extend(self.stranger(at, point, &machines[machine], &policies[policy]).map(|why| (at, why)));
            }
        }
        strangers
    }

    /// What to say of a point whose key is not that of its configuration.
    fn stranger(
        &self,
        at: usize,
        point: &PointRef,
        machine: &Result<String>,
        policy: &Result<String>,
    ) -> Option<String> {
        let unusable = |e: &StudyError| Some(format!("point {at} of the plan cannot be resolved: {e}; {AGAIN}"));
        let (machine, policy) = match (machine, policy) {
            (Ok(machine), Ok(policy)) => (machine, policy),
            (Err(e), _) | (_, Err(e)) => return unusable(e),
        };
        let detail = match self.detail(point) {
            Ok(detail) => detail,
            Err(e) => return unusable(&e),
        };
        let right = key(&self.traces[point.trace].fingerprint, point.frames, machine, policy, detail);
        (right != point.key).then(|| {
            format!(
                "point {at} of the plan ({}) has the key {}, and what it is to compute has the key {right}: the plan was \
                 changed, or made by another build; {AGAIN}",
                self.describe(at),
                point.key,
            )
        })
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
