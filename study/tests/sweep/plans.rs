//! Plan files: their points, their keys, and what is wrong with them.

use super::*;

#[test]
fn a_plan_has_every_combination_once_in_its_order() {
    let plan = plan(SMALL).unwrap();
    let all: Vec<String> = (0..plan.points.len()).map(|i| plan.describe(i)).collect();
    let want = [
        "sgrt-ti2 under full",
        "sgrt-ti2 under adaptive block=2",
        "sgrt-ti2 under adaptive block=4",
        "raycore under full",
        "raycore under adaptive block=2",
        "raycore under adaptive block=4",
        "none under full",
        "none under adaptive block=2",
    ];
    let want = want.map(|point| format!("v1_0_cornell.rtrace frames 0..1 on {point}"));
    assert_eq!(all, want);
}

#[test]
fn axes_go_forward_together_when_zipped() {
    let zipped = plan(
        r#"policies = ["full"]
        machines = ["sgrt-ti2"]
        [[axis]]
        name = "l1"
        keys = ["ti.trv_l1.size", "ti.ist_l1.size"]
        values = ["8KiB", "16KiB"]
        zip = "caches"
        [[axis]]
        name = "trv"
        key = "ti.trv"
        values = [1, 2, 4]
        [[axis]]
        name = "l2"
        key = "l2.size"
        values = ["64KiB", "128KiB"]
        zip = "caches""#,
    )
    .unwrap();
    let labels = |i: usize| zipped.describe(i).split(" under full ").nth(1).unwrap().to_owned();
    let all: Vec<String> = (0..zipped.points.len()).map(labels).collect();
    assert_eq!(
        all,
        [
            "l1=8KiB trv=1 l2=64KiB",
            "l1=8KiB trv=2 l2=64KiB",
            "l1=8KiB trv=4 l2=64KiB",
            "l1=16KiB trv=1 l2=128KiB",
            "l1=16KiB trv=2 l2=128KiB",
            "l1=16KiB trv=4 l2=128KiB",
        ]
    );
    let machine = zipped.resolve(&zipped.points[5]).unwrap().machine.unwrap();
    assert_eq!(machine.config.ti.trv, 4);
    assert_eq!(
        (machine.config.ti.trv_l1.size.0, machine.config.ti.ist_l1.size.0, machine.config.l2.size.0),
        (16384, 16384, 131_072)
    );
}

#[test]
fn points_of_every_cycle_are_what_they_were_before_there_was_detail() {
    let whole = plan(SMALL).unwrap();
    let bytes = whole.to_json().unwrap();
    assert!(!String::from_utf8_lossy(&bytes).contains("detail"));
    assert_eq!(Plan::from_json(&bytes).unwrap(), whole);
    let said = plan(&format!("detail = \"full\"{SMALL}")).unwrap();
    assert_eq!((said.id(), &said.points), (whole.id(), &whole.points));
}

#[test]
fn each_detail_is_a_point_of_its_own() {
    let whole = plan(SMALL).unwrap();
    let both = plan(&format!("detail = [\"full\", \"10%\"]{SMALL}")).unwrap();
    // Without a machine nothing is simulated: two of the eight points have no other detail.
    assert_eq!((whole.points.len(), both.points.len()), (8, 14));
    assert_ne!(both.id(), whole.id());
    assert!(
        both.describe(0).ends_with("under full detail full") && both.describe(1).ends_with("under full detail 0.1")
    );
    let keys = |detail: usize| both.points.iter().filter(move |p| p.detail == detail).map(|p| p.key.as_str());
    assert!(keys(0).eq(whole.points.iter().map(|p| p.key.as_str())));
    assert!(keys(1).count() == 6 && keys(0).all(|key| keys(1).all(|other| other != key)));
    assert_eq!(both.resolve(&both.points[1]).unwrap().detail.to_string(), "0.1");
    assert_eq!(Plan::from_json(&both.to_json().unwrap()).unwrap(), both);
    let some = plan(&format!(
        "detail = [\"full\", 0.1]\nexclude = [\"detail == '0.1' and machine != 'raycore'\"]\n{}",
        SMALL.replace("exclude", "# ")
    ));
    assert_eq!(some.unwrap().points.iter().filter(|p| p.detail == 1).count(), 3);
    // A point of which nothing is simulated has no detail to be left out by, whatever stands first.
    for details in ["\"full\", 0.1", "0.1, \"full\""] {
        let exclude = "exclude = [\"detail == 'full'\"]";
        let rest = plan(&format!("detail = [{details}]\n{exclude}\n{}", SMALL.replace("exclude", "# "))).unwrap();
        let described: Vec<String> = (0..rest.points.len()).map(|point| rest.describe(point)).collect();
        let none = described
            .iter()
            .filter(|text| text.contains(" on none "))
            .inspect(|text| assert!(!text.contains("detail")));
        assert!(none.count() > 0 && described.iter().all(|text| !text.contains("detail full")), "{described:?}");
    }
    let mut broken = both.clone();
    broken.details[1] = "half".into();
    assert!(Plan::from_json(&broken.to_json().unwrap()).unwrap_err().contains("\"half\" is no detail"));
}

