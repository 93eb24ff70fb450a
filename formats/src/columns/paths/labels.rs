//! What recent paths did at each node: one label a path and node. Each node keeps the labels of the last paths only, in
//! a ring of cells.

/// Cells of a ring, a power of two: two rows of a tile of 32 samples. In wider tiles a label is gone before the row
/// below asks for it; that costs size, not correctness.
const RING: usize = 64;
const RING_BITS: u32 = RING.trailing_zeros();

/// Labels of recent paths, for each node (or leaf) that a ray of the tile has met.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// Per node (or leaf), its key, its slot plus one; 0 where it has none yet.
    slots: Vec<u32>,
    /// Keys that have a slot, to take it back.
    keys: Vec<u32>,
    /// Per slot a ring of cells. A cell holds a label in its low byte and the stamp of its path in the high one. Cell 0
    /// belongs to no path; it holds the label that was set last.
    cells: Vec<[u16; RING]>,
}

/// Where a path's labels are: the cell, in every ring, and the stamp that tells the path from others of the same cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    index: u16,
    stamp: u16,
}

/// The labels around a ray: left, above, above left, above right; 0 where that ray did not meet the node.
#[derive(Clone, Copy, Debug)]
pub(super) struct NeighbourLabels {
    /// Left.
    pub w: u8,
    /// Above.
    pub n: u8,
    /// Above left.
    pub nw: u8,
    /// Above right.
    pub ne: u8,
}

/// Numbers paths and knows how long their labels last.
#[derive(Clone, Copy, Debug)]
pub(super) struct PathNumbers {
    next: u32,
}

impl PathNumbers {
    /// Starts at path 1.
    pub fn new() -> Self {
        Self { next: 1 }
    }

    /// The number of the next path. 0 means that the numbers have run out: all labels must be forgotten, then they
    /// start anew.
    pub fn number(&mut self) -> u32 {
        if self.next >> RING_BITS > 0xff {
            self.next = 1;
            return 0;
        }
        let number = self.next;
        self.next += 1;
        // Skips the numbers whose cell would be 0.
        if (self.next as usize).is_multiple_of(RING) {
            self.next += 1;
        }
        number
    }

    /// Where a path's labels are. Number 0 stands for no path: no cell has its stamp.
    #[inline(always)]
    pub fn cell(&self, number: u32) -> Cell {
        if number == 0 {
            return Cell { index: 1, stamp: 0xffff };
        }
        Cell { index: (number as usize % RING) as u16, stamp: (number >> RING_BITS) as u16 }
    }

    /// True while a path's labels will last another row at least.
    #[inline(always)]
    pub fn is_fresh(&self, number: u32) -> bool {
        number != 0 && self.next - number < RING as u32 / 2
    }
}

impl Labels {
    /// Starts a tile of a tree with `keys` nodes (or leaves).
    pub fn start(&mut self, keys: usize) {
        for &key in &self.keys {
            self.slots[key as usize] = 0;
        }
        self.slots.resize(keys, 0);
        self.keys.clear();
        self.cells.clear();
    }

    /// Forgets every label.
    pub fn forget(&mut self) {
        self.cells.fill([0; RING]);
    }

    /// The slot of a node (or leaf), which gets one when it is first met.
    #[inline(always)]
    pub fn slot(&mut self, key: usize) -> usize {
        let slot = self.slots[key];
        if slot != 0 { slot as usize - 1 } else { self.new_slot(key) }
    }

    #[cold]
    fn new_slot(&mut self, key: usize) -> usize {
        self.keys.push(key as u32);
        self.slots[key] = self.keys.len() as u32;
        self.cells.push([0; RING]);
        self.keys.len() - 1
    }

    /// The labels of four paths (west, north, north-west, north-east) at a node.
    #[inline(always)]
    pub fn around(&self, slot: usize, paths: &[Cell; 4]) -> NeighbourLabels {
        let ring = &self.cells[slot];
        let of = |path: &Cell| {
            let cell = ring[usize::from(path.index) % RING];
            if cell >> 8 == path.stamp { cell as u8 } else { 0 }
        };
        NeighbourLabels { w: of(&paths[0]), n: of(&paths[1]), nw: of(&paths[2]), ne: of(&paths[3]) }
    }

    /// The label that was set last at a node, by whatever path.
    #[inline(always)]
    pub fn last(&self, slot: usize) -> u8 {
        self.cells[slot][0] as u8
    }

    /// Sets the label of a path.
    #[inline(always)]
    pub fn set(&mut self, slot: usize, path: Cell, label: u8) {
        let ring = &mut self.cells[slot];
        ring[usize::from(path.index) % RING] = (path.stamp << 8) | u16::from(label);
        ring[0] = u16::from(label);
    }

    /// Adds bits to the label of a path.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, path: Cell, bits: u8) {
        self.cells[slot][usize::from(path.index) % RING] |= u16::from(bits);
    }
}
