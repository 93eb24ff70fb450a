//! Axes: from values to places, and the round numbers that are written along them.

use super::WIDTH;
use super::svg::text_width;
use crate::html::text::fixed;

/// A linear axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scale {
    /// Values at the ends.
    pub domain: [f64; 2],
    /// Places of the ends, units of the picture.
    pub range: [f64; 2],
    /// Distance of the ticks.
    step: f64,
}

impl Scale {
    /// From `low` to `high`, both moved outwards to a tick; about `ticks` of them.
    pub fn nice([low, high]: [f64; 2], ticks: u32, range: [f64; 2]) -> Self {
        let (low, high) = (bounded(low), bounded(high));
        let high = apart(low, high);
        let step = round_step((high - low) / f64::from(ticks.max(1)));
        Self { domain: [(low / step).floor() * step, (high / step).ceil() * step], range, step }
    }

    /// From exactly `low` to `high`; ticks stand at round numbers between.
    pub fn exact([low, high]: [f64; 2], ticks: u32, range: [f64; 2]) -> Self {
        let (low, high) = (bounded(low), bounded(high));
        let high = apart(low, high);
        Self { domain: [low, high], range, step: round_step((high - low) / f64::from(ticks.max(1))) }
    }

    /// Where a value stands; values outside stand at the ends.
    pub fn at(&self, value: f64) -> f64 {
        let ([low, high], [a, b]) = (self.domain, self.range);
        a + (b - a) * ((value - low) / (high - low)).clamp(0.0, 1.0)
    }

    /// The values to write along the axis.
    pub fn ticks(&self) -> Vec<f64> {
        let [low, high] = self.domain;
        let first = (low / self.step - 1e-9).ceil();
        let count = ((high / self.step + 1e-9).floor() - first).clamp(0.0, 20.0) as u32;
        (0..=count).map(|i| (first + f64::from(i)) * self.step).collect()
    }

    /// The ticks of a horizontal axis with their texts, so few of them that no text runs into the next.
    pub fn named_ticks(&self, text: impl Fn(f64) -> String) -> Vec<(f64, String)> {
        let mut named: Vec<_> = self.ticks().into_iter().map(|tick| (tick, text(tick))).collect();
        named.dedup_by(|a, b| a.1 == b.1);
        // Nor does one stick out to the right.
        named.retain(|(tick, text)| self.at(*tick) + text_width(text) / 2.0 <= WIDTH + 4.0);
        let widest = named.iter().map(|(_, text)| text_width(text) * TICK).fold(0.0, f64::max) + 4.0;
        let apart = named.windows(2).map(|pair| (self.at(pair[1].0) - self.at(pair[0].0)).abs()).fold(widest, f64::min);
        let every = if apart > 0.0 { (widest / apart).ceil() as usize } else { named.len() };
        named.into_iter().step_by(every.max(1)).collect()
    }

    /// Room at the left of a vertical axis for the longest text of a tick, and no less than `least`.
    pub fn margin(&self, least: f64, text: impl Fn(f64) -> String) -> f64 {
        let widths = self.ticks().into_iter().map(|tick| text_width(&text(tick)) * TICK + 7.0);
        widths.fold(least, f64::max)
    }

    /// The same axis in another unit: its ticks stand where they stood and are so many times as much.
    pub fn times(&self, scale: f64) -> Self {
        Self { domain: self.domain.map(|end| end * scale), step: self.step * scale, ..*self }
    }

    /// A tick as text, with the places that tell it from its neighbours.
    pub fn label(&self, tick: f64) -> String {
        if tick == 0.0 {
            return "0".into();
        }
        let (unit, name) = unit(self.domain[0].abs().max(self.domain[1].abs()));
        let mut scaled = self.step / unit;
        let mut places = 0;
        while places < PLACES_MAX && !(scaled > 0.5 && (scaled - scaled.round()).abs() < 1e-6) {
            (scaled, places) = (scaled * 10.0, places + 1);
        }
        fixed(tick / unit, places) + &name
    }
}

/// Digits of ticks are wider than other letters, for all that they are smaller.
const TICK: f64 = 1.1;

/// Most places of a tick: what differs less is one value to an axis.
const PLACES_MAX: usize = 14;

/// What the numbers of an axis are of that reaches `most`, and what stands behind them: a prefix, or a power of ten.
fn unit(most: f64) -> (f64, String) {
    match most {
        v if (1e-3..1e4).contains(&v) || v == 0.0 => (1.0, String::new()),
        v if (1e4..1e6).contains(&v) => (1e3, "k".into()),
        v if (1e6..1e9).contains(&v) => (1e6, "M".into()),
        v if (1e9..1e12).contains(&v) => (1e9, "G".into()),
        v => {
            // As it is written: a logarithm of the platform could differ in its last bit.
            let text = format!("{:e}", v.max(1e-300));
            let power = text.split('e').next_back().unwrap_or("0");
            (format!("1e{power}").parse().unwrap_or(1.0), format!("e{power}"))
        }
    }
}

/// The end of an axis: `high`, or beyond it where `low` is the same but for its last digits.
fn apart(low: f64, high: f64) -> f64 {
    let most = low.abs().max(high.abs());
    if high - low > most * 1e-12 {
        return high;
    }
    low + if low == 0.0 { 1.0 } else { low.abs() }
}

