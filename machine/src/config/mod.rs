//! A machine as numbers: plain structs, one a block, each value in the unit that its name ends with.
//!
//! Values come from presets (`presets/*.toml`), files and overrides; `load` merges and checks them and keeps for each its class
//! and source. The simulator sees only these structs, already checked.

mod check;
pub mod load;
mod merge;
pub mod schema;
pub mod source;
pub mod units;

use serde::{Deserialize, Serialize};

pub use load::{NamedMachine, PRESETS};
pub use source::{Class, Sourced};
pub use units::{Bytes, Picojoules};

/// How the three kinds of traversal work share hardware.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Pipeline {
    /// Inner-node, leaf and stack work each have their own pipeline (SA'12 poster).
    Parallel,
    /// One pipeline: one operation of any of the three a cycle, each passing all stages.
    Single,
    /// As `Single`, and triangle tests pass it too (RayCore): there is no separate intersection unit.
    Unified,
}

/// What happens to an operation whose data miss the L1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum MissHandling {
    /// It passes the pipeline as a bypass and tries again.
    Retry,
    /// It is parked in a row of the ray accumulation buffer until the line arrives.
    Accumulate,
    /// It stays in its slot of the input buffer; slots issue in the order in which they are ready (Reorder Buffer).
    Reorder,
}

/// Which line of a set makes room.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Replacement {
    /// The least recently used.
    Lru,
    /// The one filled first.
    Fifo,
    /// A random one, from a generator with a fixed seed.
    Random,
}

/// How rays and hits travel between SRP and T&I unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Interface {
    /// A direct on-chip link (Shin 2013).
    Direct,
    /// Through system memory: written by one side, read by the other.
    Memory,
}

/// Where the attributes of a tile's samples are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum GeometryBuffer {
    /// In the SRP's local memory (the tile buffer); what does not fit is spilled and charged.
    OnChip,
    /// In DRAM.
    External,
}

/// How primary visibility is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum PrimaryVisibility {
    /// By primary rays.
    Traced,
    /// By a rasteriser that writes a G-buffer.
    Raster,
}

/// What branches cost on the SRP.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Divergence {
    /// Items are sorted by branch first (inspector), then each branch runs by itself (executor).
    Inspector,
    /// Mixed batches: every item pays for every branch present in its batch.
    Naive,
}

/// A whole machine.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MachineConfig {
    /// What the cores share and how they are coupled.
    pub gpu: Gpu,
    /// The traversal and intersection unit of a core.
    pub ti: Ti,
    /// The shared second-level cache.
    pub l2: L2,
    /// The memory.
    pub dram: Dram,
    /// The programmable shader of a core.
    pub srp: Srp,
    /// Where things lie in memory, and how large they are.
    pub layout: LayoutSizes,
    /// The rasteriser (`gpu.primary_visibility = "raster"`).
    pub raster: Raster,
    /// Energy per event and leakage.
    pub energy: Energy,
}

/// The whole GPU.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gpu {
    /// Cores: each an SRP and a T&I unit.
    pub cores: u32,
    /// Tiles that a core works on at a time.
    pub tiles_in_flight: u32,
    /// Way between SRP and T&I unit.
    pub interface: Interface,
    /// Width of the direct interface per direction, bytes per T&I cycle.
    pub interface_bytes_per_cycle: u32,
    /// Size of a ray on the interface, bytes.
    pub ray_message_bytes: u32,
    /// Size of a hit on the interface, bytes.
    pub hit_message_bytes: u32,
    /// Place of the geometry buffer.
    pub geometry_buffer: GeometryBuffer,
    /// Way to primary visibility.
    pub primary_visibility: PrimaryVisibility,
}

/// The T&I unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ti {
    /// Clock of T&I units, their L1s and the L2, MHz.
    pub clock_mhz: u32,
    /// Traversal units of a core.
    pub trv: u32,
    /// Intersection units of a core.
    pub ist: u32,
    /// Pipeline arrangement.
    pub pipeline: Pipeline,
    /// Boxes tested per cycle: 2 tests a node's children together, 1 takes two passes.
    pub aabbs_per_cycle: u32,
    /// Entries of the dispatcher's ray buffer.
    pub ray_fifo_entries: u32,
    /// Rays that a traversal unit holds.
    pub rays_per_trv: u32,
    /// Entries of the input buffer of an intersection unit, leaf tasks.
    pub ist_entries: u32,
    /// Miss handling of traversal and intersection units.
    pub miss_handling: MissHandling,
    /// Rows of a ray accumulation buffer: lines waited for at a time (`accumulate`).
    pub accumulate_rows: u32,
    /// Rays that a row can hold (`accumulate`).
    pub accumulate_rays_per_row: u32,
    /// Ray setup (reciprocal direction), cycles.
    pub setup_cycles: u32,
    /// Depth of the inner-node pipeline, cycles.
    pub inner_cycles: u32,
    /// Depth of the leaf pipeline, cycles.
    pub leaf_cycles: u32,
    /// Depth of the stack pipeline, cycles.
    pub stack_cycles: u32,
    /// Depth of the triangle pipeline, cycles.
    pub ist_cycles: u32,
    /// Crossbar between TRV and IST units, per direction, cycles.
    pub crossbar_cycles: u32,
    /// Entries of the short stack; 0 is a full stack, never restarted.
    pub stack_entries: u32,
    /// Neighbouring lines that a traversal unit reads from its L1 in a cycle: banks by line. With one, a node that straddles
    /// two lines takes two cycles.
    pub trv_lines_per_cycle: u32,
    /// The same for the triangles of an intersection unit.
    pub ist_lines_per_cycle: u32,
    /// L1 of each traversal unit.
    pub trv_l1: L1,
    /// L1 of each intersection unit.
    pub ist_l1: L1,
}

