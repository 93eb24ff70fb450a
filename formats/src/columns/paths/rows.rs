//! Which paths the rays around have.

/// A path that was coded: its number in the rings (0: none) and the ray that it was coded for.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Known {
    pub number: u32,
    pub ray: u32,
}

/// The paths of the row in work and of the row above, by column from 1. Rays with equal paths share one entry.
#[derive(Debug, Default)]
pub(super) struct Rows {
    pub above: Vec<Known>,
    pub own: Vec<Known>,
    y: u32,
}

impl Rows {
    /// Starts a stream of a tile of `width` columns.
    pub fn clear(&mut self, width: usize) {
        self.above.clear();
        self.above.resize(width + 2, Known::default());
        self.own.clone_from(&self.above);
        self.y = 0;
    }

    /// Makes row `y` the row in work.
    pub fn go_to(&mut self, y: u32) {
        if y != self.y {
            std::mem::swap(&mut self.own, &mut self.above);
            self.own.fill(Known::default());
            if y != self.y + 1 {
                self.above.fill(Known::default());
            }
            self.y = y;
        }
    }

    /// West, north, north-west, north-east.
    pub fn around(&self, x: usize) -> [Known; 4] {
        [self.own[x - 1], self.above[x], self.above[x - 1], self.above[x + 1]]
    }
}
