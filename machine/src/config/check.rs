//! What the values of a machine must hold together. Ranges of single values stand beside their fields.

use rayreel_settings::{Bytes, Rule, SettingsError};

use super::cache::L1;
use super::energy::Energy;
use super::layout::LayoutSizes;
use super::schema::MACHINES;
use super::srp::{Divergence, Kernels};
use super::ti::Pipeline;
use super::whole::MachineConfig;

/// Values that cannot stand together.
#[derive(Debug)]
pub struct Conflict {
    /// Their keys, the one at fault first.
    keys: Vec<String>,
    detail: String,
}

impl Conflict {
    pub fn new<const N: usize>(keys: [&str; N], detail: impl Into<String>) -> Self {
        Self { keys: keys.map(str::to_owned).to_vec(), detail: detail.into() }
    }

    /// The error: the first of the keys that was overridden is blamed, else what has the values, `origin`.
    pub fn blame(self, overridden: impl Fn(&str) -> Option<String>, origin: &str) -> SettingsError {
        let found = self.keys.iter().find_map(|key| overridden(key));
        SettingsError::Conflict { origin: found.unwrap_or_else(|| origin.into()), detail: self.detail }
    }
}

/// Checks values against one another.
///
/// # Errors
/// The first conflict that is found, with the names and values of the keys.
pub fn check(config: &MachineConfig) -> Result<(), Conflict> {
    let found = caches(config)
        .or_else(|| ti(config))
        .or_else(|| dram(config))
        .or_else(|| layout(&config.layout))
        .or_else(|| kernels(&config.srp.kernels))
        .or_else(|| srp(config))
        .or_else(|| energy(&config.energy));
    found.map_or(Ok(()), Err)
}

fn powers_of_two(values: &[(&str, u64)]) -> Option<Conflict> {
    let (name, value) = values.iter().find(|(_, value)| !value.is_power_of_two())?;
    Some(Conflict::new([name], format!("{name} = {value} is not a power of two")))
}

fn caches(config: &MachineConfig) -> Option<Conflict> {
    let line = u64::from(config.l2.line_bytes);
    let l1 = |name: &str, l1: &L1| cache(name, l1.size.0, l1.ways.into(), line);
    powers_of_two(&[("l2.line_bytes", line), ("l2.banks", config.l2.banks.into())])
        .or_else(|| l1("ti.trv_l1", &config.ti.trv_l1))
        .or_else(|| l1("ti.ist_l1", &config.ti.ist_l1))
        .or_else(|| l1("srp.l1", &config.srp.l1))
        .or_else(|| l1("processor.code_l1", &config.processor.code_l1))
        .or_else(|| cache("l2", config.l2.size.0, config.l2.ways.into(), line))
        .or_else(|| {
            let sets = config.l2.size.0 / (u64::from(config.l2.ways) * line);
            let banks = u64::from(config.l2.banks);
            (banks > sets).then(|| {
                let keys = ["l2.banks", "l2.size", "l2.ways", "l2.line_bytes"];
                Conflict::new(keys, format!("l2.banks = {banks} is more than the {sets} sets of the L2"))
            })
        })
}

/// A set index is some bits of the line number: the number of sets must be a power of two.
fn cache(name: &str, size: u64, ways: u64, line: u64) -> Option<Conflict> {
    let [in_bytes, in_ways] = ["size", "ways"].map(|field| format!("{name}.{field}"));
    if size < ways * line {
        let (lines, near) = (size / line, near_sizes(&in_bytes, size, ways * line));
        let detail = format!("{in_ways} = {ways} is more than the {lines} lines of {line} bytes in {in_bytes}{near}");
        return Some(Conflict::new([&in_ways, &in_bytes, "l2.line_bytes"], detail));
    }
    let sets = size / (ways * line);
    (!size.is_multiple_of(ways * line) || !sets.is_power_of_two()).then(|| {
        let near = near_sizes(&in_bytes, size, ways * line);
        let detail = format!(
            "{in_bytes} = {size} bytes in {ways} ways of {line}-byte lines is not a power-of-two number of sets{near}"
        );
        Conflict::new([&in_bytes, &in_ways, "l2.line_bytes"], detail)
    })
}

