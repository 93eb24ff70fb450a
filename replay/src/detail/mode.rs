//! How much of a frame is simulated cycle by cycle.

use std::fmt;
use std::str::FromStr;

/// A part of a whole, in millionths: equal texts give equal values, and no rounding enters a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Share(u32);

impl Share {
    /// Millionths of a whole.
    const WHOLE: u32 = 1_000_000;

    /// The share of so many millionths, if it is more than nothing and not more than the whole.
    pub fn from_millionths(millionths: u32) -> Option<Self> {
        (1..=Self::WHOLE).contains(&millionths).then_some(Self(millionths))
    }

    /// As a fraction of 1.
    pub fn fraction(self) -> f64 {
        f64::from(self.0) / f64::from(Self::WHOLE)
    }
}

impl FromStr for Share {
    type Err = String;

    /// Reads a fraction (`0.05`) or a percentage (`5%`).
    fn from_str(text: &str) -> Result<Self, String> {
        let (number, scale) = match text.strip_suffix('%') {
            Some(percent) => (percent, f64::from(Self::WHOLE) / 100.0),
            None => (text, f64::from(Self::WHOLE)),
        };
        let value: f64 = number.trim().parse().map_err(|_| format!("`{text}` is neither a number nor a percentage"))?;
        let millionths = (value * scale).round();
        let whole = f64::from(Self::WHOLE);
        let inside = (1.0..=whole).contains(&millionths);
        inside
            .then_some(Self(millionths as u32))
            .ok_or_else(|| format!("`{text}` is not from 0.000001 (0.0001%) to 1 (100%)"))
    }
}

impl fmt::Display for Share {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.fraction().fmt(f)
    }
}

/// How much of a frame a machine simulates cycle by cycle. The rest is counted by a functional pass and estimated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Detail {
    /// Every cycle, tile after tile, in one thread: nothing is estimated.
    #[default]
    Full,
    /// All tiles, in windows that run side by side; only what crosses from window to window is estimated.
    All,
    /// Windows with this share of the tiles.
    Sampled(Share),
    /// As many windows as it takes until the 95 % intervals of cycles and energy are this narrow.
    Precision(Share),
    /// No cycle: what is counted without cycles, by the functional pass alone.
    Counts,
}

impl Detail {
    /// Name of the mode, as results show it.
    pub fn mode(self) -> &'static str {
        match self {
            Self::Full => "full",
            Self::All => "all",
            Self::Sampled(_) => "sampled",
            Self::Precision(_) => "precision",
            Self::Counts => "counts",
        }
    }
}

/// The text that reads as the same value again; what `--detail` takes, and `precision P` for `--precision P`.
impl fmt::Display for Detail {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sampled(share) => share.fmt(f),
            Self::Precision(share) => write!(f, "precision {share}"),
            _ => f.write_str(self.mode()),
        }
    }
}

impl FromStr for Detail {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "full" => return Ok(Self::Full),
            "all" => return Ok(Self::All),
            "counts" => return Ok(Self::Counts),
            _ => {}
        }
        match text.strip_prefix("precision ") {
            Some(share) => share.parse().map(Self::Precision),
            None => text.parse().map(Self::Sampled).map_err(|error| {
                // A number is a share, and what is wrong with it is its size.
                if text.trim_end_matches('%').trim().parse::<f64>().is_ok() {
                    return error;
                }
                format!("`{text}` is not a detail: give full, all, counts, or a share of the tiles such as 0.05 or 5%")
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_read_as_what_they_were() {
        for text in ["full", "all", "counts", "0.05", "1", "precision 0.01"] {
            let detail: Detail = text.parse().unwrap();
            assert_eq!(detail.to_string(), text);
            assert_eq!(detail.to_string().parse(), Ok(detail));
        }
        assert_eq!("5%".parse::<Detail>(), "0.05".parse());
        assert_eq!("precision 1%".parse::<Detail>(), "precision 0.01".parse());
    }

    #[test]
    fn what_is_no_detail_is_refused() {
        for text in ["", "half", "0", "-1", "1.5", "101%", "NaN", "precision 0", "precision"] {
            assert!(text.parse::<Detail>().is_err(), "{text}");
        }
        let says = |text: &str| text.parse::<Detail>().unwrap_err();
        assert!(says("half").contains("give full, all, counts"), "{}", says("half"));
        assert!(["1e-7", "101%"].iter().all(|text| says(text).contains("is not from 0.000001")), "{}", says("101%"));
    }
}
