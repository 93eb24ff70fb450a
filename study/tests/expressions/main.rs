//! The expressions of `exclude` and those of the filter on a sweep's page mean the same: one table of cases, two readers.

use std::collections::BTreeMap;
use std::io::Write;
use std::process::{Command, Stdio};

use serde::Deserialize;
use toml::Spanned;

use rayreel_study::sweep::plan::Scalar;
use rayreel_study::sweep::plan::filter::{Filters, environment};
use rayreel_study::sweep::plan::locate::Text;

const CASES: &str = include_str!("cases.json");
const LANGUAGE: &str = include_str!("../../src/html/sweep/js/language.js");

type Point = BTreeMap<String, Option<Scalar>>;

#[derive(Deserialize)]
struct Cases {
    points: BTreeMap<String, Point>,
    /// Expression, its truth for the small point and for the large one.
    cases: Vec<(String, bool, bool)>,
    /// What is an error for the small point.
    errors: Vec<String>,
}

fn cases() -> Cases {
    serde_json::from_str(CASES).unwrap()
}

/// Expressions at the bounds of both readers, and such as are just beyond: each that can be read is true of the large point.
fn bounds() -> (Vec<String>, Vec<String>) {
    let within = |n: usize, open: &str, close: &str| format!("{}2{} = 2", open.repeat(n), close.repeat(n));
    let lists = |n: usize| format!("{}2{} = {}2{}", "[".repeat(n), "]".repeat(n), "[".repeat(n), "]".repeat(n));
    let nots = |n: usize| format!("{}true", "not ".repeat(n));
    // The sign of the comparison is one of all.
    let minus = |n: usize| format!("{}2 = 2", "-".repeat(n - 1));
    let chain = |n: usize| format!("2{} = 2", "*1".repeat(n - 1));
    let long = |n: usize| format!("2 ={}2", " ".repeat(n - 4));
    let one_of = |n: usize| format!("2 in [{}2]", "3,".repeat(n));
    let good = [within(74, "(", ")"), lists(74), nots(200), minus(199), chain(200), long(10_000), one_of(4000)];
    let beyond = [
        within(75, "(", ")"),
        within(20_000, "(", ")"),
        "(".repeat(20_000),
        lists(75),
        nots(202),
        minus(201),
        chain(201),
        long(10_001),
        one_of(5000),
    ];
    (good.into(), beyond.into())
}

/// What `exclude` says.
fn excludes(expression: &str, point: &Point) -> Result<bool, String> {
    let environment = environment();
    let sources = [Spanned::new(0..0, expression.to_owned())];
    let variables: Vec<_> = point.iter().map(|(name, value)| (name.clone(), value.clone())).collect();
    let filters = Filters::new(&environment, &sources, Text { name: "plan", text: "" }).map_err(|e| e.to_string())?;
    filters.excludes(&variables).map_err(|e| e.to_string())
}

#[test]
fn plans_exclude_what_the_table_says() {
    let all = cases();
    for (expression, small, large) in &all.cases {
        for (point, truth) in [("small", *small), ("large", *large)] {
            assert_eq!(excludes(expression, &all.points[point]), Ok(truth), "{expression} of {point}");
        }
    }
    for expression in &all.errors {
        let error = excludes(expression, &all.points["small"]).expect_err(expression);
        assert!(error.contains("exclude "), "{error}");
    }
    let (good, beyond) = bounds();
    good.iter().for_each(|expression| assert_eq!(excludes(expression, &all.points["large"]), Ok(true), "{expression}"));
    for expression in &beyond {
        excludes(expression, &all.points["large"]).expect_err(expression);
    }
}

/// Skipped, saying so, where Node is not installed: a browser runs the same script in `tests/e2e/sweep_page.rs`.
#[test]
fn the_page_shows_what_the_table_says() {
    let bounds = serde_json::to_string(&bounds()).unwrap();
    let script = format!(
        "const sweep = {{}};\n{LANGUAGE}\nconst all = {CASES};\n
         const truth = (expression, point) => {{
           try {{ return sweep.language.compile(expression, (name) => name in point)((name) => point[name]); }}
           catch (error) {{ return error.message; }}
         }};
         const wrong = [];
         for (const [expression, small, large] of all.cases)
           for (const [point, wanted] of [['small', small], ['large', large]]) {{
             const found = truth(expression, all.points[point]);
             if (found !== wanted) wrong.push(`${{expression}} of ${{point}} is ${{found}} and not ${{wanted}}`);
           }}
         for (const expression of all.errors) {{
           const found = truth(expression, all.points.small);
           if (typeof found !== 'string') wrong.push(`${{expression}} is ${{found}} and no error`);
         }}
         const [good, beyond] = {bounds};
         for (const expression of good) {{
           const found = truth(expression, all.points.large);
           if (found !== true) wrong.push(`${{expression}} is ${{found}}`);
         }}
         for (const expression of beyond) {{
           const found = truth(expression, all.points.large);
           if (!/^at (character|the end).*at most/.test(found)) wrong.push(`${{expression}} is ${{found}}`);
         }}
         console.log(wrong.length === 0 ? `${{all.cases.length}} hold` : wrong.join('\\n'));"
    );
    let node = Command::new("node").arg("-").stdin(Stdio::piped()).stdout(Stdio::piped()).spawn();
    let Ok(mut node) = node else {
        eprintln!("skipped: no node is installed");
        return;
    };
    node.stdin.take().unwrap().write_all(script.as_bytes()).unwrap();
    let told = node.wait_with_output().unwrap();
    let told = String::from_utf8_lossy(&told.stdout).into_owned();
    assert_eq!(told.trim(), format!("{} hold", cases().cases.len()));
}