/// An axis of machines made points of one key, whose rows looked as if they had varied.
#[test]
fn an_axis_of_machines_is_not_for_none() {
    let axis = "[[axis]]\nname = \"l1\"\nkey = \"ti.trv_l1.size\"\nvalues = [\"8KiB\", \"16KiB\"]";
    let both = plan(&format!("machines = [\"sgrt-ti2\", \"none\"]\npolicies = [\"full\"]\n{axis}")).unwrap();
    let described: Vec<String> = (0..both.points.len()).map(|i| both.describe(i)).collect();
    assert_eq!(both.points.len(), 3, "{described:?}");
    assert!(described[0].ends_with("l1=8KiB") && !described[2].contains("l1="), "{described:?}");
    let error = plan(&format!("machines = [\"none\"]\npolicies = [\"full\"]\n{axis}")).unwrap_err();
    assert!(error.contains("axis \"l1\" changes machines, and machines = [\"none\"] has none"), "{error}");
    let error = plan("machines = [\"none\"]\npolicies = [\"full\"]\nset = [\"ti.trv=2\"]").unwrap_err();
    assert!(error.contains("set \"ti.trv=2\" is for a machine"), "{error}");
}

/// A comparison of a word with a number is false, and left nothing out without a word.
#[test]
fn constraints_that_leave_nothing_out_are_told() {
    let idle = |exclude: &str| {
        let plan = plan(&SMALL.replace("machine == 'none' and block == 4", exclude)).unwrap();
        (plan.points.len(), plan.idle)
    };
    let (some, all) = (idle("policy == 'full'"), idle("block == '4'"));
    assert_eq!((some.0, some.1.len()), (6, 0));
    let told = "plan.toml:5:12: exclude \"block == '4'\": it leaves no point out; a word stands in quotes, and no word equals a number";
    assert_eq!(all, (9, vec![told.to_owned()]));
    // Two that leave out the same both do, whichever is asked first; an error behind a point that is left out is none.
    assert_eq!(idle("policy == 'full'\", \"block is none\", \"policy != 'full' and block * 2 == 8"), (3, vec![]));
}

