//! Means over scenes, and how far they may be off.

use rayreel_replay::detail::FLOOR;

/// The geometric mean; nothing without values or where one is missing or not positive.
pub fn geometric_mean(values: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let logs: Option<Vec<f64>> = values.map(|v| v.filter(|v| *v > 0.0).map(libm::log)).collect();
    let logs = logs.filter(|logs| !logs.is_empty())?;
    Some(libm::exp(logs.iter().sum::<f64>() / logs.len() as f64))
}

/// How far a geometric mean of factors may be off that are off by so much each, independently; nothing if all are exact. It is at least
/// [`FLOOR`] for the part of them that is estimated: what makes up that is no chance that a mean would take away.
pub fn mean_interval(intervals: impl Iterator<Item = Option<f64>>) -> Option<f64> {
    let (squares, estimated, count) = intervals.fold((0.0, 0_u32, 0_u32), |(squares, estimated, count), interval| {
        let part = interval.unwrap_or(0.0);
        (squares + part * part, estimated + u32::from(part > 0.0), count + 1)
    });
    let part = f64::from(estimated) / f64::from(count.max(1));
    (squares > 0.0).then(|| (squares.sqrt() / f64::from(count)).max(FLOOR * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_known_no_better_than_windows_tell() {
        let near = |a: Option<f64>, b: f64| (a.unwrap() - b).abs() < 1e-12;
        assert_eq!(mean_interval([None, None].into_iter()), None, "all exact");
        assert!(near(mean_interval([Some(0.03), Some(0.04)].into_iter()), 0.025), "independent");
        assert!(near(mean_interval([Some(FLOOR); 5].into_iter()), FLOOR), "all at the least");
        assert!(near(mean_interval([Some(FLOOR), None].into_iter()), FLOOR / 2.0), "a half is exact");
    }
}
