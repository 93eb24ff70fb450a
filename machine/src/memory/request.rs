//! Requests for lines and their answers.

use rayreel_formats::tile::RayKind;

use crate::work::layout::Region;

/// A port of the memory system: one for each L1 and each engine that reads or writes memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Port(pub u16);

/// How a request travels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Route {
    /// A read through the L2.
    Cached,
    /// A read of DRAM past the L2.
    Read,
    /// A write to DRAM past the L2. Nobody waits for it.
    Write,
}

/// A request for one line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Request {
    /// Who asks.
    pub port: Port,
    /// Line number: address / line size.
    pub line: u64,
    /// What for.
    pub region: Region,
    /// Way.
    pub route: Route,
}

/// A line that arrived.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Response {
    /// Who asked.
    pub port: Port,
    /// Line number.
    pub line: u64,
}

/// What a unit of a T&I unit asks for when an operation of a ray first comes to its input buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Lookup {
    /// The L1 in which it is looked for.
    pub port: Port,
    /// Tile of the frame.
    pub tile: u32,
    /// The ray: its place in the rays of that tile's work.
    pub ray: u32,
    /// What the ray is.
    pub kind: RayKind,
    /// Bounces before it.
    pub depth: u8,
    /// Its sample: column and row of the frame's grid.
    pub sample: (u32, u32),
    /// What for: a node or a triangle.
    pub region: Region,
    /// Which node, or which triangle.
    pub index: u32,
}
