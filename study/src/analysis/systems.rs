//! Which sampling policy on which architecture: means over scenes, what no other pair beats, and what the paper states or expects
//! that holds on which machine.

use crate::analysis::means::{geometric_mean, mean_interval};
use crate::schema::{Gain, SystemPoint};

/// The policy that the others are compared with.
const FULL: &str = "full";
/// What the paper evaluated in this mode.
const PAPER: &str = "paper-ss";
/// What goes beyond it.
const BEYOND: &str = "multirate";

/// What the paper states of Figure 7: the least gain in performance per watt, and the power, without saying of which scenes.
const LEAST_GAIN: f64 = 1.53;
const POWER: f64 = 1.09;

/// All points of a study, by machine and policy.
pub struct Systems<'a> {
    points: &'a [SystemPoint],
    /// The machines, in the order of the study.
    pub machines: Vec<&'a str>,
    /// The policies, `full` first.
    pub policies: Vec<&'a str>,
    /// The scenes.
    pub scenes: Vec<&'a str>,
}

/// A policy on a machine over all scenes: geometric means of factors, mean of decibels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    /// Number of the machine.
    pub machine: usize,
    /// Number of the policy.
    pub policy: usize,
    /// Frames a second and watt over `full` on the same machine, whole GPU, and how far it may be off.
    pub gain: f64,
    /// Half the width of its 95 % interval, as a part of it; nothing where it is exact.
    pub interval: Option<f64>,
    /// The same of the T&I units alone, where there are any.
    pub ti_gain: Option<f64>,
    /// Frames a second and watt, whole GPU, over those of the first machine under `full`.
    pub merit: f64,
    /// Mean PSNR, dB, of the pictures that differ from those of full sampling; infinite where none does.
    pub psnr_db: f64,
}

/// The statements on a machine.
#[derive(Clone, Debug, PartialEq)]
pub struct Verdict {
    /// Number of the machine.
    pub machine: usize,
    /// By statement: whether it holds for the T&I units alone and for the whole GPU, and the values that decide; nothing where that
    /// is not known.
    pub holds: Vec<[Option<(bool, f64)>; 2]>,
}

/// What the paper states of its policies, and what it expects of multi-rate sampling, which it had not applied yet.
pub const STATEMENTS: [&str; 4] = [
    "paper-ss: more frames a joule than full in every scene (least gain)",
    "paper-ss: at least 1.53 times the frames a joule in every scene (least gain)",
    "paper-ss: at most 1.09 times the power (mean)",
    "expected, not measured there: multi-rate sampling improves on it, multirate over paper-ss, frames a joule (mean)",
];

impl<'a> Systems<'a> {
    /// Of the points of a study; nothing if there are none.
    pub fn of(points: &'a [SystemPoint]) -> Option<Self> {
        let mut systems = Self { points, machines: Vec::new(), policies: Vec::new(), scenes: Vec::new() };
        for SystemPoint { scene, machine, policy, .. } in points {
            let Self { machines, policies, scenes, .. } = &mut systems;
            for (name, known) in [(machine, machines), (policy, policies), (scene, scenes)] {
                if !known.contains(&name.as_str()) {
                    known.push(name);
                }
            }
        }
        (!points.is_empty()).then_some(systems)
    }

