//! The table of all keys of a machine, and its presets. Presets, files and overrides are all checked against it, so a wrong key or
//! value is named before anything runs.

use std::sync::LazyLock;

use rayreel_settings::{Family, Preset, Schema, Settings};
pub use rayreel_settings::{Key, Rule};

use super::whole::MachineConfig;

macro_rules! presets {
    ($($name:literal)*) => { &[$(($name, include_str!(concat!("../presets/", $name, ".toml"))),)*] };
}

/// The compiled-in presets: name and TOML text.
pub const PRESETS: &[Preset] = presets! {
    "sgrt-ti2" "sgrt-ti1" "sgrt-ti2-retry" "sgrt-ti2-accumulate" "sgrt-ti2-rob" "sgrt-hybrid-number" "raycore"
    "hybrid-raster" "external-buffers" "no-direct-interface" "gr6500" "mimd-trax" "simt-mimd" "simt-mimd-vector"
};

static SCHEMA: LazyLock<Schema> = LazyLock::new(|| {
    let schema = Schema::new("a machine", MachineConfig::ENTRIES);
    schema.too_long_to_list("`rayreel presets show sgrt-ti2` lists all keys")
});

/// What all machines have in common.
pub static MACHINES: Family = Family {
    what: "machine",
    expected: "a valid machine",
    example: "ti.trv_l1.size=32KiB",
    base: "sgrt-ti2",
    presets: PRESETS,
    kinds: &[],
    schema: |_| &SCHEMA,
};

/// All keys, in the order of the structs.
pub static KEYS: LazyLock<&'static [Key]> = LazyLock::new(|| SCHEMA.keys());

/// Whether an override `key=value` is meant for a machine: its key begins with one of the machine's tables.
pub fn is_machine_override(text: &str) -> bool {
    SCHEMA.is_override(text)
}