/// The nearest sizes below and above `size` that a power of two of sets of so many bytes has and `key` takes, as the end of a message.
fn near_sizes(key: &str, size: u64, set: u64) -> String {
    let rule = (MACHINES.schema)("").get(key).map(|key| key.rule);
    let Some(Rule::Size(low, high)) = rule else { return String::new() };
    let sizes = || (0..u64::BITS).map_while(|bits| set.checked_mul(1 << bits)).filter(|s| (low..=high).contains(s));
    let near = [sizes().filter(|s| *s < size).last(), sizes().find(|s| *s > size)];
    let near: Vec<_> = near.into_iter().flatten().map(|size| Bytes(size).to_string()).collect();
    if near.is_empty() { String::new() } else { format!("; {} would do", near.join(" or ")) }
}

fn ti(config: &MachineConfig) -> Option<Conflict> {
    let ti = &config.ti;
    let ist = |detail: String| Some(Conflict::new(["ti.ist", "ti.pipeline"], detail));
    match (ti.pipeline, ti.ist) {
        (Pipeline::Unified, 1..) => {
            ist(format!("ti.pipeline = \"unified\" tests triangles itself, so ti.ist = {} must be 0", ti.ist))
        }
        (Pipeline::Software, 1..) => {
            ist(format!("ti.pipeline = \"software\" tests triangles by instructions, so ti.ist = {} must be 0", ti.ist))
        }
        (Pipeline::Software, 0) => processor(config).or_else(|| many_rays(config)),
        (Pipeline::Gathering, 1..) => {
            ist(format!("ti.pipeline = \"gathering\" tests triangles itself, so ti.ist = {} must be 0", ti.ist))
        }
        (Pipeline::Gathering, 0) => whole_stack(config),
        (Pipeline::Parallel | Pipeline::Single, 0) => ist(format!(
            "ti.ist = 0 leaves nobody to test triangles where ti.pipeline = {:?}; only \"unified\", \"gathering\" and \
             \"software\" do without",
            ti.pipeline.name()
        )),
        _ => many_rays(config),
    }
}

fn many_rays(config: &MachineConfig) -> Option<Conflict> {
    let rays = config.ti.rays_per_trv;
    (rays > 128).then(|| {
        let detail =
            format!("ti.rays_per_trv = {rays} is more than 128, which only ti.pipeline = \"gathering\" can hold");
        Conflict::new(["ti.rays_per_trv", "ti.pipeline"], detail)
    })
}

fn whole_stack(config: &MachineConfig) -> Option<Conflict> {
    let entries = config.ti.stack_entries;
    (entries > 0).then(|| {
        let detail = format!(
            "ti.pipeline = {:?} has a full stack, so ti.stack_entries = {entries} must be 0",
            config.ti.pipeline.name()
        );
        Conflict::new(["ti.stack_entries", "ti.pipeline"], detail)
    })
}

fn processor(config: &MachineConfig) -> Option<Conflict> {
    let (ti, mix) = (&config.ti, &config.processor.kernel_mix);
    let lanes = config.processor.lanes;
    if !ti.rays_per_trv.is_multiple_of(lanes) {
        let rays = ti.rays_per_trv;
        let detail = format!("ti.rays_per_trv = {rays} is not a whole number of warps of processor.lanes = {lanes}");
        return Some(Conflict::new(["ti.rays_per_trv", "processor.lanes", "ti.pipeline"], detail));
    }
    if lanes > ti.ray_fifo_entries {
        let entries = ti.ray_fifo_entries;
        let detail = format!("ti.ray_fifo_entries = {entries} does not hold a warp of processor.lanes = {lanes}");
        return Some(Conflict::new(["ti.ray_fifo_entries", "processor.lanes", "ti.pipeline"], detail));
    }
    if let Some(conflict) = whole_stack(config) {
        return Some(conflict);
    }
    if config.srp.ideal {
        let detail = "ti.pipeline = \"software\" runs the kernels too, so srp.ideal = true leaves nothing to measure";
        return Some(Conflict::new(["srp.ideal", "ti.pipeline"], detail));
    }
    if config.srp.clock_mhz != ti.clock_mhz {
        let (srp, ti) = (config.srp.clock_mhz, ti.clock_mhz);
        let detail =
            format!("ti.pipeline = \"software\" has one clock, but srp.clock_mhz = {srp} and ti.clock_mhz = {ti}");
        return Some(Conflict::new(["srp.clock_mhz", "ti.clock_mhz", "ti.pipeline"], detail));
    }
    let all: u32 = mix.percents().iter().sum();
    (all != 100).then(|| {
        let shares = ["add", "multiply", "compare", "integer", "special", "memory"];
        let keys = shares.map(|share| format!("processor.kernel_mix.{share}_percent"));
        let detail = format!("the shares of processor.kernel_mix are {all} % together, not 100 %");
        Conflict { keys: keys.to_vec(), detail }
    })
}

