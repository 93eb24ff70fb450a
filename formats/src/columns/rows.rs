//! What the rays of the row that is being coded did, and those of the row above it: the context of the next ray. Two rows
//! are all that a ray looks at, so they stay near the processor however wide the tile is tall.

use crate::scene::Rect;

/// Values of the samples of two rows.
#[derive(Debug, Default)]
pub struct Rows<T> {
    width: u32,
    /// First sample of the current row.
    start: u32,
    /// Per column, with a border of one to the left and right.
    above: Vec<T>,
    current: Vec<T>,
}

/// The values around a sample, those of them that were coded before it; the default value stands for none.
#[derive(Clone, Copy, Debug)]
pub struct Around<T> {
    /// Left.
    pub w: T,
    /// Above.
    pub n: T,
    /// Above left.
    pub nw: T,
    /// Above right.
    pub ne: T,
}

impl<T: Copy + Default> Rows<T> {
    /// The rows of a tile; nothing is known.
    pub fn new(rect: Rect) -> Self {
        let mut rows = Self { width: 0, start: 0, above: Vec::new(), current: Vec::new() };
        rows.restart(rect);
        rows
    }

    /// Forgets everything, and goes to the top of a tile.
    pub fn restart(&mut self, rect: Rect) {
        (self.width, self.start) = (rect.width, 0);
        for row in [&mut self.above, &mut self.current] {
            row.clear();
            row.resize(rect.width as usize + 2, T::default());
        }
    }

    /// Forgets everything, and stays.
    pub fn forget(&mut self) {
        self.above.fill(T::default());
        self.current.fill(T::default());
    }

    /// Goes to a sample behind the last one, and gives its column, from 1.
    #[inline(always)]
    pub fn go_to(&mut self, sample: u32) -> usize {
        while sample - self.start >= self.width {
            self.next_row();
        }
        (sample - self.start) as usize + 1
    }

    fn next_row(&mut self) {
        self.start += self.width;
        std::mem::swap(&mut self.current, &mut self.above);
        self.current.fill(T::default());
    }

    /// What is around column `x` of the current row.
    #[inline(always)]
    pub fn around(&self, x: usize) -> Around<T> {
        let [nw, n, ne] = self.above[x - 1..][..3] else { unreachable!("a slice of three") };
        Around { w: self.current[x - 1], n, nw, ne }
    }

    /// Sets the value of column `x` of the current row.
    #[inline(always)]
    pub fn set(&mut self, x: usize, value: T) {
        self.current[x] = value;
    }
}

impl<T> Around<T> {
    /// West, north, north-west, north-east.
    #[inline(always)]
    pub fn list(self) -> [T; 4] {
        [self.w, self.n, self.nw, self.ne]
    }
}
