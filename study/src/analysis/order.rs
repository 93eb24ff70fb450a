//! In which order policies come, and whether that depends on what else was varied.
//!
//! A policy's gain is its result over that of `full` at the same values of all other dimensions; over several traces the geometric
//! mean. How much was simulated is a dimension as any other: an estimate over what was simulated whole is no gain. A conclusion that holds at one value of an estimate and not at another is none.

use std::collections::{BTreeMap, BTreeSet};

use crate::analysis::dims::{Dimension, dimensions};
use crate::table::{Field, Results};

/// The policy that the others are compared with.
const REFERENCE: &str = "full";

/// Dimensions within each value of which policies are compared, and which gains are averaged over.
const AVERAGED: [&str; 3] = ["trace", "first_frame", "frames"];

/// Most combinations of values: nobody reads a table of more.
const COMBINATIONS_MAX: usize = 1000;

/// The order of the policies, at each combination of the other dimensions.
#[derive(Clone, Debug, PartialEq)]
pub struct PolicyOrder {
    /// The policies, `full` not among them.
    pub policies: Vec<String>,
    /// In the order of the results.
    pub rows: Vec<OrderRow>,
}

/// The order at one combination of values.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OrderRow {
    /// The values.
    pub name: String,
    /// For each policy its gain by trace.
    pub gains: Vec<BTreeMap<String, f64>>,
}

impl OrderRow {
    /// The gain of a policy over those traces of which the gains of all policies are known that have some here: means over different
    /// traces say nothing about an order.
    pub fn mean(&self, policy: usize) -> Option<f64> {
        let known = |trace: &String| self.gains.iter().all(|gains| gains.is_empty() || gains.contains_key(trace));
        let gains: Vec<f64> =
            self.gains[policy].iter().filter(|(trace, _)| known(trace)).map(|(_, gain)| libm::log(*gain)).collect();
        (!gains.is_empty()).then(|| libm::exp(gains.iter().sum::<f64>() / gains.len() as f64))
    }

    /// For each trace the policy that gains most; only traces of which at least two are known.
    pub fn first(&self) -> BTreeMap<&str, usize> {
        let mut first: BTreeMap<&str, (usize, f64, usize)> = BTreeMap::new();
        for (policy, gains) in self.gains.iter().enumerate() {
            for (trace, gain) in gains {
                let best = first.entry(trace).or_insert((policy, *gain, 0));
                best.2 += 1;
                if *gain > best.1 {
                    (best.0, best.1) = (policy, *gain);
                }
            }
        }
        first.into_iter().filter(|(_, best)| best.2 > 1).map(|(trace, best)| (trace, best.0)).collect()
    }
}

impl PolicyOrder {
    /// By a result of which more is better. Nothing where fewer than two policies beside `full`, or nothing else, vary,
    /// or much more than a table can hold.
    pub fn of(results: &Results, field: &Field) -> Option<Self> {
        let all = dimensions(results);
        let of_policy = all.iter().find(|dimension| dimension.name == "policy")?;
        let reference = of_policy.values.iter().position(|policy| policy == REFERENCE)?;
        let varied: Vec<&Dimension> =
            all.iter().filter(|d| d.name != "policy" && !AVERAGED.contains(&&*d.name)).collect();
        if of_policy.values.len() < 3 || varied.is_empty() {
            return None;
        }
        let number = |row: usize| field.cells.number(row).filter(|value| *value > 0.0 && value.is_finite());
        let averaged: Vec<&Dimension> = all.iter().filter(|d| AVERAGED.contains(&&*d.name)).collect();
        // An axis may not apply to a policy, as none of policies does to `full`: its result stands for every value of that axis.
        let fits = |one: usize, row: usize| varied.iter().all(|d| d.of[one].is_none() || d.of[one] == d.of[row]);
        // One trace alone is no dimension.
        let only = results.field("trace").and_then(|field| field.cells.text(0)).unwrap_or_default();
        let trace = |row: usize| if averaged.is_empty() { only.clone() } else { words(&averaged, row) };
        let references = (0..results.rows()).filter(|&row| of_policy.of[row] == Some(reference));
        let references = References::new(&averaged, &varied, references);
        let others: Vec<usize> = (0..of_policy.values.len()).filter(|policy| *policy != reference).collect();
        let mut gains: Vec<(usize, usize, f64)> = Vec::new();
        for row in 0..results.rows() {
            let Some(policy) = others.iter().position(|policy| of_policy.of[row] == Some(*policy)) else { continue };
            let full = references.of(row).and_then(number);
            let Some((value, full)) = number(row).zip(full) else { continue };
            gains.push((row, policy, value / full));
        }
        let mut combinations: Vec<usize> = Vec::new();
        let mut seen = BTreeSet::new();
        combinations.extend(gains.iter().map(|(row, ..)| *row).filter(|row| {
            let values: Vec<Option<usize>> = varied.iter().map(|d| d.of[*row]).collect();
            seen.insert(values)
        }));
        if combinations.len() > COMBINATIONS_MAX {
            return None;
        }
        // A combination of values is a row, unless it leaves open what another says.
        let is_open = |row: &&usize| combinations.iter().any(|other| other != *row && fits(**row, *other));
        let known: Vec<usize> = combinations.iter().filter(|row| !is_open(row)).copied().collect();
        let empty = |row: &usize| OrderRow { name: words(&varied, *row), gains: vec![BTreeMap::new(); others.len()] };
        let mut rows: Vec<OrderRow> = known.iter().map(empty).collect();
        for (row, policy, gain) in gains {
            for (_, of) in known.iter().zip(&mut rows).filter(|(of, _)| fits(row, **of)) {
                of.gains[policy].insert(trace(row), gain);
            }
        }
        let policies = others.iter().map(|policy| of_policy.values[*policy].clone()).collect();
        (rows.len() > 1).then_some(Self { policies, rows })
    }

