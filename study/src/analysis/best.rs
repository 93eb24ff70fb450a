//! The best points for an objective.

use crate::analysis::goals::Goal;

/// Up to `most` of some rows with the best numbers of a result, the best first; of equal ones the first.
pub fn best(number: impl Fn(usize) -> Option<f64>, rows: &[usize], goal: Goal, most: usize) -> Vec<usize> {
    let mut rows: Vec<(usize, f64)> = rows.iter().filter_map(|row| Some((*row, number(*row)?))).collect();
    rows.sort_by(|(_, a), (_, b)| if goal == Goal::Min { a.total_cmp(b) } else { b.total_cmp(a) });
    rows.into_iter().map(|(row, _)| row).take(most).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_best_come_first_and_missing_ones_never() {
        let numbers = [Some(3.0), None, Some(1.0), Some(2.0), Some(3.0)];
        assert_eq!(best(|row| numbers[row], &[0, 1, 2, 3, 4], Goal::Min, 2), [2, 3]);
        assert_eq!(best(|row| numbers[row], &[1, 2, 3, 4], Goal::Max, 9), [4, 3, 2]);
    }
}
