//! Who stands behind a port of the memory.

use crate::config::{MachineConfig, Pipeline};
use crate::memory::Port;
use crate::system::SRP_PORTS;
use crate::traversal::TracingUnit;

/// A unit that asks memory.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asker {
    /// Core.
    pub core: u32,
    /// The unit in its core, such as `TRV 0`, `IST 3`, `SRP`, `DMA`.
    pub unit: String,
}

/// The units of a machine in the order of their ports.
pub fn askers(config: &MachineConfig) -> Vec<Asker> {
    let ti = &config.ti;
    let named = |name: &str, count: u32| (0..count).map(|i| format!("{name} {i}")).collect::<Vec<_>>();
    let tracing = match ti.pipeline {
        Pipeline::Parallel | Pipeline::Single | Pipeline::Unified => [named("TRV", ti.trv), named("IST", ti.ist)],
        Pipeline::Gathering => [named("TRV", ti.trv), Vec::new()],
        Pipeline::Software => [named("processor", ti.trv), named("processor code", ti.trv)],
    };
    let units: Vec<String> = tracing.into_iter().flatten().chain(["SRP".to_owned(), "DMA".to_owned()]).collect();
    debug_assert_eq!(units.len(), usize::from(TracingUnit::ports(config) + SRP_PORTS));
    let of_core = |core| units.iter().map(move |unit| Asker { core, unit: unit.clone() });
    (0..config.gpu.cores).flat_map(of_core).collect()
}

/// Whether the units of a machine tell what they look for, ray by ray: those of fixed function do. Processors and units that gather
/// rays look things up for several rays at once.
pub fn tells_lookups(config: &MachineConfig) -> bool {
    matches!(config.ti.pipeline, Pipeline::Parallel | Pipeline::Single | Pipeline::Unified)
}

/// The number of a port in [`askers`].
pub fn place(port: Port) -> usize {
    port.0.into()
}
