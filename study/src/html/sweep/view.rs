//! The results as the sections see them: dimensions, headline results, what a point is in words.

use std::collections::BTreeMap;

use crate::analysis::configs::{Config, Configs, Half};
use crate::analysis::dims::{Dimension, dimensions, label};
use crate::analysis::effects::Effect;
use crate::analysis::goals::{first_pair, headlines, varies, varies_within};
use crate::html::charts::gallery::Gallery;
use crate::html::sweep::number::{number, value};
use crate::table::{Field, Results};

/// Results that are infinite where another column has a value, as where two pictures are identical: their columns have no number
/// there.
pub const INFINITE: [(&str, &str, f64); 4] = [
    ("psnr_db", "identical", 1.0),
    ("worst_frame_psnr_db", "identical", 1.0),
    ("worst_tile_psnr_db", "identical", 1.0),
    ("flicker_db", "flicker", 0.0),
];

/// The key of a policy that no override changes.
const KIND: &str = "kind";

/// Most values of an axis that a heat map has room for.
pub const VALUES_MAX: usize = 64;

/// Results with what several sections look up in them.
pub struct SweepView<'a> {
    /// The results.
    pub results: &'a Results,
    /// What varies.
    pub dimensions: Vec<Dimension>,
    /// The results to show first.
    pub headlines: Vec<&'a Field>,
    /// The results of the first chart.
    pub pair: Option<[&'a str; 2]>,
    /// What best points are best in.
    pub objective: Option<&'a Field>,
    /// The dimension within each value of which points are compared: the trace, because a hard scene is no bad machine.
    pub each: Option<usize>,
    /// Resolved machines and policies.
    pub configs: [Configs; 2],
    /// For each half the values of the presets that the results name; none for a name that is no preset.
    presets: [BTreeMap<String, Option<Config>>; 2],
    /// The charts that were drawn.
    pub charts: Gallery,
}

/// What a point changes of a preset.
#[derive(Default)]
pub struct Changes {
    /// Name of the preset; nothing if the point was made from a file.
    pub preset: Option<String>,
    /// What differs from it.
    pub list: Vec<Changed>,
}

/// A value that a point has.
pub struct Changed {
    /// Its key.
    pub key: String,
    /// Its value.
    pub value: String,
    /// What the preset has, if there is one.
    pub preset: Option<String>,
}

impl<'a> SweepView<'a> {
    /// Looks at results.
    pub fn new(results: &'a Results) -> Self {
        let configs = Half::ALL.map(|half| Configs::new(results, half));
        let whole_gpu = configs[0].varying().iter().any(|key| !key.starts_with("ti."));
        let pair = first_pair(results, whole_gpu);
        let dimensions = dimensions(results);
        let efficiency = results.field("perf_per_watt").filter(|field| varies_within(results, &field.name));
        let whole = results.field("gpu_perf_per_watt").filter(|field| whole_gpu && varies_within(results, &field.name));
        let objective = whole.or(efficiency).or_else(|| results.field(pair?[1]));
        let each = dimensions.iter().position(|dimension| dimension.name == "trace");
        let headlines = headlines(results).into_iter().filter_map(|name| results.field(name)).collect();
        let presets = Half::ALL.map(|half| presets(results, half));
        Self { results, dimensions, headlines, pair, objective, each, configs, presets, charts: Gallery::default() }
    }

    /// How many points could not be computed.
    pub fn failed(&self) -> usize {
        let failed = |row: &usize| self.error(*row).is_some();
        (0..self.results.rows()).filter(failed).count()
    }

    /// Why a point failed.
    pub fn error(&self, row: usize) -> Option<String> {
        let text = |name: &str| self.results.field(name).and_then(|field| field.cells.text(row));
        let failed = text("status").is_some_and(|status| status != "done");
        text("error").or_else(|| failed.then(|| "failed".into()))
    }

    /// The value of a result in a row; infinite where it is of an identical picture.
    pub fn result(&self, field: &Field, row: usize) -> Option<f64> {
        let infinite = || {
            let (_, by, value) = INFINITE.iter().find(|(name, ..)| *name == field.name)?;
            let told = self.results.field(by)?.cells.number(row)?;
            (told == *value).then_some(f64::INFINITY)
        };
        field.cells.number(row).or_else(infinite)
    }

    /// The same for people, without its unit.
    pub fn shown(&self, field: &Field, row: usize) -> String {
        self.result(field, row).filter(|value| value.is_infinite()).map_or_else(|| value(field, row), number)
    }

