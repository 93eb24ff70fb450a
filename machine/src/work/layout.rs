//! The modelled address space: where nodes, triangles, attributes, texels, rays, tiles and pixels lie.
//!
//! Regions are 2^40 bytes apart, so they never overlap and an address names its region. Within a region things lie densely in
//! index order: nodes depth-first, triangles in leaf order, pixels row by row.

use crate::config::MachineConfig;

/// What a memory access is for. Traffic is counted by it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Region {
    /// Inner nodes.
    Node = 0,
    /// Triangles.
    Triangle = 1,
    /// Vertex attributes for shading.
    Attribute = 2,
    /// Texels.
    Texture = 3,
    /// Rays and hits on their way through memory (`gpu.interface = "memory"`).
    Ray = 4,
    /// Sample attributes: external geometry buffer, or what the tile buffer cannot hold.
    Sample = 5,
    /// Sample attributes kept for a neighbouring tile.
    Border = 6,
    /// The G-buffer of a rasteriser.
    GBuffer = 7,
    /// The framebuffer.
    Framebuffer = 8,
    /// Instructions.
    Code = 9,
    /// What is kept of samples for the next frame.
    History = 10,
}

impl Region {
    /// All regions, in counter order.
    pub const ALL: [Self; 11] = [
        Self::Node,
        Self::Triangle,
        Self::Attribute,
        Self::Texture,
        Self::Ray,
        Self::Sample,
        Self::Border,
        Self::GBuffer,
        Self::Framebuffer,
        Self::Code,
        Self::History,
    ];

    /// The byte after the last region.
    pub const END: u64 = (Self::ALL.len() as u64 + 1) << 40;

    /// The name, as reports print it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Node => "node",
            Self::Triangle => "triangle",
            Self::Attribute => "attribute",
            Self::Texture => "texture",
            Self::Ray => "ray",
            Self::Sample => "sample",
            Self::Border => "border",
            Self::GBuffer => "gbuffer",
            Self::Framebuffer => "framebuffer",
            Self::Code => "code",
            Self::History => "history",
        }
    }

    /// First byte of the region.
    pub fn base(self) -> u64 {
        (self as u64 + 1) << 40
    }
}

/// Cache lines first..=last, as line numbers (address / line size).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lines {
    /// First line.
    pub first: u64,
    /// Last line.
    pub last: u64,
}

impl Lines {
    /// How many there are.
    #[inline]
    pub fn count(self) -> u64 {
        self.last - self.first + 1
    }

    /// Shows each line, the first of them first. There is always one, so nothing is asked before it: mostly it is the only one.
    #[inline(always)]
    pub fn each(self, mut see: impl FnMut(u64)) {
        let mut line = self.first;
        loop {
            see(line);
            if line == self.last {
                return;
            }
            line += 1;
        }
    }
}

/// Bytes that lie side by side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Span {
    /// The first.
    pub address: u64,
    /// How many.
    pub bytes: u64,
}

/// Addresses by index.
#[derive(Clone, Copy, Debug)]
pub struct Layout {
    line_shift: u32,
    node_bytes: u64,
    triangle_bytes: u64,
    attribute_bytes: u64,
}

impl Layout {
    /// The layout of a machine.
    pub fn new(config: &MachineConfig) -> Self {
        Self {
            line_shift: config.l2.line_bytes.trailing_zeros(),
            node_bytes: config.layout.node_bytes.into(),
            triangle_bytes: config.layout.triangle_bytes.into(),
            attribute_bytes: config.srp.attribute_bytes.into(),
        }
    }

    /// The lines of a span of bytes; a span of no bytes has one line.
    #[inline]
    pub fn lines(&self, address: u64, bytes: u64) -> Lines {
        Lines { first: address >> self.line_shift, last: (address + bytes.max(1) - 1) >> self.line_shift }
    }

    /// Where inner node `node` lies.
    #[inline]
    pub fn node_at(&self, node: u32) -> Span {
        Span { address: Region::Node.base() + u64::from(node) * self.node_bytes, bytes: self.node_bytes }
    }

    /// Where triangle `triangle` lies.
    #[inline]
    pub fn triangle_at(&self, triangle: u32) -> Span {
        let address = Region::Triangle.base() + u64::from(triangle) * self.triangle_bytes;
        Span { address, bytes: self.triangle_bytes }
    }

    /// The lines of inner node `node`.
    #[inline]
    pub fn node(&self, node: u32) -> Lines {
        let Span { address, bytes } = self.node_at(node);
        self.lines(address, bytes)
    }

    /// The lines of triangle `triangle`.
    #[inline]
    pub fn triangle(&self, triangle: u32) -> Lines {
        let Span { address, bytes } = self.triangle_at(triangle);
        self.lines(address, bytes)
    }

    /// The lines of the vertex attributes of triangle `triangle`.
    #[inline]
    pub fn attribute(&self, triangle: u32) -> Lines {
        self.lines(Region::Attribute.base() + u64::from(triangle) * self.attribute_bytes, self.attribute_bytes)
    }
}
