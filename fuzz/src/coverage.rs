//! Which code ran, where the build counts it: `fuzz/coverage.sh` has LLVM count each edge in a byte (`sancov-module`, inline 8-bit
//! counters), with the stable toolchain. Elsewhere there are no counters and only messages tell inputs apart.

use std::ops::Range;
use std::sync::Mutex;

/// Where the counters of the parts of this program lie.
static COUNTERS: Mutex<Vec<Range<usize>>> = Mutex::new(Vec::new());

#[expect(unsafe_code, reason = "the instrumented code calls it by this name")]
// SAFETY: nobody else has this name; LLVM reserves it for the one runtime that a program has.
#[unsafe(no_mangle)]
extern "C" fn __sanitizer_cov_8bit_counters_init(start: *mut u8, end: *mut u8) {
    let range = start as usize..end as usize;
    let mut all = COUNTERS.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    if !range.is_empty() && !all.contains(&range) {
        all.push(range);
    }
}

/// What has been seen of each counter: a bit for each power of two.
#[derive(Debug, Default)]
pub struct Seen {
    parts: Vec<Range<usize>>,
    bits: Vec<Vec<u8>>,
    /// A copy of the counters of a part.
    counts: Vec<u8>,
    /// Counters that were ever above 0.
    pub edges: usize,
}

impl Seen {
    /// Nothing so far.
    pub fn new() -> Self {
        let parts = COUNTERS.lock().unwrap_or_else(std::sync::PoisonError::into_inner).clone();
        let bits = parts.iter().map(|part| vec![0; part.len()]).collect();
        Self { parts, bits, counts: Vec::new(), edges: 0 }
    }

    /// How many counters there are.
    pub fn counters(&self) -> usize {
        self.parts.iter().map(Range::len).sum()
    }

    /// Sets all counters to 0.
    pub fn clear(&self) {
        self.parts.iter().for_each(set_to_0);
    }

    /// Takes in what ran since [`Seen::clear`]. Whether anything of it is new.
    pub fn take(&mut self) -> bool {
        let mut new = false;
        for (part, bits) in self.parts.iter().zip(&mut self.bits) {
            copy(part, &mut self.counts);
            for (words, bits) in self.counts.chunks(64).zip(bits.chunks_mut(64)) {
                if words.iter().fold(0, |any, count| any | count) == 0 {
                    continue;
                }
                for (count, seen) in words.iter().zip(bits).filter(|(count, _)| **count > 0) {
                    let bit = 1 << (7 - count.leading_zeros());
                    self.edges += usize::from(*seen == 0);
                    new |= *seen & bit == 0;
                    *seen |= bit;
                }
            }
        }
        new
    }
}

// No reference to the counters is ever made: the instrumented code adds to them behind the compiler's back, this code among it, and another
// thread may do so at the same time. That thread's addition is no atomic one, so strictly it is a race; LLVM's counters are made that way.
// Inputs are read on this thread, and a count that another spoils is only a hint.

/// Copies the counters of a part.
fn copy(part: &Range<usize>, to: &mut Vec<u8>) {
    to.clear();
    to.resize(part.len(), 0);
    #[expect(unsafe_code, reason = "the counters are bytes of the program that no variable of it names")]
    // SAFETY: the instrumented code gave this range as its counters, which live as long as the program; `to` is as long, and lies elsewhere.
    unsafe {
        std::ptr::copy_nonoverlapping(part.start as *const u8, to.as_mut_ptr(), part.len());
    }
}

/// Sets the counters of a part to 0.
fn set_to_0(part: &Range<usize>) {
    #[expect(unsafe_code, reason = "as above")]
    // SAFETY: as above; every byte is a counter, and 0 is a count.
    unsafe {
        std::ptr::write_bytes(part.start as *mut u8, 0, part.len());
    }
}
