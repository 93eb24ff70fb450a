//! Axes: from values to places, and the round numbers that are written along them.

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
        let (low, high) = if high > low { (low, high) } else { (low, low + low.abs().max(1.0)) };
        let step = round_step((high - low) / f64::from(ticks.max(1)));
        Self { domain: [(low / step).floor() * step, (high / step).ceil() * step], range, step }
    }

    /// From exactly `low` to `high`; ticks stand at round numbers between.
    pub fn exact([low, high]: [f64; 2], ticks: u32, range: [f64; 2]) -> Self {
        let (low, high) = (bounded(low), bounded(high));
        let high = if high > low { high } else { low + low.abs().max(1.0) };
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
        let named: Vec<_> = self.ticks().into_iter().map(|tick| (tick, text(tick))).collect();
        let widest = named.iter().map(|(_, text)| text_width(text)).fold(0.0, f64::max) + 4.0;
        let apart = named.windows(2).map(|pair| (self.at(pair[1].0) - self.at(pair[0].0)).abs()).fold(widest, f64::min);
        let every = if apart > 0.0 { (widest / apart).ceil() as usize } else { named.len() };
        named.into_iter().step_by(every.max(1)).collect()
    }

    /// The same axis in another unit: its ticks stand where they stood and are so many times as much.
    pub fn times(&self, scale: f64) -> Self {
        Self { domain: self.domain.map(|end| end * scale), step: self.step * scale, ..*self }
    }

    /// A tick as text, with the places that tell it from its neighbours.
    pub fn label(&self, tick: f64) -> String {
        let most = self.domain[0].abs().max(self.domain[1].abs());
        let (scale, prefix) = match most {
            v if v >= 1e9 => (1e-9, "G"),
            v if v >= 1e6 => (1e-6, "M"),
            v if v >= 1e4 => (1e-3, "k"),
            _ => (1.0, ""),
        };
        let step = self.step * scale;
        let whole = |places: &usize| {
            let scaled = step * [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6][*places];
            scaled > 0.5 && (scaled - scaled.round()).abs() < 1e-6
        };
        let places = (0..7).find(whole).unwrap_or(6);
        if tick == 0.0 { "0".into() } else { fixed(tick * scale, places) + prefix }
    }
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
