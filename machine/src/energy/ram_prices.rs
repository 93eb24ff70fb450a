//! What an access of a stack or of a local memory costs when it is larger or smaller than the one that its price is of.
//!
//! CACTI 7 gives the energy of a read and of a write of a word of 32 bits in memories of 512 B, and 2, 4, 64 and 256 KB (`hardware.md`
//! 9.5). Prices follow their ratios: a price in the configuration is that of a memory of `energy.stack_priced_size` or
//! `energy.local_priced_size`. Words of a local memory cost in proportion to their bytes; the width of a stack entry changes a price as far
//! as it changes the size.

use super::by_size::{between, in_proportion};
use crate::config::{MachineConfig, Picojoules};

/// Read and write of 32 bits in a memory of so many bytes, at 22 nm, fJ. Sizes that CACTI was not asked for are by the logarithms of size
/// and energy.
const CACTI: [(u64, u64, u64); 10] = [
    (512, 200, 430),
    (1 << 10, 293, 579),
    (2 << 10, 430, 780),
    (4 << 10, 800, 900),
    (8 << 10, 1_122, 1_236),
    (16 << 10, 1_575, 1_697),
    (32 << 10, 2_210, 2_330),
    (64 << 10, 3_100, 3_200),
    (128 << 10, 4_349, 4_525),
    (256 << 10, 6_100, 6_400),
];

/// What the accesses of a memory cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct RamPrices {
    pub read: Picojoules,
    pub write: Picojoules,
}

impl RamPrices {
    /// Those of the stacks of a traversal unit: a pop reads, a push writes.
    pub fn of_stacks(config: &MachineConfig) -> Self {
        let energy = &config.energy;
        let prices = Self { read: energy.stack_pop_pj, write: energy.stack_push_pj };
        prices.of_size(energy.stack_priced_size.0, config.stack_bytes())
    }

    /// Those of the local memory of an SRP.
    pub fn of_local(config: &MachineConfig) -> Self {
        let energy = &config.energy;
        let prices = Self { read: energy.local_read_pj, write: energy.local_write_pj };
        let Self { read, write } = prices.of_size(energy.local_priced_size.0, config.srp.local_memory.0);
        let word =
            |price| in_proportion(price, config.srp.local_word_bytes.into(), energy.local_priced_word_bytes.into());
        Self { read: word(read), write: word(write) }
    }

    fn of_size(self, priced: u64, size: u64) -> Self {
        let read = |size| between(&CACTI, size, |&(bytes, read, _)| (bytes, read));
        let write = |size| between(&CACTI, size, |&(bytes, _, write)| (bytes, write));
        Self {
            read: in_proportion(self.read, read(size), read(priced)),
            write: in_proportion(self.write, write(size), write(priced)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::NamedMachine;

    /// Pop, push, read and write, fJ.
    fn prices(overrides: &[&str]) -> [u64; 4] {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let config = NamedMachine::load("sgrt-ti2", &overrides).unwrap().config;
        let (stacks, local) = (RamPrices::of_stacks(&config), RamPrices::of_local(&config));
        [stacks.read, stacks.write, local.read, local.write].map(|price| price.femtojoules)
    }

    #[test]
    fn memories_of_the_priced_size_have_the_prices_as_they_stand() {
        assert_eq!(prices(&[]), [260, 470, 1_800, 1_900]);
    }

    /// `hardware.md` 9.5 at 14 nm: 0.12 and 0.26 pJ at 512 B, 0.48 and 0.54 at 4 KB, 3.6 and 3.8 at 256 KB.
    #[test]
    fn others_have_those_of_the_table() {
        let near =
            |found: u64, pj: f64| assert!((found as f64 / 1000.0 / pj - 1.0).abs() < 0.03, "{found} fJ, {pj} pJ");
        for (entries, pop, push) in [(2, 0.12, 0.26), (16, 0.48, 0.54)] {
            let [read, write, ..] = prices(&[&format!("ti.stack_entries={entries}")]);
            near(read, pop);
            near(write, push);
        }
        assert_eq!(prices(&["ti.rays_per_trv=128"])[..2], prices(&["ti.stack_entries=16"])[..2], "4 KB either way");
        let [_, _, read, write] = prices(&["srp.local_memory=256KiB"]);
        near(read, 3.6);
        near(write, 3.8);
    }

    /// Between 4 and 64 KB the energy grows by the same factor with each doubling, and so from 512 B to 2 KB and from 64 to 256 KB.
    #[test]
    fn what_cacti_was_not_asked_for_is_by_the_logarithms() {
        let at = |bytes: u64| CACTI.iter().find(|point| point.0 == bytes).unwrap();
        for (from, to, steps) in [(512_u64, 2 << 10, 2_i32), (4 << 10, 64 << 10, 4), (64 << 10, 256 << 10, 2)] {
            for of in [|point: &(u64, u64, u64)| point.1 as f64, |point: &(u64, u64, u64)| point.2 as f64] {
                let factor = (of(at(to)) / of(at(from))).powf(1.0 / f64::from(steps));
                for step in 1..steps {
                    let wanted = of(at(from)) * factor.powi(step);
                    assert!((of(at(from << step)) - wanted).abs() < 1.0, "{} B: {wanted}", from << step);
                }
            }
        }
    }

    #[test]
    fn energy_grows_with_the_size_everywhere() {
        let sizes: Vec<u64> = (4..=24).map(|bits| 1 << bits).collect();
        let price = |size| {
            let one = Picojoules { femtojoules: 1_000_000 };
            RamPrices { read: one, write: one }.of_size(2 << 10, size)
        };
        for pair in sizes.windows(2) {
            let (small, large) = (price(pair[0]), price(pair[1]));
            assert!(small.read.femtojoules > 0 && small.read.femtojoules < large.read.femtojoules, "{pair:?}");
            assert!(small.write.femtojoules > 0 && small.write.femtojoules < large.write.femtojoules, "{pair:?}");
        }
    }

    /// Whoever knows what the memory at hand costs says so, with its size.
    #[test]
    fn a_price_may_be_of_the_size_at_hand() {
        let said = ["ti.stack_entries=16", "energy.stack_priced_size=4KiB", "energy.stack_pop_pj=0.3"];
        assert_eq!(prices(&said)[..2], [300, 470]);
        let said = ["srp.local_memory=128KiB", "energy.local_priced_size=128KiB", "energy.local_read_pj=2.0"];
        assert_eq!(prices(&said)[2..], [2_000, 1_900]);
        let said = ["srp.local_word_bytes=16", "energy.local_priced_word_bytes=16", "energy.local_read_pj=6.0"];
        assert_eq!(prices(&said)[2..], [6_000, 1_900]);
    }

    #[test]
    fn a_longer_word_costs_what_its_bytes_cost() {
        assert_eq!(prices(&["srp.local_word_bytes=8"]), [260, 470, 3_600, 3_800]);
        assert_eq!(prices(&["srp.local_word_bytes=2"])[2..], [900, 950]);
    }
}
