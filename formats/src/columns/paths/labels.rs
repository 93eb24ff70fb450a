//! What recent paths did at each node: one label a path and node, in a ring over the paths.

/// Most labels kept a node. A ring holds at least two rows of the tile.
const RING_BITS_MAX: u32 = 12;

/// Labels of recent paths, for each node (or leaf) that a ray of the tile has met.
#[derive(Debug, Default)]
pub(super) struct Labels {
    /// Per key its slot, plus one; 0 where it has none yet.
    slots: Vec<u32>,
    /// Keys that have a slot, to take it back.
    keys: Vec<u32>,
    /// Per slot a ring of cells: the upper bits of the path's number above the label. Cell 0 belongs to no path; it holds the
    /// label that was set last.
    cells: Vec<u16>,
    ring_bits: u32,
}

/// A path's place in the rings.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    index: u32,
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
    bits: u32,
    next: u32,
}

impl Ring {
    /// A ring for a tile of `width` columns.
    pub fn new(width: usize) -> Self {
        let bits = (2 * width).next_power_of_two().trailing_zeros().clamp(3, RING_BITS_MAX);
        Self { bits, next: 1 }
    }

    /// The number of the next path; 0 when numbers have run out and all labels must be forgotten first.
    pub fn number(&mut self) -> u32 {
        if self.next >> self.bits > 0xff {
            self.next = 1;
            return 0;
        }
        let number = self.next;
        self.next += 1;
        // Cell 0 is not for paths.
        if self.next & ((1 << self.bits) - 1) == 0 {
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
        Cell { index: number & ((1 << self.bits) - 1), stamp: (number >> self.bits) as u16 }
    }

    /// True while a path's labels will last another row at least.
    #[inline(always)]
    pub fn is_fresh(&self, number: u32) -> bool {
        number != 0 && self.next - number < 1 << (self.bits - 1)
    }
}

impl Labels {
    /// Starts a tile with `keys` nodes.
    pub fn start(&mut self, keys: usize, ring: &Ring) {
        for &key in &self.keys {
            self.slots[key as usize] = 0;
        }
        self.slots.resize(keys, 0);
        self.keys.clear();
        self.cells.clear();
        self.ring_bits = ring.bits;
    }

    /// Forgets every label.
    pub fn forget(&mut self) {
        self.cells.fill(0);
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
        self.cells.resize(self.cells.len() + (1 << self.ring_bits), 0);
        self.keys.len() - 1
    }

    /// The labels of four paths (west, north, north-west, north-east) at a node.
    #[inline(always)]
    pub fn around(&self, slot: usize, paths: &[Cell; 4]) -> Around {
        let ring = &self.cells[slot << self.ring_bits..(slot + 1) << self.ring_bits];
        let of = |path: &Cell| {
            let cell = ring[path.index as usize];
            if cell >> 8 == path.stamp { cell as u8 } else { 0 }
        };
        Around { w: of(&paths[0]), n: of(&paths[1]), nw: of(&paths[2]), ne: of(&paths[3]) }
    }

    /// The label that was set last at a node, by whatever path.
    #[inline(always)]
    pub fn last(&self, slot: usize) -> u8 {
        self.cells[slot << self.ring_bits] as u8
    }

    /// Sets the label of a path.
    #[inline(always)]
    pub fn set(&mut self, slot: usize, path: Cell, label: u8) {
        let ring = &mut self.cells[slot << self.ring_bits..(slot + 1) << self.ring_bits];
        ring[path.index as usize] = path.stamp << 8 | u16::from(label);
        ring[0] = u16::from(label);
    }

    /// Adds bits to the label of a path.
    #[inline(always)]
    pub fn add(&mut self, slot: usize, path: Cell, bits: u8) {
        self.cells[(slot << self.ring_bits) + path.index as usize] |= u16::from(bits);
    }
}
