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
        Policy::Adaptive(own) => own,
        other => panic!("{other:?}"),
    }
}

#[test]
fn every_preset_loads_and_names_every_key() {
    for (name, text) in PRESETS {
        let policy = load(name, &[]).unwrap();
        assert_eq!(policy.name, *name);
        policy.policy.check().unwrap();
        let table: toml::Table = text.parse().unwrap();
        assert_eq!(toml::Table::try_from(&policy.policy).unwrap(), table, "{name} leaves nothing to defaults");
        for key in schema::keys(policy.policy.kind()).unwrap() {
            let value =
                key.name.split('.').try_fold(&toml::Value::Table(table.clone()), |v, part| v.get(part)).cloned();
            assert!(value.is_some_and(|v| key.rule.allows(&v)), "{name}: {}", key.name);
        }
    }
}

#[test]
fn adaptive_is_what_the_paper_evaluated() {
    let policy = load("adaptive", &[]).unwrap();
    let own = adaptive(&policy);
    assert_eq!((own.block, own.sampling.refine), (2, Refine::Direct));
    let tests = &own.sampling.similarity;
    assert!(tests.object_id && tests.shadow);
    assert_eq!((tests.normal_deg, tests.position, tests.plane), (Limit::At(10.0), Limit::Off, Limit::Off));
}

#[test]
fn overrides_change_one_value_each() {
    let sets =
        ["similarity.normal_deg=12", "block = 4", "refine=hierarchical", "similarity.plane=0.5", "apron=\"retrace\""];
    let policy = load("adaptive", &sets).unwrap();
    let own = adaptive(&policy);
    assert_eq!((own.block, own.sampling.refine), (4, Refine::Hierarchical));
    assert_eq!((own.sampling.similarity.normal_deg, own.sampling.similarity.plane), (Limit::At(12.0), Limit::At(0.5)));
    assert!(own.sampling.similarity.object_id, "the others stay");
    assert!(policy.name.starts_with("adaptive+similarity.normal_deg=12+"), "{}", policy.name);
    let off = load("adaptive", &["similarity.normal_deg=off"]).unwrap();
    assert_eq!(adaptive(&off).sampling.similarity.normal_deg, Limit::Off);
    assert_eq!(load("adaptive", &["kind=full"]).unwrap().policy, Policy::Full);
    assert_eq!(load("full", &["kind=adaptive"]).unwrap().policy, load("adaptive", &[]).unwrap().policy);
    assert_eq!(adaptive(&load("full", &["kind=adaptive", "block=8"]).unwrap()).block, 8);
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
    let own = adaptive(&policy);
    assert_eq!(policy.name, "mine+similarity.shadow=false");
    assert_eq!(
        (own.block, own.sampling.similarity.position, own.sampling.similarity.normal_deg),
        (4, Limit::At(0.25), Limit::At(10.0))
    );
    assert!(!own.sampling.similarity.shadow);
    for (text, part) in [
        ("block = 4", "kind = \"(missing)\" is not allowed"),
        ("kind = \"adaptive\"\nblok = 4", "did you mean block?"),
        ("kind = \"adaptive\"\n[similarity]\nnormal_deg = true", "mine.toml: similarity.normal_deg = true"),
        ("kind = ", "is not valid TOML"),
        ("kind = \"multi\"", "must be \"full\" or \"adaptive\""),
    ] {
        let error = file(text).unwrap_err().to_string();
        assert!(error.contains(part), "{error:?} does not say {part:?}");
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
