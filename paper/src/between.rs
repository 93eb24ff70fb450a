//! Frames of a flight that no machine simulated, estimated from the simulated frames before and after.
//!
//! What a ray takes changes slowly along a camera path, and how many rays a frame traces is known of every frame. So time and energy a ray
//! of two simulated frames are interpolated, and a frame between them takes that times its own rays. How far such estimates may be off
//! is seen at the simulated frames themselves: each is estimated from its two neighbours too, which lie further away from it than those
//! of a frame between two. `docs/accuracy.md` compares a flight of which every frame was simulated.

use rayreel_study::schema::{CostInterval, TrackFrame};

/// Of a flight every so many frames are simulated, and its last. An odd number, for policies do some things every other frame or every
/// fourth.
pub const EVERY: u32 = 11;

/// Fewest simulated frames from which others are estimated.
pub const FEWEST: usize = 20;

/// The 97.5 % point of Student's t with 18 degrees of freedom: those of [`FEWEST`] frames, of which the first and the last have only
/// one neighbour. Longer flights have more.
const STUDENT: f64 = 2.10;

/// A simulated frame: time and energy a ray.
#[derive(Clone, Copy)]
struct Known {
    at: usize,
    time: f64,
    energy: f64,
}

/// What frames take, or how far that may be off, as a part of it.
#[derive(Clone, Copy, Default)]
struct Parts {
    time: f64,
    energy: f64,
    power: f64,
}

impl Parts {
    fn each(self, other: Self, of: impl Fn(f64, f64) -> f64) -> Self {
        let Self { time, energy, power } = self;
        Self { time: of(time, other.time), energy: of(energy, other.energy), power: of(power, other.power) }
    }

    fn interval(self) -> CostInterval {
        let Self { time, energy, power } = self;
        CostInterval { cycles: time, power_w: power, energy_mj: energy, perf_per_watt: energy }
    }
}

fn rays(frame: &TrackFrame) -> f64 {
    frame.rays_traced.max(1) as f64
}

impl Known {
    fn of(at: usize, frame: &TrackFrame) -> Option<Self> {
        Some(Self { at, time: frame.time_ms? / rays(frame), energy: frame.energy_mj? / rays(frame) })
    }

    /// Time and energy a ray at frame `at`, between this one and `to`.
    fn towards(self, to: Self, at: usize) -> Self {
        let part = (at - self.at) as f64 / (to.at - self.at) as f64;
        let between = |from: f64, to: f64| (1.0 - part) * from + part * to;
        Self { at, time: between(self.time, to.time), energy: between(self.energy, to.energy) }
    }

    /// By how much `other` is off, of this one.
    fn error_of(self, other: Self) -> Parts {
        let off = |is: f64, estimated: f64| if is > 0.0 { estimated / is - 1.0 } else { 0.0 };
        let (time, energy) = (off(self.time, other.time), off(self.energy, other.energy));
        Parts { time, energy, power: (1.0 + energy) / (1.0 + time).max(f64::MIN_POSITIVE) - 1.0 }
    }
}

