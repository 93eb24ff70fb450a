//! The comparison of two tables.

use serde::Serialize;

use crate::compare::change::{self, Change, ConfigChange, StateChange};
use crate::compare::estimates::Estimates;
use crate::compare::options::Options;
use crate::compare::pairs::Pairs;
use crate::error::Result;
use crate::table::{Results, Role};

/// What changed from A to B.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// Points of A and of B.
    pub points: [usize; 2],
    /// Points of both.
    pub matched: usize,
    /// Columns of figures that were compared.
    pub figures: usize,
    /// Columns of counters that were compared.
    pub counters: usize,
    /// Columns without a change in which values differ, but no further than their estimates may be off.
    pub within: usize,
    /// Points of A alone.
    pub vanished: Vec<String>,
    /// Points of B alone.
    pub appeared: Vec<String>,
    /// Figures and counters of A alone.
    pub columns_vanished: Vec<String>,
    /// Figures and counters of B alone.
    pub columns_appeared: Vec<String>,
    /// Points that are done in one and failed in the other, or failed otherwise.
    pub states: Vec<StateChange>,
    /// Configuration values that changed.
    pub configuration: Vec<ConfigChange>,
    /// Figures and counters that changed, those with the largest relative change first.
    pub results: Vec<Change>,
}

impl Comparison {
    /// Compares two tables.
    ///
    /// # Errors
    /// A column of [`Options::across`] that neither has; a pattern of [`Options::select`] that matches nothing.
    pub fn new(a: &Results, b: &Results, options: &Options) -> Result<Self> {
        options.select.check(&change::comparable(a, b))?;
        let pairs = Pairs::new(a, b, &options.across)?;
        let (columns, [columns_vanished, columns_appeared]) = change::columns(a, b, &options.select);
        let estimates = [a, b].map(Estimates::new);
        let (results, within) = change::results(&columns, &pairs, estimates.each_ref(), options.tolerance);
        Ok(Self {
            points: [a.rows(), b.rows()],
            matched: pairs.both.len(),
            figures: columns.iter().filter(|(_, b)| b.role == Role::Figure).count(),
            counters: columns.iter().filter(|(_, b)| b.role == Role::Counter).count(),
            within,
            vanished: pairs.vanished.clone(),
            appeared: pairs.appeared.clone(),
            columns_vanished,
            columns_appeared,
            states: change::states(a, b, &pairs),
            configuration: change::configuration([a, b], &pairs, options),
            results,
        })
    }

    /// How many columns of a role were compared.
    pub fn columns_of(&self, role: Role) -> usize {
        if role == Role::Figure { self.figures } else { self.counters }
    }

    /// Whether anything did.
    pub fn changed(&self) -> bool {
        let lists = [&self.vanished, &self.appeared, &self.columns_vanished, &self.columns_appeared];
        lists.iter().any(|list| !list.is_empty())
            || !(self.states.is_empty() && self.configuration.is_empty() && self.results.is_empty())
    }
}
