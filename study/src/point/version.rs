//! The version of everything between a trace and a result.

/// Grows by one whenever the same trace, machine and policy may give other figures than before: then old rows of a sweep are
/// not mixed with new ones. It is not the version of the program: most of those change no result, and a new one must not throw
/// a week of a cluster away. A test holds it against the golden results.
pub const MODEL_VERSION: u32 = 9;

/// The same for results of which not every cycle was simulated: it grows with every change of windows or estimates, and the
/// others stay valid.
pub const ESTIMATE_VERSION: u32 = 16;
