//! The keys of a machine: which exist, and what values they take. Presets, files and overrides are all checked against this one
//! table, so a wrong key or value is named before anything runs.
//!
//! The limits are wide: they keep out what cannot be built and what would make the simulator allocate or run without bound, and
//! nothing else. What two keys must hold together stands in `check`.

use toml::Value;

use super::units::Bytes;

/// What values a key takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Rule {
    /// One of these words.
    Word(&'static [&'static str]),
    /// A whole number from the first to the second.
    Integer(i64, i64),
    /// A size in bytes from the first to the second; text may say `16KiB`.
    Size(u64, u64),
    /// True or false.
    Flag,
    /// An energy from 0 to so many pJ, kept to the femtojoule.
    Energy(u32),
}

/// A key of a machine.
#[derive(Clone, Copy, Debug)]
pub struct Key {
    /// Name with dots.
    pub name: &'static str,
    /// Allowed values.
    pub rule: Rule,
}

/// Whether an override `key=value` is meant for a machine: its key begins with one of the machine's tables.
pub fn is_machine_override(text: &str) -> bool {
    let key = text.split('=').next().unwrap_or_default();
    let table = key.split('.').next().unwrap_or_default().trim();
    KEYS.iter().any(|known| known.name.split('.').next() == Some(table))
}

impl Rule {
    /// The value as it is kept (sizes in bytes, energies as pJ of whole femtojoules), if it is allowed.
    pub fn accept(&self, value: &Value) -> Option<Value> {
        match self {
            Self::Word(words) => value.as_str().filter(|word| words.contains(word)).map(|_| value.clone()),
            Self::Integer(low, high) => value.as_integer().filter(|i| (low..=high).contains(&i)).map(Value::Integer),
            Self::Size(low, high) => {
                let bytes = match value {
                    Value::Integer(i) => u64::try_from(*i).ok()?,
                    Value::String(text) => Bytes::parse(text)?.0,
                    _ => return None,
                };
                (*low..=*high).contains(&bytes).then_some(())?;
                i64::try_from(bytes).ok().map(Value::Integer)
            }
            Self::Flag => value.as_bool().map(Value::Boolean),
            Self::Energy(max) => {
                let pj = match value {
                    Value::Integer(i) => *i as f64,
                    Value::Float(f) => *f,
                    _ => return None,
                };
                (0.0..=f64::from(*max)).contains(&pj).then(|| Value::Float((pj * 1000.0).round() / 1000.0))
            }
        }
    }

    /// The allowed values, for people.
    pub fn describe(&self) -> String {
        match self {
            Self::Word(words) => words.iter().map(|w| format!("{w:?}")).collect::<Vec<_>>().join(" or "),
            Self::Integer(low, high) => format!("a whole number from {low} to {high}"),
            Self::Size(low, high) => format!("a size from {} to {}, such as 16KiB", Bytes(*low), Bytes(*high)),
            Self::Flag => "true or false".into(),
            Self::Energy(max) => format!("a number of picojoules from 0 to {max}"),
        }
    }

    /// An accepted value, for people and for a TOML file.
    pub fn show(&self, value: &Value) -> String {
        match (self, value) {
            (Self::Size(..), Value::Integer(bytes)) => format!("\"{}\"", Bytes(*bytes as u64)),
            _ => value.to_string(),
        }
    }
}

const fn key(name: &'static str, rule: Rule) -> Key {
    Key { name, rule }
}

const fn int(name: &'static str, low: i64, high: i64) -> Key {
    key(name, Rule::Integer(low, high))
}

const fn pj(name: &'static str) -> Key {
    key(name, Rule::Energy(1_000_000))
}

/// Clocks, MHz.
const CLOCK: Rule = Rule::Integer(1, 5000);
/// Depth of a pipeline or latency, cycles.
const DEPTH: Rule = Rule::Integer(1, 256);
/// DRAM timings, tCK.
const TIMING: Rule = Rule::Integer(1, 1024);
/// First-level caches and local memories.
const SMALL: Rule = Rule::Size(1 << 10, 1 << 20);
const WAYS: Rule = Rule::Integer(1, 64);
/// Lines waited for.
const MSHRS: Rule = Rule::Integer(1, 256);
const REPLACEMENT: Rule = Rule::Word(&["lru", "fifo", "random"]);
/// Energy is counted per item, in u64: enough room for any run.
const OPS: Rule = Rule::Integer(0, 100_000);
/// A kernel that a machine must have.
const INTERVAL: Rule = Rule::Integer(1, 10_000);
/// A kernel that a machine may lack.
const INTERVAL_OR_NONE: Rule = Rule::Integer(0, 10_000);
const PROLOGUE: Rule = Rule::Integer(0, 10_000);
/// Bytes of a field of a sample.
const FIELD: Rule = Rule::Integer(0, 64);

