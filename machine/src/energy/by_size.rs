//! Prices that follow the size of a memory.

use super::rounding::nearest;
use crate::config::Picojoules;

/// `price` x `to` / `from`, to the nearest.
pub(super) fn in_proportion(price: Picojoules, to: u64, from: u64) -> Picojoules {
    let femtojoules = nearest(u128::from(price.femtojoules) * u128::from(to), from.into()).try_into();
    Picojoules { femtojoules: femtojoules.unwrap_or(u64::MAX) }
}

/// On straight lines between the points (size, energy) of a table, both of which grow; the first and the last line go on beyond its ends.
pub(super) fn between<T>(table: &[T], size: u64, of: impl Fn(&T) -> (u64, u64)) -> u64 {
    let right = table.iter().position(|point| of(point).0 >= size).unwrap_or(table.len() - 1).max(1);
    let ((x0, y0), (x1, y1)) = (of(&table[right - 1]), of(&table[right]));
    let above = |from: u64| nearest(u128::from(from) * u128::from(y1 - y0), (x1 - x0).into()) as u64;
    if size >= x0 { y0 + above(size - x0) } else { y0.saturating_sub(above(x0 - size)) }
}
