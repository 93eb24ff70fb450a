//! The machine's part of the printed page: speed, utilisation, caches, memory, power, shader.

use std::fmt::{self, Formatter};

use crate::figures::RunCost;
use crate::report::Report;
use crate::report::counters::{code_l1, ist_activity, ist_l1, processors, srp_l1, srp_sum, stages, trv_l1};
use crate::report::detail::DetailReport;
use crate::report::extent::{Extent, reasons};
use crate::report::format::{amount, digits, grouped, percent, plus_minus};
use rayreel_machine::AreaReport;
use rayreel_machine::config::{Dram, MachineConfig};
use rayreel_machine::counters::Activity;
use rayreel_machine::energy::{Component, EnergyReport, Group, watts};
use rayreel_machine::srp::KernelId;
use rayreel_machine::stats::Stats;
use rayreel_machine::work::layout::Region;
use rayreel_replay::Detail;
use rayreel_replay::simulate::MachineRun;

/// The row of the sum of all components.
const WHOLE_GPU: &str = "whole GPU";

/// Writes the page of a report's machine, if it has one.
pub(super) fn write(f: &mut Formatter<'_>, report: &Report) -> fmt::Result {
    let Some((config, run)) = &report.machine_run else { return Ok(()) };
    let detail = report.detail.as_ref();
    speed(f, report, config)?;
    // Where no cycle was simulated nobody waited.
    let timeless = detail.is_some_and(DetailReport::is_counts);
    if !timeless {
        if has_processors(&run.stats) {
            processing(f, config, &run.stats)?;
        } else {
            utilisation(f, &run.stats, detail)?;
            shader(f, &run.stats, detail)?;
        }
    }
    caches(f, &run.stats, timeless)?;
    memory(f, config, &run.stats, timeless)?;
    power(f, config, run)?;
    area(f, report, config)
}

/// What was simulated, if that is not all.
fn extent(f: &mut Formatter<'_>, detail: &DetailReport, has_processors: bool) -> fmt::Result {
    let DetailReport { mode, fraction, windows, whole_frames, .. } = *detail;
    let whole_because = reasons(Some(&detail.whole_because));
    let clauses = Extent { mode, fraction, windows, whole_frames, whole_because, has_processors }.clauses();
    clauses.iter().try_for_each(|clause| writeln!(f, "  {clause}"))?;
    if clauses.is_empty() { Ok(()) } else { writeln!(f) }
}

