//! The tables of `MODEL.md` are what the presets and the table of keys say.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use rayreel_machine::config::schema::{KEYS, Rule};
use rayreel_machine::config::{NamedMachine, PRESETS};

fn presets() -> String {
    let mut text = "| machine | extends | how it differs, and why |\n|---|---|---|\n".to_owned();
    for (name, _) in PRESETS {
        let machine = NamedMachine::load(name, &[]).unwrap();
        let base = machine.chain.get(1).map_or(String::new(), |a| format!("`{}`", a.name));
        text += &format!("| `{name}` | {base} | {} |\n", machine.chain[0].why.replace('|', "\\|"));
    }
    text
}

fn constants() -> String {
    let machine = NamedMachine::load("sgrt-ti2", &[]).unwrap();
    let mut classes = BTreeMap::new();
    let mut text = "| key | value | unit | meaning | class | source |\n|---|---|---|---|---|---|\n".to_owned();
    for v in &machine.values {
        *classes.entry(v.class).or_insert(0) += 1;
        let key = KEYS.iter().find(|k| k.name == v.key).unwrap();
        let (value, source) = (key.rule.show(&v.value), v.source.replace('|', "\\|"));
        // A size is shown with its unit.
        let unit = if matches!(key.rule, Rule::Size(..)) { "" } else { key.unit };
        let value = value.trim_matches('"');
        text += &format!("| `{}` | {value} | {unit} | {} | {} | {source} |\n", v.key, key.meaning, v.class);
    }
    let counts: Vec<_> = classes.iter().map(|(class, n)| format!("{n} {class}")).collect();
    format!("{} values: {}.\n\n{text}", machine.values.len(), counts.join(", "))
}

/// What stands between the two markers of `name`.
fn replaced(page: &str, name: &str, table: &str) -> String {
    let (begin, end) = (format!("<!-- {name}: written by the test `model` -->\n"), format!("<!-- end of {name} -->"));
    let (head, rest) = page.split_once(&begin).unwrap_or_else(|| panic!("MODEL.md has no marker {begin:?}"));
    let (_, tail) = rest.split_once(&end).unwrap_or_else(|| panic!("MODEL.md has no marker {end:?}"));
    format!("{head}{begin}{table}{end}{tail}")
}

#[test]
fn the_tables_are_those_of_the_presets() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("MODEL.md");
    let page = fs::read_to_string(&path).unwrap();
    let expected = replaced(&replaced(&page, "presets", &presets()), "constants", &constants());
    if std::env::var_os("RAYREEL_BLESS").is_some_and(|v| v == "1") {
        fs::write(&path, &expected).unwrap();
        return;
    }
    let changed = expected.lines().zip(page.lines()).find(|(is, was)| is != was);
    assert!(
        page == expected,
        "MODEL.md is not what the presets say, first at {changed:?}; if the change is meant: RAYREEL_BLESS=1 cargo test -p \
         rayreel-machine --test model, and review the diff"
    );
}
