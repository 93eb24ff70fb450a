//! Near-certain events, coded as the gaps between surprises.
//!
//! Most steps of a path are as all neighbours predict. Passing each through the range coder would cost more time than
//! tracing it did. So they are only counted, and each surprise is coded as one number: how many expected events came
//! before it.

use crate::columns::coder::{Decoder, Encoder};
use crate::columns::numbers::Number;

/// One sequence of near-certain events.
pub(super) trait Run {
    /// Codes whether the event was as expected.
    fn as_expected(&mut self, met: bool) -> bool;
}

/// Writes a sequence.
#[derive(Debug, Default)]
pub(super) struct RunEncoder {
    count: u32,
    models: Number,
    coder: Encoder,
}

impl Run for RunEncoder {
    #[inline(always)]
    fn as_expected(&mut self, met: bool) -> bool {
        if met {
            self.count += 1;
        } else {
            self.surprise();
        }
        met
    }
}

impl RunEncoder {
    #[cold]
    fn surprise(&mut self) {
        self.models.code(&mut self.coder, self.count);
        self.count = 0;
    }

    /// Ends the sequence.
    pub fn finish(mut self) -> Vec<u8> {
        self.surprise();
        self.coder.finish()
    }
}

/// Reads a sequence.
#[derive(Debug)]
pub(super) struct RunDecoder<'a> {
    count: u32,
    models: Number,
    coder: Decoder<'a>,
}

impl<'a> RunDecoder<'a> {
    /// Starts on what [`RunEncoder::finish`] gave.
    pub fn new(bytes: &'a [u8]) -> Self {
        let (mut models, mut coder) = (Number::default(), Decoder::new(bytes));
        let count = models.code(&mut coder, 0);
        Self { count, models, coder }
    }

    #[cold]
    fn surprise(&mut self) {
        self.count = self.models.code(&mut self.coder, 0);
    }
}

impl Run for RunDecoder<'_> {
    #[inline(always)]
    fn as_expected(&mut self, _: bool) -> bool {
        if self.count > 0 {
            self.count -= 1;
            return true;
        }
        self.surprise();
        false
    }
}