/// All keys, in the order of the structs.
pub const KEYS: &[Key] = &[
    int("gpu.cores", 1, 64),
    int("gpu.tiles_in_flight", 1, 16),
    key("gpu.interface", Rule::Word(&["direct", "memory"])),
    int("gpu.interface_bytes_per_cycle", 1, 1024),
    int("gpu.ray_message_bytes", 1, 256),
    int("gpu.hit_message_bytes", 1, 256),
    key("gpu.geometry_buffer", Rule::Word(&["on_chip", "external"])),
    key("gpu.primary_visibility", Rule::Word(&["traced", "raster"])),
    key("ti.clock_mhz", CLOCK),
    int("ti.trv", 1, 16),
    int("ti.ist", 0, 16),
    key("ti.pipeline", Rule::Word(&["parallel", "single", "unified"])),
    int("ti.aabbs_per_cycle", 1, 2),
    int("ti.ray_fifo_entries", 1, 1024),
    // Slot masks have 128 bits.
    int("ti.rays_per_trv", 1, 128),
    int("ti.ist_entries", 1, 128),
    key("ti.miss_handling", Rule::Word(&["retry", "accumulate", "reorder"])),
    int("ti.accumulate_rows", 1, 128),
    int("ti.accumulate_rays_per_row", 1, 128),
    key("ti.setup_cycles", DEPTH),
    key("ti.inner_cycles", DEPTH),
    key("ti.leaf_cycles", DEPTH),
    key("ti.stack_cycles", DEPTH),
    key("ti.ist_cycles", DEPTH),
    key("ti.crossbar_cycles", DEPTH),
    int("ti.stack_entries", 0, 64),
    int("ti.trv_lines_per_cycle", 1, 4),
    int("ti.ist_lines_per_cycle", 1, 4),
    key("ti.trv_l1.size", SMALL),
    key("ti.trv_l1.ways", WAYS),
    key("ti.trv_l1.mshrs", MSHRS),
    key("ti.trv_l1.latency_cycles", DEPTH),
    key("ti.trv_l1.replacement", REPLACEMENT),
    key("ti.ist_l1.size", SMALL),
    key("ti.ist_l1.ways", WAYS),
    key("ti.ist_l1.mshrs", MSHRS),
    key("ti.ist_l1.latency_cycles", DEPTH),
    key("ti.ist_l1.replacement", REPLACEMENT),
    key("l2.size", Rule::Size(4 << 10, 64 << 20)),
    key("l2.ways", WAYS),
    int("l2.banks", 1, 64),
    int("l2.queue_entries", 1, 256),
    int("l2.mshrs", 1, 1024),
    key("l2.latency_cycles", DEPTH),
    key("l2.replacement", REPLACEMENT),
    key("l2.inclusive", Rule::Flag),
    int("l2.line_bytes", 16, 256),
    key("dram.clock_mhz", CLOCK),
    int("dram.channels", 1, 16),
    int("dram.banks", 1, 64),
    int("dram.row_bytes", 256, 65_536),
    int("dram.burst_bytes", 8, 256),
    key("dram.tccd", TIMING),
    key("dram.trcd", TIMING),
    key("dram.trp", TIMING),
    key("dram.trp_all", TIMING),
    key("dram.tras", TIMING),
    key("dram.trrd", TIMING),
    key("dram.tfaw", TIMING),
    key("dram.rl", TIMING),
    key("dram.wl", TIMING),
    key("dram.trtp", TIMING),
    key("dram.twr", TIMING),
    key("dram.twtr", TIMING),
    int("dram.trfc", 1, 10_000),
    int("dram.trefi", 100, 1_000_000),
    int("dram.read_queue_entries", 1, 256),
    int("dram.write_queue_entries", 1, 256),
    int("dram.write_high", 1, 256),
    int("dram.write_low", 0, 255),
    int("dram.controller_cycles", 0, 1024),
    int("dram.sync_cycles", 0, 16),
    key("srp.clock_mhz", CLOCK),
    key("srp.ideal", Rule::Flag),
    key("srp.divergence", Rule::Word(&["inspector", "naive"])),
    int("srp.inspector_cycles", 0, 1000),
    int("srp.batch_min", 1, 65_536),
    int("srp.batch_max", 1, 65_536),
    key("srp.kernels.raygen.ii_cycles", INTERVAL),
    key("srp.kernels.raygen.prologue_cycles", PROLOGUE),
    key("srp.kernels.raygen.ops", OPS),
    key("srp.kernels.shade.ii_cycles", INTERVAL),
    key("srp.kernels.shade.prologue_cycles", PROLOGUE),
    key("srp.kernels.shade.ops", OPS),
    key("srp.kernels.light.ii_cycles", INTERVAL),
    key("srp.kernels.light.prologue_cycles", PROLOGUE),
    key("srp.kernels.light.ops", OPS),
    key("srp.kernels.miss.ii_cycles", INTERVAL),
    key("srp.kernels.miss.prologue_cycles", PROLOGUE),
    key("srp.kernels.miss.ops", OPS),
    key("srp.kernels.update.ii_cycles", INTERVAL),
    key("srp.kernels.update.prologue_cycles", PROLOGUE),
    key("srp.kernels.update.ops", OPS),
    key("srp.kernels.similarity.ii_cycles", INTERVAL_OR_NONE),
    key("srp.kernels.similarity.prologue_cycles", PROLOGUE),
    key("srp.kernels.similarity.ops", OPS),
    key("srp.kernels.interpolate.ii_cycles", INTERVAL_OR_NONE),
    key("srp.kernels.interpolate.prologue_cycles", PROLOGUE),
    key("srp.kernels.interpolate.ops", OPS),
    key("srp.kernels.resolve.ii_cycles", INTERVAL),
    key("srp.kernels.resolve.prologue_cycles", PROLOGUE),
    key("srp.kernels.resolve.ops", OPS),
    key("srp.local_memory", SMALL),
    key("srp.sample.object", FIELD),
    key("srp.sample.normal", FIELD),
    key("srp.sample.position", FIELD),
    key("srp.sample.shadow", FIELD),
    key("srp.sample.colour", FIELD),
    key("srp.sample.flags", FIELD),
    key("srp.l1.size", SMALL),
    key("srp.l1.ways", WAYS),
    key("srp.l1.mshrs", MSHRS),
    key("srp.l1.latency_cycles", DEPTH),
    key("srp.l1.replacement", REPLACEMENT),
    int("srp.attribute_bytes", 0, 1024),
    key("srp.textures", Rule::Flag),
    int("srp.texel_bytes", 1, 64),
    int("layout.node_bytes", 8, 256),
    int("layout.triangle_bytes", 8, 256),
    int("layout.pixel_bytes", 1, 32),
    int("raster.samples_per_cycle", 1, 64),
    int("raster.gbuffer_bytes", 1, 256),
    pj("energy.box_test_pj"),
    pj("energy.triangle_test_pj"),
    pj("energy.ray_setup_pj"),
    pj("energy.bypass_pj"),
    pj("energy.ray_buffer_read_pj"),
    pj("energy.ray_buffer_write_pj"),
    pj("energy.stack_push_pj"),
    pj("energy.stack_pop_pj"),
    pj("energy.crossbar_pj"),
    pj("energy.trv_l1_read_pj"),
    pj("energy.ist_l1_read_pj"),
    pj("energy.srp_l1_read_pj"),
    pj("energy.l1_miss_pj"),
    pj("energy.l1_fill_pj"),
    pj("energy.accumulate_pj"),
    pj("energy.reorder_pj"),
    pj("energy.l2_read_pj"),
    pj("energy.l2_miss_pj"),
    pj("energy.l2_fill_pj"),
    pj("energy.interface_pj_per_byte"),
    pj("energy.srp_op_pj"),
    pj("energy.local_read_pj"),
    pj("energy.local_write_pj"),
    pj("energy.dram_row_pj"),
    pj("energy.dram_read_pj"),
    pj("energy.dram_write_pj"),
    pj("energy.dram_refresh_pj"),
    pj("energy.dram_phy_pj_per_byte"),
    int("energy.dram_background_uw", 0, 10_000_000),
    int("energy.sram_leakage_uw_per_kib", 0, 1_000_000),
    int("energy.trv_leakage_uw", 0, 10_000_000),
    int("energy.ist_leakage_uw", 0, 10_000_000),
    int("energy.srp_leakage_uw", 0, 10_000_000),
    int("energy.clock_tree_percent", 0, 100),
];
