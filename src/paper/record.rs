//! What is kept of a replay: the figures that the study is made of, frame by frame.

use rayreel_formats::scene::Meta;
use rayreel_machine::config::NamedMachine;
use rayreel_machine::srp::KernelId;
use rayreel_replay::NamedPolicy;
use rayreel_replay::counts::FrameStats;
use rayreel_replay::simulate::MachineRun;
use rayreel_study::figures::{RunCost, RunFigures};
use rayreel_study::report::{Origin, Report, TileReport};
use rayreel_study::schema::{Component, Cost, Kernel, Quality, StateShare, TileFigures, Unit};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A replay of some frames.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Record {
    /// The frames, in order.
    pub frames: Vec<Frame>,
}

/// One frame.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Frame {
    /// Position in the camera path, from 0.
    pub frame: u32,
    /// Rays of all samples.
    pub rays_full: u64,
    /// Rays traced, apron rays included.
    pub rays_traced: u64,
    /// Samples of the grid.
    pub samples_full: u64,
    /// Samples traced.
    pub samples_traced: u64,
    /// Interpolated per I-sample.
    pub similarity_ratio: Option<f64>,
    /// Sum of the squared errors of all 8-bit values, and their number.
    pub error: Option<(u64, u64)>,
    /// The picture against that of `full`.
    pub quality: Option<Quality>,
    /// Squared change of the error since the frame before, and the number of values.
    pub flicker: Option<(u64, u64)>,
    /// The tiles, if they were asked for.
    pub tiles: Vec<TileFigures>,
    /// What the machine did, if the frame was simulated.
    pub machine: Option<Machine>,
}

/// A frame on a machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Machine {
    /// Cycles of the T&I clock.
    pub cycles: u64,
    /// The T&I units.
    pub ti: Option<Cost>,
    /// The whole GPU.
    pub gpu: Option<Cost>,
    /// What each unit did with its cycles.
    pub units: Vec<Unit>,
    /// Energy by component.
    pub energy: Vec<Component>,
    /// SRP cycles by kernel.
    pub srp: Vec<Kernel>,
}

impl Frame {
    /// What is kept of a frame, its tiles only if they are wanted.
    pub fn new(
        policy: &NamedPolicy,
        meta: &Meta,
        stats: &FrameStats,
        machine: Option<(&NamedMachine, &MachineRun)>,
        tiles: bool,
    ) -> Self {
        let origin = Origin { trace: String::new(), trace_digest: None };
        let mut report = Report::new(&origin, policy, meta, std::slice::from_ref(stats));
        if let Some((machine, run)) = machine {
            report = report.with_machine(machine, std::slice::from_ref(run));
        }
        let (sum, quality) = (&report.sum, stats.quality.as_ref());
        Self {
            frame: stats.frame,
            rays_full: sum.rays_full,
            rays_traced: sum.rays_traced + sum.rays_apron,
            samples_full: sum.samples_full,
            samples_traced: sum.samples_traced,
            similarity_ratio: sum.similarity_ratio,
            error: quality.map(|q| (q.squared_error, q.values)),
            quality: quality.map(|q| Quality {
                psnr_db: sum.psnr_db,
                ssim: q.ssim,
                flip: q.flip,
                worst_tile_psnr_db: sum.worst_tile_psnr_db,
            }),
            flicker: quality.and_then(|q| q.flicker).map(|f| (f.sum, f.values)),
            tiles: if tiles { report.frames.iter().flat_map(|f| &f.tiles).map(tile).collect() } else { Vec::new() },
            machine: machine.map(|(_, run)| Machine::new(&report, run)),
        }
    }

    /// Traced samples per sample of the grid.
    pub fn mean_rate(&self) -> f64 {
        self.samples_traced as f64 / self.samples_full as f64
    }
}

fn tile(tile: &TileReport) -> TileFigures {
    let all = tile.samples_traced + tile.samples_interpolated;
    TileFigures {
        rays_full: tile.rays_full,
        rays_traced: tile.rays_traced + tile.rays_apron,
        mean_rate: tile.samples_traced as f64 / all.max(1) as f64,
        similarity_ratio: tile.similarity_ratio,
        psnr_db: tile.psnr_db,
    }
}

impl Machine {
    fn new(report: &Report, run: &MachineRun) -> Self {
        let figures = &report.run;
        let component = |c: &rayreel_study::report::run::ComponentReport| Component {
            component: c.name.into(),
            group: c.group.into(),
            mj: c.dynamic_mj + c.leakage_mj,
        };
        Self {
            cycles: run.stats.cycles,
            ti: cost(figures, &figures.ti),
            gpu: figures.gpu.as_ref().and_then(|own| cost(figures, own)),
            units: units(&report.units),
            energy: report.energy.iter().flatten().map(component).collect(),
            srp: kernels(run),
        }
    }
}

/// A cost; nothing where nothing was done in no time.
fn cost(run: &RunFigures, own: &RunCost) -> Option<Cost> {
    Some(Cost {
        cycles: run.cycles?,
        time_ms: run.time_ms?,
        power_w: own.power_w?,
        energy_mj: own.energy_mj?,
        perf_per_watt: own.perf_per_watt?,
    })
}

/// Each stage of each kind of unit, all units of the kind together. `rows` are those of a report.
fn units(rows: &Value) -> Vec<Unit> {
    let mut sums: Vec<(String, Vec<(String, u64)>)> = Vec::new();
    for row in rows.as_array().into_iter().flatten() {
        let text = |key: &str| row[key].as_str().unwrap_or_default();
        let name = format!("{}/{}", text("unit"), text("stage"));
        let at = sums.iter().position(|(known, _)| *known == name).unwrap_or_else(|| {
            sums.push((name, Vec::new()));
            sums.len() - 1
        });
        for (state, cycles) in row["classes"].as_object().into_iter().flatten() {
            let cycles = cycles.as_u64().unwrap_or(0);
            match sums[at].1.iter_mut().find(|(known, _)| known == state) {
                Some((_, sum)) => *sum += cycles,
                None => sums[at].1.push((state.clone(), cycles)),
            }
        }
    }
    let share = |(unit, states): (String, Vec<(String, u64)>)| {
        let all = states.iter().map(|(_, cycles)| cycles).sum::<u64>().max(1) as f64;
        let shares = states.into_iter().map(|(state, cycles)| StateShare { state, share: cycles as f64 / all });
        Unit { unit, shares: shares.collect() }
    };
    sums.into_iter().map(share).collect()
}

/// The kernels of all SRPs.
fn kernels(run: &MachineRun) -> Vec<Kernel> {
    let srps = || run.stats.cores.iter().map(|core| &core.srp);
    let busy = srps().map(|srp| srp.activity.busy_cycles()).sum::<u64>().max(1) as f64;
    let kernel = |id: KernelId| {
        let cycles = srps().map(|srp| srp.kernels[id as usize].cycles).sum::<u64>();
        Kernel { kernel: id.name().into(), cycles, share: cycles as f64 / busy }
    };
    KernelId::ALL.into_iter().map(kernel).collect()
}
