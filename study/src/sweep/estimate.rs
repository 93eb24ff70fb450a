//! How long a plan will take, from a look at its first points.

use std::time::{Duration, Instant};

use rayreel_formats::trace::Trace;

use crate::point::compute::compute_row;
use crate::point::tile_cache::{MemoryBudget, TileCache};
use crate::sweep::plan::{Plan, PointRef};
use rayreel_replay::Stop;
use rayreel_replay::source::PathSource;

/// Longest look at a trace.
const LOOK: Duration = Duration::from_millis(700);

/// Most traces that are looked at.
const TRACES: usize = 3;

/// Most points of a trace that are looked at, until one can be computed.
const POINTS: usize = 100;

/// Part of a point that must be done before it is believed.
const PART: f64 = 0.002;

/// Work of a plan in core-seconds of this machine; nothing if no point went far enough in the time.
///
/// Of each of up to three traces the first point that can be computed is begun and, after some 0.7 seconds, left; the others are taken to
/// cost the same per sample of the grid. Good for a shard size, not for a bet: a policy that traces a tenth of the rays costs a fifth of this.
pub fn core_seconds(plan: &Plan, open: &dyn Fn(&str) -> Result<Trace, String>) -> Option<f64> {
    let samples = |p: &PointRef| {
        let trace = &plan.traces[p.trace];
        let (width, height) = trace.size;
        f64::from(width) * f64::from(height) * f64::from(trace.samples * trace.samples) * f64::from(p.frames.1)
    };
    let mut rates = Vec::new();
    for trace in 0..plan.traces.len().min(TRACES) {
        let Ok(opened) = open(&plan.traces[trace].location) else { continue };
        let source = TileCache::new(opened, &MemoryBudget::new(0));
        for point in plan.points.iter().filter(|point| point.trace == trace).take(POINTS) {
            match look(plan, point, &source) {
                // It tells nothing of those that can be.
                Look::NotComputable => {}
                Look::Seconds(seconds) => {
                    rates.push(seconds / samples(point));
                    break;
                }
                Look::TooShort => break,
            }
        }
    }
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    // A point that shares its key with another is computed once.
    let mut keys: Vec<(&String, f64)> = plan.points.iter().map(|point| (&point.key, samples(point))).collect();
    keys.sort_by_key(|(key, _)| *key);
    keys.dedup_by_key(|(key, _)| *key);
    (!rates.is_empty()).then(|| mean * keys.iter().map(|(_, samples)| samples).sum::<f64>())
}

/// What a look at a point tells.
enum Look {
    /// Seconds that it would take.
    Seconds(f64),
    /// Not enough of it was done in the time.
    TooShort,
    /// It ends in an error, such as an adaptive policy on a machine without its kernels.
    NotComputable,
}

fn look(plan: &Plan, point: &PointRef, source: &TileCache) -> Look {
    let Ok(resolved) = plan.resolve(point) else { return Look::NotComputable };
    let (stop, tree) = (Stop::default(), source.topology());
    let (start, mut part) = (Instant::now(), (0.0, 0.0));
    let ended = compute_row(&resolved, &point.key, (source, &tree), &stop, |done, all| {
        part = (done as f64 / all as f64, start.elapsed().as_secs_f64());
        if start.elapsed() > LOOK {
            stop.request();
        }
    });
    match ended {
        Ok((row, _)) if row.error.is_some() => Look::NotComputable,
        Ok(_) => Look::Seconds(start.elapsed().as_secs_f64()),
        Err(_) if part.0 > PART => Look::Seconds(part.1 / part.0),
        Err(_) => Look::TooShort,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::sweep::plan::Sources;
    use crate::sweep::plan::locate::Text;
    use crate::sweep::segment::tests::open;

    /// Its row, which says why, was there in no time, and so was the estimate of the whole plan.
    #[test]
    fn a_point_that_cannot_be_computed_tells_nothing_of_the_others() {
        let trace = concat!(env!("CARGO_MANIFEST_DIR"), "/../traces/v1_0_cornell.rtrace");
        let text = format!("traces = [{trace:?}]\npolicies = [\"adaptive\"]\nmachines = [\"raycore\", \"none\"]\n");
        let text = Text { name: "plan.toml", text: &text };
        let sources = Sources { text, folder: Path::new(""), traces: None, detail: None, stem: "plan", open: &open };
        let plan = Plan::new(&sources).unwrap();
        let source = TileCache::new(open(trace).unwrap(), &MemoryBudget::new(0));
        assert!(matches!(look(&plan, &plan.points[0], &source), Look::NotComputable));
        assert!(matches!(look(&plan, &plan.points[1], &source), Look::Seconds(_)));
        assert!(core_seconds(&plan, &open).is_some());
        let raycore = Plan { points: plan.points[..1].to_vec(), ..plan };
        assert_eq!(core_seconds(&raycore, &open), None);
    }
}
