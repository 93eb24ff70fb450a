use super::*;
use crate::analysis::tables::{axis, figure, table, words};
use crate::table::Results;
use crate::table::{Cells, Role};

/// Points of one machine over an axis, with a result.
fn sweep(l1: &[i64], time: &[f64]) -> Results {
    let rows = l1.len();
    table(vec![
        words("key", Role::Point, &vec!["k"; rows]),
        words("machine", Role::Point, &vec!["m"; rows]),
        axis("l1", Cells::Int(l1.iter().map(|l1| Some(*l1)).collect())),
        words("error", Role::Status, &vec![""; rows]),
        figure("time_ms", time),
        words("machine_config", Role::Config, &vec![r#"{"ti.trv":4}"#; rows]),
    ])
}

fn compare(a: &Results, b: &Results) -> Comparison {
    Comparison::new(a, b, &Options::default()).unwrap()
}

#[test]
fn equal_tables_are_equal_whatever_their_keys_and_order() {
    let a = sweep(&[1, 2], &[10.0, 20.0]);
    let mut b = sweep(&[2, 1], &[20.0, 10.0]);
    b.fields[0] = words("key", Role::Point, &["other", "keys"]);
    let found = compare(&a, &b);
    assert!(!found.changed(), "{found:?}");
    assert_eq!((found.matched, found.figures), (2, 1));
}

/// A fraction or a word beside them makes another column of the same values.
#[test]
fn values_of_axes_are_matched_however_they_are_written() {
    let a = sweep(&[5, 10], &[1.0, 2.0]);
    let of = |cells: Cells| {
        let mut b = sweep(&[0, 0, 0], &[2.0, 9.0, 1.0]);
        b.fields[2] = axis("l1", cells);
        b
    };
    let floats = of(Cells::Float(vec![Some(10.0), Some(7.5), Some(5.0)]));
    let texts = of(Cells::Text(["10.0", "off", "5"].map(|text| Some(text.to_owned())).to_vec()));
    for b in [floats, texts] {
        let found = compare(&a, &b);
        assert_eq!(
            (found.matched, found.results.iter().filter(|change| change.changed > 0).count()),
            (2, 0),
            "{found:?}"
        );
    }
}

#[test]
fn changes_have_their_size_and_their_point() {
    // +10 %, -20 %, 0: the largest is -20 %, the mean -10/3 %.
    let found = compare(&sweep(&[1, 2, 3], &[10.0, 20.0, 5.0]), &sweep(&[1, 2, 3], &[11.0, 16.0, 5.0]));
    let change = &found.results[0];
    assert_eq!((change.changed, change.compared, change.largest.point.as_str()), (2, 3, "on m l1=2"));
    assert_eq!((change.largest.a, change.largest.b, change.largest.relative), (Some(20.0), Some(16.0), Some(-0.2)));
    assert!((change.mean_relative.unwrap() + 0.1 / 3.0).abs() < 1e-12);
    let within = Options { tolerance: 0.15, ..Options::default() };
    let found = Comparison::new(&sweep(&[1, 2], &[10.0, 20.0]), &sweep(&[1, 2], &[11.0, 16.0]), &within).unwrap();
    assert_eq!((found.results[0].changed, found.changed()), (1, true));
    let within = Options { tolerance: 0.2, ..Options::default() };
    assert!(
        !Comparison::new(&sweep(&[1, 2], &[10.0, 20.0]), &sweep(&[1, 2], &[11.0, 16.0]), &within).unwrap().changed()
    );
}

#[test]
fn from_zero_and_from_nothing_no_tolerance_helps() {
    let wide = Options { tolerance: 1e9, ..Options::default() };
    let found = Comparison::new(&sweep(&[1, 2], &[0.0, 7.0]), &sweep(&[1, 2], &[1e-9, f64::NAN]), &wide).unwrap();
    assert_eq!(
        (found.results[0].changed, found.results[0].largest.relative, found.results[0].mean_relative),
        (2, None, None)
    );
    assert_eq!(found.results[0].largest.point, "on m l1=1", "the first of equal ones");
    // What is 0 on both sides has no part in the mean: nothing can be said of how it changed.
    let found = compare(&sweep(&[1, 2, 3], &[0.0, 10.0, 20.0]), &sweep(&[1, 2, 3], &[0.0, 20.0, 20.0]));
    assert_eq!((found.results[0].compared, found.results[0].mean_relative), (3, Some(0.5)));
}

/// The interval of a ratio stood as how far a change from zero may be off, which has none.
#[test]
fn a_change_that_has_no_size_has_no_interval() {
    let estimated = |time: f64| {
        let mut table = sweep(&[1], &[time]);
        table.fields.push(words("interval_percent", Role::Config, &[r#"{"time_ms":5.0}"#]));
        table
    };
    let largest = |a, b| compare(&estimated(a), &estimated(b)).results[0].largest.clone();
    let (sized, from_zero) = (largest(1.0, 2.0), largest(0.0, 7.0));
    assert!(sized.relative == Some(1.0) && sized.interval.is_some_and(|part| part > 0.1), "{sized:?}");
    assert_eq!((from_zero.relative, from_zero.interval), (None, None));
}

#[test]
fn points_appear_and_vanish() {
    let found = compare(&sweep(&[1, 2], &[1.0, 2.0]), &sweep(&[2, 3], &[2.0, 3.0]));
    assert_eq!(
        (found.vanished.as_slice(), found.appeared.as_slice(), found.matched),
        (&["on m l1=1".to_owned()][..], &["on m l1=3".to_owned()][..], 1)
    );
    assert!(found.results.is_empty() && found.changed());
    // Without the axis equal ones belong together, and then the two that are left.
    let across = Options { across: vec!["l1".into()], ..Options::default() };
    let found = Comparison::new(&sweep(&[1, 2], &[1.0, 2.0]), &sweep(&[2, 3], &[2.0, 3.0]), &across).unwrap();
    assert_eq!((found.matched, found.results[0].changed, found.configuration[0].key.as_str()), (2, 1, "l1"));
    // Both are "on m" but for it, and which of them changed is to be seen.
    assert_eq!(found.results[0].largest.point, "on m l1=3");
    // The order of the rows says nothing: two machines in another order were a change.
    let found = Comparison::new(&sweep(&[1, 2], &[1.0, 2.0]), &sweep(&[2, 1], &[2.0, 1.0]), &across).unwrap();
    assert!(!found.changed() && found.matched == 2, "{found:?}");
    let two =
        Comparison::new(&sweep(&[1, 2], &[1.0, 2.0]), &sweep(&[3, 4], &[2.0, 3.0]), &across).unwrap_err().to_string();
    assert!(two.contains("--across l1: 2 points of the one and 2 of the other are alike but for it (on m)"), "{two}");
    let wrong = Options { across: vec!["nonsense".into()], ..Options::default() };
    let error = Comparison::new(&sweep(&[1], &[1.0]), &sweep(&[1], &[1.0]), &wrong).unwrap_err().to_string();
    assert!(error.contains("nonsense") && error.contains("machine, l1"), "{error}");
    let near = Options { across: vec!["machin".into()], ..Options::default() };
    let error = Comparison::new(&sweep(&[1], &[1.0]), &sweep(&[1], &[1.0]), &near).unwrap_err().to_string();
    assert!(error.contains("did you mean machine?"), "{error}");
}

/// A value that vanished was called new.
#[test]
fn what_vanished_is_gone_and_what_appeared_is_new() {
    let (known, none) = (sweep(&[1], &[3.0]), sweep(&[1], &[f64::NAN]));
    let told = |a: &Results, b: &Results| super::text::text(&compare(a, b), 0.0, 10);
    assert!(told(&known, &none).contains("gone") && !told(&known, &none).contains("new"), "{}", told(&known, &none));
    assert!(told(&none, &known).contains("new") && !told(&none, &known).contains("gone"), "{}", told(&none, &known));
}

/// Both would be equal, and a gate would let anything pass.
#[test]
fn what_has_no_value_is_no_comparison() {
    let (a, b) = (sweep(&[1], &[f64::NAN]), sweep(&[1], &[f64::NAN]));
    let compare = |a: &Results, b: &Results, only: &str, ignore: &str| {
        let select = Select::new(&[only.to_owned()], &[ignore.to_owned()]).unwrap();
        Comparison::new(a, b, &Options { select, ..Options::default() }).map_err(|e| e.to_string())
    };
    let none = compare(&a, &b, "time_ms", "ti.trv").unwrap_err();
    assert!(none.contains("time_ms has no value at any point of both"), "{none}");
    let known = sweep(&[1], &[3.0]);
    let nothing = compare(&known, &known, "time_ms", "time_*").unwrap_err();
    assert!(nothing.contains("nothing is left to compare"), "{nothing}");
    assert!(compare(&a, &known, "time_ms", "ti.trv").unwrap().changed(), "from nothing to something");
    assert!(!compare(&a, &b, "*", "time_ms").unwrap().changed(), "a key of the machine is the same");
}

#[test]
fn a_pattern_that_matches_nothing_is_no_comparison() {
    let error = |only: &[&str], ignore: &[&str]| {
        let texts = |all: &[&str]| all.iter().map(|text| (*text).to_owned()).collect::<Vec<_>>();
        let options = Options { select: Select::new(&texts(only), &texts(ignore)).unwrap(), ..Options::default() };
        let both = (sweep(&[1], &[1.0]), sweep(&[1], &[2.0]));
        Comparison::new(&both.0, &both.1, &options).map(|_| ()).map_err(|e| e.to_string())
    };
    for (only, ignore, words) in [
        (&["tiem_ms"][..], &[][..], ["--only \"tiem_ms\" matches no column", "did you mean time_ms?"]),
        (&["time_ms", "tim_*"], &[], ["--only \"tim_*\"", "time_ms"]),
        (&[], &["ti.trw"], ["--ignore \"ti.trw\"", "did you mean ti.trv?"]),
        (&["perf_per_watt"], &[], ["--only", "there are "]),
    ] {
        let error = error(only, ignore).unwrap_err();
        assert!(words.iter().all(|words| error.contains(words)), "{error}");
    }
    for known in ["time_ms", "time*", "ti.trv", "machine", "l1", "model_version", "*"] {
        assert_eq!(error(&[known], &[]), Ok(()), "{known}");
        // Without everything nothing is left.
        assert_eq!(error(&[], &[known]).is_ok(), known != "*", "{known}");
    }
}

#[test]
fn configuration_states_and_columns_are_compared_too() {
    let a = sweep(&[1, 2], &[1.0, 2.0]);
    let mut b = a.clone();
    b.fields[5] = words("machine_config", Role::Config, &[r#"{"ti.trv":4}"#, r#"{"l2.ways":8,"ti.trv":2}"#]);
    b.fields[3] = words("error", Role::Status, &["", "too small"]);
    b.fields.push(figure("fps", &[1.0, 1.0]));
    let found = compare(&a, &b);
    let keys: Vec<_> =
        found.configuration.iter().map(|c| (c.key.as_str(), c.changed, c.a.as_deref(), c.b.as_deref())).collect();
    assert_eq!(keys, [("l2.ways", 1, None, Some("8")), ("ti.trv", 1, Some("4"), Some("2"))]);
    assert_eq!((found.states[0].a.as_deref(), found.states[0].b.as_deref()), (None, Some("too small")));
    assert_eq!(found.columns_appeared, ["fps"]);
    let select = Select::new(&["time*".into(), "ti.*".into()], &["*.trv".into()]).unwrap();
    let found = Comparison::new(&a, &b, &Options { select, ..Options::default() }).unwrap();
    assert!(found.configuration.is_empty() && found.columns_appeared.is_empty() && found.figures == 1, "{found:?}");
    assert!(Select::new(&["***".into()], &[]).unwrap_err().to_string().contains("***"));
}

/// Other programs that write JSON leave out the zero.
#[test]
fn numbers_of_the_configuration_are_compared_as_values() {
    let with = |value: &str| {
        let mut table = sweep(&[1], &[1.0]);
        table.fields[5] = words("machine_config", Role::Config, &[&format!(r#"{{"energy.box_test_pj":{value}}}"#)]);
        table
    };
    for (a, b, changed) in [
        ("15.0", "15", false),
        ("1e3", "1000", false),
        ("15.0", "15.5", true),
        ("\"off\"", "0", true),
        ("9007199254740993", "9007199254740992", true),
    ] {
        assert_eq!(!compare(&with(a), &with(b)).configuration.is_empty(), changed, "{a} and {b}");
    }
}

#[test]
fn what_changed_most_comes_first() {
    let with = |x: f64, y: f64, z: f64| {
        table(vec![words("machine", Role::Point, &["m"]), figure("x", &[x]), figure("y", &[y]), figure("z", &[z])])
    };
    let found = compare(&with(100.0, 1.0, 0.0), &with(101.0, 0.5, 1.0));
    assert_eq!(found.results.iter().map(|c| c.name.as_str()).collect::<Vec<_>>(), ["z", "y", "x"]);
}
