//! What reading traces may take of memory, for the whole process.

use std::sync::OnceLock;

use rayreel_formats::budget::Budget;
use rayreel_formats::limits::MEMORY;
use rayreel_formats::{Error, Limits};

/// Parses a number of MiB.
pub fn mebibytes(text: &str) -> Result<u32, String> {
    let mib = text.parse().ok().filter(|mib| *mib > 0);
    mib.ok_or_else(|| "give a whole number of MiB of 1 or more, such as 4096".into())
}

/// MiB, if nothing is asked for.
pub const DEFAULT_MIB: u32 = 1024;

/// The limits of all traces: they share one budget.
static LIMITS: OnceLock<Limits> = OnceLock::new();

/// Whether the command line says it.
static GIVEN: OnceLock<bool> = OnceLock::new();

/// What the command line asks for, or the default; `given` says which.
pub fn set(mib: u32, given: bool) {
    GIVEN.get_or_init(|| given);
    LIMITS.get_or_init(|| Limits { memory: Budget::new(u64::from(mib) << 20).into(), ..Limits::default() });
}

/// The limits to open a trace with.
pub fn limits() -> Limits {
    LIMITS.get_or_init(Limits::default).clone()
}

/// The memory in MiB.
pub fn mib() -> usize {
    (limits().memory.total() >> 20) as usize
}

/// The memory in MiB, if the command line says it.
pub fn given() -> Option<usize> {
    GIVEN.get().is_some_and(|given| *given).then(mib)
}

/// What helps against an error about memory.
pub fn hint(error: &anyhow::Error) -> &'static str {
    let too_little = |cause: &(dyn std::error::Error + 'static)| matches!(cause.downcast_ref(), Some(Error::LimitExceeded { what, .. }) if *what == MEMORY);
    if error.chain().any(too_little) { " (--memory MIB)" } else { "" }
}
