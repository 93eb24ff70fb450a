//! The order in which columns are coded: class by class, and within a class row by row, so that a ray's neighbours in
//! the image are its context.

use crate::scene::Rect;
use crate::tile::{RayClass, Tree};

/// The nodes of one class, in sample order.
#[derive(Clone, Debug)]
pub struct ClassRays {
    /// The class.
    pub class: RayClass,
    /// `(sample, node)`, ascending.
    pub rays: Vec<(u32, u32)>,
}

/// The order in which the columns of a tile are coded, with the trees that it is taken from.
#[derive(Debug)]
pub struct CodingOrder<'a> {
    /// The ray trees.
    pub tree: &'a Tree,
    /// The tile's samples.
    pub rect: Rect,
    /// The classes of the trees, ascending.
    pub classes: Vec<ClassRays>,
}

impl<'a> CodingOrder<'a> {
    /// The coding order of a tile.
    pub fn new(tree: &'a Tree, rect: Rect) -> Self {
        Self { tree, rect, classes: classes(tree) }
    }
}

/// All classes of a tree, ascending: a parent's class stands before its children's.
fn classes(tree: &Tree) -> Vec<ClassRays> {
    let mut found: Vec<ClassRays> = Vec::new();
    // Per class its place in `found`, plus one; 0 where it was not found yet.
    let mut place: Vec<u16> = Vec::new();
    for sample in 0..tree.samples() {
        for node in tree.sample(sample) {
            let class = tree.nodes[node].class;
            let slot = class.0 as usize;
            if place.len() <= slot {
                place.resize(slot + 1, 0);
            }
            if place[slot] == 0 {
                found.push(ClassRays { class, rays: Vec::new() });
                place[slot] = found.len() as u16;
            }
            found[place[slot] as usize - 1].rays.push((sample as u32, node as u32));
        }
    }
    found.sort_by_key(|c| c.class);
    found
}

/// The rays of one class laid out over the tile, to find the coded neighbours of a sample.
#[derive(Debug)]
pub struct Raster {
    width: usize,
    /// Per sample, with a border of one to the left, right and above: a value, behind the stamp of the class that set
    /// it. Values of other stamps do not count.
    cells: Vec<(u32, u32)>,
    stamp: u32,
}

/// The values of the coded neighbours, where there are any.
#[derive(Clone, Copy, Debug, Default)]
pub struct Neighbours {
    /// Left.
    pub w: Option<u32>,
    /// Above.
    pub n: Option<u32>,
    /// Above left.
    pub nw: Option<u32>,
    /// Above right.
    pub ne: Option<u32>,
}

impl Raster {
    /// An empty raster over a tile.
    pub fn new(rect: Rect) -> Self {
        let width = rect.width as usize;
        Self { width, cells: vec![(0, 0); (width + 2) * (rect.height as usize + 1)], stamp: 1 }
    }

    /// Forgets everything, for the next class.
    pub fn clear(&mut self) {
        self.stamp += 1;
    }

    #[inline]
    fn cell(&self, sample: u32) -> usize {
        let (x, y) = (sample as usize % self.width, sample as usize / self.width);
        (y + 1) * (self.width + 2) + x + 1
    }

    #[inline]
    fn get(&self, cell: usize) -> Option<u32> {
        let (stamp, value) = self.cells[cell];
        (stamp == self.stamp).then_some(value)
    }

    /// The neighbours of a sample that were set before it.
    #[inline]
    pub fn neighbours(&self, sample: u32) -> Neighbours {
        let cell = self.cell(sample);
        let above = cell - (self.width + 2);
        Neighbours { w: self.get(cell - 1), n: self.get(above), nw: self.get(above - 1), ne: self.get(above + 1) }
    }

    /// Sets the value of a sample.
    #[inline]
    pub fn set(&mut self, sample: u32, value: u32) {
        let cell = self.cell(sample);
        self.cells[cell] = (self.stamp, value);
    }
}
