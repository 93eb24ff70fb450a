//! The tables by name.

use crate::error::{ColumnsError, Result};
use crate::rows::{AddressRows, HitRows, NodeRows, RayRows, SampleRows, StepRows, TriangleRows};
use crate::schema::Table;
use crate::simulated::{CounterRows, LookupRows, RequestRows, TileTimeRows};

/// What can be had of a trace.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Every ray.
    Rays,
    /// Every hit of a closest-hit ray.
    Hits,
    /// Every step of every ray through the tree.
    Steps,
    /// What every ray reads of nodes and triangles, and where that lies on a machine.
    Addresses,
    /// Every sample; under a policy also what the policy made of it.
    Samples,
    /// The nodes of the tree.
    Nodes,
    /// The triangles.
    Triangles,
    /// What a machine's units look for before their caches, in the order of issue.
    Lookups,
    /// What goes to a machine's memory behind the first caches, in the order of issue.
    Requests,
    /// What a machine's units count over time.
    Counters,
    /// When a machine worked on which tile, and what it was.
    Tiles,
}

/// What may be chosen of a table, where it means something.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Choice {
    /// Some frames.
    Frames,
    /// Some tiles of each frame.
    Tiles,
    /// The length of intervals.
    Interval,
}

impl What {
    /// All of them, in the order in which documents list them.
    pub const ALL: [Self; 11] = [
        Self::Rays,
        Self::Hits,
        Self::Steps,
        Self::Addresses,
        Self::Samples,
        Self::Nodes,
        Self::Triangles,
        Self::Lookups,
        Self::Requests,
        Self::Counters,
        Self::Tiles,
    ];

    /// The table.
    pub fn table(self) -> &'static Table {
        match self {
            Self::Rays => &RayRows::TABLE,
            Self::Hits => &HitRows::TABLE,
            Self::Steps => &StepRows::TABLE,
            Self::Addresses => &AddressRows::TABLE,
            Self::Samples => &SampleRows::TABLE,
            Self::Nodes => &NodeRows::TABLE,
            Self::Triangles => &TriangleRows::TABLE,
            Self::Lookups => &LookupRows::TABLE,
            Self::Requests => &RequestRows::TABLE,
            Self::Counters => &CounterRows::TABLE,
            Self::Tiles => &TileTimeRows::TABLE,
        }
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        self.table().name
    }

    /// The table of this name.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|what| what.name() == name)
    }

    /// Whether a machine simulates it.
    pub fn is_simulated(self) -> bool {
        matches!(self, Self::Lookups | Self::Requests | Self::Counters | Self::Tiles)
    }

    /// Whether it depends on a machine.
    pub fn takes_machine(self) -> bool {
        self == Self::Addresses || self.is_simulated()
    }

    /// Whether it depends on a policy.
    pub fn takes_policy(self) -> bool {
        self == Self::Samples || self.is_simulated()
    }

    /// Whether it has rows by frame and tile.
    pub fn takes_tiles(self) -> bool {
        matches!(self, Self::Rays | Self::Hits | Self::Steps | Self::Addresses | Self::Samples)
    }

    /// Whether it has rows by frame.
    pub fn takes_frames(self) -> bool {
        self.takes_tiles() || self.is_simulated()
    }

    /// Whether a choice means something for the table. `option` is the name by which it is made: `tiles`, `--tiles`.
    ///
    /// # Errors
    /// [`ColumnsError::Request`] that says why not.
    pub fn check(self, choice: Choice, option: &str) -> Result<()> {
        let name = self.name();
        let detail = match choice {
            Choice::Frames if !self.takes_frames() => {
                format!("table {name} is the same for all frames; leave {option} out")
            }
            Choice::Tiles if !self.takes_tiles() => {
                let why = if self.is_simulated() { "a machine works on whole frames" } else { "it is not of tiles" };
                format!("table {name} takes no {option}: {why}; leave it out")
            }
            Choice::Interval if self != Self::Counters => {
                format!("{option} is for table counters, not for {name}; leave it out")
            }
            _ => return Ok(()),
        };
        Err(ColumnsError::Request(detail))
    }
}
