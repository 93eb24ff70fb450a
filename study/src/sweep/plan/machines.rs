//! The machines of a plan under many overrides: each text is parsed once, and not once a point.

use std::collections::BTreeMap;

use rayon::prelude::*;
use rayreel_machine::config::{MACHINES, MachineConfig};
use rayreel_settings::Loaded;

use super::Plan;
use crate::error::Result;
use crate::point::key::{machine_json, values_json};

/// Number of a machine, and the overrides of it.
pub(super) type Variant = (usize, Vec<String>);

/// Points that are resolved at a time: many enough for all cores.
pub(super) const BLOCK: usize = 1 << 11;

/// Machines, or policies, under overrides that are remembered: some 200 MB.
pub(super) const REMEMBERED: usize = 1 << 15;

/// Items that are worth a thread.
const SHARE_MIN: usize = 16;

pub(super) struct Machines<'a> {
    plan: &'a Plan,
    /// By number; none of the machine `none`, and of a text that is no machine.
    parsed: Vec<Option<Loaded>>,
}

impl<'a> Machines<'a> {
    pub fn new(plan: &'a Plan) -> Self {
        let parse = |text: &str, name: &str| if text.is_empty() { None } else { MACHINES.parse(name, text).ok() };
        Self { plan, parsed: plan.machines.iter().map(|base| parse(&base.toml, &base.name)).collect() }
    }

    fn set(&self, (index, overrides): &Variant) -> Option<Loaded> {
        let mut loaded = self.parsed[*index].clone()?;
        overrides.iter().try_for_each(|text| loaded.set(text)).ok()?;
        Some(loaded)
    }

    /// Every value of a machine as keys have it. Whether the values can stand together is not looked at.
    ///
    /// # Errors
    /// An override that is not allowed, a text that is no machine.
    fn json(&self, variant: &Variant) -> Result<String> {
        self.set(variant).map_or_else(|| self.slow(variant), |loaded| Ok(values_json(&loaded.values)))
    }

    /// The same of machines that can be built, on all cores; none of the others, of which [`Self::slow`] says what is wrong.
    pub fn checked(&self, variants: &[Variant]) -> Vec<Option<String>> {
        let sound = |loaded: &Loaded| loaded.build::<MachineConfig>().is_ok_and(|config| config.check().is_ok());
        let json = |variant: &Variant| self.set(variant).filter(sound).map(|loaded| values_json(&loaded.values));
        on_all_cores(variants, json)
    }

    /// Without what was parsed: the errors are those of the whole way.
    ///
    /// # Errors
    /// As [`Self::json`], and values that cannot stand together.
    pub fn slow(&self, (index, overrides): &Variant) -> Result<String> {
        Ok(self.plan.machine(*index, overrides)?.as_ref().map(machine_json).unwrap_or_default())
    }

    /// [`Self::json`] of all of these, on all cores.
    pub fn all(&self, variants: Vec<Variant>) -> BTreeMap<Variant, Result<String>> {
        let jsons = on_all_cores(&variants, |variant| self.json(variant));
        variants.into_iter().zip(jsons).collect()
    }
}

/// What comes of each item, in their order, on all threads that there are for it.
pub(super) fn on_all_cores<T: Sync, R: Send>(items: &[T], make: impl Fn(&T) -> R + Sync + Send) -> Vec<R> {
    items.par_iter().with_min_len(SHARE_MIN).map(make).collect()
}