fn speed(f: &mut Formatter<'_>, report: &Report, config: &MachineConfig) -> fmt::Result {
    let name = report.machine.as_deref().unwrap_or_default();
    let (cores, ti, srp) = (config.gpu.cores, config.ti.clock_mhz, config.srp.clock_mhz);
    let many = if cores == 1 { "core" } else { "cores" };
    let run_stats = report.machine_run.as_ref().map(|(_, run)| &run.stats);
    if run_stats.is_some_and(has_processors) {
        writeln!(f, "\nmachine {name}: {cores} {many} of processors at {ti} MHz\n")?;
    } else {
        writeln!(f, "\nmachine {name}: {cores} {many}, T&I at {ti} MHz, SRP at {srp} MHz\n")?;
    }
    let run = &report.run;
    let detail = report.detail.as_ref();
    let processors = run_stats.is_some_and(has_processors);
    detail.map_or(Ok(()), |detail| extent(f, detail, processors))?;
    let within = |column: &str| detail.and_then(|d| d.interval(column)).map_or_else(String::new, plus_minus);
    let cycles = run.cycles.map_or_else(|| "-".into(), grouped);
    // Room for what stands behind an estimate.
    let [a, b, c] = if detail.is_some_and(DetailReport::is_estimated) { [22, 26, 22] } else { [16, 20, 16] };
    writeln!(f, "  {:<18} {:>a$}", "cycles", format!("{cycles}{}", within("cycles")))?;
    let mut row = |name: &str, value: String, (rate, unit): (Option<f64>, &str), column: &str| {
        writeln!(f, "  {name:<18} {value:>a$} {:>b$}", format!("{}{}", amount(rate, unit), within(column)))
    };
    row("time", small(run.time_ms, "ms", "us"), (run.fps, "frames/s"), "fps")?;
    row("rays", grouped(run.rays_machine.unwrap_or_default()), (run.mrays_per_s, "Mrays/s"), "mrays_per_s")?;
    writeln!(f, "\n  {:<18} {:>a$} {:>b$} {:>c$}", "", "T&I units", "and their memory", "whole GPU")?;
    let costs = [run.ti, run.ti_with_memory.unwrap_or_default(), run.gpu.unwrap_or_default()];
    let mut row = |name: &str, column: &str, shown: fn(&RunCost) -> String| {
        let cell = |(part, cost): (&str, &RunCost)| {
            format!("{}{}", shown(cost).trim_end(), within(&format!("{part}{column}")))
        };
        let [ti, memory, gpu] = [("", &costs[0]), ("ti_with_memory_", &costs[1]), ("gpu_", &costs[2])].map(cell);
        writeln!(f, "  {name:<18} {ti:>a$} {memory:>b$} {gpu:>c$}")
    };
    row("power", "power_w", |c| small(c.power_w, "W", "mW"))?;
    row("energy", "energy_mj", |c| small(c.energy_mj, "mJ", "uJ"))?;
    row("energy a ray", "energy_per_ray_nj", |c| amount(c.energy_per_ray_nj, "nJ"))?;
    row("frames/s a watt", "perf_per_watt", |c| amount(c.perf_per_watt, ""))?;
    if detail.is_some_and(DetailReport::is_estimated) {
        writeln!(
            f,
            "\n  What follows is estimated too, but for work; --json has the interval of each (detail.interval_percent)."
        )?;
    }
    Ok(())
}

/// An amount in `unit`, or in its thousandth part if it is below one.
fn small(value: Option<f64>, unit: &str, thousandth: &str) -> String {
    if value.is_some_and(|v| v < 1.0) { amount(value.map(|v| v * 1e3), thousandth) } else { amount(value, unit) }
}

/// What the issue stages of the T&I units did, in percent of their cycles.
fn utilisation(f: &mut Formatter<'_>, stats: &Stats, detail: Option<&DetailReport>) -> fmt::Result {
    write!(f, "\n{:<15}", "T&I units, %")?;
    Activity::default().list().iter().try_for_each(|class| write!(f, "{:>8}", class.name))?;
    writeln!(f)?;
    let (trv, ist) = (stats.trv().count(), stats.ist().count());
    for (name, activity) in stages(stats) {
        row(f, &format!("{trv} TRV {name}"), &activity, (&format!("ti_trv_{name}"), detail))?;
    }
    if ist > 0 {
        row(f, &format!("{ist} IST"), &ist_activity(stats), ("ti_ist_test", detail))?;
    }
    let rays: u64 = stats.trv().map(|unit| unit.events.ray_cycles).sum();
    if stats.cycles > 0 && trv > 0 {
        let mean = rays as f64 / stats.cycles as f64 / trv as f64;
        writeln!(f, "  rays in a TRV, mean {mean:>8.1}")?;
    }
    Ok(())
}

fn row(
    f: &mut Formatter<'_>,
    name: &str,
    activity: &Activity,
    (column, detail): (&str, Option<&DetailReport>),
) -> fmt::Result {
    let all = activity.total();
    write!(f, "  {name:<13}")?;
    for class in activity.list() {
        let is_known = is_known(class.value, &format!("{column}_{}", class.name), detail);
        write!(f, "{:>8}", if is_known { percent(class.value, all) } else { "-".into() })?;
    }
    writeln!(f)
}

/// Whether anything is known of a count. Where none was seen that is what there is to say.
fn is_known(count: u64, column: &str, detail: Option<&DetailReport>) -> bool {
    count == 0 || !detail.is_some_and(|detail| detail.is_unknown(column))
}

