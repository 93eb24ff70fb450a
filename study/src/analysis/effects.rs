//! Main effects: how much an axis moves a result when everything else is averaged.
//!
//! Values of an axis are compared like with like: over points whose partners, which differ in that axis alone, are all there. Where a plan
//! leaves out large caches with many units, large caches would have few units for company, and look better than they are. The largest set of
//! values that stand together is compared; others, as a machine with an axis of its own, are left out. Axes that go forward together have one
//! effect, whichever it is.

use std::collections::{BTreeMap, BTreeSet};

use crate::analysis::dims::Dimension;

/// What a dimension does to a result.
#[derive(Clone, Debug, PartialEq)]
pub struct Effect {
    /// Mean of the result at each value of the dimension; none where no point has it.
    pub means: Vec<Option<f64>>,
    /// Mean over all points that have a value of the dimension.
    pub overall: f64,
    /// The values with the least and the most mean.
    pub ends: [usize; 2],
    /// Points that the means are of.
    pub points: usize,
    /// Whether these are fewer than all.
    pub in_part: bool,
    /// Values of the dimension that are known and not compared.
    pub left_out: usize,
    /// Dimensions that go forward together with this one, so that nobody can tell their effects apart.
    pub together: Vec<String>,
}

impl Effect {
    /// The effect over the rows that have a value of the dimension and a number, which `result` gives; none where fewer than two values
    /// have partners. Partners are the same in all `others` but those that go forward together with the dimension.
    pub fn new(dimension: &Dimension, others: &[&Dimension], result: impl Fn(usize) -> Option<f64>) -> Option<Self> {
        let rows = dimension.of.iter().enumerate().filter_map(|(row, value)| Some((row, (*value)?, result(row)?)));
        let (together, others): (Vec<&Dimension>, Vec<&Dimension>) =
            others.iter().partition(|other| other.follows(dimension) && dimension.follows(other));
        let mut groups: BTreeMap<Vec<Option<usize>>, Vec<(usize, f64)>> = BTreeMap::new();
        for (row, value, number) in rows {
            // No mean has a number without an end, as the PSNR of equal pictures.
            if !number.is_finite() {
                continue;
            }
            groups.entry(others.iter().map(|other| other.of[row]).collect()).or_default().push((value, number));
        }
        let values = |group: &[(usize, f64)]| group.iter().map(|(value, _)| *value).collect::<BTreeSet<_>>();
        let sets: Vec<BTreeSet<usize>> = groups.values().map(|group| values(group)).collect();
        let all = sets.iter().flatten().collect::<BTreeSet<_>>().len();
        let compared = partners(&sets);
        let mut sums = vec![(0.0, 0_u32); dimension.values.len()];
        let whole = groups.values().zip(&sets).filter(|(_, set)| Some(*set) == compared);
        for (value, number) in whole.flat_map(|(group, _)| group) {
            sums[*value].0 += number;
            sums[*value].1 += 1;
        }
        let mean = |(sum, count): &(f64, u32)| (*count > 0).then(|| sum / f64::from(*count));
        let means: Vec<Option<f64>> = sums.iter().map(mean).collect();
        let (sum, count) = sums.iter().fold((0.0, 0), |all, one| (all.0 + one.0, all.1 + one.1));
        let known = || means.iter().enumerate().filter_map(|(value, mean)| Some((value, (*mean)?)));
        // The first of equal ones, so that the page is the same every time.
        let least = known().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let most = known().rev().max_by(|a, b| a.1.total_cmp(&b.1))?.0;
        let (overall, points) = (sum / f64::from(count), count as usize);
        let several = known().count() > 1;
        let in_part = points < groups.values().map(Vec::len).sum();
        let left_out = all - compared.map_or(0, BTreeSet::len);
        let together = together.into_iter().map(|other| other.name.clone()).collect();
        several.then_some(Self { overall, ends: [least, most], means, points, in_part, left_out, together })
    }