    /// The traces of a row whose first policy is another than in the first row that has two policies of the trace.
    pub fn changed(&self, row: usize) -> Vec<&str> {
        let base = |trace: &str| self.rows.iter().find_map(|row| row.first().get(trace).copied());
        let differs = |(trace, policy): &(&str, usize)| base(trace).is_some_and(|first| first != *policy);
        self.rows[row].first().into_iter().filter(differs).map(|(trace, _)| trace).collect()
    }

    /// Whether some row has two policies of a trace: otherwise there is no order.
    pub fn compares(&self) -> bool {
        self.rows.iter().any(|row| !row.first().is_empty())
    }
}

/// The results that others are compared with, found by the values that they share with these.
struct References<'a> {
    averaged: &'a [&'a Dimension],
    varied: &'a [&'a Dimension],
    /// By which of the varied dimensions apply, then by values: the first row that has them.
    by_values: BTreeMap<Vec<bool>, BTreeMap<Vec<Option<usize>>, usize>>,
}

impl<'a> References<'a> {
    fn new(averaged: &'a [&'a Dimension], varied: &'a [&'a Dimension], rows: impl Iterator<Item = usize>) -> Self {
        let mut references = Self { averaged, varied, by_values: BTreeMap::new() };
        for row in rows {
            let applies: Vec<bool> = varied.iter().map(|d| d.of[row].is_some()).collect();
            let values = references.values(row, &applies);
            references.by_values.entry(applies).or_default().entry(values).or_insert(row);
        }
        references
    }

    /// The values of a row; of the varied dimensions those that apply.
    fn values(&self, row: usize, applies: &[bool]) -> Vec<Option<usize>> {
        let varied = self.varied.iter().zip(applies).map(|(d, applies)| d.of[row].filter(|_| *applies));
        self.averaged.iter().map(|d| d.of[row]).chain(varied).collect()
    }

    /// The first that a row is compared with.
    fn of(&self, row: usize) -> Option<usize> {
        let found =
            |(applies, known): (&Vec<bool>, &BTreeMap<_, usize>)| known.get(&self.values(row, applies)).copied();
        self.by_values.iter().filter_map(found).min()
    }
}

/// The values of a row, in words.
fn words(dimensions: &[&Dimension], row: usize) -> String {
    let values: Vec<&str> = dimensions.iter().filter_map(|d| Some(d.values[d.of[row]?].as_str())).collect();
    values.join(", ")
}

#[cfg(test)]
mod tests {
    use super::super::tables::{axis, figure, table, words};
    use super::*;
    use crate::table::{Cells, Role};

    /// Three policies on two traces at two sizes of a cache; `full` has no angle.
    fn results() -> Results {
        let (mut trace, mut policy, mut size, mut angle, mut value) = (vec![], vec![], vec![], vec![], vec![]);
        for (l2, gains) in [(64, [[2.0, 3.0], [4.0, 3.5]]), (256, [[2.0, 3.0], [4.0, 5.0]])] {
            for (name, gains) in ["a", "b"].into_iter().zip(gains) {
                for (number, of) in ["full", "x", "y"].into_iter().enumerate() {
                    trace.push(name);
                    policy.push(of);
                    size.push(Some(l2));
                    angle.push((number > 0).then_some(10));
                    value.push(if number == 0 { 7.0 } else { 7.0 * gains[number - 1] });
                }
            }
        }
        table(vec![
            words("trace", Role::Point, &trace),
            words("policy", Role::Point, &policy),
            axis("l2", Cells::Int(size)),
            axis("angle", Cells::Int(angle)),
            figure("perf_per_watt", &value),
        ])
    }