    /// The results to show first that vary.
    pub fn moved(&self) -> Vec<&'a Field> {
        self.headlines.iter().copied().filter(|field| varies(&field.cells)).collect()
    }

    /// What a dimension does to a result.
    pub fn effect(&self, dimension: &Dimension, result: &Field) -> Option<Effect> {
        let others: Vec<_> = self.dimensions.iter().filter(|other| other.name != dimension.name).collect();
        Effect::new(dimension, &others, |row| self.result(result, row))
    }

    /// The dimensions by their influence on a result, the strongest first.
    pub fn effects(&self, result: &Field) -> Vec<(&Dimension, Effect)> {
        let effects = self.dimensions.iter().filter_map(|dimension| Some((dimension, self.effect(dimension, result)?)));
        let mut effects: Vec<_> = effects.collect();
        effects.sort_by(|a, b| b.1.share().total_cmp(&a.1.share()));
        effects
    }

    /// The dimensions but for the traces, those first that move the second result of the first chart most.
    pub fn strongest(&self) -> Vec<&str> {
        let result = self.pair.and_then(|[_, y]| self.results.field(y));
        let ordered = result.map(|result| self.effects(result)).unwrap_or_default();
        ordered.into_iter().map(|(dimension, _)| dimension.name.as_str()).filter(|name| *name != "trace").collect()
    }

    /// The axes of the first heat map, down and across: those that move the result most, and none with more values than there is room
    /// for as long as there are others.
    pub fn heat_axes(&self) -> Option<[&Dimension; 2]> {
        let named = |name: &str| self.dimensions.iter().find(|dimension| dimension.name == name);
        let mut axes: Vec<&Dimension> = self.strongest().into_iter().filter_map(named).collect();
        let others = self.dimensions.iter().filter(|other| !axes.iter().any(|axis| axis.name == other.name));
        axes.extend(others.collect::<Vec<_>>());
        // The order of those on one side stays.
        axes.sort_by_key(|axis| axis.values.len() > VALUES_MAX);
        Some([axes.first()?, axes.get(1)?])
    }

    /// The dimension that tells points of the first chart apart best: policy, machine, or the axis with the most influence.
    pub fn colour(&self) -> Option<&str> {
        let known =
            |name: &str| self.dimensions.iter().map(|dimension| dimension.name.as_str()).find(|known| *known == name);
        known("policy")
            .or_else(|| known("machine"))
            .or_else(|| self.strongest().first().copied())
            .or_else(|| known("trace"))
    }

    /// Name and rows of each group of points that can be compared: all points, or those of each trace.
    pub fn groups(&self) -> Vec<(String, Vec<usize>)> {
        let rows = 0..self.results.rows();
        let Some(dimension) = self.each.map(|index| &self.dimensions[index]) else {
            return vec![(String::new(), rows.collect())];
        };
        let of = |value: usize| rows.clone().filter(|row| dimension.of[*row] == Some(value)).collect();
        dimension.values.iter().enumerate().map(|(value, label)| (label.clone(), of(value))).collect()
    }

    /// The number of a point in its plan.
    pub fn number(&self, row: usize) -> String {
        self.results.field("point").and_then(|field| field.cells.text(row)).unwrap_or_else(|| row.to_string())
    }

    /// What a point is: its values of the dimensions but for the one of `except`.
    pub fn describe(&self, row: usize, except: Option<usize>) -> String {
        let value = |dimension: &Dimension| {
            dimension.of[row].map(|value| format!("{} {}", dimension.name, dimension.values[value]))
        };
        let dimensions = self.dimensions.iter().enumerate().filter(|(index, _)| Some(*index) != except);
        dimensions.filter_map(|(_, dimension)| value(dimension)).collect::<Vec<_>>().join(", ")
    }

    /// What a point changes of its preset. Of a file, which the page does not have, it is every value that
    /// varies in the sweep.
    pub fn changes(&self, row: usize, half: Half) -> Changes {
        let configs = &self.configs[half as usize];
        let Some(config) = configs.row(row) else { return Changes::default() };
        let name = self.results.field(half.name()).and_then(|field| label(field, row)).unwrap_or_default();
        let changed = |key: &str, preset: Option<&Config>| {
            let preset = preset.and_then(|preset| preset.get(key).cloned());
            Some(Changed { key: key.into(), value: config.get(key)?.clone(), preset })
        };
        match self.known(&name, half).filter(|preset| made_of(config, preset)) {
            Some(preset) => {
                let differs = |key: &&String| preset.get(*key) != config.get(*key);
                let list = config.keys().filter(differs).filter_map(|key| changed(key, Some(preset))).collect();
                Changes { preset: Some(name), list }
            }
            None => Changes {
                preset: None,
                list: configs.varying().into_iter().filter_map(|key| changed(key, None)).collect(),
            },
        }
    }

    /// Whether the point is of a file that has the name of a preset, and not of the preset.
    pub fn is_file_of_known_name(&self, row: usize, half: Half) -> bool {
        let name = self.results.field(half.name()).and_then(|field| label(field, row)).unwrap_or_default();
        let config = self.configs[half as usize].row(row);
        config.zip(self.known(&name, half)).is_some_and(|(config, preset)| !made_of(config, preset))
    }

    /// The preset of a name.
    fn known(&self, name: &str, half: Half) -> Option<&Config> {
        self.presets[half as usize].get(name)?.as_ref()
    }
}

/// Whether overrides lead from a preset to a configuration: a policy file may have the name of a preset of another kind. What the
/// preset has beside is of a later build than the results.
fn made_of(config: &Config, preset: &Config) -> bool {
    config.get(KIND) == preset.get(KIND) && config.keys().all(|key| preset.contains_key(key))
}

/// What the presets of a column of names hold.
fn presets(results: &Results, half: Half) -> BTreeMap<String, Option<Config>> {
    let Some(field) = results.field(half.name()) else { return BTreeMap::new() };
    let mut known = BTreeMap::new();
    for name in (0..results.rows()).filter_map(|row| label(field, row)) {
        known.entry(name).or_insert_with_key(|name| half.preset(name));
    }
    known
}