fn dram(config: &MachineConfig) -> Option<Conflict> {
    let (dram, line) = (&config.dram, config.l2.line_bytes);
    let below = |low: (&str, u32), high: (&str, u32)| {
        let [low_key, high_key] = [low, high].map(|(name, _)| format!("dram.{name}"));
        let detail = || format!("{low_key} = {} is more than {high_key} = {}", low.1, high.1);
        (low.1 > high.1).then(|| Conflict::new([&low_key, &high_key], detail()))
    };
    powers_of_two(&[
        ("dram.channels", dram.channels.into()),
        ("dram.banks", dram.banks.into()),
        ("dram.row_bytes", dram.row_bytes.into()),
        ("dram.burst_bytes", dram.burst_bytes.into()),
        ("dram.interleave_bytes", dram.interleave_bytes.into()),
    ])
    .or_else(|| {
        let (at, row) = (dram.interleave_bytes, dram.row_bytes);
        (at < line || at > row).then(|| {
            let other = if at < line { "l2.line_bytes" } else { "dram.row_bytes" };
            let detail =
                format!("dram.interleave_bytes = {at} is not from l2.line_bytes = {line} to dram.row_bytes = {row}");
            Conflict::new(["dram.interleave_bytes", other], detail)
        })
    })
    .or_else(|| {
        (line < dram.burst_bytes).then(|| {
            let detail = format!("l2.line_bytes = {line} is less than dram.burst_bytes = {}", dram.burst_bytes);
            Conflict::new(["l2.line_bytes", "dram.burst_bytes"], detail)
        })
    })
    .or_else(|| below(("trcd", dram.trcd), ("tras", dram.tras)))
    .or_else(|| below(("trp", dram.trp), ("trp_all", dram.trp_all)))
    .or_else(|| below(("trrd", dram.trrd), ("tfaw", dram.tfaw)))
    .or_else(|| {
        // Between two refreshes at least one row must be opened, read and closed.
        let need = dram.trfc + dram.trp_all + dram.tras + dram.trp;
        (dram.trefi <= need).then(|| {
            let detail = format!(
                "dram.trefi = {} leaves no time between refreshes (tRFC, tRPab, tRAS and tRP take {need})",
                dram.trefi
            );
            Conflict::new(["dram.trefi", "dram.trfc", "dram.trp_all", "dram.tras", "dram.trp"], detail)
        })
    })
    .or_else(|| {
        // Also where activates are far apart a row is read before the next refresh closes it, or none ever is.
        let bursts = line.div_ceil(dram.burst_bytes);
        let need = dram.tfaw + dram.trcd + bursts * dram.tccd.max(4) + dram.trp_all;
        (dram.trefi <= need).then(|| {
            let detail = format!(
                "dram.trefi = {} leaves no time to read a row between refreshes (tFAW, tRCD, the bursts of a line and tRPab take {need})",
                dram.trefi
            );
            let keys = ["trefi", "tfaw", "trcd", "tccd", "trp_all", "burst_bytes"].map(|name| format!("dram.{name}"));
            Conflict { keys: keys.into_iter().chain(["l2.line_bytes".into()]).collect(), detail }
        })
    })
    .or_else(|| {
        // The command of each burst is on the bus for 4 cycles.
        (dram.tccd < 4 && line > dram.burst_bytes).then(|| {
            let detail = format!(
                "dram.tccd = {} is less than the 4 cycles of a column command, and a line of l2.line_bytes = {line} takes several \
                 (dram.burst_bytes = {})",
                dram.tccd, dram.burst_bytes
            );
            Conflict::new(["dram.tccd", "dram.burst_bytes", "l2.line_bytes"], detail)
        })
    })
    .or_else(|| below(("write_high", dram.write_high), ("write_queue_entries", dram.write_queue_entries)))
    .or_else(|| {
        (dram.write_low >= dram.write_high).then(|| {
            let (low, high) = (dram.write_low, dram.write_high);
            let detail = format!("dram.write_low = {low} must be less than dram.write_high = {high}");
            Conflict::new(["dram.write_low", "dram.write_high"], detail)
        })
    })
}

