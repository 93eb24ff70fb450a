//! Machines from presets, files and overrides: what is taken, where it is from, and what the errors say.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use proptest::prelude::*;
use rayreel_machine::MachineError;
use rayreel_machine::config::schema::{KEYS, Rule};
use rayreel_machine::config::{Bytes, Class, MachineConfig, NamedMachine, PRESETS};
use rayreel_settings::SettingsError;

fn load(spec: &str, overrides: &[&str]) -> Result<NamedMachine, MachineError> {
    NamedMachine::load(spec, &overrides.iter().map(ToString::to_string).collect::<Vec<_>>())
}

/// Saves `text` in `folder` and loads it.
fn file(folder: &Path, name: &str, text: &str) -> Result<NamedMachine, MachineError> {
    let path = folder.join(name);
    fs::write(&path, text).unwrap();
    load(path.to_str().unwrap(), &[])
}

#[test]
fn the_keys_are_those_of_the_structs_in_their_order() {
    fn leaves(value: &serde_json::Value, prefix: &str, out: &mut Vec<String>) {
        match value.as_object() {
            Some(map) => map.iter().for_each(|(k, v)| leaves(v, &format!("{prefix}.{k}"), out)),
            None => out.push(prefix.trim_start_matches('.').to_owned()),
        }
    }
    let config = load("sgrt-ti2", &[]).unwrap().config;
    let mut found = Vec::new();
    leaves(&serde_json::to_value(config).unwrap(), "", &mut found);
    assert_eq!(found, KEYS.iter().map(|k| k.name).collect::<Vec<_>>());
}

#[test]
fn every_value_of_every_preset_has_a_class_and_a_source() {
    assert_eq!(PRESETS.len(), 14);
    for (name, _) in PRESETS {
        let machine = load(name, &[]).unwrap();
        assert_eq!(machine.name, *name);
        machine.config.check().unwrap();
        assert_eq!(
            machine.values.iter().map(|v| v.key).collect::<Vec<_>>(),
            KEYS.iter().map(|k| k.name).collect::<Vec<_>>()
        );
        for value in &machine.values {
            assert!(!value.source.trim().is_empty() && value.class != Class::Override, "{name}: {value:?}");
            for internal in ["hardware.md", "DESIGN", "[S", " section "] {
                assert!(!value.source.contains(internal), "{name}: {} cites {internal}", value.key);
            }
        }
        assert!(machine.chain.iter().all(|a| a.why.ends_with('.') && a.why.len() > 60), "{name} says why");
    }
}

/// A preset names exactly what it changes, and no two are the same machine.
#[test]
fn presets_differ_from_their_base_in_what_they_name() {
    let mut seen = BTreeMap::new();
    for (name, text) in PRESETS {
        let machine = load(name, &[]).unwrap();
        if let Some(twin) = seen.insert(machine.canonical(), name) {
            panic!("{name} is {twin}");
        }
        let table: toml::Table = text.parse().unwrap();
        let Some(base) = table.get("extends") else { continue };
        let base = load(base.as_str().unwrap(), &[]).unwrap();
        for (new, old) in machine.values.iter().zip(&base.values) {
            // A preset may restate a value with another source (raycore's retry).
            let restated = new.from == *name && new.source != old.source;
            assert!((new.from == *name) == (new.value != old.value) || restated, "{name}: {}", new.key);
        }
        assert!(machine.values.iter().any(|v| v.from == *name));
    }
}

