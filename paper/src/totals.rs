//! The animation for people: sums and means over its frames.

use std::fmt::Write as _;

use rayreel_study::html::magnitude::{ENERGY, Unit, for_all};
use rayreel_study::schema::{Study, Track, TrackFrame};

use crate::cells::{or_dash, plus_minus, psnr};
use crate::policies::word;

/// The unit in which the largest energy of a frame has enough digits.
fn unit(tracks: &[Track]) -> Unit {
    let frames = tracks.iter().flat_map(|track| &track.frames);
    for_all(&ENERGY, frames.filter_map(|frame| frame.energy_mj))
}

/// The mean energy of the frames that have one, and how many these are, if not all.
fn energy(track: &Track, scale: f64) -> String {
    let known: Vec<f64> = track.frames.iter().filter_map(|f| f.energy_mj).collect();
    if known.is_empty() {
        return "-".into();
    }
    let (count, all) = (known.len(), track.frames.len());
    let within = track.interval.map_or_else(String::new, |i| plus_minus(i.energy_mj));
    let of = if count < all { format!(" ({count} of {all} frames)") } else { String::new() };
    format!("{:.3}{within}{of}", known.iter().sum::<f64>() / count as f64 * scale)
}

/// A row for each policy; nothing without an animation.
pub fn table(study: &Study) -> String {
    let tracks = &study.tracks;
    let Some(first) = tracks.first() else { return String::new() };
    // A machine without T&I units has only the whole.
    let is_whole = study.points.iter().any(|p| p.gpu.is_some()) && study.points.iter().all(|p| p.ti.is_none());
    let Unit { name: unit, scale } = unit(tracks);
    let head = format!("{} {unit} a frame", if is_whole { "GPU" } else { "T&I" });
    let energies: Vec<String> = tracks.iter().map(|track| energy(track, scale)).collect();
    let wide = energies.iter().chain([&head]).map(|text| text.chars().count()).fold(0, usize::max);
    let mut text =
        format!("\nthe animation of {}, {} frames, {}\n\n", first.scene, first.frames.len(), word(&first.mode));
    let _ = writeln!(
        text,
        "{:<24} {:>9} {:>7} {:>8} {:>9} {head:>wide$}",
        "policy", "ray ratio", "rate %", "PSNR dB", "flicker"
    );
    for (track, energy) in tracks.iter().zip(energies) {
        let frames = &track.frames;
        let sum = |of: fn(&TrackFrame) -> u64| frames.iter().map(of).sum::<u64>() as f64;
        let rate = frames.iter().map(|f| f.mean_rate).sum::<f64>() / frames.len().max(1) as f64;
        let _ = writeln!(
            text,
            "{:<24} {:>9.2} {:>7.1} {:>8} {:>9} {energy:>wide$}",
            track.policy,
            sum(|f| f.rays_full) / sum(|f| f.rays_traced).max(1.0),
            rate * 100.0,
            psnr(track.psnr_db),
            or_dash(track.flicker, 3)
        );
    }
    text
}

#[cfg(test)]
mod tests {
    use rayreel_study::schema::CostInterval;

    use super::*;

    fn track(policy: &str, energies: &[Option<f64>], psnr_db: Option<f64>) -> Track {
        let frame = |energy_mj: &Option<f64>| TrackFrame { energy_mj: *energy_mj, ..TrackFrame::default() };
        let frames = energies.iter().map(frame).collect();
        Track { policy: policy.into(), frames, psnr_db, ..Track::default() }
    }

    fn said(tracks: Vec<Track>) -> String {
        table(&Study { tracks, ..Study::default() })
    }

    /// Rays were of all frames and energy of three, and nothing said so; of small pictures all energies were 0.000.
    #[test]
    fn energy_says_of_which_frames_it_is_and_has_digits() {
        let some = track("full", &[Some(2e-3), None, Some(4e-3)], None);
        let all = track("paper-ss", &[Some(1e-3); 3], Some(31.416));
        let text = said(vec![some, all, track("none", &[None; 3], None)]);
        let rows: Vec<&str> = text.lines().filter(|line| !line.is_empty()).skip(1).collect();
        assert!(rows[0].ends_with("T&I µJ a frame") && rows[1].ends_with(" 3.000 (2 of 3 frames)"), "{text}");
        assert!(rows[2].ends_with(" 1.000") && rows[3].ends_with(" -"), "{text}");
        assert!(rows.iter().all(|row| row.chars().count() == rows[0].chars().count()), "columns end together\n{text}");
    }

    /// A dash stood for it, as for what was not measured.
    #[test]
    fn identical_pictures_are_the_same() {
        let interval = Some(CostInterval { energy_mj: 0.0123, ..CostInterval::default() });
        let text = said(vec![Track { interval, ..track("full", &[Some(1.0)], None) }]);
        assert!(text.contains(" same ") && text.contains(" 1.000 ±1.2%"), "{text}");
    }
}
