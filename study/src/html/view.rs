//! The study as the sections see it: looked up by scene, mode and policy. A policy looks the same on the whole page.

use crate::analysis::means::geometric_mean;
use crate::html::charts::gallery::Gallery;
use crate::html::charts::svg::{COLOURS, FULL, marker};
use crate::html::magnitude::{ENERGY, Unit, for_all};
use crate::html::parts::{legend, line_key, symbol};
use crate::schema::{GainBand, Point, Scene, Study};

/// A study with what several sections look up in it.
pub struct StudyView<'a> {
    /// The study.
    pub study: &'a Study,
    /// The points of the study's machine.
    pub points: Vec<&'a Point>,
    /// The policy that the summary speaks of.
    pub headline: Option<&'a str>,
    /// The charts that the sections drew.
    pub charts: Gallery,
}

/// How a policy looks: colour class and shape of its marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// Class number; nothing for `full`, which is grey.
    pub colour: Option<usize>,
    /// Shape number.
    pub shape: usize,
}

impl Look {
    /// The class of its colour.
    pub fn class(self) -> String {
        self.colour.map_or_else(|| "pfull".into(), |i| format!("p{i}"))
    }

    /// Dash pattern of its line.
    pub fn dash(self) -> &'static str {
        if self.shape == FULL { "12 2" } else { ["", "7 3", "2 3", "9 3 2 3", "5 2", "1 4"][self.shape % 6] }
    }
}

impl<'a> StudyView<'a> {
    /// Looks at a study.
    pub fn new(study: &'a Study) -> Self {
        let of_machine: Vec<&Point> = study.points.iter().filter(|p| p.machine == study.machine).collect();
        let points = if of_machine.is_empty() { study.points.iter().collect() } else { of_machine };
        let mut view = Self { study, points, headline: None, charts: Gallery::default() };
        view.headline = study.headline_policy.as_deref().or_else(|| view.best());
        view
    }

