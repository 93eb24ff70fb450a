//! The report for people.

use std::fmt::{self, Display};

use crate::figures::SamplingFigures;
use crate::report::detail::DetailReport;
use crate::report::format::{amount, grouped, plus_minus, ratio, share};
use crate::report::{FrameReport, Report, page};
use rayreel_replay::counts::RayCounts;

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, samples_per_axis: s, .. } = self;
        writeln!(f, "{}: policy {}, {width} x {height} pixels, {s} x {s} samples a pixel", self.trace, self.policy)?;
        writeln!(f)?;
        samples(f, &self.sum)?;
        writeln!(f)?;
        rays(f, &self.sum)?;
        writeln!(f)?;
        quality(f, &self.sum, self.frames.len() > 1)?;
        page::write(f, self)?;
        if self.frames.len() > 1 { frames(f, &self.frames, self.machine.is_some()) } else { Ok(()) }
    }
}

fn frames(f: &mut fmt::Formatter<'_>, frames: &[FrameReport], machine: bool) -> fmt::Result {
    writeln!(f)?;
    write!(f, "{:>7} {:>13} {:>8} {:>8} {:>9}", "frame", "rays", "of full", "similar", "PSNR")?;
    write!(f, " {:>7} {:>7} {:>7}", "SSIM", "FLIP", "flicker")?;
    // Room for what stands behind an estimate.
    let is_estimated = |frame: &FrameReport| frame.detail.as_ref().is_some_and(DetailReport::is_estimated);
    let [a, b] = if frames.iter().any(is_estimated) { [17, 18] } else { [10, 11] };
    writeln!(f, "{}", if machine { format!(" {:>a$} {:>b$}", "time", "GPU energy") } else { String::new() })?;
    for FrameReport { frame, figures, run, detail, .. } in frames {
        let cost = figures.rays_traced + figures.rays_apron;
        write!(f, "{frame:>7} {:>13} {:>8}", grouped(cost), share(cost, figures.rays_full))?;
        write!(f, " {:>8} {:>9}", ratio(figures.similarity_ratio), psnr(figures))?;
        let flicker = figures.flicker.map_or_else(|| "-".into(), |levels| format!("{levels:.2}"));
        write!(f, " {:>7} {:>7} {flicker:>7}", ratio4(figures.ssim), ratio4(figures.flip))?;
        if let (true, Some(gpu)) = (machine, run.gpu) {
            let within = |column| detail.as_ref().and_then(|d| d.interval(column)).map_or_else(String::new, plus_minus);
            let time = amount(run.time_ms, "ms") + &within("time_ms");
            let energy = amount(gpu.energy_mj, "mJ") + &within("gpu_energy_mj");
            write!(f, " {time:>a$} {energy:>b$}")?;
        }
        writeln!(f)?;
    }
    Ok(())
}

fn samples(f: &mut fmt::Formatter<'_>, figures: &SamplingFigures) -> fmt::Result {
    let all = figures.samples_full;
    writeln!(f, "{:<22} {:>14}", "samples", grouped(all))?;
    for (name, count) in [
        ("  traced", figures.samples_traced),
        ("  interpolated", figures.samples_interpolated),
        ("  apron, traced again", figures.samples_apron),
    ] {
        writeln!(f, "{name:<22} {:>14} {:>8}", grouped(count), share(count, all))?;
    }
    writeln!(f, "{:<22} {:>14} of the I-samples", "  similar", ratio(figures.similarity_ratio))
}

fn rays(f: &mut fmt::Formatter<'_>, figures: &SamplingFigures) -> fmt::Result {
    writeln!(f, "{:<22} {:>14} {:>14} {:>8} {:>14}", "rays", "full", "traced", "of full", "apron")?;
    let kinds = &figures.rays_by_kind;
    let kind = |get: fn(&RayCounts) -> u64| (get(&kinds.full), get(&kinds.traced), get(&kinds.apron));
    for (name, (full, traced, apron)) in [
        ("  primary", kind(|c| c.primary)),
        ("  reflection", kind(|c| c.reflection)),
        ("  refraction", kind(|c| c.refraction)),
        ("  shadow", kind(|c| c.shadow)),
        ("  all", kind(RayCounts::total)),
    ] {
        let (part, full, traced, apron) = (share(traced, full), grouped(full), grouped(traced), grouped(apron));
        writeln!(f, "{name:<22} {full:>14} {traced:>14} {part:>8} {apron:>14}")?;
    }
    let sign = if figures.rays_saved < 0 { "-" } else { "" };
    writeln!(f, "{:<22} {:>14}", "  saved", format!("{sign}{}", grouped(figures.rays_saved.unsigned_abs())))
}

/// The picture against that of full; nothing more than a dash without a comparison.
fn quality(f: &mut fmt::Formatter<'_>, figures: &SamplingFigures, several: bool) -> fmt::Result {
    write!(f, "PSNR {}   SSIM {}   FLIP {}", psnr(figures), ratio4(figures.ssim), ratio4(figures.flip))?;
    if let (Some(db), Some(tile)) = (figures.worst_tile_psnr_db, figures.worst_tile) {
        write!(f, "   worst tile {db:.2} dB (tile {tile}")?;
        match figures.worst_tile_frame {
            Some(frame) if several => write!(f, " of frame {frame})")?,
            _ => write!(f, ")")?,
        }
    }
    writeln!(f)?;
    if figures.audited_pixels > 0 {
        let db = figures.audited_psnr_db.map_or_else(|| "identical".into(), |db| format!("{db:.2} dB"));
        let (pixels, factor) = (grouped(figures.audited_pixels), ratio4(figures.limit_factor));
        writeln!(f, "audits {db} on {pixels} pixels, colour limit x {factor} in the mean")?;
    }
    let Some(levels) = figures.flicker else { return Ok(()) };
    let db = figures.flicker_db.map_or_else(String::new, |db| format!(" ({db:.2} dB)"));
    writeln!(f, "flicker {levels:.2} 8-bit levels{db}")
}

fn psnr(figures: &SamplingFigures) -> String {
    match (figures.psnr_db, figures.identical) {
        (Some(db), _) => format!("{db:.2} dB"),
        (None, Some(_)) => "identical".into(),
        (None, None) => "-".into(),
    }
}

/// A figure from 0 to 1.
fn ratio4(value: Option<f64>) -> String {
    value.map_or_else(|| "-".into(), |v| format!("{v:.4}"))
}
