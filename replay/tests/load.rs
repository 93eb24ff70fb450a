//! Policies from presets, files and overrides: what is taken, and what the errors say.

use proptest::prelude::*;
use rayreel_replay::policy::{Limit, PRESETS, Policy, Refine, schema};
use rayreel_replay::{NamedPolicy, ReplayError};

fn load(spec: &str, overrides: &[&str]) -> Result<NamedPolicy, ReplayError> {
    NamedPolicy::load(spec, &overrides.iter().map(ToString::to_string).collect::<Vec<_>>())
}

fn message(spec: &str, overrides: &[&str]) -> String {
    load(spec, overrides).unwrap_err().to_string()
}

fn adaptive(policy: &NamedPolicy) -> &rayreel_replay::policy::Adaptive {
    match &policy.policy {
        Policy::Adaptive(adaptive) => adaptive,
        other => panic!("{other:?}"),
    }
}

/// Keys of results are hashes of these texts: a preset may be written in another way, but must not become another policy.
#[test]
fn every_preset_is_what_it_was() {
    let mut all = String::new();
    for (name, _) in PRESETS {
        let policy = load(name, &[]).unwrap();
        assert_eq!(policy.name, *name);
        policy.policy.check().unwrap();
        all += &format!("{name} {}\n", serde_json::to_string(&policy.policy).unwrap());
    }
    assert_eq!(all, include_str!("presets.txt"));
}

#[test]
fn every_preset_gives_every_key_a_value_that_is_allowed() {
    for (name, _) in PRESETS {
        let policy = load(name, &[]).unwrap().policy;
        let table = toml::Value::try_from(&policy).unwrap();
        for key in schema::keys(policy.kind()).unwrap() {
            let value = key.name.split('.').try_fold(&table, |v, part| v.get(part)).cloned();
            assert!(value.is_some_and(|v| key.rule.accept(&v).is_some()), "{name}: {}", key.name);
        }
        assert_eq!(leaves(&table), schema::keys(policy.kind()).unwrap().len(), "{name} has no other");
    }
}

fn leaves(value: &toml::Value) -> usize {
    value.as_table().map_or(1, |table| table.values().map(leaves).sum())
}

/// A preset that extends another names what it changes; one that extends none leaves nothing to defaults.
#[test]
fn presets_write_what_differs_from_what_they_extend() {
    for (name, text) in PRESETS {
        let mut table: toml::Table = text.parse().unwrap();
        let why = table.remove("why").unwrap();
        assert!(why.as_str().is_some_and(|why| why.ends_with('.') && why.len() > 60), "{name} says why");
        let of = |name: &str| toml::Value::try_from(&load(name, &[]).unwrap().policy).unwrap();
        let Some(base) = table.remove("extends") else {
            assert_eq!(of(name), toml::Value::Table(table), "{name} leaves nothing to defaults");
            continue;
        };
        let changed = differences(&of(name), &of(base.as_str().unwrap()));
        assert_eq!(toml::Value::Table(table), changed, "{name} names what it changes");
    }
}

/// The values of `a` that `b` has not, in their tables.
fn differences(a: &toml::Value, b: &toml::Value) -> toml::Value {
    let mut changed = toml::Table::new();
    for (name, value) in a.as_table().unwrap().iter().filter(|(name, value)| b.get(name) != Some(value)) {
        let value = if value.is_table() { differences(value, &b[name]) } else { value.clone() };
        changed.insert(name.clone(), value);
    }
    toml::Value::Table(changed)
}

#[test]
fn adaptive_is_what_the_paper_evaluated() {
    let policy = load("adaptive", &[]).unwrap();
    let values = adaptive(&policy);
    assert_eq!((values.block, values.sampling.refine), (2, Refine::Direct));
    let tests = &values.sampling.similarity;
    assert!(tests.object_id && tests.shadow);
    assert_eq!((tests.normal_deg, tests.position, tests.plane), (Limit::At(10.0), Limit::Off, Limit::Off));
}

