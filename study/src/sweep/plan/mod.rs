//! A plan: all points of a sweep with everything that is needed to compute them, but for the traces.
//!
//! Presets and files are taken in when the plan is made, so that a worker of another day, or with another folder, computes the
//! same points. [`mod@file`] is the plan as people write it, [`expand`](self::Plan::new) makes the points of it.

mod axes;
pub mod axis;
mod blame;
mod detail;
mod expand;
pub mod file;
pub mod filter;
pub mod locate;
mod quantity;
mod range;
mod scalar;
mod sources;

use serde::{Deserialize, Serialize};

use crate::error::{Result, StudyError};
use crate::point::key::{Key, Point};
use crate::point::version::MODEL_VERSION;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_replay::Detail;
use rayreel_replay::policy::NamedPolicy;

pub use axis::{Axis, AxisValue};
pub use scalar::Scalar;
pub use sources::Sources;

/// Version of the layout of `plan.json` and of segments.
pub const LAYOUT: u32 = 1;

/// Points of one bucket: what one folder of segments holds.
pub const BUCKET: usize = 64;

/// A trace of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRef {
    /// File name: what results call it.
    pub name: String,
    /// Where it was when the plan was made: an absolute path, or an address.
    pub location: String,
    /// What it must hold: [`rayreel_formats::trace::Trace::fingerprint`].
    pub fingerprint: String,
    /// Its scene.
    pub scene: String,
    /// Picture size, pixels.
    pub size: (u32, u32),
    /// Samples per pixel and axis.
    pub samples: u32,
    /// First frame and number of frames.
    pub frames: (u32, u32),
}

/// A machine or policy before the axes change it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Base {
    /// Its name.
    pub name: String,
    /// Its text; empty for the machine `none`.
    pub toml: String,
}

/// A point as indices into the plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointRef {
    /// Which trace.
    pub trace: usize,
    /// Which machine.
    pub machine: usize,
    /// Which policy.
    pub policy: usize,
    /// First frame and number of frames.
    pub frames: (u32, u32),
    /// Which detail.
    #[serde(default, skip_serializing_if = "detail::is_first")]
    pub detail: usize,
    /// Which value of each axis; none where the axis does not apply.
    pub values: Vec<Option<usize>>,
    /// Its key.
    pub key: Key,
}

/// All points of a sweep.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Plan {
    /// [`LAYOUT`].
    pub layout: u32,
    /// [`MODEL_VERSION`] of the program that made it.
    pub model: u32,
    /// What results call it.
    pub name: String,
    /// The traces.
    pub traces: Vec<TraceRef>,
    /// The machines.
    pub machines: Vec<Base>,
    /// The policies.
    pub policies: Vec<Base>,
    /// How much is simulated cycle by cycle, as texts that read as a [`Detail`].
    #[serde(default = "detail::full", skip_serializing_if = "detail::is_full")]
    pub details: Vec<String>,
    /// What varies.
    pub axes: Vec<Axis>,
    /// Overrides of all points.
    pub set: Vec<String>,
    /// The points: by trace, frames, machine, policy, detail, then the axes, the last one fastest.
    pub points: Vec<PointRef>,
}

impl Plan {
    /// The plan of `plan.json`.
    ///
    /// # Errors
    /// Not a plan; a plan of another layout or model.
    pub fn from_json(bytes: &[u8]) -> Result<Self, String> {
        #[derive(Deserialize)]
        struct Head {
            layout: u32,
            model: u32,
        }
        let head: Head = serde_json::from_slice(bytes).map_err(|e| format!("not a plan of a sweep: {e}"))?;
        if head.layout != LAYOUT {
            return Err(format!("the plan has layout {}, this program writes {LAYOUT}; make it again", head.layout));
        }
        if head.model != MODEL_VERSION {
            let (old, new) = (head.model, MODEL_VERSION);
            return Err(format!(
                "the plan was made for model version {old}, this program is version {new}: use the program that made it, or make \
                 a new plan in a new folder"
            ));
        }
        let plan: Self = serde_json::from_slice(bytes).map_err(|e| format!("not a plan of a sweep: {e}"))?;
        plan.check().map(|()| plan)
    }

