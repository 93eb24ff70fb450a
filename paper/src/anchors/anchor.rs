//! What an anchor is: a figure that a publication or an estimate puts between two bounds, and how it is measured here.

use rayreel_machine::MachineConfig;

use rayreel_study::point::figures::RowFigures;

/// A figure with bounds. One anchor may have several rows: one a machine or one a scene.
#[derive(Debug)]
pub struct Anchor {
    /// What it is.
    pub name: &'static str,
    /// Where the bounds are from, and how they follow.
    pub source: &'static str,
    /// Unit of bounds and value.
    pub unit: &'static str,
    /// Least value inside; none if there is no lower bound.
    pub low: Option<f64>,
    /// Largest value inside; none if there is no upper bound.
    pub high: Option<f64>,
    /// Its rows.
    pub rows: Rows,
    /// How a row is measured.
    pub value: Value,
    /// Why values lie outside.
    pub why: &'static [Why],
}

/// The rows of an anchor.
#[derive(Debug)]
pub enum Rows {
    /// One, of all scenes together, on a machine or on none.
    One(Option<&'static str>),
    /// One for each of these machines, of all scenes together.
    Machines(&'static [&'static str]),
    /// One for each of these scenes, on a machine.
    Scenes(&'static str, &'static [&'static str]),
}

/// How a value is made.
#[derive(Debug)]
pub enum Value {
    /// From the configuration of the row's machine, and from that of the base.
    Config(fn(&MachineConfig, &MachineConfig) -> Option<f64>),
    /// From runs: those of each [`Of`], scene by scene in the same order.
    Runs(&'static [Of], fn(&[Vec<RowFigures<'_>>]) -> Option<f64>),
}

/// What is replayed for a value.
#[derive(Clone, Copy, Debug)]
pub struct Of {
    /// The policy.
    pub policy: &'static str,
    /// Samples per pixel and axis.
    pub samples: u32,
    /// The machine.
    pub on: On,
}

/// What a replay runs on.
#[derive(Clone, Copy, Debug)]
pub enum On {
    /// The machine of the row.
    Row,
    /// The T&I units of the row's machine alone: its SRP takes no time.
    Alone,
    /// Another preset.
    Preset(&'static str),
    /// None: rays and pictures only.
    Nothing,
}

/// Why values of an anchor lie outside its bounds. Each side has its text, so that a value that changes sides is noticed.
#[derive(Debug)]
pub struct Why {
    /// The machines or scenes that it is said of; all that no other names, if empty.
    pub of: &'static [&'static str],
    /// Below the lower bound; empty if nothing is known to lie there.
    pub below: &'static str,
    /// Above the upper bound.
    pub above: &'static str,
}

/// The five scenes of the paper.
pub const SCENES: &[&str] = &["teapot", "chess", "car", "lab", "provence"];

/// A row of an anchor.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// The anchor.
    pub anchor: &'static Anchor,
    /// Its machine.
    pub machine: Option<&'static str>,
    /// Its scene; all if there is none.
    pub scene: Option<&'static str>,
}

impl Anchor {
    /// Its rows, in order.
    pub fn rows(&'static self) -> Vec<Row> {
        let row = |machine, scene| Row { anchor: self, machine, scene };
        match &self.rows {
            Rows::One(machine) => vec![row(*machine, None)],
            Rows::Machines(machines) => machines.iter().map(|machine| row(Some(*machine), None)).collect(),
            Rows::Scenes(machine, scenes) => scenes.iter().map(|scene| row(Some(*machine), Some(*scene))).collect(),
        }
    }

    /// Whether a value lies within the bounds.
    pub fn holds(&self, value: f64) -> bool {
        self.low.is_none_or(|low| value >= low) && self.high.is_none_or(|high| value <= high)
    }
}

impl Row {
    /// The scenes that it is measured on.
    pub fn scenes(&self) -> Vec<&'static str> {
        self.scene.map_or_else(|| SCENES.to_vec(), |scene| vec![scene])
    }

    /// Why a value lies outside, if that is known.
    pub fn explanation(&self, value: f64) -> Option<&'static str> {
        let names = |why: &&Why| [self.machine, self.scene].iter().flatten().any(|name| why.of.contains(name));
        let all = &self.anchor.why;
        let why = all.iter().find(names).or_else(|| all.iter().find(|why| why.of.is_empty()))?;
        let text = if self.anchor.low.is_some_and(|low| value < low) { why.below } else { why.above };
        (!text.is_empty()).then_some(text)
    }
}
