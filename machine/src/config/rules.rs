//! Rules that several settings share.
//!
//! The limits of a machine are wide: they keep out what cannot be built and what would make the simulator allocate or run without
//! bound, and nothing else. What two settings must hold together stands in `check`.

use rayreel_settings::Rule::{self, Energy, Integer, Size};

/// Clocks, MHz.
pub(super) const CLOCK: Rule = Integer(1, 5000);
/// Depth of a pipeline or latency, cycles.
pub(super) const DEPTH: Rule = Integer(1, 256);
/// Ways of a cache.
pub(super) const WAYS: Rule = Integer(1, 64);
/// First-level caches and local memories.
pub(super) const SMALL: Rule = Size(1 << 10, 1 << 20);
/// Energy of an event; events are counted in 64 bits, which leaves room for any run.
pub(super) const EVENT: Rule = Energy(1_000_000);
/// Leakage of a unit, microwatts.
pub(super) const LEAKAGE: Rule = Integer(0, 10_000_000);
