//! What the values of a machine must hold together. Ranges of single values stand beside their fields.

use rayreel_settings::{Result, SettingsError};

use super::cache::L1;
use super::layout::LayoutSizes;
use super::srp::Kernels;
use super::ti::Pipeline;
use super::whole::MachineConfig;

/// Checks values against one another; `origin` says where they are from.
///
/// # Errors
/// [`SettingsError::Conflict`], the first that is found, with the names and values of the keys.
pub fn check(config: &MachineConfig, origin: &str) -> Result<()> {
    let found = caches(config)
        .or_else(|| ti(config))
        .or_else(|| dram(config))
        .or_else(|| layout(&config.layout))
        .or_else(|| kernels(&config.srp.kernels))
        .or_else(|| srp(config));
    found.map_or(Ok(()), |detail| Err(SettingsError::Conflict { origin: origin.into(), detail }))
}

fn powers_of_two(values: &[(&str, u64)]) -> Option<String> {
    let (name, value) = values.iter().find(|(_, value)| !value.is_power_of_two())?;
    Some(format!("{name} = {value} is not a power of two"))
}

fn caches(config: &MachineConfig) -> Option<String> {
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
            (banks > sets).then(|| format!("l2.banks = {banks} is more than the {sets} sets of the L2"))
        })
}

/// A set index is some bits of the line number: the number of sets must be a power of two.
fn cache(name: &str, size: u64, ways: u64, line: u64) -> Option<String> {
    if size < ways * line {
        let lines = size / line;
        return Some(format!("{name}.ways = {ways} is more than the {lines} lines of {line} bytes in {name}.size"));
    }
    let sets = size / (ways * line);
    (!size.is_multiple_of(ways * line) || !sets.is_power_of_two()).then(|| {
        format!("{name}.size = {size} bytes in {ways} ways of {line}-byte lines is not a power-of-two number of sets")
    })
}

fn ti(config: &MachineConfig) -> Option<String> {
    let ti = &config.ti;
    match (ti.pipeline, ti.ist) {
        (Pipeline::Unified, 1..) => {
            Some(format!("ti.pipeline = \"unified\" tests triangles itself, so ti.ist = {} must be 0", ti.ist))
        }
        (Pipeline::Software, 1..) => Some(format!(
            "ti.pipeline = \"software\" tests triangles by instructions, so ti.ist = {} must be 0",
            ti.ist
        )),
        (Pipeline::Software, 0) => processor(config).or_else(|| many_rays(config)),
        (Pipeline::Gathering, 1..) => {
            Some(format!("ti.pipeline = \"gathering\" tests triangles itself, so ti.ist = {} must be 0", ti.ist))
        }
        (Pipeline::Gathering, 0) => whole_stack(config),
        (Pipeline::Parallel | Pipeline::Single, 0) => {
            Some("ti.ist = 0 leaves nobody to test triangles; only ti.pipeline = \"unified\" can do without".into())
        }
        _ => many_rays(config),
    }
}

fn many_rays(config: &MachineConfig) -> Option<String> {
    let rays = config.ti.rays_per_trv;
    (rays > 128)
        .then(|| format!("ti.rays_per_trv = {rays} is more than 128, which only ti.pipeline = \"gathering\" can hold"))
}

fn whole_stack(config: &MachineConfig) -> Option<String> {
    let entries = config.ti.stack_entries;
    (entries > 0).then(|| {
        format!(
            "ti.pipeline = {:?} has a full stack, so ti.stack_entries = {entries} must be 0",
            config.ti.pipeline.name()
        )
    })
}

fn processor(config: &MachineConfig) -> Option<String> {
    let (ti, mix) = (&config.ti, &config.processor.kernel_mix);
    let lanes = config.processor.lanes;
    if !ti.rays_per_trv.is_multiple_of(lanes) {
        let rays = ti.rays_per_trv;
        return Some(format!("ti.rays_per_trv = {rays} is not a whole number of warps of processor.lanes = {lanes}"));
    }
    if lanes > ti.ray_fifo_entries {
        let entries = ti.ray_fifo_entries;
        return Some(format!("ti.ray_fifo_entries = {entries} does not hold a warp of processor.lanes = {lanes}"));
    }
    if let Some(detail) = whole_stack(config) {
        return Some(detail);
    }
    if config.srp.ideal {
        return Some(
            "ti.pipeline = \"software\" runs the kernels too, so srp.ideal = true leaves nothing to measure".into(),
        );
    }
    if config.srp.clock_mhz != ti.clock_mhz {
        let (srp, ti) = (config.srp.clock_mhz, ti.clock_mhz);
        return Some(format!(
            "ti.pipeline = \"software\" has one clock, but srp.clock_mhz = {srp} and ti.clock_mhz = {ti}"
        ));
    }
    let all: u32 = mix.percents().iter().sum();
    (all != 100).then(|| format!("the shares of processor.kernel_mix are {all} % together, not 100 %"))
}

fn dram(config: &MachineConfig) -> Option<String> {
    let (dram, line) = (&config.dram, config.l2.line_bytes);
    let below = |low: (&str, u32), high: (&str, u32)| {
        (low.1 > high.1).then(|| format!("dram.{} = {} is more than dram.{} = {}", low.0, low.1, high.0, high.1))
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
            format!("dram.interleave_bytes = {at} is not from l2.line_bytes = {line} to dram.row_bytes = {row}")
        })
    })
    .or_else(|| {
        (line < dram.burst_bytes)
            .then(|| format!("l2.line_bytes = {line} is less than dram.burst_bytes = {}", dram.burst_bytes))
    })
    .or_else(|| below(("trcd", dram.trcd), ("tras", dram.tras)))
    .or_else(|| below(("trp", dram.trp), ("trp_all", dram.trp_all)))
    .or_else(|| below(("trrd", dram.trrd), ("tfaw", dram.tfaw)))
    .or_else(|| {
        // Between two refreshes at least one row must be opened, read and closed.
        let need = dram.trfc + dram.trp_all + dram.tras + dram.trp;
        (dram.trefi <= need).then(|| {
            format!(
                "dram.trefi = {} leaves no time between refreshes (tRFC, tRPab, tRAS and tRP take {need})",
                dram.trefi
            )
        })
    })
    .or_else(|| below(("write_high", dram.write_high), ("write_queue_entries", dram.write_queue_entries)))
    .or_else(|| {
        (dram.write_low >= dram.write_high).then(|| {
            format!("dram.write_low = {} must be less than dram.write_high = {}", dram.write_low, dram.write_high)
        })
    })
}

fn layout(layout: &LayoutSizes) -> Option<String> {
    let (block, tile) = (layout.texture_block, layout.texture_tile);
    powers_of_two(&[("layout.texture_block", block.into()), ("layout.texture_tile", tile.into())]).or_else(|| {
        (block > tile).then(|| format!("layout.texture_block = {block} is more than layout.texture_tile = {tile}"))
    })
}

/// Adaptive sampling needs all of its kernels.
fn kernels(kernels: &Kernels) -> Option<String> {
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
    Some(format!(
        "srp.kernels.{}.stages = {} and srp.kernels.{}.stages = 0: a machine has all kernels of policies or (0) none",
        present.0, present.1.stages, absent.0
    ))
}

fn srp(config: &MachineConfig) -> Option<String> {
    let srp = &config.srp;
    if srp.batch_min > srp.batch_max {
        return Some(format!("srp.batch_min = {} is more than srp.batch_max = {}", srp.batch_min, srp.batch_max));
    }
    (srp.sample.total() == 0).then(|| "all fields of srp.sample are 0: a sample must take some bytes".into())
}
