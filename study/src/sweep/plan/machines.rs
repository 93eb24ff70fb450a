//! The machines of a plan under many overrides: each text is parsed once, and not once a point.

use std::collections::BTreeMap;
use std::thread;

use rayreel_machine::config::{MACHINES, MachineConfig};
use rayreel_settings::Loaded;

use super::Plan;
use crate::error::Result;
use crate::point::key::{machine_json, values_json};

/// Number of a machine, and the overrides of it.
pub(super) type Variant = (usize, Vec<String>);

/// Items to a thread that are worth one.
const SHARE_MIN: usize = 500;

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
        match self.set(variant) {
            Some(loaded) => Ok(values_json(&loaded.values)),
            None => self.slow(variant),
        }
    }

    /// The same of a machine that can be built.
    ///
    /// # Errors
    /// As there, and values that cannot stand together.
    fn checked_json(&self, variant: &Variant) -> Result<String> {
        let sound = |loaded: &Loaded| loaded.build::<MachineConfig>().is_ok_and(|config| config.check().is_ok());
        match self.set(variant).filter(sound) {
            Some(loaded) => Ok(values_json(&loaded.values)),
            None => self.slow(variant),
        }
    }

    /// Without what was parsed: the errors are those of the whole way.
    fn slow(&self, (index, overrides): &Variant) -> Result<String> {
        Ok(self.plan.machine(*index, overrides)?.as_ref().map(machine_json).unwrap_or_default())
    }

    /// [`Self::json`] of all of these, on all cores.
    pub fn all(&self, variants: Vec<Variant>) -> BTreeMap<Variant, Result<String>> {
        let jsons = on_all_cores(&variants, |variant| self.json(variant));
        variants.into_iter().zip(jsons).collect()
    }

    /// [`Self::checked_json`] of all of these, on all cores.
    pub fn all_checked(&self, variants: Vec<Variant>) -> BTreeMap<Variant, Result<String>> {
        let jsons = on_all_cores(&variants, |variant| self.checked_json(variant));
        variants.into_iter().zip(jsons).collect()
    }
}

/// What comes of each item, in their order.
pub(super) fn on_all_cores<T: Sync, R: Send>(items: &[T], make: impl Fn(&T) -> R + Sync) -> Vec<R> {
    let cores = thread::available_parallelism().map_or(1, usize::from);
    let share = items.len().div_ceil(cores).max(SHARE_MIN);
    let some = |part: &[T]| part.iter().map(&make).collect::<Vec<_>>();
    thread::scope(|scope| {
        let threads: Vec<_> = items.chunks(share).map(|part| scope.spawn(|| some(part))).collect();
        let ended = threads.into_iter().map(|thread| thread.join());
        ended.flat_map(|made| made.unwrap_or_else(|panic| std::panic::resume_unwind(panic))).collect()
    })
}
