//! Machines by preset name or file, with overrides.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Table;

use super::merge::{self, Layer};
use super::schema::KEYS;
use super::source::Sourced;
use super::{MachineConfig, check};
use crate::error::{MachineError, Result};
use rayreel_settings::near;

macro_rules! presets {
    ($($name:literal)*) => { &[$(($name, include_str!(concat!("../presets/", $name, ".toml"))),)*] };
}

/// The compiled-in presets: name and TOML text.
pub const PRESETS: &[(&str, &str)] = presets! {
    "sgrt-ti2" "sgrt-ti1" "sgrt-ti2-retry" "sgrt-ti2-accumulate" "sgrt-ti2-rob" "sgrt-hybrid-number" "raycore"
    "hybrid-raster" "external-buffers" "no-direct-interface"
};

/// Files that may extend one another in a row.
const CHAIN_MAX: usize = 16;

/// A preset or file in the chain of a machine.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ancestor {
    /// Preset name or file stem.
    pub name: String,
    /// How it differs from the next of the chain, and why.
    pub why: String,
}

/// A machine, what results call it, and where each of its values is from.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMachine {
    /// Preset or file stem, then `+key=value` per override.
    pub name: String,
    /// The preset or file itself, what it extends, and so on to the base.
    pub chain: Vec<Ancestor>,
    /// The values, checked.
    pub config: MachineConfig,
    /// Every value with its class and source, in the order of the structs.
    pub values: Vec<Sourced>,
}

impl NamedMachine {
    /// The machine of a preset, or of a TOML file if `spec` ends in `.toml` or contains a path separator, with each of
    /// `overrides` (`key=value`, dotted key, TOML value; words and sizes need no quotes) applied in order.
    ///
    /// # Errors
    /// An unknown preset, an unreadable file, a circle of `extends`, a key that does not exist or is missing, a value out of
    /// range, values that cannot stand together.
    pub fn load(spec: &str, overrides: &[String]) -> Result<Self> {
        let (chain, values) = inherit(spec)?;
        let origin = chain[0].0.clone();
        Self::resolve(chain.into_iter().map(|(_, ancestor)| ancestor).collect(), values, &origin, overrides)
    }

    /// The machine that [`NamedMachine::to_toml`] wrote, with overrides as in [`NamedMachine::load`].
    ///
    /// # Errors
    /// As there; a key that is missing, for such a text extends nothing.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self> {
        let origin = format!("machine {name}");
        let layer = merge::parse(text, &origin, name)?;
        Self::resolve(vec![Ancestor { name: name.into(), why: layer.why }], layer.values, &origin, overrides)
    }

    fn resolve(chain: Vec<Ancestor>, mut values: Vec<Sourced>, origin: &str, overrides: &[String]) -> Result<Self> {
        let mut name = chain[0].name.clone();
        for text in overrides {
            merge::over(&mut values, vec![merge::parse_override(text)?]);
            name = format!("{name}+{}", text.trim());
        }
        let config = build(&values, origin)?;
        Ok(Self { name, chain, config, values })
    }

    /// A machine file that stands by itself: every value with its class and source, and nothing extended.
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        for own in &self.values {
            let mut leaf = Table::new();
            leaf.insert("value".into(), own.value.clone());
            leaf.insert("class".into(), own.class.name().into());
            leaf.insert("source".into(), own.source.clone().into());
            text += &format!("{} = {}\n", own.key, toml::Value::Table(leaf));
        }
        text
    }

    /// All values as sorted lines `key = value`, sizes in bytes: equal for equal machines, whatever they are called and however
    /// they were put together. Results are stamped with it.
    pub fn canonical(&self) -> String {
        let mut lines: Vec<String> = self.values.iter().map(|v| format!("{} = {}\n", v.key, v.value)).collect();
        lines.sort();
        lines.concat()
    }
}

impl MachineConfig {
    /// Checks a machine that was made by code rather than loaded.
    ///
    /// # Errors
    /// [`MachineError::BadValue`] names key, value and the allowed range; [`MachineError::MachineConflict`] names the values that
    /// cannot stand together.
    pub fn check(&self) -> Result<()> {
        let table = Table::try_from(self).map_err(|e| MachineError::Usage { detail: e.to_string() })?;
        // Bare values are a file without sources.
        merge::parse(&table.to_string(), "machine", "machine")?;
        check::check(self, "machine")
    }
}

/// Presets and files, each with its origin for messages, and extending the next.
type Chain = Vec<(String, Ancestor)>;

/// The chain of `spec`, itself first; and the values of all, later ones over the base's.
fn inherit(spec: &str) -> Result<(Chain, Vec<Sourced>)> {
    let mut chain = Chain::new();
    let mut layers = Vec::new();
    let (mut spec, mut folder) = (spec.to_owned(), PathBuf::new());
    loop {
        let (origin, ancestor, layer) = read(&spec, &mut folder)?;
        let seen = chain.iter().any(|(known, _)| *known == origin);
        chain.push((origin, ancestor));
        if seen || chain.len() > CHAIN_MAX {
            let names: Vec<_> = chain.iter().map(|(origin, _)| origin.as_str()).collect();
            return Err(MachineError::MachineCircle { chain: names.join(" -> "), limit: CHAIN_MAX });
        }
        layers.push(layer.values);
        match layer.extends {
            Some(next) => spec = next,
            None => break,
        }
    }
    let mut values = Vec::new();
    for layer in layers.into_iter().rev() {
        merge::over(&mut values, layer);
    }
    Ok((chain, values))
}

/// One preset or file. A path in `extends` is relative to the `folder` of the file that holds it.
fn read(spec: &str, folder: &mut PathBuf) -> Result<(String, Ancestor, Layer)> {
    let (name, origin, text) = if let Some((name, text)) = PRESETS.iter().find(|(name, _)| *name == spec) {
        ((*name).to_owned(), format!("preset {name}"), (*text).to_owned())
    } else if spec.ends_with(".toml") || spec.contains(['/', '\\']) {
        let path = folder.join(spec);
        let text = std::fs::read_to_string(&path)
            .map_err(|source| MachineError::MachineFile { path: path.clone(), source })?;
        *folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        let name = path.file_stem().map_or_else(|| spec.into(), |stem| stem.to_string_lossy().into_owned());
        (name, path.display().to_string(), text)
    } else {
        let names: Vec<_> = PRESETS.iter().map(|(name, _)| *name).collect();
        return Err(MachineError::UnknownMachine { name: spec.into(), near: near(spec, &names) });
    };
    let layer = merge::parse(&text, &origin, &name)?;
    Ok((origin, Ancestor { name, why: layer.why.clone() }, layer))
}

/// The structs of a whole set of values.
fn build(values: &[Sourced], origin: &str) -> Result<MachineConfig> {
    if let Some(key) = KEYS.iter().find(|k| !values.iter().any(|v| v.key == k.name)) {
        return Err(MachineError::MissingMachineKey { origin: origin.into(), key: key.name });
    }
    let config = MachineConfig::deserialize(merge::nest(values))
        .map_err(|e| MachineError::MachineSyntax { origin: origin.into(), detail: e.to_string() })?;
    check::check(&config, origin)?;
    Ok(config)
}
