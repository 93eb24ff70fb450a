//! What the clock and the leakage of a traversal unit come to when it tests more or fewer boxes and triangles a cycle than the one that
//! these prices are of.
//!
//! Both follow the area of its logic (`area.box_um2`, `area.triangle_um2`, `area.trv_control_um2`): prices in the configuration are of a
//! unit of `energy.trv_priced_boxes` and `energy.trv_priced_triangles`.

use super::by_size::in_proportion;
use super::rounding::nearest;
use crate::config::{MachineConfig, Picojoules};

/// Clock and leakage of a traversal unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct TrvPrices {
    /// A cycle in which its clock runs.
    pub clock: Picojoules,
    /// What its logic leaks, microwatts.
    pub leakage_uw: u64,
}

impl TrvPrices {
    /// Those of the units of a machine.
    pub fn of(config: &MachineConfig) -> Self {
        let (to, from) = (config.trv_um2(config.trv_width()), config.trv_um2(config.trv_priced_width()));
        let (clock, leakage_uw) = (config.energy.trv_clock_pj, config.energy.trv_leakage_uw);
        // Logic without an area says nothing of its width.
        if from == 0 {
            return Self { clock, leakage_uw };
        }
        let leakage_uw = nearest(u128::from(leakage_uw) * u128::from(to), from.into());
        Self { clock: in_proportion(clock, to, from), leakage_uw: u64::try_from(leakage_uw).unwrap_or(u64::MAX) }
    }
}

#[cfg(test)]
mod tests {
    use super::TrvPrices;
    use crate::config::NamedMachine;

    /// Clock in fJ, leakage in microwatts.
    fn prices(machine: &str, overrides: &[&str]) -> (u64, u64) {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        let TrvPrices { clock, leakage_uw } = TrvPrices::of(&NamedMachine::load(machine, &overrides).unwrap().config);
        (clock.femtojoules, leakage_uw)
    }

    #[test]
    fn units_of_presets_have_the_prices_as_they_stand() {
        for &(machine, _) in crate::config::PRESETS {
            let config = NamedMachine::load(machine, &[]).unwrap().config;
            let energy = &config.energy;
            assert_eq!(prices(machine, &[]), (energy.trv_clock_pj.femtojoules, energy.trv_leakage_uw), "{machine}");
        }
    }

    #[test]
    fn others_follow_the_area() {
        // 1520 + 15600 of 1520 + 2 x 15600 um2: 0.5232.
        assert_eq!(prices("sgrt-ti2", &["ti.aabbs_per_cycle=1"]), (3_139, 128));
        // A triangle test of 36700 um2 beside them: 69420 of 32720. The preset of a unified unit says 520 itself.
        assert_eq!(prices("sgrt-ti2", &["ti.pipeline=unified", "ti.ist=0"]), (12_730, 520));
        // 1520 + 20 x 15600 + 2 x 36700 of 1520 + 10 x 15600 + 36700 um2.
        assert_eq!(
            prices("gr6500", &["ti.gather_boxes=10", "ti.gather_triangles=2"]),
            (76_499, 2_988),
            "386920 of 194220"
        );
        assert_eq!(prices("sgrt-ti2", &["ti.gather_boxes=10"]), (6_000, 245), "nothing is gathered here");
        let none = ["area.box_um2=0", "area.triangle_um2=0", "area.trv_control_um2=0", "ti.aabbs_per_cycle=1"];
        assert_eq!(prices("sgrt-ti2", &none), (6_000, 245));
    }
}
