//! The contract of the machine's components: cores, units, memories, and the engines within them.
//!
//! A component has state and counters, and time reaches it from outside only:
//!
//! 1. Its owner hands it what came in (`push`, `fill`, `respond`, `request`, ..), at any cycle.
//! 2. Then its owner calls [`Tick::tick`] once for that cycle. The component does what is due, and hands on what it sends.
//! 3. [`Component::next_event`] names the next cycle at which something happens without anything coming in. The owner may jump
//!    there. It may also tick earlier: ticks at which nothing is due change nothing. A component whose request was refused names
//!    no cycle for that; whoever may take the request next time has the event, and the owner ticks the component then.
//! 4. After the last cycle the owner calls [`Component::finish`], which closes the accounts and gives what was counted.
//!
//! So the machine may be run cycle by cycle or from event to event, and the result is the same. Calls are resolved when
//! compiled. What a tick works with differs from component to component (a memory, a unit, an SRP, ..), hence the parameter
//! of [`Tick`].

use crate::time::{TiCycle, When};

/// A part of the machine with accounts and events, in the T&I clock.
pub trait Component {
    /// What it counted.
    type Report;

    /// The next cycle after `now` at which something happens by itself; [`When::NEVER`] if it waits for others.
    fn next_event(&self, now: TiCycle) -> When;

    /// Closes the accounts of a run that ends before cycle `end`: they then cover cycles 0 to `end - 1`.
    fn finish(&mut self, end: TiCycle) -> Self::Report;
}

/// A component that does something in a cycle, with the help of `W`.
pub trait Tick<W>: Component {
    /// Runs cycle `now`. Time never runs backwards from call to call.
    fn tick(&mut self, now: TiCycle, with: W);
}
