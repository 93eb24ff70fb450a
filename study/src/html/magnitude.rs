//! The unit of figures that may be of any size: one for all that stands together, so that they compare at a glance.

/// A unit, and how many of it make one of the unit that a study stores.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: &'static str,
    /// A stored value times this is a value in the unit.
    pub scale: f64,
}

const fn unit(name: &'static str, scale: f64) -> Unit {
    Unit { name, scale }
}

/// Of energies, which are stored in mJ.
pub const ENERGY: [Unit; 3] = [unit("mJ", 1.0), unit("µJ", 1e3), unit("nJ", 1e6)];

/// Of times, which are stored in ms.
pub const TIME: [Unit; 3] = [unit("ms", 1.0), unit("µs", 1e3), unit("ns", 1e6)];

/// Three places are written: of the largest value two digits or more.
const LARGEST_LEAST: f64 = 0.1;

/// The first of the units in which the largest value has enough digits; the last one for values that have them in none.
pub fn for_all(units: &[Unit; 3], values: impl IntoIterator<Item = f64>) -> Unit {
    let largest = values.into_iter().map(f64::abs).fold(0.0, f64::max);
    let enough = |unit: &&Unit| largest * unit.scale >= LARGEST_LEAST;
    // Where all is zero, any unit will do.
    let last = if largest > 0.0 { units[2] } else { units[0] };
    units.iter().find(enough).copied().unwrap_or(last)
}

/// The unit in which to write values that are stored in `stored`: that itself where it has no others.
pub fn of(stored: &'static str, values: impl IntoIterator<Item = f64>) -> Unit {
    let known = [ENERGY, TIME].into_iter().find(|units| units[0].name == stored);
    known.map_or(unit(stored, 1.0), |units| for_all(&units, values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_value_decides() {
        let name = |values: &[f64]| for_all(&ENERGY, values.iter().copied()).name;
        assert_eq!([name(&[1e-6, 960.8]), name(&[0.1]), name(&[0.0012, 0.0006])], ["mJ", "mJ", "µJ"]);
        assert_eq!([name(&[2e-6]), name(&[1e-300]), name(&[0.0]), name(&[])], ["nJ", "nJ", "mJ", "mJ"]);
        assert_eq!([of("ms", [2e-5]).name, of("dB", [2e-4]).name, of("", []).name], ["ns", "dB", ""]);
        for units in [ENERGY, TIME] {
            assert!(units.windows(2).all(|pair| pair[1].scale == 1e3 * pair[0].scale));
        }
    }
}
