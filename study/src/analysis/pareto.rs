//! Points that no other beats.

use crate::analysis::goals::Goal;

/// Which points no other beats: none is at least as good in both values and better in one. Points without both values are beaten.
/// Equal points are on the front together.
pub fn front(points: &[Option<[f64; 2]>], goals: [Goal; 2]) -> Vec<bool> {
    // From here on, less is better.
    let sign = goals.map(|goal| if goal == Goal::Max { -1.0 } else { 1.0 });
    let signed = |row: usize| points[row].map(|[x, y]| [sign[0] * x, sign[1] * y]);
    let mut order: Vec<(usize, [f64; 2])> = (0..points.len()).filter_map(|row| Some((row, signed(row)?))).collect();
    order.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let mut on = vec![false; points.len()];
    let mut last: Option<[f64; 2]> = None;
    for (row, [x, y]) in order {
        if last.is_none_or(|[best_x, best_y]| y < best_y || (y == best_y && x == best_x)) {
            on[row] = true;
            last = Some([x, y]);
        }
    }
    on
}

#[cfg(test)]
mod tests {
    use rayreel_testkit::Random;

    use super::*;

    #[test]
    fn a_front_worked_out_by_hand() {
        // Cost and loss: (1,9), (2,5) and (4,1) are on it; (2,6) loses to (2,5), (3,5) too, (9,1) to (4,1).
        let points = [[1.0, 9.0], [2.0, 6.0], [2.0, 5.0], [3.0, 5.0], [4.0, 1.0], [9.0, 1.0]].map(Some);
        assert_eq!(front(&points, [Goal::Min, Goal::Min]), [true, false, true, false, true, false]);
        // More cost and less loss: (9,1) alone.
        assert_eq!(front(&points, [Goal::Max, Goal::Min]), [false, false, false, false, false, true]);
        // More of both: (1,9), (2,6), (3,5), (9,1).
        assert_eq!(front(&points, [Goal::Max, Goal::Max]), [true, true, false, true, false, true]);
    }

    #[test]
    fn equal_points_stand_together_and_missing_ones_nowhere() {
        let points = [Some([1.0, 1.0]), None, Some([1.0, 1.0]), Some([1.0, 2.0])];
        assert_eq!(front(&points, [Goal::Min, Goal::Min]), [true, false, true, false]);
        // An identical picture has an infinite PSNR.
        let points = [Some([f64::INFINITY, 5.0]), Some([40.0, 5.0]), Some([30.0, 1.0])];
        assert_eq!(front(&points, [Goal::Max, Goal::Min]), [true, false, true]);
        assert!(front(&[], [Goal::Min, Goal::Min]).is_empty());
    }

    /// Against the definition, word by word.
    #[test]
    fn it_is_what_its_definition_says() {
        let mut random = Random(7);
        for _ in 0..200 {
            let mut point = |_| Some([random.below(32), random.below(32)].map(f64::from));
            let points: Vec<Option<[f64; 2]>> = (0..20).map(&mut point).collect();
            let beaten = |point: [f64; 2]| {
                points
                    .iter()
                    .flatten()
                    .any(|[x, y]| *x <= point[0] && *y >= point[1] && (*x < point[0] || *y > point[1]))
            };
            let wanted: Vec<bool> = points.iter().flatten().map(|point| !beaten(*point)).collect();
            assert_eq!(front(&points, [Goal::Min, Goal::Max]), wanted, "{points:?}");
        }
    }
}
