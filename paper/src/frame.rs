//! What the study says of a frame, out of the figures of a row: of the row of a point of one frame, or of a frame by itself.
//!
//! All of it follows from the row bit by bit, so a point that a sweep has computed need not be computed again.

use rayreel_machine::config::{Divergence, NamedMachine, Pipeline};
use rayreel_machine::counters::Activity;
use rayreel_machine::energy::EnergyReport;
use rayreel_machine::srp::{KernelId, SrpStats};
use rayreel_machine::stats::Stats;
use rayreel_study::point::details::TileFigures as TileDetails;
use rayreel_study::point::estimates::{RowEstimates, Sampled};
use rayreel_study::point::figures::RowFigures;
use rayreel_study::point::key::Point;
use rayreel_study::schema::{
    Component, Cost, CostInterval, Gain, GainInterval, Kernel, Quality, StateShare, TileFigures, Unit,
};
use serde_json::{Map, Value};

/// Figures of one frame.
#[derive(Clone, Copy)]
pub struct FrameView<'a> {
    figures: RowFigures<'a>,
    /// The point that it is of.
    point: &'a Point,
    /// The machine that simulated it, if one did.
    machine: Option<&'a NamedMachine>,
}

/// Figures without which a row says too little.
const NEEDED: &[&str] = &[
    "rays_full",
    "rays_traced",
    "rays_apron",
    "samples_full",
    "samples_traced",
    "similarity_ratio",
    "psnr_db",
    "ssim",
    "flip",
    "worst_tile_psnr_db",
    "identical",
    "cycles",
    "time_ms",
    "power_w",
    "energy_mj",
    "perf_per_watt",
    "gpu_power_w",
    "gpu_energy_mj",
    "gpu_perf_per_watt",
];

impl<'a> FrameView<'a> {
    /// The figures of the one frame of a point.
    pub fn new(row: &'a Map<String, Value>, point: &'a Point) -> Self {
        Self { figures: RowFigures(row), point, machine: point.machine.as_deref() }
    }

    /// The figures of one of the frames of a point, which a machine has simulated or not.
    pub fn one_of(row: &'a Map<String, Value>, point: &'a Point, simulated: bool) -> Self {
        Self { machine: point.machine.as_deref().filter(|_| simulated), ..Self::new(row, point) }
    }

    /// Whether nothing is missing in the row: a program of another version may have known fewer figures.
    pub fn is_complete(self) -> bool {
        let simulated =
            || self.figures.count("cycles").is_some() && self.figures.counter("srp/activity/inspector").is_some();
        NEEDED.iter().all(|name| self.figures.has(name)) && (self.machine.is_none() || simulated())
    }

    fn count(self, name: &str) -> u64 {
        self.figures.count(name).unwrap_or(0)
    }

    /// Rays of all samples.
    pub fn rays_full(self) -> u64 {
        self.count("rays_full")
    }

    /// Rays traced, apron rays included.
    pub fn rays_traced(self) -> u64 {
        self.count("rays_traced") + self.count("rays_apron")
    }

    /// Samples of the grid.
    pub fn samples_full(self) -> u64 {
        self.count("samples_full")
    }

    /// Samples traced.
    pub fn samples_traced(self) -> u64 {
        self.count("samples_traced")
    }

    /// Traced samples per sample of the grid.
    pub fn mean_rate(self) -> f64 {
        self.samples_traced() as f64 / self.samples_full() as f64
    }

    /// Interpolated per I-sample.
    pub fn similarity_ratio(self) -> Option<f64> {
        self.figures.number("similarity_ratio")
    }

    /// The picture against that of `full`, if they were compared.
    pub fn quality(self) -> Option<Quality> {
        let number = |name: &str| self.figures.number(name);
        let compared = self.figures.0.get("identical").is_some_and(Value::is_boolean);
        compared.then(|| Quality {
            psnr_db: number("psnr_db"),
            ssim: number("ssim"),
            flip: number("flip"),
            worst_tile_psnr_db: number("worst_tile_psnr_db"),
        })
    }

    /// Cost of the T&I units.
    pub fn ti(self) -> Option<Cost> {
        self.cost("")
    }

    /// Cost of the whole GPU.
    pub fn gpu(self) -> Option<Cost> {
        self.cost("gpu_")
    }