/// A first-level cache. Non-blocking; reads only.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L1 {
    /// Size, bytes.
    pub size: Bytes,
    /// Ways.
    pub ways: u32,
    /// Lines that can be waited for at a time.
    pub mshrs: u32,
    /// Hit latency, cycles.
    pub latency_cycles: u32,
    /// Replacement.
    pub replacement: Replacement,
}

/// The second-level cache, in the clock of the T&I unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct L2 {
    /// Size, bytes.
    pub size: Bytes,
    /// Ways.
    pub ways: u32,
    /// Banks, interleaved by line; each takes one request a cycle.
    pub banks: u32,
    /// Requests that a bank can queue.
    pub queue_entries: u32,
    /// Lines that can be waited for at a time, all banks.
    pub mshrs: u32,
    /// Hit latency, cycles.
    pub latency_cycles: u32,
    /// Replacement.
    pub replacement: Replacement,
    /// A line that leaves the L2 leaves the L1s too.
    pub inclusive: bool,
    /// Line size of all caches, bytes.
    pub line_bytes: u32,
}

/// LPDDR4: timings in cycles of its clock (tCK).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Dram {
    /// Clock, MHz: half the data rate.
    pub clock_mhz: u32,
    /// Channels of 16 bits, interleaved by line.
    pub channels: u32,
    /// Banks per channel.
    pub banks: u32,
    /// Row (page) of a bank, bytes.
    pub row_bytes: u32,
    /// Bytes per burst: BL16 on 16 bits.
    pub burst_bytes: u32,
    /// Data bus time of a burst, and least distance of column commands (tCCD).
    pub tccd: u32,
    /// Activate to column command.
    pub trcd: u32,
    /// Precharge of a bank.
    pub trp: u32,
    /// Precharge of all banks, before a refresh.
    pub trp_all: u32,
    /// Activate to precharge.
    pub tras: u32,
    /// Activate to activate, other bank.
    pub trrd: u32,
    /// Window of four activates.
    pub tfaw: u32,
    /// Read command to first data, tDQSCK included.
    pub rl: u32,
    /// Write command to first data.
    pub wl: u32,
    /// Read to precharge.
    pub trtp: u32,
    /// End of write data to precharge.
    pub twr: u32,
    /// End of write data to read command.
    pub twtr: u32,
    /// All-bank refresh.
    pub trfc: u32,
    /// Mean distance of refreshes.
    pub trefi: u32,
    /// Entries of the read queue of a channel, lines.
    pub read_queue_entries: u32,
    /// Entries of the write queue of a channel, lines.
    pub write_queue_entries: u32,
    /// Writes waiting at which writes go first.
    pub write_high: u32,
    /// Writes waiting at which reads go first again.
    pub write_low: u32,
    /// Controller and network, request to command queue and data to requester together, cycles.
    pub controller_cycles: u32,
    /// Synchroniser at each clock-domain crossing, cycles of the receiving clock.
    pub sync_cycles: u32,
}

/// A kernel of the SRP.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernel {
    /// Initiation interval: cycles from one item to the next. 0 means that the machine has no such kernel.
    pub ii_cycles: u32,
    /// Prologue and epilogue of the software pipeline, cycles a batch.
    pub prologue_cycles: u32,
    /// Operations an item, for energy.
    pub ops: u32,
}

/// The kernels, in order of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Kernels {
    /// A primary ray.
    pub raygen: Kernel,
    /// A hit: material, texture, one light; spawns shadow and secondary rays.
    pub shade: Kernel,
    /// Every shadow ray beyond the first of a hit.
    pub light: Kernel,
    /// A closest-hit ray that left the scene.
    pub miss: Kernel,
    /// The result of a shadow ray, added to its sample.
    pub update: Kernel,
    /// A similarity test.
    pub similarity: Kernel,
    /// An interpolated sample.
    pub interpolate: Kernel,
    /// A sample averaged into its pixel.
    pub resolve: Kernel,
}

