//! What the machine as a whole must obey, whatever is inside: closed forms, bounds, invariants. Everything they compare with
//! is computed here, from the work and the configuration alone.

mod bounds;
mod caches;
mod closed_forms;
mod harness;
mod invariants;
mod monotone;
mod neighbours;
mod other_units;
mod single_ray;
mod stepping;