    /// A cost; nothing where nothing was done in no time.
    fn cost(self, group: &str) -> Option<Cost> {
        let number = |name: &str| self.figures.number(&format!("{group}{name}"));
        let interval = self.interval(group);
        Some(Cost {
            interval,
            cycles: self.figures.count("cycles")?,
            time_ms: self.figures.number("time_ms")?,
            power_w: number("power_w")?,
            energy_mj: number("energy_mj")?,
            perf_per_watt: number("perf_per_watt")?,
        })
    }

    /// How far a cost may be off; nothing if it is exact.
    fn interval(self, group: &str) -> Option<CostInterval> {
        let estimates = self.estimates();
        let of = |name: &str| estimates.interval(&format!("{group}{name}"));
        let interval = CostInterval {
            cycles: estimates.interval("cycles"),
            power_w: of("power_w"),
            energy_mj: of("energy_mj"),
            perf_per_watt: of("perf_per_watt"),
        };
        (interval != CostInterval::default()).then_some(interval)
    }

    /// What is known of its estimates.
    fn estimates(self) -> RowEstimates {
        let Point { source, frames, detail, .. } = self.point;
        let sampled = Sampled::new(source, *frames, &detail.to_string(), &self.point.policy_config());
        RowEstimates::of_row(self.figures.0, sampled)
    }

    /// The T&I units relative to those of another frame.
    pub fn ti_gain(self, over: Self) -> Option<Gain> {
        self.gain(over, "")
    }

    /// The whole GPU relative to that of another frame.
    pub fn gpu_gain(self, over: Self) -> Option<Gain> {
        self.gain(over, "gpu_")
    }

    /// Factors over another frame.
    fn gain(self, over: Self, group: &str) -> Option<Gain> {
        let (cost, reference) = (self.cost(group)?, over.cost(group)?);
        let [estimates, of_reference] = [self, over].map(Self::estimates);
        let of = |name: &str| estimates.interval_of_ratio(&of_reference, name);
        let interval = GainInterval {
            performance: of("cycles"),
            power: of(&format!("{group}power_w")),
            perf_per_watt: of(&format!("{group}perf_per_watt")),
        };
        Some(Gain {
            performance: reference.time_ms / cost.time_ms,
            power: cost.power_w / reference.power_w,
            perf_per_watt: cost.perf_per_watt / reference.perf_per_watt,
            // Over itself a frame is exactly 1.
            interval: (!std::ptr::eq(self.figures.0, over.figures.0)
                && (cost.interval.is_some() || reference.interval.is_some()))
            .then_some(interval),
        })
    }

    /// What each stage of each kind of unit did with its cycles, all units of the kind together.
    pub fn units(self) -> Vec<Unit> {
        let Some(machine) = self.machine else { return Vec::new() };
        let classes = |counters: Vec<rayreel_machine::counters::Counter>| counters.into_iter().map(|c| c.name);
        let activity = || classes(Activity::default().list());
        // A stage has counters of all classes.
        let has = |stage: &str, class: &str| self.figures.counter(&format!("ti/trv/{stage}/{class}")).is_some();
        let is_stage = |stage: &&str| activity().all(|class| has(stage, class));
        let stages = self.figures.between("ti/trv/", "/busy").filter(is_stage);
        let mut units: Vec<Unit> =
            stages.map(|stage| self.unit(&format!("trv/{stage}"), &format!("ti/trv/{stage}"), activity())).collect();
        if has_units(machine) {
            units.push(self.unit("ist/test", "ti/ist/test", activity()));
            units.push(self.unit("srp/array", "srp/activity", classes(SrpStats::default().activity.list())));
        }
        units
    }

    /// Shares of cycles by state, of the counters of a group.
    fn unit(self, name: &str, group: &str, states: impl Iterator<Item = &'static str>) -> Unit {
        let cycles = |state: &str| self.figures.counter(&format!("{group}/{state}")).unwrap_or(0);
        let states: Vec<(&str, u64)> = states.map(|state| (state, cycles(state))).collect();
        let all = states.iter().map(|(_, cycles)| cycles).sum::<u64>().max(1) as f64;
        let share = |(state, cycles): (&str, u64)| StateShare { state: state.into(), share: cycles as f64 / all };
        Unit { unit: name.into(), shares: states.into_iter().map(share).collect() }
    }

    /// Energy by component.
    pub fn energy(self) -> Vec<Component> {
        let Some(machine) = self.machine else { return Vec::new() };
        let component = |component: &rayreel_machine::energy::Component| {
            let (dynamic, leakage) = self.figures.energy_mj(component.name)?;
            Some(Component {
                component: component.name.into(),
                group: component.group.name().into(),
                mj: dynamic + leakage,
            })
        };
        no_energy(machine).components.iter().filter_map(component).collect()
    }

