//! Figures of a row, by the names that reports have for them.

use serde_json::{Map, Value};

use crate::report::flat::plain as column;

/// The figures of a row, or of one frame.
#[derive(Clone, Copy, Debug)]
pub struct RowFigures<'a>(pub &'a Map<String, Value>);

impl<'a> RowFigures<'a> {
    /// Whether there is such a figure; it may still be null.
    pub fn has(self, name: &str) -> bool {
        self.0.contains_key(name)
    }

    /// A figure; nothing where it is null.
    pub fn number(self, name: &str) -> Option<f64> {
        self.0.get(name)?.as_f64()
    }

    /// A figure that is counted.
    pub fn count(self, name: &str) -> Option<u64> {
        self.0.get(name)?.as_u64()
    }

    /// A counter by its name in reports, such as `srp/kernel/shade/cycles`.
    pub fn counter(self, name: &str) -> Option<u64> {
        self.count(&column(name))
    }

    /// Dynamic energy and leakage of a component, mJ.
    pub fn energy_mj(self, component: &str) -> Option<(f64, f64)> {
        let part = |part: &str| self.number(&format!("energy_{}_{part}", column(component)));
        Some((part("dynamic_mj")?, part("leakage_mj")?))
    }

    /// What stands in place of `*` in the names of counters such as `ti/trv/*/busy`, in their order.
    pub fn between(self, before: &str, after: &str) -> impl Iterator<Item = &'a str> {
        let (before, after) = (column(before), column(after));
        self.0.keys().filter_map(move |name| name.strip_prefix(&before)?.strip_suffix(&after))
    }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn figures_are_found_by_the_names_of_reports() {
        let value = json!({
            "psnr_db": null, "cycles": 12, "ti_trv_inner_busy": 3, "ti_trv_leaf_busy": 4, "ti_trv_l1_hits": 9,
            "energy_trv_l1_dynamic_mj": 0.5, "energy_trv_l1_leakage_mj": 0.25,
        });
        let figures = RowFigures(value.as_object().unwrap());
        assert!(figures.has("psnr_db") && !figures.has("ssim"));
        assert_eq!((figures.number("psnr_db"), figures.count("cycles")), (None, Some(12)));
        assert_eq!(figures.counter("ti/trv/inner/busy"), Some(3));
        assert_eq!(figures.between("ti/trv/", "/busy").collect::<Vec<_>>(), ["inner", "leaf"]);
        assert_eq!(figures.energy_mj("trv_l1"), Some((0.5, 0.25)));
    }
}
