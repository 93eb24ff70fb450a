//! What a kernel costs: batch timing.
//!
//! A batch of n items takes `[inspector] + prologue + sum of the items' initiation intervals` SRP cycles (software pipelining on
//! the array). Item i is complete at `start + inspector + prologue + (intervals of items 0..=i)`.
//!
//! * `divergence = "inspector"`: a kernel that branches (`shade` by material, `similarity` by its outcome) is preceded by the
//!   inspector, `inspector_cycles` an item, which sorts items by branch; a batch then has one branch.
//! * `divergence = "naive"`: one batch holds items of k branches and each item pays for all of them (predicated execution):
//!   `prologue + k x intervals`. `similarity` has k = 2 in a round that both interpolates and traces.
//! * The interval of a `shade` item is `shade.ii + light.ii x (shadow rays - 1)`: the first light is part of `shade`.
//!
//! Class of these rules: estimate, except that kernels use inspector and executor (paper).

use crate::config::{Divergence, Kernel, MachineConfig};
use crate::work::TileWork;

/// The kernels, in order of the report and of priority among equals.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum KernelId {
    /// A primary ray.
    Raygen = 0,
    /// A hit.
    Shade = 1,
    /// A closest-hit ray that left the scene.
    Miss = 2,
    /// The result of a shadow ray.
    ShadowResult = 3,
    /// A similarity test.
    Similarity = 4,
    /// An interpolated sample.
    Interpolate = 5,
    /// A sample averaged into its pixel.
    Resolve = 6,
}

impl KernelId {
    /// All kernels, in order.
    pub const ALL: [Self; 7] =
        [Self::Raygen, Self::Shade, Self::Miss, Self::ShadowResult, Self::Similarity, Self::Interpolate, Self::Resolve];

    /// The name, as presets and reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raygen => "raygen",
            Self::Shade => "shade",
            Self::Miss => "miss",
            Self::ShadowResult => "update",
            Self::Similarity => "similarity",
            Self::Interpolate => "interpolate",
            Self::Resolve => "resolve",
        }
    }

    /// Whether items of this kernel send rays.
    pub fn emits(self) -> bool {
        matches!(self, Self::Raygen | Self::Shade)
    }

    /// Whether items of this kernel take different branches.
    pub fn branches(self) -> bool {
        matches!(self, Self::Shade | Self::Similarity)
    }
}

/// Costs of all kernels of a machine.
#[derive(Clone, Debug)]
pub struct Costs {
    kernels: [Kernel; 7],
    light: Kernel,
    inspector_cycles: Option<u64>,
}

impl Costs {
    /// The costs of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        let k = &config.srp.kernels;
        Self {
            kernels: [k.raygen, k.shade, k.miss, k.update, k.similarity, k.interpolate, k.resolve],
            light: k.light,
            inspector_cycles: (config.srp.divergence == Divergence::Inspector)
                .then_some(config.srp.inspector_cycles.into()),
        }
    }

    /// Whether an inspector sorts items by branch.
    pub fn sorts(&self) -> bool {
        self.inspector_cycles.is_some()
    }

    /// SRP cycles of the inspector before a batch.
    pub fn inspector(&self, kernel: KernelId, items: u64) -> u64 {
        match self.inspector_cycles {
            Some(cycles) if kernel.branches() => cycles * items,
            _ => 0,
        }
    }

    /// SRP cycles of the prologue and epilogue of a batch.
    pub fn prologue(&self, kernel: KernelId) -> u64 {
        self.kernels[kernel as usize].prologue_cycles.into()
    }

    /// SRP cycles from the item before to this one, for an item with `shadows` shadow rays, in a batch of one branch.
    #[inline]
    pub fn interval(&self, kernel: KernelId, shadows: u8) -> u64 {
        let first = u64::from(self.kernels[kernel as usize].ii_cycles);
        first + u64::from(self.light.ii_cycles) * u64::from(shadows.saturating_sub(1))
    }

    /// Operations of an item with `shadows` shadow rays. Operations of branches not taken are not counted.
    #[inline]
    pub fn ops(&self, kernel: KernelId, shadows: u8) -> u64 {
        let first = u64::from(self.kernels[kernel as usize].ops);
        first + u64::from(self.light.ops) * u64::from(shadows.saturating_sub(1))
    }
}

/// Optional kernels that some work needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// It makes similarity tests.
    pub similarity: bool,
    /// It interpolates samples.
    pub interpolate: bool,
}

impl Needs {
    /// What the work of a tile needs.
    pub fn of(work: &TileWork) -> Self {
        Self {
            similarity: work.rounds.iter().any(|w| w.tests > 0),
            interpolate: work.rounds.iter().any(|w| w.interpolated > 0),
        }
    }

    /// What either needs.
    pub fn or(self, other: Self) -> Self {
        Self { similarity: self.similarity || other.similarity, interpolate: self.interpolate || other.interpolate }
    }
}

/// Names of the kernels that are needed and that the machine does not have (`ii_cycles = 0`).
pub fn missing_kernels(config: &MachineConfig, needs: &Needs) -> Vec<&'static str> {
    let k = &config.srp.kernels;
    [(needs.similarity, k.similarity, "similarity"), (needs.interpolate, k.interpolate, "interpolate")]
        .into_iter()
        .filter(|(needed, kernel, _)| *needed && kernel.ii_cycles == 0)
        .map(|(_, _, name)| name)
        .collect()
}