/// Cycles of the SRPs by kernel, and why they stood still.
fn shader(f: &mut Formatter<'_>, stats: &Stats, detail: Option<&DetailReport>) -> fmt::Result {
    let srp = srp_sum(stats);
    let activity = srp.activity;
    let all: u64 = activity.total();
    let busy = srp.kernels.iter().map(|kernel| kernel.cycles).sum::<u64>() + activity.inspector;
    let estimated = detail.filter(|detail| detail.is_estimated());
    let head = if estimated.is_some() { "      ±%" } else { "" };
    writeln!(f, "\n{:<34} {:>12} {:>15} {:>8} {:>7}{head}", "SRP", "items", "SRP cycles", "% busy", "% all")?;
    let line = |f: &mut Formatter<'_>, name: &str, items: String, cycles: u64, (of_busy, column): (bool, &str)| {
        if !is_known(cycles, column, detail) {
            return writeln!(f, "  {name:<32} {items:>12} {:>15} {:>8} {:>7}", "-", "", "-");
        }
        let busy = if of_busy { percent(cycles, busy) } else { String::new() };
        let interval = estimated.and_then(|detail| detail.interval(column)).filter(|_| cycles > 0);
        let interval = interval.map_or_else(String::new, |percent| format!(" {percent:>7.1}"));
        let (cycles, of_all) = (grouped(cycles), percent(cycles, all));
        writeln!(f, "  {name:<32} {items:>12} {cycles:>15} {busy:>8} {of_all:>7}{interval}")
    };
    for kernel in KernelId::ALL {
        let (name, counts) = (kernel.name(), srp.kernels[kernel as usize]);
        line(f, name, grouped(counts.items), counts.cycles, (true, &format!("srp_kernel_{name}_cycles")))?;
    }
    line(f, "inspector", String::new(), activity.inspector, (true, "srp_activity_inspector"))?;
    line(f, "busy", String::new(), busy, (true, ""))?;
    for (name, cycles, column) in [
        ("waits for room for rays", activity.output, "srp_activity_output"),
        ("waits for attributes and texels", activity.memory, "srp_activity_memory"),
        ("waits for the T&I unit", activity.unit, "srp_activity_unit"),
        ("waits for transfers of tiles", activity.transfer, "srp_activity_transfer"),
        ("waits for tiles beside its own", activity.border, "srp_activity_border"),
        ("has no tile", activity.idle, "srp_activity_idle"),
    ] {
        line(f, name, String::new(), cycles, (false, column))?;
    }
    Ok(())
}

/// Processors stand in the place of T&I units and of the SRPs' arrays.
fn has_processors(stats: &Stats) -> bool {
    stats.processors().next().is_some()
}

/// What the warps of processors did, how many instructions they issued, and the items of kernels among them.
fn processing(f: &mut Formatter<'_>, config: &MachineConfig, stats: &Stats) -> fmt::Result {
    let all = processors(stats);
    let (cycles, units) = (stats.cycles * stats.processors().count() as u64, &config.processor.units);
    writeln!(f, "\n{:<34} {:>15} {:>7}", "processors", "warp cycles", "% all")?;
    let warp_cycles = all.executing + all.units + all.memory + all.empty;
    for (name, count) in [
        ("executing", all.executing),
        ("waits for units that others have", all.units),
        ("waits for data or instructions", all.memory),
        ("empty", all.empty),
    ] {
        writeln!(f, "  {name:<32} {:>15} {:>7}", grouped(count), percent(count, warp_cycles))?;
    }
    let lanes = all.lane_instructions + all.lanes_off;
    writeln!(
        f,
        "  {:<32} {:>15} {:>7}",
        "instructions times lanes at work",
        "",
        percent(all.lane_instructions, lanes)
    )?;
    writeln!(f, "\n{:<34} {:>15} {:>7}", "instructions", "operations", "% of peak")?;
    for (name, count, per_cycle) in [
        ("issued", all.instructions, config.processor.issue),
        ("add", all.add, units.add),
        ("multiply", all.multiply, units.multiply),
        ("compare", all.compare, units.compare),
        ("integer", all.integer, units.integer),
        ("special", all.special, units.special),
        ("words read and written", all.words, units.memory),
    ] {
        writeln!(f, "  {name:<32} {:>15} {:>7}", grouped(count), percent(count, cycles * u64::from(per_cycle)))?;
    }
    writeln!(f, "\n{:<34} {:>15} {:>15}", "kernels", "items", "operations")?;
    let srp = srp_sum(stats);
    KernelId::ALL.into_iter().try_for_each(|kernel| {
        let counts = srp.kernels[kernel as usize];
        writeln!(f, "  {:<32} {:>15} {:>15}", kernel.name(), grouped(counts.items), grouped(counts.ops))
    })
}

