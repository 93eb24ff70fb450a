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
mod machines;
mod quantity;
mod range;
mod scalar;
mod sources;
mod stored;

use serde::{Deserialize, Serialize};

use crate::error::{Result, StudyError};
use crate::point::key::{Key, Point};
use rayreel_machine::config::NamedMachine;
use rayreel_machine::config::schema::is_machine_override;
use rayreel_replay::Detail;
use rayreel_replay::policy::NamedPolicy;

pub use axis::{Axis, AxisValue};
pub use scalar::Scalar;
pub use sources::Sources;

/// Version of the layout of `plan.json` and of records of submissions.
pub const LAYOUT: u32 = 2;

/// Points of one bucket: what one folder of segments holds.
pub const BUCKET: usize = 64;

/// A trace of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TraceRef {
    /// File name: what results call it.
    pub name: String,
    /// Where it was when the plan was made: an absolute path, or an address without what may be a secret of it (user, password,
    /// query).
    pub location: String,
    /// Whether the address had such a part: whoever opens it has to know it from elsewhere.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub signed: bool,
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

impl Base {
    /// Whether it is the machine `none`.
    pub fn is_none(&self) -> bool {
        self.toml.is_empty()
    }
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
    /// [`MODEL_VERSION`](crate::point::version::MODEL_VERSION) of the program that made it.
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
    /// What there is to say of constraints that leave no point out; of a plan that was just made.
    #[serde(skip)]
    pub idle: Vec<String>,
}

impl Plan {
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
        let (machine, policy) = (self.machine(point.machine, &of_machine)?, self.policy(point.policy, &of_policy)?);
        let plain = Point::plain(&self.traces[point.trace].fingerprint, point.frames, machine, policy);
        Ok(Point { detail: self.detail(point)?, ..plain })
    }

    /// Machine number `index` with these overrides; none if that is the machine `none`.
    fn machine(&self, index: usize, overrides: &[String]) -> Result<Option<NamedMachine>> {
        let Base { name, toml } = &self.machines[index];
        let parse = || Ok(NamedMachine::parse(name, toml, overrides)?);
        (!toml.is_empty()).then(parse).transpose()
    }

    /// Policy number `index` with these overrides.
    fn policy(&self, index: usize, overrides: &[String]) -> Result<NamedPolicy> {
        let Base { name, toml } = &self.policies[index];
        Ok(NamedPolicy::parse(name, toml, overrides)?)
    }

    /// How much of a point is simulated cycle by cycle.
    ///
    /// # Errors
    /// Never for a plan that was made or read.
    pub fn detail(&self, point: &PointRef) -> Result<Detail> {
        self.details[point.detail].parse().map_err(|detail| StudyError::Usage { detail })
    }

    /// The same as text; none where there is no machine, of which nothing is simulated.
    pub fn detail_text(&self, point: &PointRef) -> Option<&str> {
        (!self.machines[point.machine].is_none()).then(|| self.details[point.detail].as_str())
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
        if let Some(detail) = self.detail_text(point).filter(|_| !detail::is_full(&self.details)) {
            text += &format!(" detail {detail}");
        }
        text
    }
}
