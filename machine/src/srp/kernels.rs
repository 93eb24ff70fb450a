//! What a kernel costs: batch timing.
//!
//! A batch of n items takes `[inspector] + prologue + sum of the items' initiation intervals` SRP cycles (software pipelining on
//! the array). Item i is complete at `start + inspector + prologue + (intervals of items 0..=i)`.
//!
//! * `divergence = "inspector"`: a kernel that branches (`shade` by material, `similarity` by its outcome) is preceded by the
//!   inspector, `inspector_cycles` an item, which sorts items by branch; a batch then has one branch.
//! * `divergence = "naive"`: one batch holds items of k branches and each item pays for all of them (predicated execution):
//!   `prologue + k x intervals`. `similarity` has k = 2 in a round that both interpolates and traces.
//! * The interval of a `shade` item is `shade.ii + light.ii x (lights - 1) + secondary.ii x (reflection and refraction
//!   rays)`: the first light is part of `shade`.
//! * What a policy adds has kernels whose operations are counted from what it reads ([`PolicyReads`]): `similarity` the
//!   attributes of a pair of hits, `colour` a difference of colours, `look_back` a hit in the history, `interpolate` the colour of a sample, `attributes` what
//!   later tests read of an interpolated hit, `control` the rate or limit of a tile; `reshade` is `shade` without its reads. Their interval is the operations over
//!   `srp.ops_per_cycle`, rounded up, and the prologue so many stages of it.
//!
//! Class of these rules: estimate, except that kernels use inspector and executor (paper).

use crate::config::{Divergence, Kernel, MachineConfig, Pipeline, PolicyKernel};
use crate::work::{NO_RAY, PolicyReads, RayWork, TileWork};

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
    /// A difference of colours.
    Colour = 5,
    /// An interpolated sample.
    Interpolate = 6,
    /// The attributes of an interpolated hit.
    Attributes = 7,
    /// An interpolated sample that is shaded from its attributes.
    Reshade = 8,
    /// A hit whose lights are looked for in the frame before.
    LookBack = 9,
    /// The rate or limit of a tile.
    Control = 10,
    /// A sample averaged into its pixel.
    Resolve = 11,
}

/// Number of kernels.
pub const KERNELS: usize = 12;

impl KernelId {
    /// All kernels, in order.
    pub const ALL: [Self; KERNELS] = [
        Self::Raygen,
        Self::Shade,
        Self::Miss,
        Self::ShadowResult,
        Self::Similarity,
        Self::Colour,
        Self::Interpolate,
        Self::Attributes,
        Self::Reshade,
        Self::LookBack,
        Self::Control,
        Self::Resolve,
    ];

    /// The name, as presets and reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Raygen => "raygen",
            Self::Shade => "shade",
            Self::Miss => "miss",
            Self::ShadowResult => "update",
            Self::Similarity => "similarity",
            Self::Colour => "colour",
            Self::Interpolate => "interpolate",
            Self::Attributes => "attributes",
            Self::Reshade => "reshade",
            Self::LookBack => "look_back",
            Self::Control => "control",
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

/// The rays that an item of `shade` sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Sends {
    /// Shadow rays.
    pub shadows: u8,
    /// Lights that are shaded without a ray.
    pub known: u8,
    /// Reflection and refraction rays.
    pub secondary: u8,
}

impl Sends {
    /// Lights beyond the first.
    fn more_lights(self) -> u64 {
        u64::from((self.shadows + self.known).saturating_sub(1))
    }

    /// Those of an item of `kernel`.
    #[inline]
    pub fn of(kernel: KernelId, ray: &RayWork) -> Self {
        if kernel != KernelId::Shade {
            return Self::default();
        }
        let secondary = u8::from(ray.reflect != NO_RAY) + u8::from(ray.refract != NO_RAY);
        Self { shadows: ray.shadows, known: ray.known_lights, secondary }
    }
}

/// Costs of all kernels of a machine under a policy.
#[derive(Clone, Debug)]
pub struct Costs {
    kernels: [Kernel; KERNELS],
    light: Kernel,
    secondary: Kernel,
    inspector_cycles: Option<u64>,
    inspector_ops: u64,
    /// Items take time of the array.
    timed: bool,
}