/// Without time (`timeless`) nothing is known of lines that are on their way: what merges with them counts as a hit.
fn caches(f: &mut Formatter<'_>, stats: &Stats, timeless: bool) -> fmt::Result {
    writeln!(f, "\n{:<15}{:>15}{:>14}{:>12}{:>12}", "caches", "lookups", "hits %", "merged %", "misses %")?;
    let mut row = |name: &str, lookups: u64, hits: u64, merges: u64, misses: u64| {
        let [hits, merges, misses] = [hits, merges, misses].map(|n| percent(n, lookups));
        let merges = if timeless { "-".into() } else { merges };
        writeln!(f, "  {name:<13}{:>15}{hits:>14}{merges:>12}{misses:>12}", grouped(lookups))
    };
    let units = [("TRV L1", trv_l1(stats)), ("IST L1", ist_l1(stats)), ("SRP L1", srp_l1(stats))];
    let processors = [("data L1", trv_l1(stats)), ("code L1", code_l1(stats))];
    for (name, cache) in if has_processors(stats) { &processors[..] } else { &units[..] } {
        row(name, cache.lookups, cache.hits, cache.merges, cache.misses)?;
    }
    let l2 = stats.memory.l2;
    row("L2", l2.lookups, l2.hits, l2.merges, l2.misses)
}

/// Peak bandwidth, bytes a microsecond.
fn peak(dram: &Dram) -> f64 {
    let bytes = f64::from(dram.channels) * f64::from(dram.burst_bytes) * f64::from(dram.clock_mhz);
    bytes / f64::from(dram.tccd)
}

fn memory(f: &mut Formatter<'_>, config: &MachineConfig, stats: &Stats, timeless: bool) -> fmt::Result {
    let (traffic, dram) = (&stats.memory.traffic, stats.memory.dram());
    let microseconds = stats.cycles as f64 / f64::from(config.ti.clock_mhz);
    let peak = peak(&config.dram);
    let (scale, read, written) =
        if traffic.total() < 20_000_000 { (1e-3, "read kB", "written kB") } else { (1e-6, "read MB", "written MB") };
    writeln!(f, "\n{:<15}{read:>15}{written:>14}{:>12}{:>12}", "DRAM", "GB/s", "% of peak")?;
    let mut row = |name: &str, read: u64, written: u64| {
        let rate = (read + written) as f64 / microseconds;
        // Without time there is no rate.
        let timed = |text: String| if microseconds > 0.0 { text } else { "-".into() };
        let (gigabytes, share) = (timed(digits(rate * 1e-3)), timed(format!("{:.1}", 100.0 * rate / peak)));
        let [read, written] = [read, written].map(|bytes| format!("{:.1}", bytes as f64 * scale));
        writeln!(f, "  {name:<13}{read:>15}{written:>14}{gigabytes:>12}{share:>12}")
    };
    for region in Region::ALL {
        let (read, written) = (traffic.read[region as usize], traffic.written[region as usize]);
        if read + written > 0 {
            row(region.name(), read, written)?;
        }
    }
    row("all", traffic.read.iter().sum(), traffic.written.iter().sum())?;
    if timeless {
        // Which rows are open is a matter of time.
        return Ok(());
    }
    let rows = dram.row_hits + dram.row_closed + dram.row_conflicts;
    let hits = [dram.row_hits, dram.row_closed, dram.row_conflicts].map(|n| percent(n, rows));
    writeln!(f, "  row hits {} %, closed banks {} %, row conflicts {} %", hits[0], hits[1], hits[2])?;
    let latency = dram.read_latency as f64 / f64::from(config.dram.clock_mhz) * 1e3;
    if stats.cycles == 0 {
        return Ok(());
    }
    let latency = super::run::ratio(latency, dram.read_lines as f64);
    let latency = amount(latency, "ns");
    writeln!(f, "  a read takes {latency} on average from a channel's queue to its last data, controller excluded")
}