#[test]
fn overrides_change_one_value_each() {
    let sets =
        ["similarity.normal_deg=12", "block = 4", "refine=hierarchical", "similarity.plane=0.5", "apron=\"retrace\""];
    let policy = load("adaptive", &sets).unwrap();
    let values = adaptive(&policy);
    assert_eq!((values.block, values.sampling.refine), (4, Refine::Hierarchical));
    assert_eq!(
        (values.sampling.similarity.normal_deg, values.sampling.similarity.plane),
        (Limit::At(12.0), Limit::At(0.5))
    );
    assert!(values.sampling.similarity.object_id, "the others stay");
    assert!(policy.name.starts_with("adaptive+similarity.normal_deg=12+"), "{}", policy.name);
    let off = load("adaptive", &["similarity.normal_deg=off"]).unwrap();
    assert_eq!(adaptive(&off).sampling.similarity.normal_deg, Limit::Off);
    assert_eq!(load("adaptive", &["kind=full"]).unwrap().policy, Policy::Full);
    assert_eq!(load("full", &["kind=adaptive"]).unwrap().policy, load("adaptive", &[]).unwrap().policy);
    assert_eq!(adaptive(&load("full", &["kind=adaptive", "block=8"]).unwrap()).block, 8);
    // Another kind would undo what was set before it.
    let undone = load("multirate", &["start=2", "kind=adaptive"]).unwrap_err().to_string();
    assert!(
        undone.contains("\"kind=adaptive\"") && undone.contains("start was set before; set kind first"),
        "{undone}"
    );
    assert_eq!(adaptive(&load("adaptive", &["block=8", "kind=adaptive"]).unwrap()).block, 8, "it is no other");
}

#[test]
fn errors_name_key_range_and_neighbours() {
    let cases = [
        (message("adaptive", &["similarity.norml_deg=3"]), "did you mean similarity.normal_deg?"),
        (message("adaptive", &["normal_deg=3"]), "did you mean similarity.normal_deg?"),
        (message("adaptive", &["zebra=3"]), "there are kind, block"),
        (message("adaptive", &["block=5"]), "block = 5 is not allowed; it must be 2 or 3 or 4 or 8"),
        (message("adaptive", &["block=2.0"]), "must be 2 or 3"),
        (message("adaptive", &["similarity.normal_deg=181"]), "a number from 0 to 180, or \"off\""),
        (message("adaptive", &["similarity.normal_deg=nan"]), "a number from 0 to 180"),
        (message("adaptive", &["similarity.shadow=1"]), "true or false"),
        (message("adaptive", &["similarity=1"]), "a table with object_id, normal_deg"),
        (message("adaptive", &["similarity.plane.x=1"]), "similarity.plane"),
        (message("adaptive", &["refine=fast"]), "\"direct\" or \"hierarchical\""),
        (message("adaptive", &["block"]), "write key=value"),
        (message("adaptive", &["=3"]), "write key=value"),
        (message("adaptive", &["similarity.convexity=2"]), "a number from 0 to 1, or \"off\""),
        (message("adaptive", &["shade=light"]), "\"colour\" or \"attributes\""),
        (message("adaptive", &["shade=attributes"]), "shade_ambient = 0.0 is not allowed; it must be 0.000001 or more"),
        (message("kim2016", &["shade_ambient=1e-46"]), "it must be 0.000001 or more with shade = \"attributes\""),
        (message("kim2016", &["shade_ambient=11"]), "a number from 0 to 10"),
        (message("kim2016", &["secondary=true"]), "secondary = true is not allowed; it must be false with shade"),
        // What was set is at fault, not the preset that it was set over.
        (message("kim2016", &["secondary=true"]), "override \"secondary=true\": secondary = true"),
        (
            message("multirate", &["coarsest=2"]),
            "override \"coarsest=2\": coarsest = 2 is not allowed; it must be a value not below",
        ),
        (
            message("multirate", &["finest=16"]),
            "override \"finest=16\": finest = 16 is not allowed; it must be a value up to that",
        ),
        (message("full", &["block=2"]), "policy of kind \"full\""),
        (message("adaptve", &[]), "did you mean adaptive"),
        (message("no/such/file.toml", &[]), "cannot read the policy file no/such/file.toml"),
    ];
    for (text, part) in cases {
        assert!(text.contains(part), "{text:?} does not say {part:?}");
        assert!(text.starts_with(char::is_lowercase), "{text}");
    }
}

