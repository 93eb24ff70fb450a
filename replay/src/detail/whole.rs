//! Frames that are simulated whole though a sample was asked for.

/// Why a sample cannot stand for a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WhyWhole {
    /// It has too few tiles, or too small ones, for windows to be worth their warm-up.
    FewTiles,
    /// The machine gathers rays, traces them by threads or has a rasteriser.
    Machine,
    /// A single tile decides how long it takes.
    OneTile,
    /// Its parts are alike, as those of sky and walls.
    Uniform,
    /// No sample reaches the precision that was asked for.
    Precision,
    /// The policy cannot begin a frame again.
    Policy,
}

impl WhyWhole {
    /// All of them, in the order in which they are told.
    pub const ALL: [Self; 6] =
        [Self::FewTiles, Self::Machine, Self::OneTile, Self::Uniform, Self::Precision, Self::Policy];

    /// Its name in results.
    pub fn name(self) -> &'static str {
        match self {
            Self::FewTiles => "few_tiles",
            Self::Machine => "machine",
            Self::OneTile => "one_tile",
            Self::Uniform => "uniform",
            Self::Precision => "precision",
            Self::Policy => "policy",
        }
    }

    /// The same in words.
    pub fn words(self) -> &'static str {
        match self {
            Self::FewTiles => "too few tiles, or too small ones, for what was asked",
            Self::Machine => "a machine that gathers rays, traces them by threads or has a rasteriser",
            Self::OneTile => "one tile is a large part of a frame",
            Self::Uniform => "tiles too alike",
            Self::Precision => "a precision that no sample reaches",
            Self::Policy => "a policy that cannot begin a frame again",
        }
    }
}

/// How many frames were simulated whole, for each reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct WholeFrames([u64; WhyWhole::ALL.len()]);

impl WholeFrames {
    /// One frame.
    pub fn one(why: WhyWhole) -> Self {
        let mut frames = Self::default();
        frames.0[why as usize] = 1;
        frames
    }

    /// All of them.
    pub fn total(&self) -> u64 {
        self.0.iter().sum()
    }

    /// Adds those of another run.
    pub fn add(&mut self, other: &Self) {
        self.0.iter_mut().zip(other.0).for_each(|(sum, more)| *sum += more);
    }

    /// The reasons that there are, with their frames.
    pub fn reasons(&self) -> impl Iterator<Item = (WhyWhole, u64)> + use<> {
        WhyWhole::ALL.into_iter().zip(self.0).filter(|(_, frames)| *frames > 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reasons_stay_apart() {
        let mut frames = WholeFrames::one(WhyWhole::Uniform);
        frames.add(&WholeFrames::one(WhyWhole::Policy));
        frames.add(&WholeFrames::one(WhyWhole::Uniform));
        assert_eq!(frames.total(), 3);
        assert_eq!(frames.reasons().collect::<Vec<_>>(), [(WhyWhole::Uniform, 2), (WhyWhole::Policy, 1)]);
        assert!(WhyWhole::ALL.iter().enumerate().all(|(place, why)| *why as usize == place));
    }
}