#[test]
fn presets_are_what_their_names_say() {
    use rayreel_machine::config::{GeometryBuffer, Interface, MissHandling, Pipeline, PrimaryVisibility};
    let of = |name: &str| load(name, &[]).unwrap().config;
    let base = of("sgrt-ti2");
    assert_eq!((base.gpu.cores, base.ti.trv, base.ti.ist, base.ti.aabbs_per_cycle), (4, 4, 1, 2));
    assert_eq!((base.ti.clock_mhz, base.srp.clock_mhz, base.dram.clock_mhz), (500, 1000, 1600));
    assert_eq!((base.ti.trv_l1.size, base.l2.size), (Bytes(16 << 10), Bytes(256 << 10)));
    assert_eq!((base.energy.box_test_pj.femtojoules, base.energy.stack_pop_pj.femtojoules), (15_000, 260));
    let ti1 = of("sgrt-ti1").ti;
    assert_eq!((ti1.aabbs_per_cycle, ti1.pipeline), (1, Pipeline::Single));
    assert_eq!(of("sgrt-ti2-retry").ti.miss_handling, MissHandling::Retry);
    assert_eq!(of("sgrt-ti2-accumulate").ti.miss_handling, MissHandling::Accumulate);
    assert_eq!(of("sgrt-ti2-rob").ti.miss_handling, MissHandling::Reorder);
    assert!(of("sgrt-hybrid-number").layout.node_bytes < base.layout.node_bytes);
    let raycore = of("raycore");
    assert_eq!((raycore.ti.pipeline, raycore.ti.ist, raycore.srp.kernels.similarity.stages), (Pipeline::Unified, 0, 0));
    assert_eq!(of("hybrid-raster").gpu.primary_visibility, PrimaryVisibility::Raster);
    assert_eq!(of("external-buffers").gpu.geometry_buffer, GeometryBuffer::External);
    assert_eq!(of("no-direct-interface").gpu.interface, Interface::Memory);
}

#[test]
fn overrides_change_one_value_each() {
    let machine =
        load("sgrt-ti2", &["ti.trv_l1.size=32KiB", " l2.inclusive = true ", "energy.box_test_pj=12.3456"]).unwrap();
    assert_eq!(machine.name, "sgrt-ti2+ti.trv_l1.size=32KiB+l2.inclusive = true+energy.box_test_pj=12.3456");
    assert_eq!(machine.config.ti.trv_l1.size, Bytes(32 << 10));
    assert!(machine.config.l2.inclusive);
    assert_eq!(machine.config.energy.box_test_pj.femtojoules, 12_346, "kept to the femtojoule");
    let changed: Vec<_> = machine.values.iter().filter(|v| v.class == Class::Override).map(|v| v.key).collect();
    assert_eq!(changed, ["ti.trv_l1.size", "l2.inclusive", "energy.box_test_pj"]);
    assert_eq!(load("sgrt-ti2", &["ti.trv=8", "ti.trv=2"]).unwrap().config.ti.trv, 2, "the last one counts");
    assert_eq!(
        load("sgrt-ti2", &["ti.trv_l1.size=16384"]).unwrap().canonical(),
        load("sgrt-ti2", &[]).unwrap().canonical()
    );
}

