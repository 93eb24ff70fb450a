//! The column codec: each column of a tile as one range-coded stream.

pub mod classes;
pub mod coder;
pub mod hits;
pub mod numbers;
pub mod paths;
pub mod radiance;
pub mod rows;
pub mod tree;