    /// Cycles of all SRPs by kernel.
    pub fn srp(self) -> Vec<Kernel> {
        // Processors run the kernels where they trace the rays, and no SRP counts them.
        let Some(machine) = self.machine.filter(|machine| has_units(machine)) else { return Vec::new() };
        let srp = &machine.config.srp;
        let inspector = if srp.divergence == Divergence::Inspector { u64::from(srp.inspector_cycles) } else { 0 };
        let counter = |name: String| self.figures.counter(&name).unwrap_or(0);
        let kernels = KernelId::ALL.into_iter().map(KernelId::name);
        let busy = kernels.clone().chain(["inspector"]);
        let busy = busy.map(|state| counter(format!("srp/activity/{state}"))).sum::<u64>().max(1) as f64;
        let kernel = |name: &str| {
            // What sorts the items of a test by their outcome is part of the test.
            let sorted =
                if name == KernelId::Similarity.name() { counter(format!("srp/kernel/{name}/items")) } else { 0 };
            let cycles = counter(format!("srp/kernel/{name}/cycles")) + sorted * inspector;
            Kernel { kernel: name.into(), cycles, share: cycles as f64 / busy }
        };
        kernels.map(kernel).collect()
    }
}

/// Whether a machine has T&I units and SRPs: processors do the work of both.
fn has_units(machine: &NamedMachine) -> bool {
    machine.config.ti.pipeline != Pipeline::Software
}

/// The components of a machine and their groups, without energy.
fn no_energy(machine: &NamedMachine) -> EnergyReport {
    EnergyReport::new(&machine.config, &Stats::default())
}

/// A tile as the study has it.
pub fn tile(tile: &TileDetails) -> TileFigures {
    let all = tile.samples_traced + tile.samples_interpolated;
    TileFigures {
        rays_full: tile.rays_full,
        rays_traced: tile.rays_traced + tile.rays_apron,
        mean_rate: tile.samples_traced as f64 / all.max(1) as f64,
        similarity_ratio: tile.similarity_ratio,
        psnr_db: tile.psnr_db,
    }
}

#[cfg(test)]
mod tests {
    use rayreel_replay::NamedPolicy;
    use rayreel_replay::detail::FLOOR;
    use serde_json::json;

    use super::*;

    /// Replicates of which the last four say how far what is read from DRAM may be off.
    #[test]
    fn what_is_read_from_dram_cancels_under_one_policy_alone_and_nothing_between_traces() {
        let row = json!({
            "cycles": 1000, "time_ms": 1.0, "gpu_power_w": 1.0, "gpu_energy_mj": 1.0, "gpu_perf_per_watt": 1.0,
            "interval_percent": { "cycles": 1.0, "gpu_energy_mj": 3.0, "gpu_perf_per_watt": 3.0 },
            "replicates": { "freedom": 4, "cycles": [0, 0, 0, 0, 0, 0, 0], "gpu_energy_mj": [0, 0, 0, 9000, -9000, 0, 0] },
        });
        let row = row.as_object().unwrap();
        let point = |source: &str, machine: &str, policy: &str| {
            let machine = NamedMachine::load("sgrt-ti2", &[machine.into()]).unwrap();
            Point::plain(source, (0, 1), Some(machine), NamedPolicy::load(policy, &[]).unwrap())
        };
        let base = point("a", "srp.divergence=inspector", "paper-ss");
        let itself = FrameView::new(row, &base);
        assert_eq!(itself.gpu_gain(itself).unwrap().interval, None);
        let row = row.clone();
        let within = |other: &Point| {
            let gain = FrameView::new(&row, other).gpu_gain(itself).unwrap();
            gain.interval.unwrap().perf_per_watt
        };
        assert!((within(&point("a", "srp.divergence=naive", "paper-ss")) - FLOOR).abs() < 1e-12);
        let other_policy = within(&point("a", "srp.divergence=inspector", "full"));
        assert!(other_policy > 4.0 * FLOOR, "{other_policy}");
        let other_trace = within(&point("b", "srp.divergence=inspector", "paper-ss"));
        assert!((other_trace - 0.03 * 2f64.sqrt()).abs() < 1e-12, "{other_trace}");
    }
}
