//! Functional units as places: so many a cycle, taken in the order in which they are asked for.

/// Places of one kind.
#[derive(Clone, Copy, Debug)]
pub struct Places {
    per_cycle: u64,
    /// The first place that nobody has, numbered from cycle 0.
    next: u64,
}

impl Places {
    /// So many a cycle.
    pub fn new(per_cycle: u32) -> Self {
        Self { per_cycle: per_cycle.max(1).into(), next: 0 }
    }

    /// Takes the next `count` places from cycle `from` on; gives the cycle by which all of them are over.
    #[inline]
    pub fn take(&mut self, from: u64, count: u64) -> u64 {
        if count == 0 {
            return from;
        }
        self.next = self.next.max(from * self.per_cycle) + count;
        self.next.div_ceil(self.per_cycle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_taken_in_order_and_none_is_lost() {
        let mut two = Places::new(2);
        assert_eq!(two.take(10, 0), 10);
        assert_eq!(two.take(10, 3), 12, "cycles 10 and 11, of which one place is left");
        assert_eq!(two.take(10, 1), 12, "that place");
        assert_eq!(two.take(10, 4), 14);
        assert_eq!(two.take(20, 1), 21);
    }
}
