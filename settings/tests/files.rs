//! Files that extend one another: what is taken, from where, and what the errors say.

use std::fs;
use std::path::Path;
use std::sync::LazyLock;

use rayreel_settings::{Entry, Family, Key, Loaded, Rule, Schema, Settings, SettingsError, settings, text};

settings! {
    /// A box on legs.
    struct Table {
        legs: u32 = Rule::Integer(3, 8), "legs";
        top: Top, "what stands on them";
        height: u64 = Rule::Size(1, 1 << 20), "how much fits below", "bytes";
    }

    /// The top.
    struct Top {
        width: f64 = Rule::Number(4.0), "from side to side", "metres";
        round: bool = Rule::Flag, "whether it has no corners";
    }
}

static SCHEMA: LazyLock<Schema> = LazyLock::new(|| Schema::new("a table", Table::ENTRIES));

static TABLES: Family = Family {
    what: "table",
    expected: "a valid table",
    example: "legs=4",
    base: "plain",
    presets: &[
        ("plain", "why = \"The base.\"\nlegs = 4\nheight = \"1KiB\"\n[top]\nwidth = 1\nround = false"),
        ("bistro", "extends = \"plain\"\nlegs = 3\ntop.round = { value = true, class = \"paper\", source = \"seen\" }"),
    ],
    kinds: &[],
    schema: |_| &SCHEMA,
};

const KIND: Entry =
    Entry::Key(Key { name: "kind", rule: Rule::Word(&["flat", "deep"]), unit: "", meaning: "which kind" });
const DEPTH: Entry = Entry::Key(Key { name: "depth", rule: Rule::Integer(0, 9), unit: "", meaning: "how deep" });
static FLAT: LazyLock<Schema> = LazyLock::new(|| Schema::new("a flat plate", &[KIND]));
static DEEP: LazyLock<Schema> = LazyLock::new(|| Schema::new("a deep plate", &[KIND, DEPTH]));

static PLATES: Family = Family {
    what: "plate",
    expected: "a valid plate",
    example: "depth=4",
    base: "deep",
    presets: &[
        ("flat", "kind = \"flat\""),
        ("deep", "kind = \"deep\"\ndepth = 3"),
        ("soup", "extends = \"deep\"\ndepth = 5"),
    ],
    kinds: &["flat", "deep"],
    schema: |kind| if kind == "deep" { &DEEP } else { &FLAT },
};

fn write(folder: &Path, name: &str, text: &str) -> String {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(&path, text).unwrap();
    path.display().to_string()
}

fn names(loaded: &Loaded) -> Vec<&str> {
    loaded.chain.iter().map(|ancestor| ancestor.name.as_str()).collect()
}

#[test]
fn paths_are_relative_to_the_file_that_holds_them() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "base.toml", "extends = \"bistro\"\nwhy = \"larger\"\ntop.width = 2.5");
    write(folder, "inner/middle.toml", "extends = \"../base.toml\"\nlegs = 5");
    let top = write(folder, "top.toml", "extends = \"inner/middle.toml\"\nheight = 4096");
    let loaded = TABLES.load(&top).unwrap();
    assert_eq!(names(&loaded), ["top", "middle", "base", "bistro", "plain"]);
    let table: Table = loaded.build().unwrap();
    assert_eq!(table, Table { legs: 5, top: Top { width: 2.5, round: true }, height: 4096 });
    let from: Vec<_> = loaded.values.iter().map(|v| (v.key, v.class.name(), v.from.as_str())).collect();
    let expected = [
        ("legs", "override", "middle"),
        ("top.width", "override", "base"),
        ("top.round", "paper", "bistro"),
        ("height", "override", "top"),
    ];
    assert_eq!(from, expected, "in the order of the structs");
}

#[test]
fn a_chain_ends() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    write(folder, "a.toml", "extends = \"b.toml\"");
    let circle = write(folder, "b.toml", "extends = \"a.toml\"");
    let error = TABLES.load(&circle).unwrap_err();
    let SettingsError::Circle { what: "table", chain, limit: 16 } = &error else { panic!("{error}") };
    assert_eq!(chain.split(" -> ").count(), 3, "{chain}");
    write(folder, "0.toml", "extends = \"plain\"");
    let deep: Vec<_> =
        (1..17).map(|i| write(folder, &format!("{i}.toml"), &format!("extends = \"{}.toml\"", i - 1))).collect();
    assert_eq!(TABLES.load(&deep[13]).unwrap().chain.len(), 16);
    assert!(matches!(TABLES.load(&deep[14]), Err(SettingsError::Circle { .. })), "17 in a row");
}