    /// The point of a scene and mode under a policy.
    pub fn point(&self, scene: &str, mode: &str, policy: &str) -> Option<&'a Point> {
        self.points.iter().copied().find(|p| p.scene == scene && p.mode == mode && p.policy == policy)
    }

    /// The points of a scene in a mode, in the order of the policies.
    pub fn of(&self, scene: &str, mode: &str) -> Vec<&'a Point> {
        let mut points: Vec<&Point> =
            self.points.iter().copied().filter(|p| p.scene == scene && p.mode == mode).collect();
        points.sort_by_key(|p| self.order(&p.policy));
        points
    }

    /// The scenes that have a point in a mode; also those that the list of the study lacks.
    pub fn scenes(&self, mode: &str) -> Vec<&'a str> {
        let mut names: Vec<&str> = self.study.scenes.iter().map(|s| s.name.as_str()).collect();
        for point in &self.points {
            if !names.contains(&point.scene.as_str()) {
                names.push(&point.scene);
            }
        }
        names.retain(|name| self.points.iter().any(|p| p.scene == *name && p.mode == mode));
        names
    }

    /// The modes that have points: supersampling first, as in the paper.
    pub fn modes(&self) -> Vec<&'a str> {
        let mut modes: Vec<&str> = Vec::new();
        for point in &self.points {
            if !modes.contains(&point.mode.as_str()) {
                modes.push(&point.mode);
            }
        }
        modes.sort_by(|a, b| b.cmp(a));
        modes
    }

    /// Position of a policy in the study; behind all if it is not listed.
    fn order(&self, policy: &str) -> usize {
        self.study.policies.iter().position(|p| p.name == policy).unwrap_or(self.study.policies.len())
    }

    /// Policies that have points, in order, without `full`.
    pub fn policies(&self, mode: Option<&str>) -> Vec<&'a str> {
        let mut names: Vec<&str> = Vec::new();
        for point in self.points.iter().filter(|p| p.kind != "full" && mode.is_none_or(|m| p.mode == m)) {
            if !names.contains(&point.policy.as_str()) {
                names.push(&point.policy);
            }
        }
        names.sort_by_key(|name| self.order(name));
        names
    }

    /// The look of a policy.
    pub fn look(&self, policy: &str) -> Look {
        let full = self.points.iter().any(|p| p.kind == "full" && p.policy == policy) || policy == "full";
        if full {
            return Look { colour: None, shape: FULL };
        }
        let mut all: Vec<&str> = self.study.policies.iter().map(|p| p.name.as_str()).filter(|p| *p != "full").collect();
        let named = self.study.tracks.iter().map(|t| t.policy.as_str());
        let named = named.chain(self.study.systems.iter().map(|p| p.policy.as_str()).filter(|p| *p != "full"));
        for name in self.points.iter().filter(|p| p.kind != "full").map(|p| p.policy.as_str()).chain(named) {
            if !all.contains(&name) {
                all.push(name);
            }
        }
        let i = all.iter().position(|name| *name == policy).unwrap_or(0);
        Look { colour: Some(i % COLOURS), shape: i % 6 }
    }

    /// A legend of some policies.
    pub fn legend(&self, policies: &[&str]) -> String {
        let entry = |policy: &&str| {
            let look = self.look(policy);
            symbol(&format!("<path d=\"{}\" class=\"{}\"/>", marker(look.shape, 8.0, 8.0), look.class()), policy)
        };
        legend(&policies.iter().map(entry).collect::<String>())
    }

    /// A legend of some policies whose charts have lines: each as its line.
    pub fn legend_of_lines(&self, policies: &[&str]) -> String {
        let entry = |policy: &&str| {
            let look = self.look(policy);
            line_key(&look.class(), look.dash(), policy)
        };
        legend(&policies.iter().map(entry).collect::<String>())
    }

    /// The policy that does what the paper evaluated in a mode.
    pub fn paper_policy(&self, mode: &str) -> Option<&'a str> {
        let stated = self.study.references.policies.iter().find(|p| p.mode == mode).map(|p| p.policy.as_str());
        stated.or_else(|| self.policies(Some(mode)).first().copied())
    }

    /// The paper's performance per watt of a scene.
    pub fn band(&self, scene: &str) -> Option<&'a GainBand> {
        self.study.references.gains.iter().find(|band| band.scene == scene)
    }

    /// Whether any scene has a performance per watt in the paper.
    pub fn has_bands(&self) -> bool {
        self.points.iter().any(|point| self.band(&point.scene).is_some())
    }

    /// Whether any point is an estimate.
    fn is_estimated(&self) -> bool {
        let costs = self.points.iter().flat_map(|point| [point.ti, point.gpu]).flatten();
        costs.filter_map(|cost| cost.interval).any(|interval| interval.cycles > 0.0)
    }

    /// What the thin lines of charts mean, behind other sentences; nothing where there are none.
    pub fn intervals_drawn(&self) -> &'static str {
        if self.is_estimated() {
            " Thin lines with caps are 95 % intervals, where they are long enough to be seen."
        } else {
            ""
        }
    }

    /// That shares of cycles have no intervals, behind other sentences; nothing where all are exact.
    pub fn shares_estimated(&self) -> &'static str {
        if self.is_estimated() {
            " Where cycles are estimates these shares are too; how far they may be off is not stated."
        } else {
            ""
        }
    }

    /// The unit of all energies of whole frames.
    pub fn energy_unit(&self) -> Unit {
        let parts = |point: &&Point| point.energy.iter().map(|part| part.mj).sum::<f64>();
        let whole = |point: &&Point| point.gpu.map_or(0.0, |cost| cost.energy_mj);
        for_all(&ENERGY, self.points.iter().flat_map(|point| [parts(point), whole(point)]))
    }

    /// The points of a policy in a mode, one for each scene that has the mode; nothing if one is missing.
    pub fn everywhere(&self, mode: &str, policy: &str) -> Option<Vec<&'a Point>> {
        let scenes = self.scenes(mode);
        let points: Option<Vec<_>> = scenes.iter().map(|scene| self.point(scene, mode, policy)).collect();
        points.filter(|points| !points.is_empty())
    }

    /// The scenes in which a policy has more performance per watt and more PSNR than another, and those where both are known.
    pub fn beaten(&self, mode: &str, policy: &str, other: &str) -> (usize, usize) {
        let pairs = self.scenes(mode).into_iter().filter_map(|scene| {
            let [a, b] = [policy, other].map(|name| self.point(scene, mode, name).and_then(merit));
            Some((a?, b?))
        });
        pairs.fold((0, 0), |(won, all), ((gain, psnr), (other_gain, other_psnr))| {
            (won + usize::from(gain > other_gain && psnr > other_psnr), all + 1)
        })
    }

    /// The policy worth a summary: the one that beats the paper's in the most scenes, and of equal ones that with the most
    /// performance per watt.
    fn best(&self) -> Option<&'a str> {
        let mode = *self.modes().first()?;
        let paper = self.paper_policy(mode)?;
        let candidates = self.policies(Some(mode)).into_iter().filter(|p| *p != paper).filter_map(|policy| {
            let points = self.everywhere(mode, policy)?;
            let gain = geometric_mean(points.iter().map(|p| merit(p).map(|(gain, _)| gain)))?;
            Some((self.beaten(mode, policy, paper).0, gain, policy))
        });
        candidates.max_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))).map(|(_, _, policy)| policy)
    }
}

/// By how much a scene may have more or fewer triangles than the paper's of that name: user's models may have any name.
const TRIANGLES_OFF: f64 = 0.1;

/// Whether a scene is of the kind and size of one of the paper's.
pub fn has_counterpart(scene: &Scene) -> bool {
    let paper = scene.paper_triangles.filter(|paper| *paper > 0);
    paper.is_some_and(|paper| (scene.triangles as f64 / paper as f64 - 1.0).abs() <= TRIANGLES_OFF)
}

/// Gain in performance per watt (T&I units alone, or else the whole GPU) and PSNR, infinite for identical pictures.
pub fn merit(point: &Point) -> Option<(f64, f64)> {
    let quality = point.quality?;
    Some((gain(point)?, quality.psnr_db.unwrap_or(f64::INFINITY)))
}

/// Gain in performance per watt: T&I units alone as in the paper, or else the whole GPU.
pub fn gain(point: &Point) -> Option<f64> {
    point.ti_gain.or(point.gpu_gain).map(|gain| gain.perf_per_watt)
}

/// How far the gain in performance per watt may be off, as a part of it.
pub fn gain_interval(point: &Point) -> Option<f64> {
    Some(point.ti_gain.or(point.gpu_gain)?.interval?.perf_per_watt)
}