#[test]
fn impossible_values_are_named() {
    let cases: &[(&[&str], &str)] = &[
        (&["gpu.cores=0"], "gpu.cores = 0 is not allowed; it must be a whole number from 1 to 64"),
        (&["gpu.cores=65"], "from 1 to 64"),
        (&["gpu.cores=4.0"], "gpu.cores = 4.0 is not allowed"),
        (&["gpu.tiles_in_flight=17"], "from 1 to 16"),
        (&["gpu.interface=wifi"], "\"direct\" or \"memory\""),
        (&["ti.clock_mhz=5001"], "from 1 to 5000"),
        (&["ti.trv=0"], "from 1 to 16"),
        (&["ti.ist=0"], "ti.ist = 0 leaves nobody to test triangles"),
        (&["ti.pipeline=unified"], "so ti.ist = 1 must be 0"),
        (&["ti.aabbs_per_cycle=3"], "from 1 to 2"),
        (
            &["ti.rays_per_trv=129"],
            "ti.rays_per_trv = 129 is more than 128, which only ti.pipeline = \"gathering\" can hold",
        ),
        (&["ti.rays_per_trv=4097"], "from 1 to 4096"),
        (&["ti.pipeline=gathering"], "ti.pipeline = \"gathering\" tests triangles itself, so ti.ist = 1 must be 0"),
        (
            &["ti.pipeline=gathering", "ti.ist=0"],
            "ti.pipeline = \"gathering\" has a full stack, so ti.stack_entries = 8",
        ),
        (&["ti.pipeline=software"], "ti.pipeline = \"software\" tests triangles by instructions, so ti.ist = 1"),
        (&["ti.pipeline=software", "ti.ist=0"], "ti.pipeline = \"software\" has a full stack, so ti.stack_entries = 8"),
        (
            &["ti.pipeline=software", "ti.ist=0", "ti.stack_entries=0"],
            "ti.pipeline = \"software\" has one clock, but srp.clock_mhz = 1000 and ti.clock_mhz = 500",
        ),
        (
            &["ti.pipeline=software", "ti.ist=0", "processor.lanes=12"],
            "ti.rays_per_trv = 64 is not a whole number of warps of processor.lanes = 12",
        ),
        (
            &["ti.pipeline=software", "ti.ist=0", "processor.lanes=32", "ti.ray_fifo_entries=31"],
            "ti.ray_fifo_entries = 31 does not hold a warp of processor.lanes = 32",
        ),
        (&["processor.kernel_mix.add_percent=101"], "from 0 to 100"),
        (&["ti.ist_entries=129"], "from 1 to 128"),
        (
            &["ti.trv_l1.size=24KiB"],
            "ti.trv_l1.size = 24576 bytes in 4 ways of 64-byte lines is not a power-of-two number of sets; 16KiB or 32KiB would do",
        ),
        (
            &["ti.trv_l1.size=1KiB", "ti.trv_l1.ways=32"],
            "ti.trv_l1.ways = 32 is more than the 16 lines of 64 bytes in ti.trv_l1.size; 2KiB would do",
        ),
        (&["srp.l1.size=1MiB", "srp.l1.ways=3"], "number of sets; 768KiB would do"),
        (
            &["ti.ist=0"],
            "where ti.pipeline = \"parallel\"; only \"unified\", \"gathering\" and \"software\" do without",
        ),
        (
            &["energy.dram_power_down_uw=38001"],
            "energy.dram_power_down_uw = 38001 is more than energy.dram_background_uw = 38000",
        ),
        (&["energy.dram_background_uw=12899"], "energy.dram_power_down_uw = 12900 is more than"),
        (&["energy.box_test_pj=0.0004"], "from 0 to 1000000 in steps of 0.001 pJ"),
        (&["ti.trv_l1.ways=0"], "from 1 to 64"),
        (&["ti.trv_l1.size=2MiB"], "a size from 1KiB to 1MiB, such as 16KiB"),
        (&["ti.trv_l1.size=16kb"], "a size from 1KiB"),
        (&["ti.trv_l1.size=-1"], "a size from 1KiB"),
        (&["l2.size=65MiB"], "to 64MiB"),
        (&["l2.size=192KiB"], "l2.size = 196608 bytes"),
        (&["l2.line_bytes=48"], "l2.line_bytes = 48 is not a power of two"),
        (&["l2.banks=3"], "l2.banks = 3 is not a power of two"),
        (&["l2.size=4KiB", "l2.banks=16"], "l2.banks = 16 is more than the 8 sets"),
        (&["l2.line_bytes=16"], "l2.line_bytes = 16 is less than dram.burst_bytes = 32"),
        (&["dram.tras=28"], "dram.trcd = 29 is more than dram.tras = 28"),
        (&["dram.trp_all=28"], "dram.trp = 29 is more than dram.trp_all = 28"),
        (&["dram.tfaw=15"], "dram.trrd = 16 is more than dram.tfaw = 15"),
        (&["dram.trefi=579"], "dram.trefi = 579 leaves no time between refreshes"),
        (&["dram.trefi=700", "dram.trrd=700", "dram.tfaw=700"], "leaves no time to read a row between refreshes"),
        (&["dram.tccd=3"], "dram.tccd = 3 is less than the 4 cycles of a column command"),
        (&["srp.ideal=true", "srp.divergence=naive"], "srp.ideal = true has no batches"),
        (&["dram.write_low=24"], "dram.write_low = 24 must be less than dram.write_high = 24"),
        (&["dram.write_high=33"], "dram.write_high = 33 is more than dram.write_queue_entries = 32"),
        (&["dram.channels=3"], "dram.channels = 3 is not a power of two"),
        (&["gpu.stream_reads=0"], "gpu.stream_reads = 0 is not allowed; it must be a whole number from 1 to 256"),
        (&["gpu.stream_unwritten_lines=0"], "from 1 to 4096"),
        (&["gpu.stream_flush_cycles=0"], "from 1 to 10000"),
        (&["srp.output_rays=0"], "srp.output_rays = 0 is not allowed; it must be a whole number from 1 to 65536"),
        (&["srp.gather_entries=0"], "from 1 to 128"),
        (&["srp.gather_entries=129"], "from 1 to 128"),
        (&["srp.dma_reads=0"], "from 1 to 1024"),
        (&["srp.rays_low_percent=101"], "from 0 to 100"),
        (&["ti.ray_record_bytes=0"], "from 1 to 1024"),
        (&["layout.ring_lines=255"], "from 256 to 65536"),
        (&["layout.texture_block=3"], "layout.texture_block = 3 is not a power of two"),
        (&["layout.texture_tile=48"], "layout.texture_tile = 48 is not a power of two"),
        (&["layout.texture_block=64"], "layout.texture_block = 64 is more than layout.texture_tile = 32"),
        (&["srp.batch_min=257"], "srp.batch_min = 257 is more than srp.batch_max = 256"),
        (&["srp.kernels.shade.ii_cycles=0"], "from 1 to 10000"),
        (&["srp.kernels.similarity.stages=0"], "a machine has all kernels of policies or (0) none"),
        (&["srp.ideal=1"], "true or false"),
        (&["energy.box_test_pj=-1"], "a number of picojoules from 0 to 1000000"),
        (&["energy.box_test_pj=nan"], "a number of picojoules"),
        (&["ti.trv_l1.sise=3"], "did you mean ti.trv_l1.size"),
        (&["trv_l1.latency=3"], "no key \"trv_l1.latency\" in a machine; "),
        (&["zebra=3"], "`rayreel presets show sgrt-ti2` lists all keys"),
        (&["ti=3"], "a table with clock_mhz, trv"),
        (&["ti.trv.x=3"], "no key \"ti.trv.x\""),
        (&["ti.trv"], "write key=value"),
        (&["=4"], "write key=value"),
        (&["ti.trv=[4]"], "ti.trv = [4] is not allowed"),
    ];
    let mix = load("mimd-trax", &["processor.kernel_mix.add_percent=26"]).unwrap_err().to_string();
    assert!(mix.contains("the shares of processor.kernel_mix are 101 % together, not 100 %"), "{mix}");
    for (overrides, part) in cases {
        let text = load("sgrt-ti2", overrides).expect_err(&format!("{overrides:?}")).to_string();
        assert!(text.contains(part), "{text:?} does not say {part:?}");
        assert!(text.starts_with(char::is_lowercase), "{text}");
    }
    for (overrides, key) in
        [(&["dram.trefi=580"], "trefi"), (&["ti.rays_per_trv=128"], "rays"), (&["dram.tras=29"], "tras")]
    {
        assert!(load("sgrt-ti2", overrides).is_ok(), "{key} at its limit");
    }
    assert!(load("sgrt-ti3", &[]).unwrap_err().to_string().contains("did you mean sgrt-ti2 or sgrt-ti1?"));
    assert!(load("no/such.toml", &[]).unwrap_err().to_string().contains("cannot read the machine file no/such.toml"));
}