/// A value with which sums and products stay finite.
fn bounded(value: f64) -> f64 {
    value.clamp(-1e100, 1e100)
}

/// The least of 1, 2 and 5 times a power of ten that is `raw` or more.
fn round_step(raw: f64) -> f64 {
    if !(raw > 0.0 && raw.is_finite()) {
        return 1.0;
    }
    // By multiplication, since a logarithm of the platform could differ in its last bit.
    let mut power = 1.0;
    while power > raw {
        power /= 10.0;
    }
    while power * 10.0 <= raw {
        power *= 10.0;
    }
    [1.0, 2.0, 5.0].into_iter().map(|m| m * power).find(|&step| step >= raw * (1.0 - 1e-9)).unwrap_or(power * 10.0)
}

/// Least and most of some values; nothing without values.
pub fn extent(values: impl IntoIterator<Item = f64>) -> Option<[f64; 2]> {
    values.into_iter().fold(None, |extent, v| {
        let [low, high] = extent.unwrap_or([v, v]);
        Some([low.min(v), high.max(v)])
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        let scale = Scale::nice([0.0, 2.98], 4, [100.0, 0.0]);
        assert_eq!((scale.ticks(), scale.at(0.0), scale.at(3.0)), (vec![0.0, 1.0, 2.0, 3.0], 100.0, 0.0));
        assert_eq!(Scale::nice([28.5, 49.0], 4, [0.0, 1.0]).ticks(), [20.0, 30.0, 40.0, 50.0]);
        assert_eq!(Scale::exact([1.0, 700.0], 4, [0.0, 1.0]).ticks(), [200.0, 400.0, 600.0]);
        assert_eq!(Scale::nice([0.0, 0.07], 4, [0.0, 1.0]).label(0.02), "0.02");
        let millions = Scale::nice([0.0, 9.1e6], 4, [0.0, 1.0]);
        let labels: Vec<String> = millions.ticks().into_iter().map(|tick| millions.label(tick)).collect();
        assert_eq!(labels, ["0", "5M", "10M"]);
        let small = Scale::nice([0.0, 0.0012], 4, [0.0, 1.0]);
        let labels: Vec<String> = small.ticks().into_iter().map(|tick| small.times(1e3).label(tick * 1e3)).collect();
        assert_eq!(labels, ["0", "0.5", "1.0", "1.5"]);
        let close = Scale::nice([0.99312, 0.99402], 4, [0.0, 1.0]);
        let labels: Vec<String> = close.ticks().into_iter().map(|tick| close.label(tick)).collect();
        assert!(labels.windows(2).all(|pair| pair[0] != pair[1]), "{labels:?}");
        for (domain, texts) in [
            ([1e-12, 9e-10], ["0", "0.5e-9", "1.0e-9"].as_slice()),
            ([22_400.0, 22_400.001], &["22.4000000k", "22.4000005k", "22.4000010k"]),
            ([0.0, 2.5e17], &["0", "1e17", "2e17", "3e17"]),
            ([-20.0, -19.999], &["\u{2212}20.0000", "\u{2212}19.9995", "\u{2212}19.9990"]),
        ] {
            let scale = Scale::nice(domain, 3, [0.0, 1.0]);
            let labels: Vec<String> = scale.ticks().into_iter().map(|tick| scale.label(tick)).collect();
            assert_eq!(labels, texts);
            let widest = labels.iter().map(|label| label.chars().count()).max().unwrap();
            assert!(scale.margin(1.0, |tick| scale.label(tick)) > 6.0 * widest as f64);
        }
        // One number that two sums gave.
        let one = Scale::nice([1e15, 1e15 + 0.5], 4, [0.0, 1.0]);
        assert!(one.named_ticks(|tick| one.label(tick)).windows(2).all(|pair| pair[0].1 != pair[1].1));
    }

    #[test]
    fn texts_of_ticks_do_not_run_into_one_another() {
        for (domain, range) in
            [([0.951, 0.978], [151.0, 348.0]), ([0.0, 3.0], [151.0, 348.0]), ([5.0, 5.0], [0.0, 30.0])]
        {
            let scale = Scale::nice(domain, 5, range);
            let named = scale.named_ticks(|tick| scale.label(tick) + "×");
            let free = |pair: &[(f64, String)]| {
                scale.at(pair[1].0) - scale.at(pair[0].0) - (text_width(&pair[0].1) + text_width(&pair[1].1)) / 2.0
            };
            assert!(named.windows(2).all(|pair| free(pair) > 0.0), "{named:?}");
            assert!(!named.is_empty() && named.len() <= scale.ticks().len());
        }
        let roomy = Scale::nice([0.0, 3.0], 4, [0.0, 300.0]);
        assert_eq!(
            roomy.named_ticks(|tick| roomy.label(tick)).len(),
            roomy.ticks().len(),
            "none is left out without need"
        );
    }

    #[test]
    fn no_values_are_no_trouble() {
        for domain in [[0.0, 0.0], [5.0, 5.0], [-1e300, 1e300], [0.0, 1e-300]] {
            let scale = Scale::nice(domain, 4, [0.0, 10.0]);
            assert!(scale.at(domain[1]).is_finite() && scale.ticks().len() <= 21, "{domain:?}");
        }
    }
}