    /// How far a mean lies from the mean over all, as a share of that. Where the mean over all is 0, as that of -5 and 5, it is a
    /// share of the mean magnitude of the means; 0 where they all are 0.
    pub fn relative(&self, mean: f64) -> f64 {
        let magnitude = || {
            let known = || self.means.iter().flatten();
            known().map(|mean| mean.abs()).sum::<f64>() / known().count().max(1) as f64
        };
        let whole = if self.overall == 0.0 { magnitude() } else { self.overall.abs() };
        if whole == 0.0 { 0.0 } else { (mean - self.overall) / whole }
    }

    /// How far an end lies from the mean over all ([`Self::relative`]).
    pub fn end(&self, end: usize) -> f64 {
        self.relative(self.means[self.ends[end]].unwrap_or(self.overall))
    }

    /// The distance of the ends, as a share of the same.
    pub fn share(&self) -> f64 {
        self.end(1) - self.end(0)
    }
}

/// The values that are compared: of the sets that groups of partners have, the largest; of those of one size that which most groups have; of
/// those the first.
fn partners(sets: &[BTreeSet<usize>]) -> Option<&BTreeSet<usize>> {
    let mut groups: BTreeMap<&BTreeSet<usize>, usize> = BTreeMap::new();
    sets.iter().for_each(|set| *groups.entry(set).or_default() += 1);
    // The last of equal ones would be taken.
    groups.into_iter().rev().max_by_key(|(set, groups)| (set.len(), *groups)).map(|(set, _)| set)
}

#[cfg(test)]
mod tests {
    use super::super::tables::{axis, figure};
    use super::*;
    use crate::table::Cells;