#[test]
fn errors_say_what_and_where() {
    let error = |text: &str| TABLES.parse("mine", text).unwrap_err().to_string();
    assert!(error("legs = ").starts_with("table mine is not a valid table: "));
    assert_eq!(
        error("extends = \"plan\""),
        "table mine: extends: no table preset \"plan\"; did you mean plain? (or give the path of a .toml file)"
    );
    assert_eq!(
        error("extends = \"plain\"\nlegs = 9"),
        "table mine: legs = 9 is not allowed; it must be a whole number from 3 to 8"
    );
    assert_eq!(
        error("[top]\nround = { value = true, class = \"paper\" }"),
        "table mine: top.round.source is missing; it must be a text that says where the value is from"
    );
    assert_eq!(error("[topp]\nround = true"), "table mine: no key \"topp.round\" in a table; did you mean top.round?");
    assert_eq!(error("top = 3"), "table mine: top = 3 is not allowed; it must be a table with width, round");
    let missing = TABLES.parse("mine", "legs = 4").unwrap().build::<Table>().unwrap_err();
    assert!(missing.to_string().starts_with("table mine: top.width is missing; set it, or write extends = \"plain\""));
    let file = TABLES.load("no/such.toml").unwrap_err();
    assert_eq!(file.to_string(), "cannot read the table file no/such.toml");
    assert!(std::error::Error::source(&file).is_some(), "the reason stands behind it");
}

#[test]
fn overrides_are_checked_as_files_are() {
    let mut table = TABLES.load("bistro").unwrap();
    for text in ["legs = 8", "height=2KiB", "top={ width = 0.5 }"] {
        table.set(text).unwrap();
    }
    assert_eq!(table.build::<Table>().unwrap(), Table { legs: 8, top: Top { width: 0.5, round: true }, height: 2048 });
    for (text, part) in [
        ("legs", "cannot read the override \"legs\"; write key=value, for example legs=4"),
        ("legs=2", "override \"legs=2\": legs = 2 is not allowed"),
        ("lags=4", "did you mean legs?"),
        ("legs={ value = 4 }", "legs = { value = 4 } is not allowed"),
    ] {
        let error = table.set(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
    assert!(SCHEMA.is_override("top.colour=3") && SCHEMA.is_override(" legs =3") && !SCHEMA.is_override("le=3"));
}

#[test]
fn a_kind_has_a_preset_of_its_name() {
    let depth = |loaded: &Loaded| loaded.get("depth").map(ToString::to_string);
    let mut plate = PLATES.parse("mine", "kind = \"deep\"").unwrap();
    assert_eq!((names(&plate), depth(&plate)), (vec!["mine", "deep"], Some("3".into())));
    plate.set("depth=4").unwrap();
    plate.set("kind=deep").unwrap();
    assert_eq!(depth(&plate).as_deref(), Some("4"), "the kind that it has");
    let undone = plate.set("kind=flat").unwrap_err().to_string();
    assert!(undone.contains("depth was set before; set kind first"), "{undone}");
    let mut plate = PLATES.parse("mine", "kind = \"deep\"").unwrap();
    plate.set("kind=deep").unwrap();
    plate.set("kind=flat").unwrap();
    assert_eq!(depth(&plate), None);
    assert!(plate.set("depth=4").unwrap_err().to_string().contains("no key \"depth\" in a flat plate"));
    plate.set("kind=deep").unwrap();
    assert_eq!(depth(&plate).as_deref(), Some("3"));
    let error = |text: &str| PLATES.parse("mine", text).unwrap_err().to_string();
    assert_eq!(error("depth = 3"), "plate mine: kind is missing; it must be \"flat\" or \"deep\"",);
    assert!(error("extends = \"soup\"\nkind = \"flat\"").contains("must be \"deep\", the kind of what it extends"));
    assert!(error("extends = \"flat\"\ndepth = 3").contains("in a flat plate"));
}

#[test]
fn files_are_told_apart_by_what_they_lead_to() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let kind = write(folder, "kind.toml", "kind = \"dep\"\ndepth = 99");
    write(folder, "x/soup.toml", "extends = \"soup\"");
    let soup = write(folder, "soup.toml", "extends = \"x/soup.toml\"\nlegs = 3");
    let bistro = write(folder, "bistro.toml", "extends = \"bistro\"");
    let circle = write(folder, "c.toml", "extends = \"c.toml\"");
    for (spec, tables, plates) in [
        ("plain", true, false),
        ("soup", false, true),
        ("neither", false, false),
        (&kind, false, true),
        (&soup, false, true),
        (&bistro, true, false),
        (&circle, false, false),
        ("no/such.toml", false, false),
    ] {
        assert_eq!((TABLES.owns(spec), PLATES.owns(spec)), (tables, plates), "{spec}");
    }
}

#[test]
fn pages_load_again_and_have_each_table_once() {
    let loaded = TABLES.load("bistro").unwrap();
    let page = text::page("bistro", &loaded.chain, &loaded.values, &SCHEMA);
    let expected = "\
# bistro
# bistro:
# plain: The base.
legs = { value = 3,        class = \"override\", source = \"set in bistro\" }  # [bistro]
height = { value = \"1KiB\", class = \"override\", source = \"set in plain\" }

[top]
width = { value = 1,       class = \"override\", source = \"set in plain\" }
round = { value = true,    class = \"paper\",    source = \"seen\" }  # [bistro]
";
    assert_eq!(page, expected);
    for text in [page, text::to_toml(&loaded.values)] {
        let again = TABLES.parse("again", &text).unwrap();
        assert_eq!(text::canonical(&again.values), text::canonical(&loaded.values));
        assert_eq!(again.values[0].source, "set in bistro");
    }
}
