//! The golden traces.

use std::path::Path;

use rayreel_formats::Limits;
use rayreel_formats::trace::Trace;

/// A trace of the folder `traces`.
///
/// # Panics
/// When there is none of that name, or it cannot be read.
pub fn trace(name: &str) -> Trace {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../traces").join(name);
    Trace::open(&file, Limits::default()).unwrap()
}

/// Both.
pub fn traces() -> [Trace; 2] {
    ["v1_0_cornell.rtrace", "v1_0_teapot.rtrace"].map(trace)
}