    fn effect_of(dimension: &Dimension, cells: &Cells) -> Option<Effect> {
        Effect::new(dimension, &[], |row| cells.number(row))
    }

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() < 1e-12, "{a} is not {b}");
    }

    /// time = 10 a + b over all pairs of a in 1, 2, 3 and b in 0, 4: the means over b are 12, 22, 32, those over a 20 and 24, and
    /// the mean of all is 22.
    #[test]
    fn of_a_sum_it_is_the_part_of_each_axis() {
        let pairs: Vec<(i64, i64)> = [1, 2, 3].into_iter().flat_map(|a| [(a, 0), (a, 4)]).collect();
        let column = |name: &str, of: fn(&(i64, i64)) -> i64| {
            axis(name, Cells::Int(pairs.iter().map(|p| Some(of(p))).collect()))
        };
        let (a, b) = (Dimension::new(&column("a", |p| p.0)), Dimension::new(&column("b", |p| p.1)));
        let time = Cells::Float(pairs.iter().map(|(a, b)| Some((10 * a + b) as f64)).collect());
        let effect = effect_of(&a, &time).unwrap();
        assert_eq!(effect.means, [Some(12.0), Some(22.0), Some(32.0)]);
        assert_eq!((effect.overall, effect.ends), (22.0, [0, 2]));
        close(effect.share(), 20.0 / 22.0);
        close(effect.end(0), -10.0 / 22.0);
        close(effect_of(&b, &time).unwrap().share(), 4.0 / 22.0);
        // An axis that changes nothing.
        close(effect_of(&a, &Cells::Float(vec![Some(5.0); 6])).unwrap().share(), 0.0);
    }

    /// time = a + 100 b over pairs of a in 1, 2, 3 and b in 0, 1, but for 3 with 1: averaged over what is there 3 would look best.
    #[test]
    fn values_are_compared_like_with_like() {
        let pairs = [(1, 0), (2, 0), (3, 0), (1, 1), (2, 1)];
        let column = |name: &str, of: fn(&(i64, i64)) -> i64| {
            Dimension::new(&axis(name, Cells::Int(pairs.iter().map(|p| Some(of(p))).collect())))
        };
        let (a, b) = (column("a", |p| p.0), column("b", |p| p.1));
        let time = |row: usize| Some((pairs[row].0 + 100 * pairs[row].1) as f64);
        let effect = Effect::new(&a, &[&b], time).unwrap();
        assert_eq!((effect.means.as_slice(), effect.overall), (&[Some(1.0), Some(2.0), Some(3.0)][..], 2.0));
        assert_eq!((effect.points, effect.in_part, effect.left_out, effect.ends), (3, true, 0, [0, 2]));
        let effect = Effect::new(&b, &[&a], time).unwrap();
        assert_eq!((effect.means.as_slice(), effect.points), (&[Some(1.5), Some(101.5)][..], 4));
        // Another axis that goes forward with it is no company.
        let zipped = Dimension { name: "zipped".into(), ..a.clone() };
        let effect = Effect::new(&a, &[&b, &zipped], time).unwrap();
        assert_eq!((effect.points, effect.together.as_slice()), (3, &["zipped".to_owned()][..]));
        // Of points that all differ in more than one axis nothing can be told.
        let each = Dimension { name: "each".into(), of: (0..5).map(Some).collect(), ..a.clone() };
        assert_eq!(Effect::new(&a, &[&each], time), None);
        // A value that is nowhere known is no partner that one could have.
        let effect = Effect::new(&a, &[&b], |row| time(row).filter(|_| pairs[row].0 < 3)).unwrap();
        assert_eq!((effect.means.as_slice(), effect.in_part), (&[Some(51.0), Some(52.0), None][..], false));
    }

    /// Machines 0, 1 and 2, of which 2 has an axis of its own; time = 10 machine + 100 axis. Means over what is there made it the slowest.
    #[test]
    fn a_value_with_an_axis_of_its_own_has_no_partners() {
        let points: [(usize, Option<usize>); 6] =
            [(0, None), (1, None), (2, Some(0)), (2, Some(1)), (2, Some(2)), (2, Some(3))];
        let column = |name: &str, of: fn(&(usize, Option<usize>)) -> Option<usize>| {
            Dimension::new(&axis(name, Cells::Int(points.iter().map(|p| of(p).map(|v| v as i64)).collect())))
        };
        let (machine, of_one) = (column("machine", |p| Some(p.0)), column("axis", |p| p.1));
        let time = |row: usize| Some((10 * points[row].0 + 100 * points[row].1.unwrap_or(0)) as f64);
        let effect = Effect::new(&machine, &[&of_one], time).unwrap();
        assert_eq!(effect.means, [Some(0.0), Some(10.0), None]);
        assert_eq!((effect.points, effect.in_part, effect.left_out), (2, true, 1));
        assert_eq!(Effect::new(&of_one, &[&machine], time).unwrap().points, 4);
    }

    /// These were "no change".
    #[test]
    fn around_zero_it_is_a_share_of_the_magnitude() {
        let a = Dimension::new(&axis("a", Cells::Int(vec![Some(1), Some(2)])));
        let effect = effect_of(&a, &Cells::Float(vec![Some(-5.0), Some(5.0)])).unwrap();
        assert_eq!(effect.overall, 0.0);
        close(effect.end(0), -1.0);
        close(effect.share(), 2.0);
        close(effect_of(&a, &Cells::Float(vec![Some(0.0); 2])).unwrap().share(), 0.0);
    }

    #[test]
    fn points_without_a_value_do_not_count() {
        let a = Dimension::new(&axis("a", Cells::Int(vec![Some(1), Some(2), None, Some(1)])));
        let effect = effect_of(&a, &Cells::Float(vec![Some(2.0), Some(6.0), Some(1e9), None])).unwrap();
        assert_eq!((effect.overall, effect.means.as_slice()), (4.0, &[Some(2.0), Some(6.0)][..]));
        close(effect.share(), 1.0);
        assert_eq!(effect_of(&a, &Cells::Float(vec![Some(2.0), None, None, None])), None, "one value is no axis");
        let endless = [Some(2.0), Some(6.0), Some(f64::INFINITY), Some(f64::INFINITY)];
        let effect = effect_of(&a, &Cells::Float(endless.to_vec())).unwrap();
        assert_eq!((effect.overall, effect.points), (4.0, 2));
        assert_eq!(effect_of(&a, &figure("none", &[f64::NAN; 4]).cells), None);
    }
}