/// Gives time, power and energy to the frames that have none, where enough others have them. What is given back is how far the sums over
/// all frames may be off; nothing if no frame was estimated.
pub fn estimate(frames: &mut [TrackFrame]) -> Option<CostInterval> {
    let known: Vec<Known> = (0..).zip(&*frames).filter_map(|(at, frame)| Known::of(at, frame)).collect();
    let (first, last) = (known.first()?.at, known.last()?.at);
    if known.len() < FEWEST || known.len() == frames.len() || (first, last + 1) != (0, frames.len()) {
        return None;
    }
    let errors = known.windows(3).map(|k| k[1].error_of(k[0].towards(k[2], k[1].at)));
    let squares = errors.fold(Parts::default(), |sum, error| sum.each(error, |sum, error| sum + error * error));
    let off = squares.each(squares, |squares, _| STUDENT * (squares / (known.len() - 2) as f64).sqrt());
    let (mut sum, mut of_gaps) = (Parts::default(), Parts::default());
    for pair in known.windows(2) {
        let mut gap = Parts::default();
        let first = pair[0].at + 1;
        for (at, frame) in (first..).zip(&mut frames[first..pair[1].at]) {
            let Known { time, energy, .. } = pair[0].towards(pair[1], at);
            let (time, energy) = (time * rays(frame), energy * rays(frame));
            (frame.time_ms, frame.energy_mj) = (Some(time), Some(energy));
            frame.power_w = (time > 0.0).then(|| energy / time);
            frame.interval = Some(off.interval());
            gap = gap.each(Parts { time, energy, power: energy }, |gap, frame| gap + frame);
        }
        // Frames between the same two are off alike, those of another pair otherwise.
        of_gaps = of_gaps.each(gap, |sum, gap| sum + gap * gap);
    }
    for frame in &*frames {
        let (time, energy) = (frame.time_ms.unwrap_or(0.0), frame.energy_mj.unwrap_or(0.0));
        sum = sum.each(Parts { time, energy, power: energy }, |sum, frame| sum + frame);
    }
    let part = of_gaps.each(sum, |gaps, sum| if sum > 0.0 { gaps.sqrt() / sum } else { 0.0 });
    Some(part.each(off, |part, off| part * off).interval())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A flight whose frames take so many times their rays, of which every `every`-th frame, and the last, is simulated.
    fn flight(frames: usize, every: usize, energy: impl Fn(usize) -> f64) -> (Vec<TrackFrame>, Vec<TrackFrame>) {
        let whole: Vec<TrackFrame> = (0..frames)
            .map(|at| {
                let rays_traced = 1000 + 37 * (at as u64 % 13);
                let energy = energy(at) * rays_traced as f64;
                let time = 0.5 * energy;
                TrackFrame {
                    frame: at as u32 + 1,
                    rays_traced,
                    time_ms: Some(time),
                    energy_mj: Some(energy),
                    power_w: Some(energy / time),
                    ..TrackFrame::default()
                }
            })
            .collect();
        let mut sampled = whole.clone();
        for (at, frame) in sampled.iter_mut().enumerate() {
            if at % every != 0 && at + 1 != frames {
                (frame.time_ms, frame.energy_mj, frame.power_w) = (None, None, None);
            }
        }
        (whole, sampled)
    }

    fn sum(frames: &[TrackFrame]) -> f64 {
        frames.iter().filter_map(|frame| frame.energy_mj).sum()
    }

    #[test]
    fn what_changes_evenly_is_met() {
        let (whole, mut sampled) = flight(300, 11, |at| 2.0 + 0.01 * at as f64);
        let interval = estimate(&mut sampled).unwrap();
        assert!(interval.energy_mj < 1e-9 && interval.power_w < 1e-9);
        for (is, estimated) in whole.iter().zip(&sampled) {
            assert!((is.energy_mj.unwrap() - estimated.energy_mj.unwrap()).abs() < 1e-6);
            assert!((is.power_w.unwrap() - estimated.power_w.unwrap()).abs() < 1e-9);
        }
    }

    #[test]
    fn intervals_hold_what_frames_differ_by() {
        // Slow and quick changes: a wave of some hundred frames, and something like noise.
        let noise = |at: usize| ((at * 7919 + 13) % 101) as f64 / 101.0 - 0.5;
        let (whole, mut sampled) = flight(700, 11, |at| 2.0 + (at as f64 / 30.0).sin() + 0.1 * noise(at));
        let simulated = sampled.iter().filter(|frame| frame.energy_mj.is_some()).count();
        let interval = estimate(&mut sampled).unwrap();
        let off = (sum(&sampled) / sum(&whole) - 1.0).abs();
        assert!(off <= interval.energy_mj && interval.energy_mj < 0.02, "{off} {interval:?}");
        let holds = |(is, of): (&TrackFrame, &TrackFrame)| {
            let off = (of.energy_mj.unwrap() / is.energy_mj.unwrap() - 1.0).abs();
            of.interval.is_some_and(|interval| off <= interval.energy_mj)
        };
        let held = whole.iter().zip(&sampled).filter(|pair| holds(*pair)).count();
        assert!(held as f64 >= 0.93 * (700 - simulated) as f64, "{held}");
        // Those that were simulated stay as they are.
        assert!(whole.iter().zip(&sampled).step_by(11).all(|(is, of)| is == of));
    }

    #[test]
    fn nothing_is_made_of_too_few_frames() {
        let (_, mut few) = flight(190, 11, |_| 1.0);
        let before = few.clone();
        assert!(estimate(&mut few).is_none() && few == before);
        let (whole, mut all) = flight(300, 1, |_| 1.0);
        assert!(estimate(&mut all).is_none() && all == whole);
        let (_, mut open) = flight(300, 11, |_| 1.0);
        open[0].energy_mj = None;
        assert_eq!(estimate(&mut open), None, "nothing lies before the first");
        assert_eq!(estimate(&mut []), None);
    }
}
