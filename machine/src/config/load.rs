//! Machines by preset name or file, with overrides.

use rayreel_settings::{Ancestor, Loaded, Sourced, text};
use toml::Table;

use super::schema::MACHINES;
use super::whole::MachineConfig;
use super::{check, prices};
use crate::error::{MachineError, Result};

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
        Self::resolve(MACHINES.load(spec)?, overrides)
    }

    /// The machine that [`NamedMachine::to_toml`] wrote, or any other text of a machine file, with overrides as in
    /// [`NamedMachine::load`].
    ///
    /// # Errors
    /// As there.
    pub fn parse(name: &str, text: &str, overrides: &[String]) -> Result<Self> {
        Self::resolve(MACHINES.parse(name, text)?, overrides)
    }

    fn resolve(mut loaded: Loaded, overrides: &[String]) -> Result<Self> {
        let mut name = loaded.chain[0].name.clone();
        for text in overrides {
            loaded.set(text)?;
            name = format!("{name}+{}", text.trim());
        }
        let config = loaded.build()?;
        check::check(&config)
            .and_then(|()| prices::check(&config, &loaded.values, &loaded.chain))
            .map_err(|found| found.blame(|key| loaded.overridden(key), &loaded.origin))?;
        Ok(Self { name, chain: loaded.chain, config, values: loaded.values })
    }

    /// A machine file that stands by itself: every value with its class and source, and nothing extended.
    pub fn to_toml(&self) -> String {
        text::to_toml(&self.values)
    }

    /// The same for people, table by table, with a head that says how the machine differs from what it extends.
    pub fn page(&self) -> String {
        text::page(&self.name, &self.chain, &self.values, (MACHINES.schema)(""))
    }

    /// All values as sorted lines `key = value`, sizes in bytes: equal for equal machines, whatever they are called and however
    /// they were put together. Results are stamped with it.
    pub fn canonical(&self) -> String {
        text::canonical(&self.values)
    }
}

impl MachineConfig {
    /// Checks a machine that was made by code rather than loaded.
    ///
    /// # Errors
    /// A value out of range, with the name of its key; values that cannot stand together.
    pub fn check(&self) -> Result<()> {
        let table = Table::try_from(self).map_err(|e| MachineError::Usage { detail: e.to_string() })?;
        MACHINES.check(table)?;
        Ok(check::check(self).map_err(|found| found.blame(|_| None, "machine"))?)
    }
}