fn layout(layout: &LayoutSizes) -> Option<Conflict> {
    let (block, tile) = (layout.texture_block, layout.texture_tile);
    powers_of_two(&[("layout.texture_block", block.into()), ("layout.texture_tile", tile.into())]).or_else(|| {
        (block > tile).then(|| {
            let detail = format!("layout.texture_block = {block} is more than layout.texture_tile = {tile}");
            Conflict::new(["layout.texture_block", "layout.texture_tile"], detail)
        })
    })
}

/// Adaptive sampling needs all of its kernels.
fn kernels(kernels: &Kernels) -> Option<Conflict> {
    let Kernels { similarity, colour, interpolate, attributes, control, .. } = kernels;
    let all = [
        ("similarity", similarity),
        ("colour", colour),
        ("interpolate", interpolate),
        ("attributes", attributes),
        ("control", control),
    ];
    let has = |wanted| all.iter().find(|(_, kernel)| (kernel.stages > 0) == wanted);
    let (present, absent) = has(true).zip(has(false))?;
    let [there, missing] = [present, absent].map(|(name, _)| format!("srp.kernels.{name}.stages"));
    let stages = present.1.stages;
    let detail = format!("{there} = {stages} and {missing} = 0: a machine has all kernels of policies or (0) none");
    // Whichever was set; another of either side may have been, where several are.
    let keys = [missing, there].into_iter().chain(all.map(|(name, _)| format!("srp.kernels.{name}.stages")));
    Some(Conflict { keys: keys.collect(), detail })
}

fn srp(config: &MachineConfig) -> Option<Conflict> {
    let srp = &config.srp;
    if srp.batch_min > srp.batch_max {
        let detail = format!("srp.batch_min = {} is more than srp.batch_max = {}", srp.batch_min, srp.batch_max);
        return Some(Conflict::new(["srp.batch_min", "srp.batch_max"], detail));
    }
    if srp.ideal && srp.divergence == Divergence::Naive {
        let detail = "srp.divergence = \"naive\" pays for the branches of a batch, and srp.ideal = true has no batches; take \"inspector\"";
        return Some(Conflict::new(["srp.ideal", "srp.divergence"], detail));
    }
    (srp.sample.total() == 0).then(|| {
        let fields = (MACHINES.schema)("").keys().iter().map(|key| key.name);
        let keys = fields.filter(|name| name.starts_with("srp.sample.")).map(str::to_owned).collect();
        Conflict { keys, detail: "all fields of srp.sample are 0: a sample must take some bytes".into() }
    })
}

/// What a channel saves in power-down is the difference, and never less than nothing.
fn energy(energy: &Energy) -> Option<Conflict> {
    let (down, up) = (energy.dram_power_down_uw, energy.dram_background_uw);
    (down > up).then(|| {
        let detail = format!("energy.dram_power_down_uw = {down} is more than energy.dram_background_uw = {up}");
        Conflict::new(["energy.dram_power_down_uw", "energy.dram_background_uw"], detail)
    })
}