#[test]
fn bad_plans_are_one_error_with_its_place() {
    let axis = |body: &str| format!("policies = [\"full\"]\n[[axis]]\nname = \"x\"\n{body}");
    let named = |name: &str| axis("key = \"ti.trv\"\nvalues = [1]").replace("\"x\"", &format!("{name:?}"));
    let cases = [
        (
            "policies = [\"full\"]\npolicy = \"full\"".to_owned(),
            "plan.toml:3:1: unknown field `policy`; did you mean `policies`?",
        ),
        ("policies = [\"full\"\n".to_owned(), "plan.toml:"),
        ("machines = [\"sgrt-ti2\"]".to_owned(), "missing field `policies`"),
        ("policies = []".to_owned(), "plan.toml:2:12: policies is empty"),
        ("policies = [\"fulll\"]".to_owned(), "plan.toml:2:13: no policy preset \"fulll\"; did you mean full"),
        ("policies = [\"full\"]\nmachines = [\"sgrt\"]".to_owned(), "plan.toml:3:13: no machine preset \"sgrt\""),
        ("policies = [\"full\", \"full\"]".to_owned(), "plan.toml:2:21: \"full\" stands here twice"),
        (
            "policies = [\"full\"]\nframes = [\"3\"]".to_owned(),
            "plan.toml:3:11: frames \"3\": v1_0_cornell.rtrace holds frames 0..1",
        ),
        ("policies = [\"full\"]\nframes = [\"0\", \"all\"]".to_owned(), "these frames stand here twice"),
        ("policies = [\"full\"]\nframes = [\"x\"]".to_owned(), "write \"all\", \"3\" or \"0..10\""),
        (axis("key = \"ti.trv\"\nvalues = []"), "plan.toml:6:10: axis \"x\" has no values"),
        (
            axis("key = \"ti.trvs\"\nvalues = [1]"),
            "plan.toml:3:1: sgrt-ti2 under full x=1: override \"ti.trvs=1\": no key",
        ),
        (axis("key = \"ti.trv\"\nvalues = [\"many\"]"), "plan.toml:3:1: sgrt-ti2 under full x=many"),
        (axis("key = \"block\"\nvalues = [2]"), "in a policy of kind \"full\""),
        (axis("key = \"ti.trv\"\nrange = { from = 1, to = 1e9 }"), "would have more than 65536 values"),
        (
            axis("key = \"ti.trv\"\nvalues = [1]\nonly = [\"multirate\"]"),
            "is only for \"multirate\", which is no machine or policy",
        ),
        (
            axis("key = \"ti.trv\"\nvalues = [1]\n[[axis]]\nname = \"x\"\nkey = \"l2.size\"\nvalues = [1]"),
            "plan.toml:8:8: a second axis \"x\"",
        ),
        (
            axis("key = \"ti.trv\"\nvalues = [1]\n[[axis]]\nname = \"y\"\nkey = \"ti.trv\"\nvalues = [2]"),
            "axes \"x\" and \"y\" both set ti.trv; let only one of them set it",
        ),
        (
            axis("key = \"ti.trv\"\nvalues = [1]\n[[axis]]\nname = \"not\"\nkey = \"l2.size\"\nvalues = [1]"),
            "axis \"not\": that is a word of the language of exclude",
        ),
        (
            axis(
                "key = \"ti.trv\"\nvalues = [1]\nzip = \"z\"\n[[axis]]\nname = \"y\"\nkey = \"l2.size\"\nvalues = [1, 2]\nzip = \"z\"",
            ),
            "axes \"x\" and \"y\" go forward together but have 1 and 2 values",
        ),
        (
            "policies = [\"full\"]\nexclude = [\"l1 > 3\"]".to_owned(),
            "plan.toml:3:12: exclude \"l1 > 3\": l1 is no name of a point; there are trace",
        ),
        ("policies = [\"full\"]\nexclude = [\"width >\"]".to_owned(), "plan.toml:3:12: exclude \"width >\""),
        (
            "policies = [\"full\"]\nexclude = [\"width > 0\"]".to_owned(),
            "the plan has no points: every one is excluded",
        ),
        (
            "name = \"\"\npolicies = [\"full\"]".to_owned(),
            "plan.toml:2:8: a name has letters or digits, and fits a line",
        ),
        ("name = \"a\\nb\"\npolicies = [\"full\"]".to_owned(), "plan.toml:2:8: a name has letters or digits"),
        (
            "policies = [\"full\"]\n[[axis]]\nname = \"cycles\"\nkey = \"ti.trv\"\nvalues = [1]".to_owned(),
            "plan.toml:4:8: axis \"cycles\": results have a column of that name",
        ),
        (
            named("Cycles"),
            "plan.toml:4:8: axis \"Cycles\": results have a column \"cycles\", which databases take for the same",
        ),
        (named("MACHINE"), "results have a column \"machine\""),
        (named("Rays_Primary_Full"), "results have a column \"rays_primary_full\""),
        (named("detail_fraction"), "axis \"detail_fraction\": results have a column of that name"),
        (
            named("l1") + "\n[[axis]]\nname = \"L1\"\nkey = \"ti.ist\"\nvalues = [1]",
            "plan.toml:8:8: a second axis \"L1\" beside \"l1\", which databases take for the same; give it another name",
        ),
    ];
    for (body, want) in cases {
        let got = plan(&body).map(|plan| plan.points.len());
        assert!(got.as_ref().is_err_and(|e| e.contains(want)), "{body}\n  gave {got:?}\n  want {want}");
    }
    let missing = plan_of("traces = [\"a\",\n \"/nowhere/b.rtrace\"]\npolicies = [\"full\"]").unwrap_err();
    assert!(missing.starts_with("plan.toml:1:11: trace "), "{missing}");
    assert!(missing.ends_with("nor can these be opened: /nowhere/b.rtrace"), "{missing}");
    let missing = plan_of("traces = [\n \"/nowhere/*.rtrace\"]\npolicies = [\"full\"]").unwrap_err();
    assert!(missing.starts_with("plan.toml:2:2: no file matches /nowhere/*.rtrace"), "{missing}");
}

#[test]
fn ranges_that_explode_are_refused_before_they_do() {
    let axis = |name: &str, key: &str| {
        format!("[[axis]]\nname = \"{name}\"\nkey = \"{key}\"\nrange = {{ from = 1, to = 2000 }}\n")
    };
    let text = format!("policies = [\"full\"]\n{}{}", axis("a", "ti.trv"), axis("b", "ti.rays_per_trv"));
    let error = plan(&text).unwrap_err();
    assert!(error.contains("more than 1000000 points: a 2000 x b 2000"), "{error}");
}

#[test]
fn keys_change_with_what_matters_and_with_nothing_else() {
    let base = "policies = [\"adaptive\"]\n[[axis]]\nname = \"l1\"\nkey = \"ti.trv_l1.size\"\nvalues = [\"8KiB\", \"16KiB\"]\n";
    let keys = |text: &str| -> Vec<String> { plan(text).unwrap().points.iter().map(|p| p.key.clone()).collect() };
    let base_keys = keys(base);
    assert_ne!(base_keys[0], base_keys[1], "another value");
    assert!(base_keys.iter().all(|key| key.len() == 32));
    // The order, comments and names are nothing.
    let turned =
        format!("# a comment\nname = \"other\"\n{}", base.replace("[\"8KiB\", \"16KiB\"]", "[16384, 8192] # bytes"));
    assert_eq!(keys(&turned), [base_keys[1].clone(), base_keys[0].clone()]);
    // The default of a machine written out is the default.
    assert_eq!(keys(&format!("set = [\"ti.trv=4\"]\n{base}")), base_keys);
    // Constants, policies and frames are not.
    for other in [
        "set = [\"energy.trv_l1_read_pj=5.8\"]",
        "set = [\"similarity.normal_deg=11\"]",
        "machines = [\"sgrt-ti2-rob\"]",
    ] {
        let other = keys(&format!("{other}\n{base}"));
        assert!(other.iter().all(|key| !base_keys.contains(key)), "{other:?}");
    }
}