    /// Refuses indices that point nowhere.
    fn check(&self) -> Result<(), String> {
        let good = |p: &PointRef| {
            let values = p.values.iter().zip(&self.axes);
            p.trace < self.traces.len()
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

    /// The plan as `plan.json` holds it: the same bytes for the same plan.
    ///
    /// # Errors
    /// Never for a plan that was made by [`Plan::new`]: numbers are finite.
    pub fn to_json(&self) -> Result<Vec<u8>> {
        serde_json::to_vec(self).map_err(|e| StudyError::Usage { detail: e.to_string() })
    }

    /// Which plan it is: a hash of its points and of what their rows are called, wherever the traces lie.
    pub fn id(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        let mut part = |text: &str| {
            hasher.update(&(text.len() as u64).to_le_bytes()).update(text.as_bytes());
        };
        part(&self.name);
        for trace in &self.traces {
            part(&trace.name);
        }
        for base in self.machines.iter().chain(&self.policies) {
            part(&base.name);
        }
        for axis in &self.axes {
            part(&axis.name);
            axis.values.iter().for_each(|value| part(&value.label));
        }
        // A plan of every cycle is known by what it was known by before there was detail.
        if !detail::is_full(&self.details) {
            self.details.iter().for_each(|detail| part(detail));
        }
        for point in &self.points {
            part(&point.key);
            part(&format!("{} {} {} {:?}", point.trace, point.machine, point.policy, point.values));
        }
        hasher.finalize().to_hex()[..16].to_owned()
    }

    /// The overrides of a point, in the order in which they apply.
    fn overrides(&self, values: &[Option<usize>]) -> Vec<String> {
        let chosen = self.axes.iter().zip(values).filter_map(|(axis, value)| Some(&axis.values[(*value)?].set));
        self.set.iter().chain(chosen.flatten()).cloned().collect()
    }

    /// Those of them that are the policy's.
    pub(crate) fn policy_overrides(&self, point: &PointRef) -> Vec<String> {
        let mut all = self.overrides(&point.values);
        all.retain(|text| !is_machine_override(text));
        all
    }

    /// A point with its machine and policy.
    ///
    /// # Errors
    /// Values that cannot stand together.
    pub fn resolve(&self, point: &PointRef) -> Result<Point> {
        self.resolve_with(point, self.overrides(&point.values))
    }

    /// The same with these overrides instead of its own.
    fn resolve_with(&self, point: &PointRef, overrides: Vec<String>) -> Result<Point> {
        let (of_machine, of_policy): (Vec<_>, Vec<_>) =
            overrides.into_iter().partition(|text| is_machine_override(text));
        let (machine, policy) = (&self.machines[point.machine], &self.policies[point.policy]);
        let machine = match machine.toml.as_str() {
            "" => None,
            toml => Some(NamedMachine::parse(&machine.name, toml, &of_machine)?),
        };
        let policy = NamedPolicy::parse(&policy.name, &policy.toml, &of_policy)?;
        let plain = Point::plain(&self.traces[point.trace].fingerprint, point.frames, machine, policy);
        Ok(Point { detail: self.detail(point)?, ..plain })
    }

    /// How much of a point is simulated cycle by cycle.
    ///
    /// # Errors
    /// Never for a plan that was made or read.
    pub fn detail(&self, point: &PointRef) -> Result<Detail> {
        self.details[point.detail].parse().map_err(|detail| StudyError::Usage { detail })
    }

    /// What point `index` is, in words: for messages and progress.
    pub fn describe(&self, index: usize) -> String {
        let point = &self.points[index];
        let (first, count) = point.frames;
        let mut text = format!(
            "{} frames {first}..{} on {} under {}",
            self.traces[point.trace].name,
            first + count,
            self.machines[point.machine].name,
            self.policies[point.policy].name,
        );
        for (axis, value) in self.axes.iter().zip(&point.values) {
            if let Some(value) = value {
                text += &format!(" {}={}", axis.name, axis.values[*value].label);
            }
        }
        if !detail::is_full(&self.details) {
            text += &format!(" detail {}", self.details[point.detail]);
        }
        text
    }
}
