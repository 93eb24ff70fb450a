//! A pipeline: what enters leaves a fixed number of cycles later, at most one a cycle, and it never stalls inside.

use std::collections::VecDeque;

use crate::machine::memory::Cycle;

/// Items on their way through a pipeline of fixed depth, entered in order of time.
#[derive(Clone, Debug)]
pub struct Pipe<T> {
    depth: Cycle,
    items: VecDeque<(Cycle, T)>,
}

impl<T> Pipe<T> {
    /// A pipeline of `depth` cycles: what enters at cycle t leaves at t + depth.
    pub fn new(depth: u32) -> Self {
        Self { depth: depth.into(), items: VecDeque::new() }
    }

    /// Enters an item at cycle `at`, which may lie ahead.
    #[inline]
    pub fn push(&mut self, at: Cycle, item: T) {
        debug_assert!(self.items.back().is_none_or(|last| last.0 <= at + self.depth), "time ran backwards");
        self.items.push_back((at + self.depth, item));
    }

    /// The next item that has left by cycle `now`.
    #[inline]
    pub fn pop(&mut self, now: Cycle) -> Option<T> {
        if self.items.front()?.0 > now {
            return None;
        }
        self.items.pop_front().map(|(_, item)| item)
    }

    /// When the next item leaves; never, if there is none.
    #[inline]
    pub fn next_event(&self) -> Cycle {
        self.items.front().map_or(Cycle::MAX, |item| item.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_at_depth_and_not_before() {
        let mut pipe = Pipe::new(10);
        pipe.push(5, 'a');
        pipe.push(6, 'b');
        assert_eq!((pipe.next_event(), pipe.pop(14)), (15, None));
        assert_eq!((pipe.pop(15), pipe.pop(15), pipe.pop(16)), (Some('a'), None, Some('b')));
        assert_eq!(pipe.next_event(), Cycle::MAX);
    }
}
