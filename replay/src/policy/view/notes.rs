//! What a policy did beside tracing, round by round: what it notes, or what is noted for it.

use super::{Closer, RoundCounts, SampleState, TileView};
use crate::image::psnr::SquaredError;
use crate::policy::history::LightChecks;
use crate::policy::reuse::Eye;
use crate::policy::similarity::Compared;

impl TileView {
    /// Notes `tests` similarity tests in round `round` that decide about sample (`x`, `y`) and others.
    pub fn tested(&mut self, at: (u32, u32), round: u8, tests: u32) {
        self.count(at, round, |counts| counts.tests += tests);
    }

    /// Notes tests and differences of colours, as [`TileView::tested`].
    pub(crate) fn compared(&mut self, at: (u32, u32), round: u8, compared: Compared) {
        self.count(at, round, |counts| {
            counts.tests += compared.pairs;
            counts.colours += compared.colours;
        });
    }

    /// Attributes of interpolated hits are made when they are read: from now on.
    pub(crate) fn make_attributes_lazily(&mut self) {
        self.attributes.begin(self.rect);
    }

    /// The first `hits` hits of sample `read` are read by a test of round `round` that decides about sample `at`. What was not made
    /// of them is made.
    pub(crate) fn read_hits(&mut self, at: (u32, u32), round: u8, read: (u32, u32), hits: u32) {
        let i = self.offset(read.0, read.1);
        if matches!(self.states[i], Some((SampleState::Interpolated, _))) {
            let new = self.attributes.read(i, hits);
            self.read_attributes(at, round, new);
        }
    }

    /// The same of an interpolated sample of the row below the tile, in column `x`.
    pub(crate) fn read_hits_below(&mut self, at: (u32, u32), round: u8, x: u32, hits: u32) {
        let new = self.attributes.read_below((x - self.rect.x) as usize, hits);
        self.read_attributes(at, round, new);
    }

    /// Notes `hits` interpolated hits whose attributes tests of round `round` read for the first time.
    pub(crate) fn read_attributes(&mut self, at: (u32, u32), round: u8, hits: u32) {
        self.count(at, round, |counts| counts.attributes += hits);
    }

    /// Notes what was looked for in the history in round `round` for sample (`x`, `y`).
    pub(crate) fn looked_back(&mut self, (x, y): (u32, u32), round: u8, eye: &Eye<'_>) {
        if eye.hits > 0 {
            self.count((x, y), round, |counts| counts.looked_back += eye.hits);
            let closer = self.closer(x, y);
            eye.place.into_iter().for_each(|place| self.rounds.look_up(closer, place));
            self.light_checks.lights += eye.checked.lights;
            self.light_checks.mistaken += eye.checked.mistaken;
        }
    }

    /// Lights that were known and looked for all the same.
    pub(crate) fn light_checks(&self) -> LightChecks {
        self.light_checks
    }

    /// The places of the history that `closer` looks up for it.
    pub(crate) fn looked_up(&self, closer: Closer) -> &[u32] {
        self.rounds.looked_up(closer)
    }

    /// Notes that an interpolated sample was shaded from its attributes.
    pub(crate) fn shaded(&mut self, at: (u32, u32), round: u8) {
        self.count(at, round, |counts| counts.shaded += 1);
    }

    /// Notes `colours` differences of colours that tests of round `round` compute, as [`TileView::tested`].
    pub fn compared_colours(&mut self, at: (u32, u32), round: u8, colours: u32) {
        self.count(at, round, |counts| counts.colours += colours);
    }

    /// Notes what an audit found: the squared error of values that the policy interpolated and then traced.
    pub fn audited(&mut self, error: SquaredError) {
        self.audited = self.audited + error;
    }

    /// Sum of what audits found.
    pub fn audits(&self) -> SquaredError {
        self.audited
    }

    /// Per round what `closer` does beside tracing; rounds that are not there do nothing.
    pub fn rounds(&self, closer: Closer) -> &[RoundCounts] {
        self.rounds.of(closer)
    }
}