/// The programmable shader.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Srp {
    /// Clock, MHz.
    pub clock_mhz: u32,
    /// Kernels take no time: the T&I unit alone is measured. Memory and interface traffic stay.
    pub ideal: bool,
    /// Cost of branches.
    pub divergence: Divergence,
    /// Inspector, cycles an item.
    pub inspector_cycles: u32,
    /// A batch waits for so many items while others can run or the T&I unit still works.
    pub batch_min: u32,
    /// Most items of a batch.
    pub batch_max: u32,
    /// Kernels.
    pub kernels: Kernels,
    /// Local memory, bytes.
    pub local_memory: Bytes,
    /// Bytes a sample in the tile buffer, by field.
    pub sample: SampleFields,
    /// L1 data cache: vertex attributes and texels.
    pub l1: L1,
    /// Bytes of vertex attributes read per hit.
    pub attribute_bytes: u32,
    /// Hits read a texel each: the trace does not say which materials are textured.
    pub textures: bool,
    /// Bytes a texel.
    pub texel_bytes: u32,
}

/// The tile buffer, bytes a sample by field.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleFields {
    /// Object id.
    pub object: u32,
    /// Normal.
    pub normal: u32,
    /// Position.
    pub position: u32,
    /// Shadow bits.
    pub shadow: u32,
    /// Colour.
    pub colour: u32,
    /// State of the sample.
    pub flags: u32,
}

impl SampleFields {
    /// A whole sample.
    pub fn total(&self) -> u32 {
        self.object + self.normal + self.position + self.shadow + self.colour + self.flags
    }
}

/// Sizes of what lies in memory.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LayoutSizes {
    /// A node of two children, bytes.
    pub node_bytes: u32,
    /// A triangle, bytes.
    pub triangle_bytes: u32,
    /// A pixel of the framebuffer, bytes.
    pub pixel_bytes: u32,
}

/// The rasteriser of a hybrid GPU.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Raster {
    /// Samples a T&I cycle and core.
    pub samples_per_cycle: u32,
    /// Bytes of a G-buffer sample, written by the rasteriser and read by the SRP.
    pub gbuffer_bytes: u32,
}

/// Energy per event, pJ, and leakage. Component names are those of the report.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Energy {
    /// Test of one box (two boxes a two-AABB operation).
    pub box_test_pj: Picojoules,
    /// Test of one triangle.
    pub triangle_test_pj: Picojoules,
    /// Ray setup.
    pub ray_setup_pj: Picojoules,
    /// An operation that passes a pipeline as a bypass.
    pub bypass_pj: Picojoules,
    /// Read of a ray's record from a ray buffer.
    pub ray_buffer_read_pj: Picojoules,
    /// Write of a ray's record into a ray buffer.
    pub ray_buffer_write_pj: Picojoules,
    /// Push onto a traversal stack.
    pub stack_push_pj: Picojoules,
    /// Pop from a traversal stack.
    pub stack_pop_pj: Picojoules,
    /// Transfer of a leaf task or its result through the crossbar.
    pub crossbar_pj: Picojoules,
    /// L1 of a TRV unit: read of a line that hits.
    pub trv_l1_read_pj: Picojoules,
    /// L1 of an IST unit: read of a line that hits.
    pub ist_l1_read_pj: Picojoules,
    /// L1 of the SRP: read of a line that hits.
    pub srp_l1_read_pj: Picojoules,
    /// Any L1: a lookup that misses (tags only).
    pub l1_miss_pj: Picojoules,
    /// Any L1: fill of a line.
    pub l1_fill_pj: Picojoules,
    /// A lookup or update of an accumulation row.
    pub accumulate_pj: Picojoules,
    /// A state update of a reorder-buffer slot.
    pub reorder_pj: Picojoules,
    /// L2: read of a line that hits.
    pub l2_read_pj: Picojoules,
    /// L2: a lookup that misses.
    pub l2_miss_pj: Picojoules,
    /// L2: fill of a line.
    pub l2_fill_pj: Picojoules,
    /// Direct interface, per byte.
    pub interface_pj_per_byte: Picojoules,
    /// SRP operation, operands and configuration included.
    pub srp_op_pj: Picojoules,
    /// SRP local memory: 4 bytes read.
    pub local_read_pj: Picojoules,
    /// SRP local memory: 4 bytes written.
    pub local_write_pj: Picojoules,
    /// DRAM: activate and precharge of a row.
    pub dram_row_pj: Picojoules,
    /// DRAM: read of a burst, IO included.
    pub dram_read_pj: Picojoules,
    /// DRAM: write of a burst, IO included.
    pub dram_write_pj: Picojoules,
    /// DRAM: refresh of all banks of a channel.
    pub dram_refresh_pj: Picojoules,
    /// PHY and controller, per byte.
    pub dram_phy_pj_per_byte: Picojoules,
    /// DRAM background, per channel, microwatts.
    pub dram_background_uw: u64,
    /// SRAM leakage, microwatts per KiB.
    pub sram_leakage_uw_per_kib: u64,
    /// Logic leakage of a TRV unit, microwatts.
    pub trv_leakage_uw: u64,
    /// Logic leakage of an IST unit, microwatts.
    pub ist_leakage_uw: u64,
    /// Logic leakage of an SRP, microwatts.
    pub srp_leakage_uw: u64,
    /// Clock tree: percent of dynamic on-chip energy, added to each component.
    pub clock_tree_percent: u64,
}