impl Costs {
    /// The costs of a machine under a policy that reads what `policy` says.
    pub fn new(config: &MachineConfig, policy: &PolicyReads) -> Self {
        let (srp, k) = (&config.srp, &config.srp.kernels);
        let only = |ops: u32, is_read: bool| if is_read { ops } else { 0 };
        let (test, mix) = (&srp.test_ops, &srp.mix_ops);
        let tests = only(test.object, policy.object)
            + only(test.normal, policy.normal)
            + only(test.shadow, policy.shadow)
            + only(test.position, policy.position)
            + only(test.plane, policy.plane);
        let mixed = only(mix.identity, policy.object || policy.shadow)
            + only(mix.normal, policy.normal || policy.plane)
            + only(mix.position, policy.distance())
            + only(mix.distance, policy.distance())
            + only(mix.local, policy.local)
            + only(mix.weights, policy.weights);
        let made = |kernel: &PolicyKernel, more: u32| {
            let ops = kernel.ops + more;
            let ii_cycles = ops.div_ceil(srp.ops_per_cycle.max(1)).max(1);
            Kernel { ii_cycles, prologue_cycles: kernel.stages * ii_cycles, ops }
        };
        Self {
            kernels: [
                k.raygen,
                k.shade,
                k.miss,
                k.update,
                made(&k.similarity, tests),
                made(&k.colour, 0),
                made(&k.interpolate, 0),
                made(&k.attributes, mixed),
                // The material is that of the ends, its texel is in their colours: nothing is gathered, no ray is sent.
                k.shade,
                made(&k.look_back, 0),
                made(&k.control, 0),
                k.resolve,
            ],
            light: k.light,
            secondary: k.secondary,
            inspector_cycles: (srp.divergence == Divergence::Inspector).then_some(srp.inspector_cycles.into()),
            inspector_ops: srp.inspector_ops.into(),
            timed: !srp.ideal && config.ti.pipeline != Pipeline::Software,
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

    /// SRP cycles from the item before to this one, for an item that sends `sends`, in a batch of one branch.
    #[inline]
    pub fn interval(&self, kernel: KernelId, sends: Sends) -> u64 {
        let first = u64::from(self.kernels[kernel as usize].ii_cycles);
        first
            + u64::from(self.light.ii_cycles) * sends.more_lights()
            + u64::from(self.secondary.ii_cycles) * u64::from(sends.secondary)
    }

    /// The work of so many items, in SRP cycles, whatever they send: nothing where the array takes no time for it. It tells how far a
    /// machine is, so it depends on nothing but which items are done.
    pub fn work(&self, kernel: KernelId, items: u64) -> u64 {
        if self.timed { items * u64::from(self.kernels[kernel as usize].ii_cycles) } else { 0 }
    }

    /// Operations of an item that sends `sends`, in a batch of `branches` branches: predicated, an item does those of all. The
    /// inspector's are among them.
    #[inline]
    pub fn ops(&self, kernel: KernelId, sends: Sends, branches: u64) -> u64 {
        let first = u64::from(self.kernels[kernel as usize].ops);
        let rays = u64::from(self.light.ops) * sends.more_lights()
            + u64::from(self.secondary.ops) * u64::from(sends.secondary);
        let inspector = if self.sorts() && kernel.branches() { self.inspector_ops } else { 0 };
        (first + rays) * branches + inspector
    }
}

/// Optional kernels that some work needs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Needs {
    /// It makes similarity tests.
    pub similarity: bool,
    /// It interpolates samples.
    pub interpolate: bool,
    /// It looks for lights in the frame before.
    pub look_back: bool,
}

impl Needs {
    /// What the work of a tile needs.
    pub fn of(work: &TileWork) -> Self {
        Self {
            similarity: work.rounds.iter().any(|w| w.tests > 0 || w.colours > 0),
            interpolate: work.rounds.iter().any(|w| w.interpolated > 0 || w.attributes > 0),
            look_back: work.rounds.iter().any(|w| w.looked_back > 0),
        }
    }

    /// What either needs.
    pub fn or(self, other: Self) -> Self {
        Self {
            similarity: self.similarity || other.similarity,
            interpolate: self.interpolate || other.interpolate,
            look_back: self.look_back || other.look_back,
        }
    }
}

/// Names of the kernels that are needed and that the machine does not have (`stages = 0`).
pub fn missing_kernels(config: &MachineConfig, needs: &Needs) -> Vec<&'static str> {
    let k = &config.srp.kernels;
    [
        (needs.similarity, k.similarity, "similarity"),
        (needs.interpolate, k.interpolate, "interpolate"),
        (needs.look_back, k.look_back, "look_back"),
    ]
    .into_iter()
    .filter(|(needed, kernel, _)| *needed && kernel.stages == 0)
    .map(|(_, _, name)| name)
    .collect()
}