    /// The point of a scene under a policy on a machine.
    pub fn point(&self, scene: &str, machine: &str, policy: &str) -> Option<&'a SystemPoint> {
        self.points.iter().find(|p| p.scene == scene && p.machine == machine && p.policy == policy)
    }

    /// The points of all scenes; nothing if one is missing.
    fn all(&self, machine: &str, policy: &str) -> Option<Vec<&'a SystemPoint>> {
        self.scenes.iter().map(|scene| self.point(scene, machine, policy)).collect()
    }

    /// A policy on a machine; nothing where a scene is missing.
    pub fn pair(&self, machine: usize, policy: usize) -> Option<Pair> {
        let points = self.all(self.machines[machine], self.policies[policy])?;
        let base = self.all(self.machines[0], FULL)?;
        let is_full = self.policies[policy] == FULL;
        let gain = |gain: Option<Gain>| if is_full { Some(1.0) } else { gain.map(|gain| gain.perf_per_watt) };
        let merit =
            |(point, base): (&&SystemPoint, &&SystemPoint)| Some(point.gpu?.perf_per_watt / base.gpu?.perf_per_watt);
        let within = mean_interval(points.iter().map(|p| Some(p.gpu_gain?.interval?.perf_per_watt)));
        let psnrs: Vec<f64> = points.iter().filter_map(|p| p.psnr_db).collect();
        let psnr_db = if psnrs.is_empty() { f64::INFINITY } else { psnrs.iter().sum::<f64>() / psnrs.len() as f64 };
        let has_units = points.iter().all(|p| p.ti.is_some());
        Some(Pair {
            machine,
            policy,
            gain: geometric_mean(points.iter().map(|p| gain(p.gpu_gain)))?,
            interval: within.filter(|_| !is_full),
            ti_gain: has_units.then(|| geometric_mean(points.iter().map(|p| gain(p.ti_gain)))).flatten(),
            merit: geometric_mean(points.iter().zip(&base).map(merit))?,
            psnr_db,
        })
    }

    /// All pairs of which every scene is there, machine by machine.
    pub fn pairs(&self) -> Vec<Pair> {
        let all = (0..self.machines.len()).flat_map(|m| (0..self.policies.len()).map(move |p| (m, p)));
        all.filter_map(|(machine, policy)| self.pair(machine, policy)).collect()
    }

    /// The pairs that no other beats in both frames a joule and PSNR, by PSNR.
    pub fn frontier(&self) -> Vec<Pair> {
        let pairs = self.pairs();
        let beats = |a: &Pair, b: &Pair| {
            a.merit >= b.merit && a.psnr_db >= b.psnr_db && (a.merit > b.merit || a.psnr_db > b.psnr_db)
        };
        let mut best: Vec<Pair> =
            pairs.iter().filter(|pair| !pairs.iter().any(|other| beats(other, pair))).copied().collect();
        best.sort_by(|a, b| a.psnr_db.total_cmp(&b.psnr_db));
        best
    }

    /// Which of [`STATEMENTS`] hold on each machine that can sample adaptively.
    pub fn verdicts(&self) -> Vec<Verdict> {
        (0..self.machines.len()).filter_map(|machine| self.verdict(machine)).collect()
    }

    fn verdict(&self, machine: usize) -> Option<Verdict> {
        let paper = self.all(self.machines[machine], PAPER)?;
        let beyond = self.all(self.machines[machine], BEYOND);
        type Part = fn(&SystemPoint) -> Option<Gain>;
        let parts: [Part; 2] = [|p| p.ti_gain, |p| p.gpu_gain];
        let least = |of: Part| {
            let gains: Option<Vec<f64>> = paper.iter().map(|p| of(p).map(|gain| gain.perf_per_watt)).collect();
            gains.map(|gains| gains.into_iter().fold(f64::INFINITY, f64::min))
        };
        let power = |of: Part| geometric_mean(paper.iter().map(|p| of(p).map(|gain| gain.power)));
        let over = |of: Part| {
            let both = beyond.as_ref()?.iter().zip(&paper);
            geometric_mean(both.map(|(a, b)| Some(of(a)?.perf_per_watt / of(b)?.perf_per_watt)))
        };
        let holds = vec![
            parts.map(|of| least(of).map(|v| (v > 1.0, v))),
            parts.map(|of| least(of).map(|v| (v >= LEAST_GAIN, v))),
            parts.map(|of| power(of).map(|v| (v <= POWER, v))),
            parts.map(|of| over(of).map(|v| (v > 1.0, v))),
        ];
        Some(Verdict { machine, holds })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::schema::Cost;

    fn point(scene: &str, machine: &str, policy: &str, per_watt: f64, psnr_db: Option<f64>, power: f64) -> SystemPoint {
        let gain = |perf_per_watt| Gain { perf_per_watt, power, ..Gain::default() };
        let full = if machine == "a" { 10.0 } else { 1.0 };
        SystemPoint {
            scene: scene.into(),
            machine: machine.into(),
            policy: policy.into(),
            psnr_db,
            gpu: Some(Cost { perf_per_watt: per_watt, ..Cost::default() }),
            gpu_gain: (policy != FULL).then(|| gain(per_watt / full)),
            ..SystemPoint::default()
        }
    }

    fn points() -> Vec<SystemPoint> {
        vec![
            point("x", "a", FULL, 10.0, None, 1.0),
            point("x", "a", PAPER, 20.0, Some(30.0), 1.2),
            point("x", "a", BEYOND, 18.0, Some(40.0), 1.0),
            point("y", "a", FULL, 10.0, None, 1.0),
            point("y", "a", PAPER, 14.0, Some(32.0), 1.0),
            point("y", "a", BEYOND, 40.0, Some(40.0), 1.0),
            point("x", "b", FULL, 1.0, None, 1.0),
            point("y", "b", FULL, 1.0, None, 1.0),
            point("x", "b", PAPER, 3.0, Some(30.0), 1.0),
        ]
    }

    #[test]
    fn means_are_over_all_scenes_and_merit_over_the_first_machine() {
        let points = points();
        let systems = Systems::of(&points).unwrap();
        assert_eq!((systems.machines.clone(), systems.policies.len()), (vec!["a", "b"], 3));
        let pair = systems.pair(0, 1).unwrap();
        assert!((pair.gain - f64::sqrt(2.0 * 1.4)).abs() < 1e-12 && (pair.merit - pair.gain).abs() < 1e-12);
        assert_eq!((pair.psnr_db, pair.ti_gain), (31.0, None));
        let full = systems.pair(1, 0).unwrap();
        assert_eq!((full.gain, full.psnr_db), (1.0, f64::INFINITY));
        assert!((full.merit - 0.1).abs() < 1e-12);
        assert_eq!(systems.pair(1, 1), None, "scene y is missing");
        assert!(Systems::of(&[]).is_none());
    }

    /// One picture that is exact made the mean of all infinite, and intervals of means were below what windows can tell.
    #[test]
    fn means_are_of_what_there_is() {
        use crate::schema::GainInterval;
        use rayreel_replay::detail::FLOOR;
        let mut points = points();
        points[1].psnr_db = None;
        for point in points.iter_mut().filter(|point| point.machine == "a" && point.policy != FULL) {
            let interval = GainInterval { performance: FLOOR, power: FLOOR, perf_per_watt: FLOOR };
            point.gpu_gain.as_mut().unwrap().interval = Some(interval);
        }
        let systems = Systems::of(&points).unwrap();
        let [full, paper, beyond] = [0, 1, 2].map(|policy| systems.pair(0, policy).unwrap());
        assert_eq!((paper.psnr_db, beyond.psnr_db, full.psnr_db), (32.0, 40.0, f64::INFINITY));
        assert_eq!((full.interval, beyond.interval), (None, Some(FLOOR)));
        let best: Vec<usize> = systems.frontier().iter().map(|pair| pair.policy).collect();
        assert_eq!(best, [2, 0], "paper-ss is beaten all the same");
    }

    #[test]
    fn what_nothing_beats_and_what_holds() {
        let points = points();
        let systems = Systems::of(&points).unwrap();
        let best: Vec<(usize, usize)> = systems.frontier().iter().map(|p| (p.machine, p.policy)).collect();
        assert_eq!(
            best,
            [(0, 2), (0, 0)],
            "multirate beats paper-ss in both; machine b is beaten by the same pictures on a"
        );
        let verdicts = systems.verdicts();
        assert_eq!(verdicts.len(), 1, "of b a scene is missing");
        let gpu: Vec<bool> = verdicts[0].holds.iter().map(|both| both[1].unwrap().0).collect();
        assert_eq!(gpu, [true, false, false, true], "least 1.4, mean power 1.095");
        assert!(verdicts[0].holds.iter().all(|both| both[0].is_none()));
    }
}
