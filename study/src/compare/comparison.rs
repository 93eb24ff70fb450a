//! The comparison of two tables.

use serde::Serialize;

use crate::compare::change::{self, Change, ConfigChange, StateChange};
use crate::compare::estimates::Estimates;
use crate::compare::options::Options;
use crate::compare::pairs::Pairs;
use crate::error::{Result, StudyError};
use crate::table::{Field, Results, Role};

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

/// Refuses to compare what has no value anywhere: it would be called equal, and a gate would let everything pass.
fn check_values<'a>(tables: [&Results; 2], taken: impl Iterator<Item = &'a String>, pairs: &Pairs) -> Result<()> {
    let taken: Vec<&String> = taken.collect();
    let fields = |name: &str| tables.map(|table| table.field(name));
    let is_result =
        |name: &str| fields(name).into_iter().flatten().any(|field| matches!(field.role, Role::Figure | Role::Counter));
    let has_value = |name: &str| {
        let [a, b] = fields(name);
        let known = |field: Option<&Field>, row: usize| field.is_some_and(|field| field.cells.number(row).is_some());
        pairs.both.iter().any(|(row_a, row_b, _)| known(a, *row_a) || known(b, *row_b))
    };
    if pairs.both.is_empty() || taken.iter().any(|name| !is_result(name) || has_value(name)) {
        return Ok(());
    }
    let detail = match taken.as_slice() {
        [] => "nothing is left to compare: --ignore leaves out all of it".to_owned(),
        [one] => format!("{one} has no value at any point of both: there is nothing to compare"),
        [first, ..] => format!(
            "none of {} columns, such as {first}, has a value at any point of both: there is nothing to compare",
            taken.len()
        ),
    };
    Err(StudyError::Usage { detail })
}

impl Comparison {
    /// Compares two tables.
    ///
    /// # Errors
    /// A column of [`Options::across`] that neither has; a pattern of [`Options::select`] that matches nothing, or patterns that leave
    /// nothing to compare.
    pub fn new(a: &Results, b: &Results, options: &Options) -> Result<Self> {
        let names = change::comparable(a, b);
        options.select.check(&names)?;
        let pairs = Pairs::new(a, b, &options.across)?;
        check_values([a, b], names.iter().filter(|name| options.select.takes(name)), &pairs)?;
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
