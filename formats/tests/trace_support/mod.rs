//! Made-up scenes, tiles and traces: legal, but with nothing in them that follows from anything else.

#![allow(dead_code, reason = "each test binary uses its own part of this")]

pub mod forge;
pub mod soup;
pub mod tiles;
pub mod whole;

pub use rayreel_testkit::Random;