#[test]
fn files_are_completed_from_the_preset_of_their_kind() {
    let folder = tempfile::tempdir().unwrap();
    let file = |text: &str| {
        let path = folder.path().join("mine.toml");
        std::fs::write(&path, text).unwrap();
        load(path.to_str().unwrap(), &["similarity.shadow=false"])
    };
    let policy = file("kind = \"adaptive\"\nblock = 4\n[similarity]\nposition = 0.25\n").unwrap();
    let values = adaptive(&policy);
    assert_eq!(policy.name, "mine+similarity.shadow=false");
    assert_eq!(
        (values.block, values.sampling.similarity.position, values.sampling.similarity.normal_deg),
        (4, Limit::At(0.25), Limit::At(10.0))
    );
    assert!(!values.sampling.similarity.shadow);
    for (text, part) in [
        ("block = 4", "kind is missing; it must be"),
        ("kind = \"adaptive\"\nblok = 4", "did you mean block?"),
        ("kind = \"adaptive\"\n[similarity]\nnormal_deg = true", "mine.toml: similarity.normal_deg = true"),
        ("kind = ", "is not valid TOML"),
        ("kind = \"multi\"", "must be \"full\" or \"adaptive\""),
    ] {
        let error = file(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

#[test]
fn files_extend_presets_and_files() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    write("a.toml", "extends = \"adaptive-8\"\n[similarity]\nplane = 0.5\n");
    let b =
        write("b.toml", "extends = \"./a.toml\"\nwhy = \"mine\"\nkind = \"adaptive\"\n[similarity]\nshadow = false\n");
    let policy = load(&b, &["apron=retrace"]).unwrap();
    assert_eq!(policy.name, "b+apron=retrace");
    let same = load("adaptive-8", &["similarity.plane=0.5", "similarity.shadow=false", "apron=retrace"]).unwrap();
    assert_eq!(policy.policy, same.policy);
    // Another kind takes all of its preset.
    let quality = write("q.toml", "extends = \"quality\"\nstart = 8");
    assert_eq!(load(&quality, &["kind=adaptive"]).unwrap().policy, load("adaptive", &[]).unwrap().policy);
    assert_eq!(load(&quality, &["kind=multirate"]).unwrap().policy, load("quality", &["start=8"]).unwrap().policy);
    for (text, part) in [
        ("extends = \"me.toml\"", "policy files extend one another in a circle"),
        ("extends = \"multirat\"", "no policy preset \"multirat\"; did you mean multirate?"),
        ("extends = \"gone.toml\"", "cannot read the policy file"),
        ("extends = 3", "me.toml: extends = 3 is not allowed; it must be a text in quotes"),
        ("extends = \"multirate\"\nblok = 4", "no key \"blok\" in a policy of kind \"multirate\""),
        ("extends = \"multirate\"\nhold = 9", "me.toml: hold = 9 is not allowed; it must be 1 or 2"),
        (
            "extends = \"multirate\"\nkind = \"adaptive\"",
            "me.toml: kind = \"adaptive\" is not allowed; it must be \"multirate\", the kind of what it extends",
        ),
        ("extends = \"quality\"\nfinest = 16", "finest = 16 is not allowed; it must be a value up to that of coarsest"),
    ] {
        let path = write("me.toml", text);
        let error = load(&path, &[]).unwrap_err().to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
    }
}

/// What `presets show` prints of a policy, and what a plan keeps of it, are policy files that give it back.
#[test]
fn a_printed_policy_loads_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("again.toml");
    for (name, _) in PRESETS {
        let sets: &[&str] = match load(name, &[]).unwrap().policy {
            Policy::Full => &[],
            Policy::Whitted1980(_) => &["colour=0.0000001"],
            Policy::Mitchell1987(_) => &["red=0.0000001"],
            Policy::Jin2009(_) => &["threshold.colour=0.0000001", "priority.ste=2"],
            _ => &["similarity.colour=0.0000001", "shade=colour", "secondary=true"],
        };
        let policy = load(name, sets).unwrap();
        for text in [policy.page(), policy.to_toml().unwrap()] {
            std::fs::write(&path, &text).unwrap();
            assert_eq!(load(path.to_str().unwrap(), &[]).unwrap().policy, policy.policy, "{text}");
        }
        assert_eq!(policy.page().lines().count(), 1 + schema::keys(policy.policy.kind()).unwrap().len());
    }
}

proptest! {
    #[test]
    fn overrides_never_panic(text in "\\PC{0,40}") {
        let _ = load("adaptive", &[&text]);
    }

    #[test]
    fn overrides_of_real_keys_never_panic(key in 0usize..9, value in "[-+0-9a-z.\"\\[\\]{}= ]{0,12}") {
        let name = schema::keys("adaptive").unwrap()[key].name;
        if let Ok(policy) = load("adaptive", &[&format!("{name}={value}")]) {
            policy.policy.check().unwrap();
        }
    }

    #[test]
    fn files_never_panic(text in "(kind|block|=|\"adaptive\"|\\[similarity\\]|\n| |[0-9]|off){0,12}") {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("p.toml");
        std::fs::write(&path, text).unwrap();
        let _ = load(path.to_str().unwrap(), &[]);
    }
}
