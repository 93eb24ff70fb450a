//! What names a chunk, and the version of the format.

use std::fmt;

/// Stands for "no frame" or "no tile" in a [`ChunkId`].
pub const NONE: u32 = u32::MAX;

/// Version of the format.
///
/// A reader reads every file of its own major version: a newer minor version only adds chunk kinds, which are skipped,
/// and uses for reserved fields, which are ignored. A writer continues only files of a version it knows in full.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct FormatVersion {
    /// Changes when an older reader would misread the file.
    pub major: u16,
    /// Changes when something is added that an older reader can ignore.
    pub minor: u16,
}

impl FormatVersion {
    /// The version this build writes, and the newest it knows.
    pub const CURRENT: Self = Self { major: 1, minor: 0 };
}

impl fmt::Display for FormatVersion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{}", self.major, self.minor)
    }
}

/// What a chunk holds: four bytes, printable in every kind defined so far.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChunkKind(pub [u8; 4]);

impl ChunkKind {
    /// What was captured and how; one per file, needed to make sense of the others.
    pub const META: Self = Self(*b"META");
    /// The acceleration structure; one per file.
    pub const BVH: Self = Self(*b"BVH ");
    /// One frame: its camera.
    pub const FRAM: Self = Self(*b"FRAM");
    /// One tile of one frame: columns of samples.
    pub const TILE: Self = Self(*b"TILE");
    /// The table of all other chunks; the last chunk of a finished file.
    pub const INDX: Self = Self(*b"INDX");

    /// Whether this version of the format defines the kind. Readers skip the others.
    pub fn is_known(self) -> bool {
        [Self::META, Self::BVH, Self::FRAM, Self::TILE, Self::INDX].contains(&self)
    }
}

impl fmt::Display for ChunkKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.0.escape_ascii().to_string().trim_end())
    }
}

impl fmt::Debug for ChunkKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ChunkKind({self})")
    }
}

/// Names a chunk. A file holds at most one chunk of each id, except of kinds this version does not define.
///
/// The order is by kind, then frame, then tile: good for look-ups, not the order of chunks in a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ChunkId {
    /// What it holds.
    pub kind: ChunkKind,
    /// Frame, counted from 0; [`NONE`] for chunks of the whole file.
    pub frame: u32,
    /// Tile within the frame, counted from 0; [`NONE`] for chunks of the whole file or a whole frame.
    pub tile: u32,
}

impl ChunkId {
    /// The metadata.
    pub const META: Self = Self { kind: ChunkKind::META, frame: NONE, tile: NONE };
    /// The acceleration structure.
    pub const BVH: Self = Self { kind: ChunkKind::BVH, frame: NONE, tile: NONE };
    /// The index.
    pub(crate) const INDX: Self = Self { kind: ChunkKind::INDX, frame: NONE, tile: NONE };

    /// A frame.
    pub const fn frame(frame: u32) -> Self {
        Self { kind: ChunkKind::FRAM, frame, tile: NONE }
    }

    /// A tile of a frame.
    pub const fn tile(frame: u32, tile: u32) -> Self {
        Self { kind: ChunkKind::TILE, frame, tile }
    }

    /// Whether frame and tile are given exactly where the kind wants them. Always true for unknown kinds.
    pub(crate) fn is_well_formed(self) -> bool {
        let given = (self.frame != NONE, self.tile != NONE);
        match self.kind {
            ChunkKind::META | ChunkKind::BVH | ChunkKind::INDX => given == (false, false),
            ChunkKind::FRAM => given == (true, false),
            ChunkKind::TILE => given == (true, true),
            _ => true,
        }
    }
}

impl fmt::Display for ChunkId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} chunk", self.kind)?;
        if self.frame != NONE {
            write!(f, " of frame {}", self.frame)?;
        }
        if self.tile != NONE {
            write!(f, ", tile {}", self.tile)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_print_only_what_they_have() {
        assert_eq!(ChunkId::BVH.to_string(), "BVH chunk");
        assert_eq!(ChunkId::frame(2).to_string(), "FRAM chunk of frame 2");
        assert_eq!(ChunkId::tile(2, 0).to_string(), "TILE chunk of frame 2, tile 0");
        assert_eq!(ChunkKind(*b"a\n\xffz").to_string(), "a\\n\\xffz");
    }
}
