//! What recent paths did at each node: one label a path and node, in a ring over the paths.

/// Cells of a ring, a power of two: two rows of the usual tile. (Wider tiles forget sooner, which costs size, not correctness.)
const RING: usize = 64;
const RING_BITS: u32 = RING.trailing_zeros();

/// Labels of recent paths, for each node (or leaf) that a ray of the tile has met.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// Per key its slot, plus one; 0 where it has none yet.
    slots: Vec<u32>,
    /// Keys that have a slot, to take it back.
    keys: Vec<u32>,
    /// Per slot a ring of cells: the upper bits of the path's number above the label. Cell 0 belongs to no path; it holds the
    /// label that was set last.
    cells: Vec<[u16; RING]>,
}

/// A path's place in the rings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    index: u16,
    stamp: u16,
}

/// The labels around a ray: left, above, above left, above right; 0 where that ray did not meet the node.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
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
pub(super) struct Ring {
    next: u32,
}

impl Ring {
    /// Starts at path 1.
    pub fn new() -> Self {
        Self { next: 1 }
    }

    /// The number of the next path; 0 when numbers have run out and all labels must be forgotten first.
    pub fn number(&mut self) -> u32 {
        if self.next >> RING_BITS > 0xff {
            self.next = 1;
            return 0;
        }
        let number = self.next;
        self.next += 1;
        // Cell 0 is not for paths.
        if (self.next as usize).is_multiple_of(RING) {
            self.next += 1;
        }
        number
    }

    /// Where a path's labels are; of path 0 there are none.
    #[inline(always)]
    pub fn cell(&self, number: u32) -> Cell {
        // Cell 1 with a stamp that no path has is as good as nothing for path 0.
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
    /// Starts a tile with `keys` nodes.
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

    /// The slot of a key.
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
    pub fn around(&self, slot: usize, paths: &[Cell; 4]) -> Around {
        let ring = &self.cells[slot];
        let of = |path: &Cell| {
            let cell = ring[usize::from(path.index) % RING];
            if cell >> 8 == path.stamp { cell as u8 } else { 0 }
        };
        Around { w: of(&paths[0]), n: of(&paths[1]), nw: of(&paths[2]), ne: of(&paths[3]) }
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
