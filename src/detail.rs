//! `--detail` and `--precision`: how much is simulated cycle by cycle.

use rayreel_replay::Detail;
use rayreel_replay::detail::Share;

/// How much is simulated cycle by cycle.
#[derive(Clone, Copy, Debug, clap::Args)]
pub struct DetailArgs {
    /// How much the machine simulates cycle by cycle: full, all, counts, or a share of the tiles such as 0.05 or 5%.
    ///
    /// full is every cycle, in one thread; all is every tile, in windows side by side on all cores; a share is a sample, from which
    /// everything is estimated, with intervals; counts is no cycle: work, misses and energy without time. No result depends on the
    /// number of threads.
    #[arg(long, value_name = "full|all|counts|SHARE", conflicts_with = "precision")]
    detail: Option<Detail>,
    /// Simulate as many windows of tiles as it takes until the 95 % intervals of cycles and energy reach no further than this part
    /// of them, such as 1%.
    #[arg(long, value_name = "SHARE")]
    precision: Option<Share>,
}

impl DetailArgs {
    /// What was asked for, if anything was.
    pub fn asked(&self) -> Option<Detail> {
        self.precision.map(Detail::Precision).or(self.detail)
    }

    /// The option as it was given, for messages.
    pub fn said(&self) -> String {
        self.words().map_or_else(String::new, |(option, value)| format!("{option} {value}"))
    }

    /// The option and its value, if one was given.
    pub fn words(&self) -> Option<(&'static str, String)> {
        match (self.precision, self.detail) {
            (Some(share), _) => Some(("--precision", share.to_string())),
            (None, Some(detail)) => Some(("--detail", detail.to_string())),
            (None, None) => None,
        }
    }
}
