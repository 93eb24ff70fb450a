//! The plan file (TOML) as it is written.
//!
//! ```toml
//! name = "caches"
//! traces = ["captures/*.rtrace"]        # files or patterns, relative to this file; or s3://, gs://, http(s)://
//! machines = ["sgrt-ti2"]               # presets or machine files; "none" replays without a machine
//! policies = ["full", "multirate"]      # presets or policy files
//! frames = ["all"]                      # each entry one point: "all", "3", "0..10"
//! detail = "5%"                         # simulate a sample; or several, each entry one point: ["full", "5%"]
//! set = ["srp.ideal=true"]              # overrides of all points
//! exclude = ["l1 > 65536 and trv == 8"] # points that are left out
//!
//! [[axis]]
//! name = "l1"
//! key = "ti.trv_l1.size"
//! log = { from = "4KiB", to = "64KiB", factor = 2 }
//! ```

use rayreel_settings::{one_table, with_near_key};
use serde::Deserialize;
use toml::{Spanned, Value};

use crate::error::Result;
use crate::sweep::plan::locate::Text;

/// A value with its place in the file.
pub type At<T> = Spanned<T>;

/// The whole file.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanFile {
    /// What results call it; the stem of the file if it is missing.
    pub name: Option<At<String>>,
    /// Files, patterns or addresses.
    pub traces: At<Vec<At<String>>>,
    /// Presets or files.
    #[serde(default)]
    pub machines: Option<At<Vec<At<String>>>>,
    /// Presets or files.
    pub policies: At<Vec<At<String>>>,
    /// `all`, `A` or `A..B`.
    #[serde(default)]
    pub frames: Option<At<Vec<At<String>>>>,
    /// How much is simulated cycle by cycle: every cycle if it is missing.
    #[serde(default)]
    pub detail: Option<At<Value>>,
    /// `key=value` of all points.
    #[serde(default)]
    pub set: Vec<At<String>>,
    /// Expressions over axes; points for which one is true are left out.
    #[serde(default)]
    pub exclude: Vec<At<String>>,
    /// What varies.
    #[serde(default)]
    pub axis: Vec<At<AxisFile>>,
}

/// An axis: `values`, `range` or `log`.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AxisFile {
    /// Name: a letter, then letters, digits and underscores.
    pub name: At<String>,
    /// The key that it sets.
    pub key: Option<At<String>>,
    /// Or several keys, all set to the same value.
    pub keys: Option<At<Vec<At<String>>>>,
    /// The values; or tables `{ name = "small", set = ["key=value", ...] }`.
    pub values: Option<At<Vec<At<Value>>>>,
    /// `{ from, to, step }`, both ends included.
    pub range: Option<At<Span>>,
    /// `{ from, to, factor }`, both ends included.
    pub log: Option<At<Span>>,
    /// Axes of the same `zip` go forward together.
    pub zip: Option<At<String>>,
    /// Machines and policies that it is for; for others it does not vary.
    pub only: Option<At<Vec<At<String>>>>,
}

/// Ends and step of a range.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Span {
    /// The first value: a number, or a size such as "4KiB".
    pub from: At<Value>,
    /// The last value.
    pub to: At<Value>,
    /// Of a range: the step.
    pub step: Option<At<Value>>,
    /// Of a log range: the factor.
    pub factor: Option<At<Value>>,
}

impl PlanFile {
    /// Reads the file.
    ///
    /// # Errors
    /// Not TOML, an unknown or missing key, a value of the wrong kind: with line and column.
    pub fn parse(text: Text<'_>) -> Result<Self> {
        let words = |message: &str| match one_table(message) {
            Some(what) => format!("{what}; write its name in two brackets: `[[axis]]`"),
            None => with_near_key(message),
        };
        toml::from_str(text.text).map_err(|e| text.error(&e.span().unwrap_or(0..0), words(e.message())))
    }
}
