//! `rayreel presets`: what it shows of a machine or policy is a file that means the same.

use std::ffi::OsString;
use std::fs;

use serde_json::Value;

use crate::common::run;
use crate::rayreel;

fn json(args: &[&str]) -> Value {
    let line: Vec<OsString> = ["presets", "show", "--json"].iter().chain(args).map(Into::into).collect();
    serde_json::from_str(&run(&line).expect(0).out).unwrap()
}

/// Values, classes and sources of a machine; the values of a policy. Not what it is called, nor which file set what.
fn meaning(mut shown: Value) -> Value {
    if let Some(values) = shown["values"].as_object_mut() {
        values.values_mut().for_each(|value| drop(value.as_object_mut().unwrap().remove("from")));
        return shown["values"].take();
    }
    shown["policy"].take()
}

#[test]
fn what_is_shown_loads_again() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("x.toml");
    let path = file.to_str().unwrap();
    let list: Value = serde_json::from_str(&rayreel!["presets", "list", "--json"].expect(0).out).unwrap();
    let mut shown = 0;
    for preset in ["machines", "policies"].iter().flat_map(|half| list[half].as_array().unwrap()) {
        let name = preset["name"].as_str().unwrap();
        fs::write(&file, rayreel!["presets", "show", name].expect(0).out).unwrap();
        assert_eq!(meaning(json(&[path])), meaning(json(&[name])), "{name}");
        assert_eq!(json(&[path])["name"], "x");
        shown += 1;
    }
    assert_eq!(shown, 29);
}

#[test]
fn files_of_both_are_shown_with_overrides() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        fs::write(folder.path().join(name), text).unwrap();
        folder.path().join(name).to_str().unwrap().to_owned()
    };
    let machine = write("m.toml", "extends = \"raycore\"\n[ti]\nrays_per_trv = 16\n");
    let shown = json(&[&machine, "--set", "l2.size=1MiB"]);
    assert_eq!(
        (&shown["values"]["l2.size"]["value"], &shown["values"]["ti.ist"]["value"]),
        (&1048576.into(), &0.into())
    );
    write("base.toml", "extends = \"multirate\"\nhold = 3\n");
    let policy = write("p.toml", "extends = \"base.toml\"\n[similarity]\nplane = 0.5\n");
    let shown = json(&[&policy, "--set", "finest=4"]);
    assert_eq!(shown["name"], "p+finest=4");
    let policy = &shown["policy"];
    assert_eq!(
        (&policy["hold"], &policy["finest"], &policy["similarity"]["plane"]),
        (&3.into(), &4.into(), &0.5.into())
    );
    let wrong = write("w.toml", "extends = \"base.toml\"\nholt = 3\n");
    let error = rayreel!["presets", "show", &wrong].expect(2).err;
    assert!(error.contains("no key \"holt\" in a policy of kind \"multirate\"; did you mean hold?"), "{error}");
}