fn power(f: &mut Formatter<'_>, config: &MachineConfig, run: &MachineRun) -> fmt::Result {
    let total = run.energy.gpu_fj();
    // Where no cycle was simulated some components may be unknown: no part of a sum can be told then.
    let timeless = run.estimate.as_ref().is_some_and(|estimate| estimate.detail == Detail::Counts);
    let unknown = if timeless { EnergyReport::timed_components(config) } else { &[] };
    let milliwatts = |fj: u128| match run.stats.cycles {
        0 => "-".to_owned(),
        cycles => format!("{:.1}", watts(fj, cycles, config.ti.clock_mhz) * 1e3),
    };
    let (scale, unit) = if total < 20_000_000_000_000 { (1e-9, "uJ") } else { (1e-12, "mJ") };
    let joules = |fj: u128| format!("{:.2}", fj as f64 * scale);
    let leaked = |fj: u128| if timeless { "-".into() } else { joules(fj) };
    // Without leakage parts are none of the whole.
    let has_parts = total > 0 && unknown.is_empty() && !timeless;
    let part = |fj: u128| if !has_parts { "-".into() } else { format!("{:.1}", 100.0 * fj as f64 / total as f64) };
    let (dynamic, leakage) = (format!("dynamic {unit}"), format!("leakage {unit}"));
    writeln!(f, "\n{:<15}{dynamic:>15}{leakage:>14}{:>12}{:>12}", "power", "mW", "% of GPU")?;
    let mut row = |name: &str, dynamic: u128, leakage: u128| {
        let all = dynamic + leakage;
        let is_known = !unknown.contains(&name) && (unknown.is_empty() || name != WHOLE_GPU);
        let (dynamic, leakage) = (if is_known { joules(dynamic) } else { "-".into() }, leaked(leakage));
        writeln!(f, "  {name:<13}{dynamic:>15}{leakage:>14}{:>12}{:>12}", milliwatts(all), part(all))
    };
    for Component { name, dynamic_fj, leakage_fj, .. } in &run.energy.components {
        row(name, *dynamic_fj, *leakage_fj)?;
    }
    let sum = |of: fn(&Component) -> u128| run.energy.components.iter().map(of).sum();
    row(WHOLE_GPU, sum(|c| c.dynamic_fj), sum(|c| c.leakage_fj))
}

/// Area by component, and rays a second for it.
fn area(f: &mut Formatter<'_>, report: &Report, config: &MachineConfig) -> fmt::Result {
    let AreaReport { components } = AreaReport::new(config);
    let all: u64 = components.iter().map(|c| c.um2).sum();
    let ti = components.iter().filter(|c| c.group == Group::Ti).map(|c| c.um2).sum();
    writeln!(f, "\n{:<15}{:>15}{:>14}{:>24}", "area", "mm2", "% of GPU", "Mrays/s a mm2")?;
    let mut row = |name: &str, um2: u64, rate: Option<f64>| {
        let rate = rate.map_or_else(String::new, digits);
        let line = format!("  {name:<13}{:>15.3}{:>14}{rate:>24}", um2 as f64 / 1e6, percent(um2, all));
        writeln!(f, "{}", line.trim_end())
    };
    components.iter().try_for_each(|c| row(c.name, c.um2, None))?;
    if ti > 0 {
        row("T&I units", ti, report.run.mrays_per_mm2)?;
    }
    row(WHOLE_GPU, all, report.run.gpu_mrays_per_mm2)
}
