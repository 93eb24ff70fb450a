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

/// Part of a point that must be done before it is believed.
const PART: f64 = 0.002;

/// Work of a plan in core-seconds of this machine; nothing if no point went far enough in the time.
///
/// The first point of each of up to three traces is begun and, after a second at most, left; the others are taken to cost the same
/// per sample of the grid. Good for a shard size, not for a bet: a policy that traces a tenth of the rays costs a fifth of this.
pub fn core_seconds(plan: &Plan, open: &dyn Fn(&str) -> Result<Trace, String>) -> Option<f64> {
    let samples = |p: &PointRef| {
        let trace = &plan.traces[p.trace];
        let (width, height) = trace.size;
        f64::from(width) * f64::from(height) * f64::from(trace.samples * trace.samples) * f64::from(p.frames.1)
    };
    let mut rates = Vec::new();
    for trace in 0..plan.traces.len().min(TRACES) {
        let Some(point) = plan.points.iter().find(|point| point.trace == trace) else { continue };
        let Ok(opened) = open(&plan.traces[trace].location) else { continue };
        if let Some(seconds) = look(plan, point, opened) {
            rates.push(seconds / samples(point));
        }
    }
    let mean = rates.iter().sum::<f64>() / rates.len() as f64;
    // A point that shares its key with another is computed once.
    let mut keys: Vec<(&String, f64)> = plan.points.iter().map(|point| (&point.key, samples(point))).collect();
    keys.sort_by_key(|(key, _)| *key);
    keys.dedup_by_key(|(key, _)| *key);
    (!rates.is_empty()).then(|| mean * keys.iter().map(|(_, samples)| samples).sum::<f64>())
}

/// Seconds that a point would take.
fn look(plan: &Plan, point: &PointRef, trace: Trace) -> Option<f64> {
    let resolved = plan.resolve(point).ok()?;
    let (stop, source) = (Stop::default(), TileCache::new(trace, &MemoryBudget::new(0)));
    let tree = source.topology();
    let (start, mut part) = (Instant::now(), (0.0, 0.0));
    let ended = compute_row(&resolved, &point.key, (&source, &tree), &stop, |done, all| {
        part = (done as f64 / all as f64, start.elapsed().as_secs_f64());
        if start.elapsed() > LOOK {
            stop.request();
        }
    });
    match ended {
        Ok(_) => Some(start.elapsed().as_secs_f64()),
        Err(_) => (part.0 > PART).then(|| part.1 / part.0),
    }
}
