//! Counters that say what they are: every group is declared beside the code that counts, with name, unit and meaning.

/// One counter with its value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Counter {
    /// Name within its group.
    pub name: &'static str,
    /// Unit: `cycles`, `events`, `bytes`, `rays`, ...
    pub unit: &'static str,
    /// Meaning.
    pub description: &'static str,
    /// Value.
    pub value: u64,
}

/// Declares a struct of `u64` counters that can be added and listed. A counter is listed under the name of its field, or under
/// another one: `field as "name": "unit", "meaning";`.
macro_rules! counters {
    (@name $field:ident) => { stringify!($field) };
    (@name $field:ident $listed:literal) => { $listed };
    ($(#[$doc:meta])* $vis:vis struct $name:ident {
        $($field:ident $(as $listed:literal)?: $unit:literal, $text:literal;)*
    }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
        $vis struct $name { $(#[doc = concat!($text, " (", $unit, ").")] pub $field: u64,)* }

        impl $name {
            /// All counters of the group, in declaration order.
            pub fn list(&self) -> Vec<$crate::counters::Counter> {
                vec![$($crate::counters::Counter {
                    name: $crate::counters::counters!(@name $field $($listed)?), unit: $unit, description: $text, value: self.$field,
                },)*]
            }
        }

        impl $name {
            /// Calls `visit` with the place of each counter in the group, and the counter.
            #[allow(dead_code, reason = "not every group is part of a run's list")]
            pub(crate) fn each_mut(&mut self, mut visit: impl FnMut(usize, &mut u64)) {
                [$(&mut self.$field,)*].into_iter().enumerate().for_each(|(place, counter)| visit(place, counter));
            }
        }
        impl std::ops::AddAssign for $name {
            fn add_assign(&mut self, other: Self) { $(self.$field += other.$field;)* }
        }
    };
}
pub(crate) use counters;

counters! {
    /// What an issue stage did in each cycle. Every cycle is in exactly one class, so the classes add up to the cycles of the run.
    pub struct Activity {
        busy: "cycles", "issued an operation";
        bypass: "cycles", "issued an operation whose data had missed: it passes the pipe without work (miss_handling = \"retry\")";
        fetch: "cycles", "operations wait for the L1's hit latency or its port";
        memory: "cycles", "all waiting operations wait for L2 or DRAM";
        mshr: "cycles", "the next lookup was refused (no MSHR, accumulation row or L2 queue entry) and hit when it was let in; if it missed, all of its wait is memory";
        blocked: "cycles", "an operation is ready, but the stage behind is full";
        starved: "cycles", "rays are here, but none needs this stage now";
        idle: "cycles", "there is no ray";
    }
}

impl Activity {
    /// All cycles.
    pub fn total(&self) -> u64 {
        self.list().iter().map(|c| c.value).sum()
    }
}

/// Busy cycles of an issue stage so far.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StageBusy {
    /// Kind of the unit.
    pub unit: &'static str,
    /// Number of the unit in its core.
    pub index: usize,
    /// Stage of the unit.
    pub stage: &'static str,
    /// Cycles in which it issued an operation.
    pub cycles: u64,
}

#[cfg(test)]
mod tests {
    counters! {
        /// Two counters.
        struct Two {
            first: "events", "the first";
            second as "other": "cycles", "the second";
        }
    }

    #[test]
    fn a_counter_is_listed_under_its_field_or_under_the_name_that_it_is_given() {
        let mut two = Two { first: 1, second: 2 };
        two += Two { first: 10, second: 20 };
        let listed: Vec<_> = two.list().iter().map(|c| (c.name, c.unit, c.value)).collect();
        assert_eq!(listed, [("first", "events", 11), ("other", "cycles", 22)]);
    }
}