    #[test]
    fn gains_are_those_over_full_at_the_same_values() {
        let results = results();
        let order = PolicyOrder::of(&results, results.field("perf_per_watt").unwrap()).unwrap();
        assert_eq!(order.policies, ["x", "y"]);
        assert_eq!(order.rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["64", "256"]);
        let mean = order.rows[0].mean(0).unwrap();
        assert!((mean - 8.0_f64.sqrt()).abs() < 1e-12, "{mean}");
        assert_eq!(order.rows[0].first(), BTreeMap::from([("a", 1), ("b", 0)]));
        assert_eq!(order.rows[1].first(), BTreeMap::from([("a", 1), ("b", 1)]));
        assert_eq!((order.changed(0), order.changed(1)), (vec![], vec!["b"]));
    }

    #[test]
    fn gains_are_those_of_one_detail() {
        let policies = ["full", "x", "y", "full", "x", "y", "x"];
        let details = ["full", "full", "full", "5%", "5%", "5%", "2%"];
        let results = table(vec![
            words("policy", Role::Point, &policies),
            words("detail", Role::Point, &details),
            figure("perf_per_watt", &[1.0, 2.0, 3.0, 2.0, 6.0, 8.0, 9.0]),
        ]);
        let order = PolicyOrder::of(&results, results.field("perf_per_watt").unwrap()).unwrap();
        let gains = order.rows.iter().map(|row| (row.name.as_str(), row.gains.clone())).collect::<Vec<_>>();
        let of = |gain| BTreeMap::from([(String::new(), gain)]);
        // At 2 % there is no `full` to compare with.
        assert_eq!(gains, [("full", vec![of(2.0), of(3.0)]), ("5%", vec![of(3.0), of(4.0)])]);
    }

    #[test]
    fn one_policy_has_no_order() {
        let mut results = results();
        results.fields.remove(1);
        let field = results.field("perf_per_watt").unwrap();
        assert_eq!(PolicyOrder::of(&results, field), None);
    }

    /// Each policy has an axis of its own, and one has none: its result stands in all rows.
    #[test]
    fn what_an_axis_is_not_for_is_compared_at_all_of_its_values() {
        let angle = |values: &[Option<i64>]| axis("angle", Cells::Int(values.to_vec()));
        let results = table(vec![
            words("policy", Role::Point, &["full", "x", "y", "y"]),
            angle(&[None, None, Some(5), Some(10)]),
            figure("perf_per_watt", &[1.0, 2.0, 1.5, 3.0]),
        ]);
        let order = PolicyOrder::of(&results, results.field("perf_per_watt").unwrap()).unwrap();
        assert_eq!(order.rows.iter().map(|row| row.name.as_str()).collect::<Vec<_>>(), ["5", "10"]);
        assert_eq!(order.rows[0].first(), BTreeMap::from([("", 0)]));
        assert_eq!((order.compares(), order.changed(1)), (true, vec![""]));
        // With no policy beside it nothing is compared, and no order was found to be the same.
        let apart = table(vec![
            words("policy", Role::Point, &["full", "x", "y"]),
            angle(&[None, Some(5), Some(10)]),
            figure("perf_per_watt", &[1.0, 2.0, 3.0]),
        ]);
        let order = PolicyOrder::of(&apart, apart.field("perf_per_watt").unwrap()).unwrap();
        assert!(order.rows.len() == 2 && !order.compares());
    }

    #[test]
    fn means_are_over_the_same_traces() {
        let gains = [[("a", 2.0), ("b", 8.0)].as_slice(), &[("a", 3.0)], &[]];
        let of = |gains: &&[(&str, f64)]| gains.iter().map(|(trace, gain)| ((*trace).to_owned(), *gain)).collect();
        let row = OrderRow { name: String::new(), gains: gains.iter().map(of).collect() };
        let means = [0, 1, 2].map(|policy| row.mean(policy).map(|mean| (mean * 1e6).round() * 1e-6));
        assert_eq!(means, [Some(2.0), Some(3.0), None], "b is not known of both");
    }
}