/// What was set over a machine is blamed where it is at fault: the machine alone is sound.
#[test]
fn conflicts_name_the_override_that_made_them() {
    for (name, overrides, start) in [
        ("sgrt-ti2", &["ti.trv_l1.size=3KiB"][..], "override \"ti.trv_l1.size=3KiB\": ti.trv_l1.size = 3072 bytes"),
        ("sgrt-ti2", &["ti.trv_l1.ways=3"], "override \"ti.trv_l1.ways=3\": ti.trv_l1.size = 16384 bytes in 3 ways"),
        ("sgrt-ti2", &["l2.line_bytes=48"], "override \"l2.line_bytes=48\": "),
        ("sgrt-ti2", &["ti.pipeline=unified"], "override \"ti.pipeline=unified\": ti.pipeline = \"unified\" tests"),
        ("sgrt-ti2", &["gpu.cores=1", "ti.ist=0"], "override \"ti.ist=0\": ti.ist = 0 leaves nobody"),
        ("raycore", &["ti.ist=2"], "override \"ti.ist=2\": "),
        ("sgrt-ti2", &["dram.tras=28"], "override \"dram.tras=28\": dram.trcd = 29 is more than"),
        ("sgrt-ti2", &["dram.trfc=6200"], "override \"dram.trfc=6200\": dram.trefi = "),
        ("sgrt-ti2", &["dram.interleave_bytes=4096"], "override \"dram.interleave_bytes=4096\": dram."),
        ("mimd-trax", &["processor.kernel_mix.special_percent=99"], "override \"processor.kernel_mix.special_percent="),
        ("sgrt-ti2", &["srp.kernels.control.stages=0"], "override \"srp.kernels.control.stages=0\": "),
        ("raycore", &["srp.kernels.control.stages=4"], "override \"srp.kernels.control.stages=4\": "),
        ("sgrt-ti2", &["energy.dram_background_uw=0"], "override \"energy.dram_background_uw=0\": "),
    ] {
        let text = load(name, overrides).expect_err(&format!("{overrides:?}")).to_string();
        assert!(text.starts_with(start), "{text:?} does not begin with {start:?}");
    }
    let folder = tempfile::tempdir().unwrap();
    let refused = file(folder.path(), "own.toml", "extends = \"sgrt-ti2\"\nti.trv_l1.size = \"3KiB\"").unwrap_err();
    assert!(refused.to_string().contains("own.toml: ti.trv_l1.size = 3072 bytes"), "{refused}");
    let twice = "extends = \"sgrt-ti2\"\n\"ti.trv\" = 8\n[ti]\ntrv = 4";
    let refused = file(folder.path(), "twice.toml", twice).unwrap_err();
    assert!(refused.to_string().contains("twice.toml: ti.trv stands twice"), "{refused}");
}

