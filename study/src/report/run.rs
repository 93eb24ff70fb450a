//! Figures of a machine: time, rays a second, power. Each is one expression over integer counts.

use serde::Serialize;
use serde_json::{Map, Value, json};

use crate::figures::{RunCost, RunFigures};
use rayreel_machine::AreaReport;
use rayreel_machine::config::{MachineConfig, Pipeline};
use rayreel_machine::energy::EnergyReport;
use rayreel_replay::Detail;
use rayreel_replay::simulate::MachineRun;

impl RunFigures {
    /// Figures of a run of so many frames.
    pub fn new(config: &MachineConfig, run: &MachineRun, frames: usize) -> Self {
        let cycles = run.stats.cycles;
        let seconds = cycles as f64 / (f64::from(config.ti.clock_mhz) * 1e6);
        let rays = run.stats.rays();
        let cost = |fj: u128| RunCost::new(fj, seconds, rays, frames);
        let area = AreaReport::new(config);
        let mrays_per_s = ratio(rays as f64 * 1e-6, seconds);
        let over = |mm2: f64| mrays_per_s.and_then(|mrays| ratio(mrays, mm2));
        let has_units = config.ti.pipeline != Pipeline::Software;
        let timeless = run.estimate.as_ref().is_some_and(|estimate| estimate.detail == Detail::Counts);
        let knows_all = !timeless || EnergyReport::timed_components(config).is_empty();
        Self {
            cycles: (!timeless).then_some(cycles),
            time_ms: (!timeless).then_some(seconds * 1e3),
            fps: ratio(frames as f64, seconds),
            rays_machine: Some(rays),
            mrays_per_s,
            // Processors do the work of the T&I units and of the SRPs: there is no unit to measure alone.
            ti: if has_units { cost(run.energy.ti_fj()) } else { RunCost::default() },
            ti_with_memory: has_units.then(|| cost(run.energy.ti_with_memory_fj())),
            gpu: Some(if knows_all { cost(run.energy.gpu_fj()) } else { RunCost::default() }),
            ti_area_mm2: has_units.then(|| area.ti_mm2()),
            gpu_area_mm2: Some(area.gpu_mm2()),
            mrays_per_mm2: over(area.ti_mm2()),
            gpu_mrays_per_mm2: over(area.gpu_mm2()),
        }
    }
}

impl RunCost {
    fn new(fj: u128, seconds: f64, rays: u64, frames: usize) -> Self {
        let joules = fj as f64 * 1e-15;
        Self {
            power_w: ratio(joules, seconds),
            energy_mj: Some(fj as f64 * 1e-12),
            energy_per_ray_nj: ratio(fj as f64 * 1e-6, rays as f64),
            // Frames a second over joules a second.
            perf_per_watt: ratio(frames as f64, joules).filter(|_| seconds > 0.0),
        }
    }
}

/// A component of the energy, all cores together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct ComponentReport {
    /// Name.
    pub name: &'static str,
    /// `ti`, `srp` or `memory`.
    pub group: &'static str,
    /// Dynamic energy, mJ; null where no cycle was simulated and it follows from what takes time to count.
    pub dynamic_mj: Option<f64>,
    /// Leakage, mJ; of the DRAM its background; null where no cycle was simulated.
    pub leakage_mj: Option<f64>,
    /// Mean power, W.
    pub power_w: Option<f64>,
}

/// The components of a run of `time_ms`; `timeless` if no cycle was simulated.
pub(super) fn components(
    config: &MachineConfig,
    energy: &EnergyReport,
    time_ms: Option<f64>,
    timeless: bool,
) -> Vec<ComponentReport> {
    let unknown = if timeless { EnergyReport::timed_components(config) } else { &[] };
    let mj = |fj: u128| fj as f64 * 1e-12;
    let component = |c: &rayreel_machine::energy::Component| ComponentReport {
        name: c.name,
        group: c.group.name(),
        dynamic_mj: (!unknown.contains(&c.name)).then(|| mj(c.dynamic_fj)),
        leakage_mj: (!timeless).then(|| mj(c.leakage_fj)),
        power_w: time_ms.and_then(|ms| ratio(mj(c.total_fj()), ms)),
    };
    energy.components.iter().map(component).collect()
}

/// Area by component, and of T&I units and GPU, mm2.
pub(super) fn area(config: &MachineConfig) -> Value {
    let area = AreaReport::new(config);
    let components = area.components.iter().map(|c| (c.name.to_owned(), json!(c.mm2())));
    let sums = [("ti".to_owned(), json!(area.ti_mm2())), ("gpu".to_owned(), json!(area.gpu_mm2()))];
    Value::Object(components.chain(sums).collect::<Map<_, _>>())
}

/// A ratio, unless there is nothing to divide by.
pub(super) fn ratio(a: f64, b: f64) -> Option<f64> {
    (b > 0.0).then(|| a / b)
}
