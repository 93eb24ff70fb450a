//! Which figures of the study are estimates, and how far they may be off.

use rayreel_replay::Detail;
use rayreel_replay::detail::WHY_WHOLE;
use rayreel_study::schema::{Gain, Point};

use crate::setup::{self, Setup};

/// A sentence for readers; nothing without a machine, or if every cycle was simulated.
pub fn note(setup: &Setup, points: &[Point]) -> Option<String> {
    setup.machines.as_ref()?;
    let what = match setup.detail {
        Detail::Full | Detail::Counts => return None,
        Detail::All => "of windows of tiles, all of them, side by side".to_owned(),
        Detail::Sampled(share) => format!("of windows with {} % of the tiles", 100.0 * share.fraction()),
        Detail::Precision(share) => {
            format!("of as many windows of tiles as give cycles and energy to {} %", 100.0 * share.fraction())
        }
    };
    let (simulated, estimated) = counted(points);
    if estimated == 0 {
        let asked = if setup.detail == setup::detail() { "is the default" } else { "was asked for" };
        return Some(format!("Every cycle of the points was simulated, though {} {asked}: {WHY_WHOLE}.", setup.detail));
    }
    let mut note = format!(
        "Cycles, power, energy and gains of {estimated} of {simulated} points are estimates from simulations {what}; rays, samples \
         and pictures are exact. What stands behind ± is half the width of a 95 % interval."
    );
    let widths = |of: fn(&Point) -> Option<Gain>| {
        let mut all: Vec<f64> = points.iter().filter_map(|p| Some(of(p)?.interval?.perf_per_watt)).collect();
        all.sort_by(f64::total_cmp);
        Some((*all.get(all.len() / 2)?, *all.last()?))
    };
    for (part, of) in
        [("T&I units alone", (|p| p.ti_gain) as fn(&Point) -> Option<Gain>), ("whole GPU", |p| p.gpu_gain)]
    {
        if let Some((median, most)) = widths(of) {
            let [median, most] = [median, most].map(|part| 100.0 * part);
            note += &format!(
                " Of gains in performance per watt, {part}, that is {median:.1} % in the middle and {most:.1} % at most."
            );
        }
    }
    Some(note)
}

/// Points with a cost, and those of them whose cost is an estimate.
fn counted(points: &[Point]) -> (usize, usize) {
    let costs = |p: &Point| [p.ti, p.gpu].into_iter().flatten().collect::<Vec<_>>();
    let simulated = points.iter().filter(|p| !costs(p).is_empty()).count();
    let estimated = points.iter().filter(|p| costs(p).iter().any(|cost| cost.interval.is_some())).count();
    (simulated, estimated)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup::Machines;

    #[test]
    fn nobody_is_said_to_have_asked_for_the_default() {
        let machines = Machines::load("sgrt-ti2", false).unwrap();
        let mut setup = Setup::new([rayreel_scenes::load("cornell").unwrap()], Some(machines)).unwrap();
        let said = |setup: &Setup| note(setup, &[]).unwrap();
        assert!(said(&setup).contains("though 0.05 is the default: "), "{}", said(&setup));
        setup.detail = Detail::Sampled(rayreel_replay::detail::Share::from_millionths(100_000).unwrap());
        assert!(said(&setup).contains("though 0.1 was asked for: "), "{}", said(&setup));
    }
}
