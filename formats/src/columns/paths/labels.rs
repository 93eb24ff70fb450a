//! What recent paths did at each node: one label a path and node. Each node keeps the labels of the last paths only, in
//! a ring of cells.

/// Cells of a ring, a power of two: two rows of a tile of 32 samples. In wider tiles a label is gone before the row
/// below asks for it; that costs size, not correctness.
const RING: usize = 64;
const RING_BITS: u32 = RING.trailing_zeros();

/// The cells of a node. A cell holds a label in its low byte and the stamp of its path in the high one. Cell 0 belongs
/// to no path; it holds the label that was set last. It begins with a line of the cache, so that it has two and not
/// three.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(super) struct Ring([u16; RING]);

const NO_LABELS: Ring = Ring([0; RING]);

/// Labels of recent paths, for each node (or leaf) that a ray of the tile has met, by slot.
#[derive(Debug, Default)]
pub(super) struct Labels {
    rings: Vec<Ring>,
}

/// Where a path's labels are: the cell, in every ring, and the stamp (in its high byte) that tells the path from others of
/// the same cell.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Cell {
    index: u16,
    stamp: u16,
}

/// The labels around a ray, a byte each, lowest first: left, above, above left, above right; 0 where that ray did not meet
/// the node.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct NeighbourLabels(u32);

impl NeighbourLabels {
    /// Left, above, above left, above right.
    #[inline(always)]
    pub fn list(self) -> [u8; 4] {
        self.0.to_le_bytes()
    }

    /// The neighbours' outcomes (the lower 3 bits of their labels) in one number, left lowest.
    #[inline(always)]
    pub fn outcomes(self) -> usize {
        let each = self.0 & 0x0707_0707;
        let pairs = each | each >> 5;
        ((pairs & 0o77) | (pairs >> 10 & 0o7700)) as usize
    }

    /// The neighbours' pops (the next 2 bits) in one number, left lowest.
    #[inline(always)]
    pub fn pops(self) -> usize {
        let each = self.0 >> 3 & 0x0303_0303;
        let pairs = each | each >> 6;
        ((pairs & 0xf) | (pairs >> 12 & 0xf0)) as usize
    }
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
            // Cell 0 has stamp 0.
            return Cell { index: 0, stamp: 0xff00 };
        }
        Cell { index: (number as usize % RING) as u16, stamp: (number >> RING_BITS) as u16 * 256 }
    }

    /// True while a path's labels will last another row at least.
    #[inline(always)]
    pub fn is_fresh(&self, number: u32) -> bool {
        number != 0 && self.next - number < RING as u32 / 2
    }
}

impl Labels {
    /// Starts a tile: nothing is met but what slot 0 stands for.
    pub fn start(&mut self) {
        self.rings.clear();
        self.rings.push(NO_LABELS);
    }

    /// The slot of one more node (or leaf).
    pub fn meet(&mut self) -> u32 {
        self.rings.push(NO_LABELS);
        self.rings.len() as u32 - 1
    }

    /// Forgets every label.
    pub fn forget(&mut self) {
        self.rings.fill(NO_LABELS);
    }

    /// The labels at a node.
    #[inline(always)]
    pub fn ring(&mut self, slot: u32) -> &mut Ring {
        &mut self.rings[slot as usize]
    }
}

impl Ring {
    /// The labels of four paths (west, north, north-west, north-east).
    #[inline(always)]
    pub fn around(&self, paths: &[Cell; 4]) -> NeighbourLabels {
        let of = |path: &Cell| {
            // The stamps cancel out if they are the same.
            let label = self.0[usize::from(path.index) % RING] ^ path.stamp;
            if label < 256 { u32::from(label) } else { 0 }
        };
        let [w, n, nw, ne] = [of(&paths[0]), of(&paths[1]), of(&paths[2]), of(&paths[3])];
        NeighbourLabels(w | n << 8 | nw << 16 | ne << 24)
    }

    /// The label that was set last, by whatever path.
    #[inline(always)]
    pub fn last(&self) -> u8 {
        self.0[0] as u8
    }

    /// Sets the label of a path.
    #[inline(always)]
    pub fn set(&mut self, path: Cell, label: u8) {
        self.0[usize::from(path.index) % RING] = path.stamp | u16::from(label);
        self.0[0] = u16::from(label);
    }

    /// Adds bits to the label of a path.
    #[inline(always)]
    pub fn add(&mut self, path: Cell, bits: u8) {
        self.0[usize::from(path.index) % RING] |= u16::from(bits);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contexts_by_hand() {
        // Outcomes 5, 1, 0, 3 and pops 0, 2, 1, 1.
        let around = NeighbourLabels(u32::from_le_bytes([5, 1 | 2 << 3, 1 << 3, 3 | 1 << 3]));
        assert_eq!(around.outcomes(), 0o3015);
        assert_eq!(around.pops(), 0b01_01_10_00);
        assert_eq!(around.list(), [5, 17, 8, 11]);
    }

    #[test]
    fn a_label_is_that_of_its_path_until_another_takes_the_cell() {
        let (mut labels, mut numbers) = (Labels::default(), PathNumbers::new());
        labels.start();
        let taken: Vec<u32> = (0..200).map(|_| numbers.number()).collect();
        let cells: Vec<Cell> = taken.iter().map(|&number| numbers.cell(number)).collect();
        let none = numbers.cell(0);
        for (i, &cell) in cells.iter().enumerate() {
            labels.ring(0).set(cell, 1 + (i % 5) as u8);
            let far = cells[i.saturating_sub(RING - 1)];
            let found = labels.ring(0).around(&[cell, none, cells[i / 2], far]).list();
            let kept = |at: usize| if i - at < RING - 1 { 1 + (at % 5) as u8 } else { 0 };
            assert_eq!(found, [kept(i), 0, kept(i / 2), kept(i.saturating_sub(RING - 1))], "path {i}");
        }
    }
}
