//! What is wanted of a point: figures of all frames or of each, and what can be looked at.

use std::fmt::Write as _;

/// What is wanted of a point. By default its row, as sweeps want it.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Wanted {
    /// Which figures.
    pub figures: Figures,
    /// What no figure says.
    pub views: Views,
}

/// Which figures of a point are wanted.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Figures {
    /// A [`crate::point::row::Row`]: sums over all frames, each simulated and compared as a viewer sees it.
    #[default]
    Row,
    /// Those of each frame by itself.
    Frames {
        /// How frames are compared with those of `full`. Pictures and tiles have what that gives, and no more.
        compared: Compared,
        /// The frames that the machine simulates.
        simulated: Vec<u32>,
    },
}

impl Figures {
    /// Whether a machine simulates a frame for the details.
    pub(crate) fn simulates_details(&self) -> bool {
        matches!(self, Self::Frames { simulated, .. } if !simulated.is_empty())
    }
}

/// How a picture is compared with that of `full`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Compared {
    /// Not at all.
    Not,
    /// Value by value: PSNR and flicker.
    Valued,
    /// As a viewer sees it, too: SSIM and FLIP.
    Seen,
}

impl Compared {
    fn name(self) -> &'static str {
        match self {
            Self::Not => "not",
            Self::Valued => "valued",
            Self::Seen => "seen",
        }
    }
}

/// What can be looked at of a point.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Views {
    /// Figures of each tile.
    pub tiles: bool,
    /// Pictures.
    pub pictures: Vec<PictureWanted>,
}

/// A picture of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureWanted {
    /// The frame.
    pub frame: u32,
    /// What it shows.
    pub kind: Kind,
    /// How many times smaller it is than the frame.
    pub shrink: u32,
}

/// What a picture shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The policy's picture.
    Result,
    /// That of `full`.
    Reference,
    /// Their difference.
    Error,
    /// Where a viewer sees that they differ.
    Flip,
    /// Which samples were interpolated.
    Similarity,
    /// At what rate each tile was sampled.
    Rate,
}

impl Kind {
    /// All kinds, in the order in which `rayreel replay` writes them.
    pub const ALL: [Self; 6] = [Self::Result, Self::Reference, Self::Error, Self::Flip, Self::Similarity, Self::Rate];

    /// Its name, in file names.
    pub fn name(self) -> &'static str {
        match self {
            Self::Result => "result",
            Self::Reference => "reference",
            Self::Error => "error",
            Self::Flip => "flip",
            Self::Similarity => "similarity",
            Self::Rate => "rate",
        }
    }

    /// What its making needs.
    fn needs(self) -> Compared {
        match self {
            Self::Result | Self::Similarity | Self::Rate => Compared::Not,
            Self::Reference | Self::Error => Compared::Valued,
            Self::Flip => Compared::Seen,
        }
    }
}

impl Views {
    /// Whether nothing is wanted.
    pub fn is_empty(&self) -> bool {
        !self.tiles && self.pictures.is_empty()
    }

    /// The comparison that they need.
    pub(crate) fn needs(&self) -> Compared {
        let all = || self.pictures.iter().map(|picture| picture.kind.needs());
        if all().any(|needed| needed == Compared::Seen) {
            Compared::Seen
        } else if self.tiles || all().any(|needed| needed == Compared::Valued) {
            Compared::Valued
        } else {
            Compared::Not
        }
    }
}

impl Wanted {
    /// What is wanted beside a row, as text: equal for equal wishes, and part of a key. Nothing if that is nothing.
    pub(crate) fn canonical(&self) -> Option<String> {
        let mut text = String::new();
        match &self.figures {
            Figures::Row if self.views.is_empty() => return None,
            Figures::Row => {}
            Figures::Frames { compared, simulated } => {
                let _ = write!(text, "frames compared {} simulated", compared.name());
                for frame in simulated {
                    let _ = write!(text, " {frame}");
                }
                text.push('\n');
            }
        }
        if self.views.tiles {
            text += "tiles\n";
        }
        for PictureWanted { frame, kind, shrink } in &self.views.pictures {
            let _ = writeln!(text, "picture {} frame {frame} shrink {shrink}", kind.name());
        }
        Some(text)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_wishes_have_one_text_and_others_another() {
        let picture = |frame, kind| PictureWanted { frame, kind, shrink: 1 };
        let views = |tiles, pictures: &[PictureWanted]| Views { tiles, pictures: pictures.to_vec() };
        let frames = |compared, simulated: &[u32]| Figures::Frames { compared, simulated: simulated.to_vec() };
        let all = [
            Wanted { figures: Figures::Row, views: views(true, &[]) },
            Wanted { figures: Figures::Row, views: views(false, &[picture(0, Kind::Result)]) },
            Wanted { figures: Figures::Row, views: views(false, &[picture(1, Kind::Result)]) },
            Wanted { figures: Figures::Row, views: views(false, &[picture(0, Kind::Error)]) },
            Wanted { figures: Figures::Row, views: views(true, &[picture(0, Kind::Result)]) },
            Wanted { figures: frames(Compared::Not, &[]), views: Views::default() },
            Wanted { figures: frames(Compared::Valued, &[]), views: Views::default() },
            Wanted { figures: frames(Compared::Valued, &[12]), views: Views::default() },
            Wanted { figures: frames(Compared::Valued, &[1, 2]), views: Views::default() },
        ];
        let texts: std::collections::BTreeSet<_> = all.iter().map(|wanted| wanted.canonical().unwrap()).collect();
        assert_eq!(texts.len(), all.len());
        assert_eq!(all[0].canonical().unwrap(), "tiles\n");
        assert_eq!(all[8].canonical().unwrap(), "frames compared valued simulated 1 2\n");
        assert_eq!(Wanted::default().canonical(), None);
    }
}
