//! The paths of a tile as operations, straight from the decoder: it walks the tree anyway, so what it finds is known to lead
//! through it and need not be walked again.

use rayreel_formats::bvh::Child;
use rayreel_formats::tile::step;
use rayreel_formats::trace::{LeafTests, PathSink, SharedPaths};

use super::NO_TRIANGLE;
use super::check::PathCounts;
use super::ops::Op;

/// The paths of a tile. Rays may share one.
#[derive(Clone, Debug, Default)]
pub struct TilePaths {
    /// Per ray, in ray order, which of the paths it has.
    rays: Vec<u32>,
    paths: Vec<RecordedPath>,
    ops: Vec<Op>,
}

/// A path of a tile.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RecordedPath {
    /// Where its operations begin in the tile's.
    start: usize,
    /// Number of its operations.
    len: u32,
    /// Number of its steps.
    pub steps: u32,
    /// The last triangle that was hit; [`NO_TRIANGLE`] if there is none.
    pub hit: u32,
    /// What it asks for.
    pub counts: PathCounts,
}

impl TilePaths {
    /// Which path ray `ray` has, below [`TilePaths::paths`]; `None` if there is no such ray.
    #[inline]
    pub fn of_ray(&self, ray: u32) -> Option<u32> {
        self.rays.get(ray as usize).copied()
    }

    /// Number of rays.
    pub fn rays(&self) -> usize {
        self.rays.len()
    }

    /// Bytes that they take in memory.
    pub fn bytes(&self) -> usize {
        let Self { rays, paths, ops } = self;
        let lists = [
            rays.capacity() * size_of::<u32>(),
            paths.capacity() * size_of::<RecordedPath>(),
            ops.capacity() * size_of::<Op>(),
        ];
        size_of::<Self>() + lists.iter().sum::<usize>()
    }

    /// Number of paths.
    pub fn paths(&self) -> usize {
        self.paths.len()
    }

    /// A path and its operations.
    ///
    /// # Panics
    /// When there is none of this number.
    #[inline]
    pub fn path(&self, path: u32) -> (&RecordedPath, &[Op]) {
        let recorded = &self.paths[path as usize];
        (recorded, &self.ops[recorded.start..][..recorded.len as usize])
    }
}

/// Gathers the paths of a tile from a decoder.
#[derive(Debug)]
pub struct PathRecorder {
    paths: Vec<RecordedPath>,
    ops: Vec<Op>,
    /// Where the path under way begins, and what is known of it.
    start: usize,
    hit: u32,
    hits: u64,
}

impl Default for PathRecorder {
    fn default() -> Self {
        Self { paths: Vec::new(), ops: Vec::new(), start: 0, hit: NO_TRIANGLE, hits: 0 }
    }
}

impl PathRecorder {
    /// All paths, and which ray has which.
    ///
    /// # Panics
    /// When these are not the paths of the rays.
    pub fn finish(self, shared: SharedPaths) -> TilePaths {
        assert_eq!(shared.steps.len(), self.paths.len(), "the decoder tells of each path once");
        TilePaths { rays: shared.rays, paths: self.paths, ops: self.ops }
    }
}

impl PathSink for PathRecorder {
    #[inline(always)]
    fn visit(&mut self, node: u32, outcome: u8) {
        self.ops.push(Op::visit(node, outcome >= step::LEFT_FIRST));
    }

    #[inline(always)]
    fn leaf(&mut self, leaf: Child, tests: LeafTests) {
        let first = leaf.first() as u32;
        self.ops.push(Op::leaf(first, tests.count()));
        if let Some(last) = tests.last_hit() {
            self.hit = first + last;
            self.hits += u64::from(tests.hits());
        }
    }

    #[inline(always)]
    fn pop(&mut self, node: u32, visited: bool) {
        self.ops.push(Op::pop(node, !visited));
    }

    fn end(&mut self, empty: bool, steps: u32) {
        if empty {
            self.ops.push(Op::END);
        }
        let ops = &self.ops[self.start..];
        let counts = PathCounts { hits: self.hits, ..PathCounts::of_ops(ops) };
        self.paths.push(RecordedPath { start: self.start, len: ops.len() as u32, steps, hit: self.hit, counts });
        (self.start, self.hit, self.hits) = (self.ops.len(), NO_TRIANGLE, 0);
    }
}
