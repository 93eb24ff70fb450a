//! Figures of a machine: time, rays a second, power. Each is one expression over integer counts.

use serde::Serialize;

use rayreel_machine::config::MachineConfig;
use rayreel_machine::energy::EnergyReport;
use rayreel_replay::simulate::MachineRun;

/// Time, speed and power of one frame or of all; everything is null without a machine.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct RunFigures {
    /// Cycles of the T&I clock.
    pub cycles: Option<u64>,
    /// Simulated time, ms.
    pub time_ms: Option<f64>,
    /// Frames a second.
    pub fps: Option<f64>,
    /// Rays that the T&I units took.
    pub rays_machine: Option<u64>,
    /// The same a second, millions.
    pub mrays_per_s: Option<f64>,
    /// Cost of the T&I units alone.
    #[serde(flatten)]
    pub ti: Cost,
    /// Cost of the T&I units and of what their nodes and triangles cause at L2 and DRAM.
    pub ti_with_memory: Option<Cost>,
    /// Cost of the whole GPU with its memory.
    pub gpu: Option<Cost>,
}

/// What something costs; null where nothing was done in no time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Cost {
    /// Mean power, W.
    pub power_w: Option<f64>,
    /// Energy, mJ.
    pub energy_mj: Option<f64>,
    /// Energy a ray, nJ.
    pub energy_per_ray_nj: Option<f64>,
    /// Frames a second and watt.
    pub perf_per_watt: Option<f64>,
}

impl RunFigures {
    /// Figures of a run of so many frames.
    pub fn new(config: &MachineConfig, run: &MachineRun, frames: usize) -> Self {
        let cycles = run.stats.cycles;
        let seconds = cycles as f64 / (f64::from(config.ti.clock_mhz) * 1e6);
        let rays = run.stats.rays();
        let cost = |fj: u128| Cost::new(fj, seconds, rays, frames);
        Self {
            cycles: Some(cycles),
            time_ms: Some(seconds * 1e3),
            fps: ratio(frames as f64, seconds),
            rays_machine: Some(rays),
            mrays_per_s: ratio(rays as f64 * 1e-6, seconds),
            ti: cost(run.energy.ti_fj()),
            ti_with_memory: Some(cost(run.energy.ti_with_memory_fj())),
            gpu: Some(cost(run.energy.gpu_fj())),
        }
    }
}

impl Cost {
    fn new(fj: u128, seconds: f64, rays: u64, frames: usize) -> Self {
        let joules = fj as f64 * 1e-15;
        Self {
            power_w: ratio(joules, seconds),
            energy_mj: Some(fj as f64 * 1e-12),
            energy_per_ray_nj: ratio(fj as f64 * 1e-6, rays as f64),
            // Frames a second over joules a second.
            perf_per_watt: ratio(frames as f64, joules),
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
    /// Dynamic energy, mJ.
    pub dynamic_mj: f64,
    /// Leakage, mJ; of the DRAM its background.
    pub leakage_mj: f64,
    /// Mean power, W.
    pub power_w: Option<f64>,
}

/// The components of a run of `seconds`.
pub(super) fn components(energy: &EnergyReport, time_ms: Option<f64>) -> Vec<ComponentReport> {
    let mj = |fj: u128| fj as f64 * 1e-12;
    let component = |c: &rayreel_machine::energy::Component| ComponentReport {
        name: c.name,
        group: c.group.name(),
        dynamic_mj: mj(c.dynamic_fj),
        leakage_mj: mj(c.leakage_fj),
        power_w: time_ms.and_then(|ms| ratio(mj(c.total_fj()), ms)),
    };
    energy.components.iter().map(component).collect()
}

/// A ratio, unless there is nothing to divide by.
pub(super) fn ratio(a: f64, b: f64) -> Option<f64> {
    (b > 0.0).then(|| a / b)
}
