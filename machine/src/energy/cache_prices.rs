//! What a cache's accesses cost when it is larger or smaller than the one that their prices are of.
//!
//! CACTI 7 gives the energy of a read and of a fill of a 64-byte line for seven sizes (`hardware.md` 9.5). Prices follow their
//! ratios: a price in the configuration is that of a cache of `energy.l1_priced_size` or `energy.l2_priced_size`, with lines of
//! `energy.priced_line_bytes`.

use super::by_size::{between, in_proportion};
use crate::config::{Energy, L1, MachineConfig, Picojoules};

/// Read and fill of a 64-byte line in a 4-way cache of so many KiB, at 22 nm, fJ. Fills are 1.5 reads at 8 KiB and 3.6 at 128 KiB; at
/// the other sizes by the logarithm of the size.
const CACTI: [(u64, u64, u64); 7] = [
    (8, 8_500, 12_750),
    (16, 9_500, 19_238),
    (32, 11_600, 29_580),
    (64, 15_600, 47_970),
    (128, 23_500, 84_600),
    (256, 34_300, 141_488),
    (512, 62_800, 292_020),
];

/// What the accesses of one cache cost.
#[derive(Clone, Copy, Debug)]
pub(super) struct CachePrices {
    read: Picojoules,
    miss: Picojoules,
    fill: Picojoules,
}

impl CachePrices {
    /// Those of a first-level cache whose reads have this price.
    pub fn of_l1(config: &MachineConfig, cache: &L1, read: Picojoules) -> Self {
        let energy = &config.energy;
        let prices = Self { read, miss: energy.l1_miss_pj, fill: energy.l1_fill_pj };
        prices.of_size(config, energy.l1_priced_size.0, cache.size.0)
    }

    /// Those of the L2.
    pub fn of_l2(config: &MachineConfig) -> Self {
        let Energy { l2_read_pj: read, l2_miss_pj: miss, l2_fill_pj: fill, l2_priced_size, .. } = config.energy;
        Self { read, miss, fill }.of_size(config, l2_priced_size.0, config.l2.size.0)
    }

    fn of_size(self, config: &MachineConfig, priced: u64, size: u64) -> Self {
        let lines = (u64::from(config.l2.line_bytes), u64::from(config.energy.priced_line_bytes));
        let scaled = |price, of: fn(u64) -> u64, (line, priced_line): (u64, u64)| {
            in_proportion(price, of(size) * line, of(priced) * priced_line)
        };
        Self {
            read: scaled(self.read, read, lines),
            // Tags do not grow with the line.
            miss: scaled(self.miss, read, (1, 1)),
            fill: scaled(self.fill, fill, lines),
        }
    }

    /// Events and their energies: reads of lines, lookups that miss or merge, fills.
    pub fn of(&self, reads: u64, missing: u64, fills: u64) -> [(u64, Picojoules); 3] {
        [(reads, self.read), (missing, self.miss), (fills, self.fill)]
    }
}

fn read(size: u64) -> u64 {
    between(&CACTI, size, |&(kib, read, _)| (kib << 10, read))
}

/// Never less than a read: below 8 KiB the line would end there.
fn fill(size: u64) -> u64 {
    between(&CACTI, size, |&(kib, _, fill)| (kib << 10, fill)).max(read(size))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::NamedMachine;

    fn prices(overrides: &[&str]) -> (CachePrices, CachePrices) {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let config = NamedMachine::load("sgrt-ti2", &overrides).unwrap().config;
        (CachePrices::of_l1(&config, &config.ti.trv_l1, config.energy.trv_l1_read_pj), CachePrices::of_l2(&config))
    }

    fn fj(prices: CachePrices) -> [u64; 3] {
        [prices.read, prices.miss, prices.fill].map(|price| price.femtojoules)
    }

    #[test]
    fn a_cache_of_the_priced_size_has_the_prices_as_they_stand() {
        let (l1, l2) = prices(&[]);
        assert_eq!((fj(l1), fj(l2)), ([5_700, 600, 11_500], [21_000, 2_100, 87_000]));
    }

    /// `hardware.md` 9.5 at 14 nm: 5.1, 7.0 and 9.4 pJ a read at 8, 32 and 64 KiB, 14 and 38 pJ at 128 and 512 KiB.
    #[test]
    fn reads_of_other_sizes_are_those_of_the_table() {
        let near = |size: &str, l1: bool, pj: f64| {
            let key = if l1 { "ti.trv_l1.size" } else { "l2.size" };
            let (small, large) = prices(&[&format!("{key}={size}")]);
            let [read, ..] = fj(if l1 { small } else { large });
            assert!((read as f64 / 1000.0 / pj - 1.0).abs() < 0.03, "{size}: {read} fJ, {pj} pJ");
        };
        for (size, pj) in [("8KiB", 5.1), ("32KiB", 7.0), ("64KiB", 9.4)] {
            near(size, true, pj);
        }
        for (size, pj) in [("128KiB", 14.0), ("512KiB", 38.0)] {
            near(size, false, pj);
        }
    }

    #[test]
    fn a_fill_is_one_and_a_half_reads_at_8_and_three_and_a_half_at_128_kib() {
        for (kib, percent) in [(8, 150), (16, 202), (32, 255), (128, 360), (256, 412)] {
            assert_eq!((fill(kib << 10) * 100 + 50) / read(kib << 10), percent, "{kib} KiB");
        }
    }

    #[test]
    fn energy_grows_with_the_size_everywhere() {
        let sizes: Vec<u64> = (0..=16).map(|step| 1 << (10 + step)).collect();
        for pair in sizes.windows(2) {
            assert!(read(pair[0]) < read(pair[1]) && fill(pair[0]) < fill(pair[1]), "{pair:?}");
        }
        assert!(sizes.iter().all(|&size| fill(size) >= read(size)));
        assert_eq!((read(4 << 10), read(48 << 10), read(1 << 20)), (8_000, 13_600, 119_800), "by straight lines");
    }

    #[test]
    fn a_line_twice_as_long_costs_twice_as_much_but_for_its_tag() {
        let (l1, l2) = prices(&["l2.line_bytes=128"]);
        assert_eq!((fj(l1), fj(l2)), ([11_400, 600, 23_000], [42_000, 2_100, 174_000]));
    }

    /// Whoever knows what the cache at hand costs says so, with its size.
    #[test]
    fn a_price_may_be_of_the_size_at_hand() {
        let (l1, _) = prices(&["ti.trv_l1.size=64KiB", "energy.l1_priced_size=64KiB", "energy.trv_l1_read_pj=9"]);
        assert_eq!(fj(l1), [9_000, 600, 11_500]);
    }
}
