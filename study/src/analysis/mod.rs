//! What a table of results says: which points no other beats, which axis moves which result, which points are best and how they are
//! configured. For the page of `rayreel report` and for `rayreel compare`.

pub mod best;
pub mod configs;
pub mod dims;
pub mod effects;
pub mod goals;
pub mod load;
pub mod means;
pub mod order;
pub mod pareto;
pub mod systems;

#[cfg(test)]
pub mod tables;
