//! What was compared: scenes, policies and every value of the machine.

use serde::{Deserialize, Serialize};

/// A scene.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scene {
    /// Name, as the points use it.
    pub name: String,
    /// Triangles.
    pub triangles: u64,
    /// Triangles of the paper's scene of this kind.
    pub paper_triangles: Option<u64>,
    /// Light sources.
    pub lights: u32,
    /// The frame of the points.
    pub frame: u32,
    /// Rays of all samples, by mode.
    pub rays_full: Vec<ModeRays>,
}

/// Rays in a mode.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModeRays {
    /// `2x2` (supersampling) or `1x1` (undersampling).
    pub mode: String,
    /// Rays.
    pub rays: u64,
}

/// A sampling policy.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Policy {
    /// Name, as the points use it.
    pub name: String,
    /// One sentence.
    pub summary: String,
    /// Every value, as a policy file.
    pub config_toml: String,
}

/// A value of the machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ConfigValue {
    /// Key, such as `ti.trv`.
    pub key: String,
    /// Value.
    pub value: String,
    /// Unit; may be empty.
    pub unit: String,
    /// How well it is known, such as `paper`.
    pub class: String,
    /// Where it is from.
    pub source: String,
}
