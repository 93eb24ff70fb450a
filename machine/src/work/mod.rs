//! What a policy hands to the machine: for each tile the rays that it traces, round by round, and what is done instead of the
//! others.
//!
//! A round is what the SRP can decide at one moment: first the R-samples, then the samples that the X step tests (those that
//! pass are interpolated, those that fail are traced), then those of the Y step, and so on. Rays that hang on a hit (shadow
//! and secondary rays) are spawned by the machine when that hit comes back.

pub mod check;
pub mod history;
pub mod layout;
pub mod ops;
pub mod recorded;
pub mod synthetic;
pub mod topology;

use rayreel_formats::scene::Rect;
use rayreel_formats::tile::RayKind;

use self::history::HistoryWork;
use self::ops::Op;

/// No ray.
pub const NO_RAY: u32 = u32::MAX;
/// No triangle: the ray left the scene.
pub const NO_TRIANGLE: u32 = u32::MAX;

/// One ray of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RayWork {
    /// Where its operations begin in [`TileWork::ops`].
    pub ops_start: u32,
    /// Number of its operations.
    pub ops_len: u32,
    /// What it is.
    pub kind: RayKind,
    /// Number of shadow rays of its hit; they are the rays that follow it directly.
    pub shadows: u8,
    /// The hit triangle; [`NO_TRIANGLE`] for a miss and for shadow rays.
    pub triangle: u32,
    /// Material of the hit triangle: the branch that shading takes.
    pub material: u32,
    /// The reflection ray of its hit; [`NO_RAY`] if there is none.
    pub reflect: u32,
    /// The refraction ray of its hit; [`NO_RAY`] if there is none.
    pub refract: u32,
    /// Sample in the frame's grid: column.
    pub x: u32,
    /// Sample in the frame's grid: row.
    pub y: u32,
    /// Bounces before this ray.
    pub depth: u8,
    /// Lights that shine on its hit or do not, as is known without shadow rays: they are shaded, and no ray is sent.
    pub known_lights: u8,
}

/// One round of a tile.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Round {
    /// Similarity tests (pairs of hits) made before anything of this round is traced or interpolated.
    pub tests: u32,
    /// Differences of colours that these tests compute.
    pub colours: u32,
    /// Hits and whole subtrees interpolated; one for a sample of which nothing is traced.
    pub interpolated: u32,
    /// Interpolated hits of which later tests read the attributes.
    pub attributes: u32,
    /// Interpolated samples that are shaded from their attributes.
    pub shaded: u32,
    /// Hits whose lights were looked for in the history.
    pub looked_back: u32,
    /// The rays that the SRP starts, as indices into [`TileWork::rays`], row by row: primary rays, and rays of any kind that
    /// leave an interpolated hit. All others are spawned by a hit that comes back.
    pub starts: Vec<u32>,
}

/// What a policy reads of hits beside their colour, and what it decides: the work of the SRP's kernels depends on it, and what a
/// sample takes in the tile buffer.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct PolicyReads {
    /// Objects are tested.
    pub object: bool,
    /// Normals are tested.
    pub normal: bool,
    /// Shadow bits are tested.
    pub shadow: bool,
    /// Distances of hit points are tested.
    pub position: bool,
    /// Distances from tangent planes are tested.
    pub plane: bool,
    /// Local colours of hits are read.
    pub local: bool,
    /// Weights of reflection and refraction are read: hits are interpolated one by one.
    pub weights: bool,
    /// Each tile has a rate or a limit of its own, which the SRP computes.
    pub control: bool,
    /// Samples are kept for the next frame, and looked for in it.
    pub history: bool,
}

impl PolicyReads {
    /// What the paper's tests read: object, normal, shadow bits.
    pub const PAPER: Self = Self {
        object: true,
        normal: true,
        shadow: true,
        position: false,
        plane: false,
        local: false,
        weights: false,
        control: false,
        history: false,
    };

    /// Whether lengths of rays are read: distances are relative to them.
    pub fn distance(&self) -> bool {
        self.position || self.plane || self.history
    }
}

/// A tile of the same frame that has to come first.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbour {
    /// Its number in the frame.
    pub tile: u32,
    /// So many of its rounds must be done.
    pub rounds: u32,
    /// Before this round of the tile that waits.
    pub before: u32,
}

/// The work of one tile.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct TileWork {
    /// Frame number.
    pub frame: u32,
    /// Tile number in the frame.
    pub tile: u32,
    /// Its samples in the frame's grid.
    pub rect: Rect,
    /// The tile to the left, if this one closes its last columns.
    pub left: Option<Neighbour>,
    /// The tile above, if this one closes its last rows, or those of the tile to the left of that.
    pub above: Option<Neighbour>,
    /// Samples of neighbouring tiles that are traced again.
    pub apron_samples: u32,
    /// Samples at the borders of the tiles to the left and above whose attributes it reads.
    pub border_samples: u32,
    /// Samples at its borders whose attributes are kept for the tiles to the right and below.
    pub kept_samples: u32,
    /// Samples that it audits: each is compared with what was interpolated.
    pub audited_samples: u32,
    /// Secondary hits that its similarity tests look at, kept beside the samples.
    pub secondary_hits: u32,
    /// What it reads of the history of the frame before, and keeps for the next.
    pub history: HistoryWork,
    /// The traced rays: each sample's in ray order (closest-hit ray, its shadow rays, then its children's subtrees).
    pub rays: Vec<RayWork>,
    /// The operations of all rays: every ray's are a valid path through the tree. Rays of one path may share them.
    pub ops: Vec<Op>,
    /// The rounds, in order.
    pub rounds: Vec<Round>,
}

/// The size of work: node visits, one and a half for each triangle test, which takes longer, and four for each ray, whatever it
/// meets.
pub(crate) fn cost(visits: u64, tests: u64, rays: u64) -> f64 {
    visits as f64 + 1.5 * tests as f64 + 4.0 * rays as f64
}

impl TileWork {
    /// A tile without rays and rounds, that waits for no other.
    pub fn empty(frame: u32, tile: u32, rect: Rect) -> Self {
        Self {
            frame,
            tile,
            rect,
            left: None,
            above: None,
            apron_samples: 0,
            border_samples: 0,
            kept_samples: 0,
            audited_samples: 0,
            secondary_hits: 0,
            history: HistoryWork::default(),
            rays: Vec::new(),
            ops: Vec::new(),
            rounds: Vec::new(),
        }
    }

    /// What has to come before round `round`.
    pub fn neighbours_before(&self, round: usize) -> impl Iterator<Item = Neighbour> {
        let all = [self.left, self.above].into_iter().flatten();
        all.filter(move |neighbour| neighbour.before as usize == round)
    }

    /// Number of operations that its rays do, whether they share them or not.
    pub fn operations(&self) -> u64 {
        self.rays.iter().map(|ray| u64::from(ray.ops_len)).sum()
    }

    /// The operations of ray `ray`.
    #[inline]
    pub fn path(&self, ray: u32) -> &[Op] {
        let RayWork { ops_start, ops_len, .. } = self.rays[ray as usize];
        &self.ops[ops_start as usize..][..ops_len as usize]
    }
}
