//! The paths of the rays to the left and above.

/// A path that was coded.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct CodedPath {
    /// Its number, under which its labels are kept; 0 for no path.
    pub number: u32,
    /// The ray that it was coded for.
    pub ray: u32,
}

/// The paths of the current row and of the row above, by column from 1. A ray that has a neighbour's path shares its
/// entry.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub above: Vec<CodedPath>,
    pub current: Vec<CodedPath>,
    y: u32,
}

impl Rows {
    /// Starts a stream of a tile of `width` columns.
    pub fn clear(&mut self, width: usize) {
        self.above.clear();
        self.above.resize(width + 2, CodedPath::default());
        self.current.clone_from(&self.above);
        self.y = 0;
    }

    /// Makes row `y` the current one.
    pub fn go_to(&mut self, y: u32) {
        if y != self.y {
            std::mem::swap(&mut self.current, &mut self.above);
            self.current.fill(CodedPath::default());
            if y != self.y + 1 {
                self.above.fill(CodedPath::default());
            }
            self.y = y;
        }
    }

    /// The paths to the left, above, above left and above right.
    pub fn neighbours(&self, x: usize) -> [CodedPath; 4] {
        [self.current[x - 1], self.above[x], self.above[x - 1], self.above[x + 1]]
    }
}
