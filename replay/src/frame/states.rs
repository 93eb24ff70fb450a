//! What became of each sample of a frame.

use crate::policy::view::SampleState;

/// State and wave of every sample of a frame, row by row.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StateMap {
    /// Columns of samples.
    pub width: u32,
    /// Rows of samples.
    pub height: u32,
    states: Vec<SampleState>,
    waves: Vec<u8>,
}

impl StateMap {
    /// A map in which every sample is an R-sample.
    pub fn new((width, height): (u32, u32)) -> Self {
        let len = width as usize * height as usize;
        Self { width, height, states: vec![SampleState::Reference; len], waves: vec![0; len] }
    }

    /// The state of sample (`x`, `y`).
    ///
    /// # Panics
    /// When the sample is outside the frame.
    pub fn state(&self, x: u32, y: u32) -> SampleState {
        self.states[self.offset(x, y)]
    }

    /// The wave in which a sample was traced or interpolated: 0 for R-samples, then the tests of the X step, then those of
    /// the Y step, one wave a level of refinement.
    ///
    /// # Panics
    /// When the sample is outside the frame.
    pub fn wave(&self, x: u32, y: u32) -> u8 {
        self.waves[self.offset(x, y)]
    }

    pub(super) fn set(&mut self, x: u32, y: u32, (state, wave): (SampleState, u8)) {
        let i = self.offset(x, y);
        self.states[i] = state;
        self.waves[i] = wave;
    }

    fn offset(&self, x: u32, y: u32) -> usize {
        assert!(x < self.width && y < self.height, "sample ({x}, {y}) is outside the frame");
        y as usize * self.width as usize + x as usize
    }
}