#[test]
fn files_extend_presets_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    fs::write(folder.join("a.toml"), "extends = \"sgrt-ti2-rob\"\n[ti]\ntrv = 2\n").unwrap();
    let b = "extends = \"./a.toml\"\nwhy = \"mine\"\n[l2]\nsize = { value = \"1MiB\", class = \"estimate\", source = \"me\" }\n";
    let machine = file(folder, "b.toml", b).unwrap();
    assert_eq!(machine.name, "b");
    assert_eq!(
        machine.chain.iter().map(|a| a.name.as_str()).collect::<Vec<_>>(),
        ["b", "a", "sgrt-ti2-rob", "sgrt-ti2"]
    );
    let of = |key: &str| machine.values.iter().find(|v| v.key == key).unwrap();
    assert_eq!((machine.config.ti.trv, machine.config.l2.size), (2, Bytes(1 << 20)));
    assert_eq!((of("ti.trv").class, of("ti.trv").source.as_str()), (Class::Override, "set in a"));
    assert_eq!((of("l2.size").class, of("l2.size").from.as_str()), (Class::Estimate, "b"));
    assert_eq!(of("ti.miss_handling").from, "sgrt-ti2-rob");

    for (text, part) in [
        ("extends = \"me.toml\"", "in a circle"),
        ("extends = \"sgrt-ti\"", "did you mean"),
        ("extends = 3", "extends = 3 is not allowed; it must be a text in quotes"),
        ("[ti]\ntrv = 4", "gpu.cores is missing; set it, or write extends"),
        ("extends = ", "is not a valid machine"),
        ("extends = \"sgrt-ti2\"\n[ti]\ntvr = 4", "did you mean ti.trv"),
        ("extends = \"sgrt-ti2\"\n[ti]\ntrv = { value = 4, class = \"memory\" }", "ti.trv.source is missing"),
        (
            "extends = \"sgrt-ti2\"\n[ti]\ntrv = { value = 4, class = \"memory\", source = \" \" }",
            "ti.trv.source = \" \"",
        ),
        (
            "extends = \"sgrt-ti2\"\n[ti]\ntrv = { value = 4, class = \"hearsay\", source = \"x\" }",
            "ti.trv.class = \"hearsay\"",
        ),
        (
            "extends = \"sgrt-ti2\"\n[ti]\ntrv = { value = 99, class = \"memory\", source = \"x\" }",
            "me.toml: ti.trv = 99",
        ),
        (
            "extends = \"sgrt-ti2\"\n[ti]\ntrv = { vale = 4 }",
            "no key \"ti.trv.vale\" in a machine; did you mean value?",
        ),
        ("extends = \"sgrt-ti2\"\n[ti]\ntrv_l1 = 3", "a table with size, ways"),
    ] {
        let error = file(folder, "me.toml", text).unwrap_err().to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

/// What `presets show` prints of a machine, and what a plan keeps of it, are machine files that give it back, classes and sources
/// included.
#[test]
fn a_printed_machine_loads_again() {
    let folder = tempfile::tempdir().unwrap();
    let odd = "extends = \"raycore\"\nwhy = \"a\\nb\\u0007\"\nti.rays_per_trv = { value = 3, class = \"memory\", source = \"\\\"x\\\"\\n'y'\" }";
    fs::write(folder.path().join("odd.toml"), odd).unwrap();
    let odd = folder.path().join("odd.toml").display().to_string();
    for name in PRESETS.iter().map(|(name, _)| *name).chain([odd.as_str()]) {
        let machine = load(name, &["ti.ray_fifo_entries=77", "energy.reorder_pj=0.001"]).unwrap();
        for text in [machine.page(), machine.to_toml()] {
            let again = file(folder.path(), "again.toml", &text).unwrap();
            assert_eq!(again.config, machine.config);
            assert_eq!(again.canonical(), machine.canonical());
            let parts =
                |m: &NamedMachine| m.values.iter().map(|v| (v.key, v.class, v.source.clone())).collect::<Vec<_>>();
            assert_eq!(parts(&again), parts(&machine));
        }
    }
}

#[test]
fn a_machine_made_by_code_is_checked_too() {
    let mut config: MachineConfig = load("sgrt-ti2", &[]).unwrap().config;
    config.check().unwrap();
    config.ti.rays_per_trv = 0;
    assert!(config.check().unwrap_err().to_string().contains("machine: ti.rays_per_trv = 0"));
    config.ti.rays_per_trv = 1;
    config.ti.ist = 0;
    assert!(config.check().unwrap_err().to_string().contains("ti.ist = 0"));
}

proptest! {
    #[test]
    fn overrides_never_panic(text in "\\PC{0,40}") {
        let _ = load("sgrt-ti2", &[&text]);
    }

    #[test]
    fn what_loads_is_checked(key in 0usize..KEYS.len(), value in "[-+0-9a-zKMiB.\"\\[\\]{}= ]{0,12}") {
        if let Ok(machine) = load("sgrt-ti2", &[&format!("{}={value}", KEYS[key].name)]) {
            machine.config.check().unwrap();
        }
    }

    #[test]
    fn limits_are_inclusive(key in 0usize..KEYS.len()) {
        if let Rule::Integer(low, high) = KEYS[key].rule {
            let range = |v: i64| {
                let loaded = load("sgrt-ti2", &[&format!("{}={v}", KEYS[key].name)]);
                !matches!(loaded, Err(MachineError::Settings(SettingsError::BadValue { .. })))
            };
            prop_assert!(range(low) && range(high) && !range(low - 1) && !range(high + 1));
        }
    }
}
