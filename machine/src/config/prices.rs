//! Prices of caches, stacks, local memories, rows and bursts are of a size, those of traversal units of a width. Whoever sets one beside such a size
//! says which size it is of: taken for that of the base, it would be changed in proportion without a word.

use rayreel_settings::{Ancestor, Sourced};

use super::check::Conflict;
use super::whole::MachineConfig;

/// A price, a size that it is scaled to, and the size that it is of.
type Priced = (&'static str, &'static str, &'static str);

const L1: &str = "energy.l1_priced_size";
const L2: &str = "energy.l2_priced_size";
const LINE: &str = "energy.priced_line_bytes";
const LOCAL: &str = "energy.local_priced_size";
const STACKS: &str = "energy.stack_priced_size";

/// What the stacks of a traversal unit cost, and what their size follows from.
const STACK_PRICES: [&str; 2] = ["energy.stack_push_pj", "energy.stack_pop_pj"];
const STACK_SIZES: [&str; 4] = ["ti.stack_entries", "ti.full_stack_entries", "ti.stack_entry_bytes", "ti.rays_per_trv"];

const ROW: &str = "energy.dram_priced_row_bytes";
const BURST: &str = "energy.dram_priced_burst_bytes";

/// What a traversal unit costs whatever it does, and what its width follows from.
const TRV_PRICES: [&str; 2] = ["energy.trv_clock_pj", "energy.trv_leakage_uw"];
const TRV_SIZES: [&str; 4] = ["ti.pipeline", "ti.aabbs_per_cycle", "ti.gather_boxes", "ti.gather_triangles"];
const TRV_BOXES: &str = "energy.trv_priced_boxes";
const TRV_TRIANGLES: &str = "energy.trv_priced_triangles";

const WORD: &str = "energy.local_priced_word_bytes";

const ALL: [Priced; 27] = [
    ("energy.trv_l1_read_pj", "ti.trv_l1.size", L1),
    ("energy.ist_l1_read_pj", "ti.ist_l1.size", L1),
    ("energy.srp_l1_read_pj", "srp.l1.size", L1),
    ("energy.l1_miss_pj", "ti.trv_l1.size", L1),
    ("energy.l1_miss_pj", "ti.ist_l1.size", L1),
    ("energy.l1_miss_pj", "srp.l1.size", L1),
    ("energy.l1_miss_pj", "processor.code_l1.size", L1),
    ("energy.l1_fill_pj", "ti.trv_l1.size", L1),
    ("energy.l1_fill_pj", "ti.ist_l1.size", L1),
    ("energy.l1_fill_pj", "srp.l1.size", L1),
    ("energy.l1_fill_pj", "processor.code_l1.size", L1),
    ("energy.l2_read_pj", "l2.size", L2),
    ("energy.l2_miss_pj", "l2.size", L2),
    ("energy.l2_fill_pj", "l2.size", L2),
    ("energy.trv_l1_read_pj", "l2.line_bytes", LINE),
    ("energy.ist_l1_read_pj", "l2.line_bytes", LINE),
    ("energy.srp_l1_read_pj", "l2.line_bytes", LINE),
    ("energy.l1_fill_pj", "l2.line_bytes", LINE),
    ("energy.l2_read_pj", "l2.line_bytes", LINE),
    ("energy.l2_fill_pj", "l2.line_bytes", LINE),
    ("energy.local_read_pj", "srp.local_memory", LOCAL),
    ("energy.local_write_pj", "srp.local_memory", LOCAL),
    ("energy.local_read_pj", "srp.local_word_bytes", WORD),
    ("energy.local_write_pj", "srp.local_word_bytes", WORD),
    ("energy.dram_row_pj", "dram.row_bytes", ROW),
    ("energy.dram_read_pj", "dram.burst_bytes", BURST),
    ("energy.dram_write_pj", "dram.burst_bytes", BURST),
];

/// Checks that a file, or the command line, that sets a price and another size than it is said to be of says so itself, and does not
/// inherit it. `chain` is the file and what it extends.
///
/// # Errors
/// The first price of which that is not so.
pub fn check(config: &MachineConfig, values: &[Sourced], chain: &[Ancestor]) -> Result<(), Conflict> {
    // The command line, which is in no chain, comes before all files.
    let rank = |value: &Sourced| chain.iter().position(|file| file.name == value.from).map_or(0, |at| at + 1);
    let of = |key: &str| values.iter().find(|value| value.key == key);
    // A price and a size that one file sets, and which size the price is of, if that is inherited.
    let unsaid = |price, size, priced| {
        let (price, size, priced) = (of(price)?, of(size)?, of(priced)?);
        (price.from == size.from && rank(priced) > rank(price)).then_some((price, size, priced))
    };
    for (price, size, priced) in ALL {
        let Some((price, size, priced)) = unsaid(price, size, priced) else { continue };
        if priced.value != size.value {
            let detail = format!(
                "{} is set beside {} = {}, and is a price of {} = {}: set that too, to what the price is of",
                price.key, size.key, size.value, priced.key, priced.value
            );
            return Err(Conflict::new([price.key, size.key], detail));
        }
    }
    let (bytes, of_bytes) = (config.stack_bytes(), config.energy.stack_priced_size.0);
    let stacks = STACK_PRICES.into_iter().flat_map(|price| STACK_SIZES.map(|size| (price, size)));
    let of_stacks = stacks.filter_map(|(price, size)| unsaid(price, size, STACKS)).find(|_| bytes != of_bytes);
    if let Some((price, size, priced)) = of_stacks {
        let detail = format!(
            "{} is set beside {} = {}, with which the stacks of a traversal unit have {bytes} bytes, and is a price of {} = {of_bytes}: set that \
             too, to what the price is of",
            price.key, size.key, size.value, priced.key
        );
        return Err(Conflict::new([price.key, size.key], detail));
    }
    let (width, of_width) = (config.trv_width(), config.trv_priced_width());
    let parts = [
        (TRV_BOXES, "boxes", width.boxes, of_width.boxes),
        (TRV_TRIANGLES, "triangles", width.triangles, of_width.triangles),
    ];
    for (priced, what, tested, of_tested) in parts {
        let units = TRV_PRICES.into_iter().flat_map(|price| TRV_SIZES.map(|size| (price, size)));
        let of_units = units.filter_map(|(price, size)| unsaid(price, size, priced)).find(|_| tested != of_tested);
        let Some((price, size, priced)) = of_units else { continue };
        let detail = format!(
            "{} is set beside {} = {}, with which a traversal unit tests {what} {tested} at a time, and is a price of {} = {of_tested}: set that \
             too, to what the price is of",
            price.key, size.key, size.value, priced.key
        );
        return Err(Conflict::new([price.key, size.key], detail));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::config::NamedMachine;

    fn load(overrides: &[&str]) -> Result<(), String> {
        let overrides: Vec<String> = overrides.iter().map(|&text| text.to_owned()).collect();
        NamedMachine::load("sgrt-ti2", &overrides).map(|_| ()).map_err(|error| error.to_string())
    }

    /// Presets that have prices of their own say of which unit: another width is no conflict of theirs.
    #[test]
    fn presets_say_what_unit_their_prices_are_of() {
        for (name, wider) in [("raycore", "ti.aabbs_per_cycle=1"), ("sgrt-ti1", "ti.aabbs_per_cycle=2")] {
            assert!(NamedMachine::load(name, &[wider.to_owned()]).is_ok(), "{name} with {wider}");
        }
        let unified = ["ti.pipeline=unified", "ti.ist=0"].map(String::from);
        assert!(NamedMachine::load("sgrt-ti1", &unified).is_ok());
    }

    #[test]
    fn a_price_beside_a_size_says_what_it_is_of() {
        assert_eq!(
            load(&["ti.trv_l1.size=64KiB", "energy.trv_l1_read_pj=9"]).unwrap_err(),
            "override \"energy.trv_l1_read_pj=9.0\": energy.trv_l1_read_pj is set beside ti.trv_l1.size = 65536, and is a price of \
             energy.l1_priced_size = 16384: set that too, to what the price is of"
        );
        for size in ["16KiB", "64KiB"] {
            let priced = format!("energy.l1_priced_size={size}");
            assert_eq!(load(&["ti.trv_l1.size=64KiB", "energy.trv_l1_read_pj=9", &priced]), Ok(()), "{size}");
        }
        assert_eq!(load(&["ti.trv_l1.size=16KiB", "energy.trv_l1_read_pj=9"]), Ok(()), "it is of that size");
        assert_eq!(load(&["ti.ist_l1.size=64KiB", "energy.trv_l1_read_pj=9"]), Ok(()), "of another cache");
        assert_eq!(
            load(&["energy.l1_priced_size=32KiB"]),
            Ok(()),
            "prices and sizes of the preset, said to be of others"
        );
        assert!(load(&["l2.size=1MiB", "energy.l2_fill_pj=300"]).unwrap_err().contains("energy.l2_priced_size"));
        assert!(load(&["l2.line_bytes=128", "energy.l1_fill_pj=20"]).unwrap_err().contains("priced_line_bytes"));
    }

    #[test]
    fn a_price_of_stacks_too() {
        let error = load(&["ti.rays_per_trv=32", "energy.stack_pop_pj=0.2"]).unwrap_err();
        assert!(
            error.ends_with(
                "energy.stack_pop_pj is set beside ti.rays_per_trv = 32, with which the stacks of a traversal unit have 1024 bytes, and is a \
                 price of energy.stack_priced_size = 2048: set that too, to what the price is of"
            ),
            "{error}"
        );
        let fine = [
            &["ti.rays_per_trv=32", "energy.stack_pop_pj=0.2", "energy.stack_priced_size=1KiB"][..],
            &["ti.rays_per_trv=32", "ti.stack_entries=16", "energy.stack_pop_pj=0.2"],
            &["energy.stack_pop_pj=0.2"],
            &["ti.rays_per_trv=32"],
        ];
        fine.iter().for_each(|overrides| assert_eq!(load(overrides), Ok(()), "{overrides:?}"));
        assert!(
            load(&["dram.row_bytes=4096", "energy.dram_row_pj=1500"]).unwrap_err().contains("dram_priced_row_bytes")
        );
        let said = ["dram.burst_bytes=64", "energy.dram_read_pj=4000", "energy.dram_priced_burst_bytes=64"];
        assert_eq!(load(&said), Ok(()));
        assert!(
            load(&["srp.local_memory=32KiB", "energy.local_write_pj=2"]).unwrap_err().contains("local_priced_size")
        );
        assert!(
            load(&["srp.local_word_bytes=8", "energy.local_write_pj=2"])
                .unwrap_err()
                .contains("local_priced_word_bytes")
        );
    }

    #[test]
    fn a_price_of_traversal_units_too() {
        let error = load(&["ti.aabbs_per_cycle=1", "energy.trv_clock_pj=4"]).unwrap_err();
        assert!(
            error.ends_with(
                "energy.trv_clock_pj is set beside ti.aabbs_per_cycle = 1, with which a traversal unit tests boxes 1 at a time, and is a price of \
                 energy.trv_priced_boxes = 2: set that too, to what the price is of"
            ),
            "{error}"
        );
        let error = load(&["ti.pipeline=unified", "ti.ist=0", "energy.trv_leakage_uw=500"]).unwrap_err();
        assert!(
            error.contains("tests triangles 1 at a time, and is a price of energy.trv_priced_triangles = 0"),
            "{error}"
        );
        let fine = [
            &["ti.aabbs_per_cycle=1", "energy.trv_clock_pj=4", "energy.trv_priced_boxes=1"][..],
            &["ti.aabbs_per_cycle=2", "energy.trv_clock_pj=4"],
            &["ti.gather_boxes=8", "energy.trv_clock_pj=4"],
            &["ti.aabbs_per_cycle=1"],
        ];
        fine.iter().for_each(|overrides| assert_eq!(load(overrides), Ok(()), "{overrides:?}"));
    }

    #[test]
    fn so_does_a_file() {
        let parse =
            |text: &str| NamedMachine::parse("mine", &format!("extends = \"sgrt-ti2\"\n{text}"), &[]).map(|_| ());
        let trust = "class = \"estimate\"\nsource = \"a test\"\n";
        let set = |key: &str, value: &str| format!("[{key}]\nvalue = {value}\n{trust}");
        let (size, price) = (set("ti.trv_l1.size", "\"64KiB\""), set("energy.trv_l1_read_pj", "9.0"));
        let error = parse(&format!("{size}{price}")).unwrap_err().to_string();
        assert!(error.contains("energy.l1_priced_size = 16384: set that too"), "{error}");
        let said = set("energy.l1_priced_size", "\"64KiB\"");
        assert_eq!(parse(&format!("{size}{price}{said}")).map_err(|error| error.to_string()), Ok(()));
    }

    /// Each key of the table is one of a machine.
    #[test]
    fn all_keys_are_there() {
        let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
        use super::*;
        let stacks =
            [&STACK_PRICES[..], &STACK_SIZES, &[STACKS], &TRV_PRICES, &TRV_SIZES, &[TRV_BOXES, TRV_TRIANGLES]].concat();
        for key in ALL.into_iter().flat_map(|(price, size, priced)| [price, size, priced]).chain(stacks) {
            assert!(machine.values.iter().any(|value| value.key == key), "{key}");
        }
    }
}
