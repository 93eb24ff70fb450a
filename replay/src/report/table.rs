//! The report for people.

use std::fmt::{self, Display};

use super::{Figures, Report};
use crate::frame::counts::RayCounts;

impl Display for Report {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { width, height, samples_per_axis: s, .. } = self;
        writeln!(f, "{}: policy {}, {width} x {height} pixels, {s} x {s} samples a pixel", self.trace, self.policy)?;
        writeln!(f)?;
        samples(f, &self.sum)?;
        writeln!(f)?;
        rays(f, &self.sum)?;
        writeln!(f)?;
        writeln!(f, "PSNR {}   SSIM {}", psnr(&self.sum), ssim(&self.sum))?;
        if self.frames.len() > 1 {
            writeln!(f)?;
            writeln!(
                f,
                "{:>7} {:>14} {:>8} {:>11} {:>10} {:>8}",
                "frame", "rays", "of full", "similar", "PSNR", "SSIM"
            )?;
            for frame in &self.frames {
                let own = &frame.figures;
                let cost = own.rays_traced + own.rays_apron;
                write!(f, "{:>7} {:>14} {:>8}", frame.frame, grouped(cost), share(cost, own.rays_full))?;
                writeln!(f, " {:>11} {:>10} {:>8}", ratio(own.similarity_ratio), psnr(own), ssim(own))?;
            }
        }
        Ok(())
    }
}

fn samples(f: &mut fmt::Formatter<'_>, figures: &Figures) -> fmt::Result {
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

fn rays(f: &mut fmt::Formatter<'_>, figures: &Figures) -> fmt::Result {
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

fn psnr(figures: &Figures) -> String {
    match (figures.psnr_db, figures.identical) {
        (Some(db), _) => format!("{db:.2} dB"),
        (None, Some(_)) => "identical".into(),
        (None, None) => "-".into(),
    }
}

fn ssim(figures: &Figures) -> String {
    figures.ssim.map_or_else(|| "-".into(), |v| format!("{v:.4}"))
}

fn ratio(ratio: Option<f64>) -> String {
    ratio.map_or_else(|| "-".into(), |r| format!("{:.1} %", r * 100.0))
}

fn share(part: u64, whole: u64) -> String {
    ratio((whole > 0).then(|| part as f64 / whole as f64))
}

/// Digits in groups of three.
fn grouped(n: u64) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups() {
        let cases = [(0, "0"), (999, "999"), (1000, "1 000"), (1_234_567, "1 234 567")];
        cases.into_iter().for_each(|(n, text)| assert_eq!(grouped(n), text));
    }
}
