use super::*;
use crate::analysis::goals::Goal;
use crate::analysis::tables::{axis, field, figure, table, words};
use crate::point::key::machine_json;
use crate::table::{Cells, Role};
use rayreel_machine::config::NamedMachine;

fn of(rows: usize) -> Results {
    let number = |i: usize| Some(i as i64);
    let machine = NamedMachine::load("sgrt-ti2", &["ti.trv=5".into()]).map(|found| machine_json(&found)).unwrap();
    let floats = |factor: f64| (0..rows).map(|i| factor * (i + 1) as f64).collect::<Vec<_>>();
    table(vec![
        field("point", Role::Point, Cells::Int((0..rows).map(number).collect())),
        words("machine", Role::Point, &vec!["sgrt-ti2"; rows]),
        axis("a<b", Cells::Int((0..rows).map(|i| Some(i as i64 % 3)).collect())),
        words("status", Role::Status, &vec!["done"; rows]),
        figure("time_ms", &floats(1.5)),
        figure("energy_mj", &floats(-0.25)),
        words("machine_config", Role::Config, &vec![machine.as_str(); rows]),
    ])
}

#[test]
fn the_same_results_give_the_same_page() {
    let html = page::page(&of(6));
    assert_eq!(html, page::page(&of(6)));
    assert!(html.starts_with("<!DOCTYPE html>"));
    // The name of SVG is no address that anything loads.
    assert!(!html.replace("http://www.w3.org/2000/svg", "").contains("://"), "nothing from elsewhere");
    assert!(html.contains("a&lt;b") && !html.contains(">a<b"), "names are escaped");
    assert!(html.contains("ti.trv=5"), "what differs from the preset stands there");
    assert!(html.contains("Main effects") && html.contains("Least energy_mj"), "it reads without a script");
}

#[test]
fn odd_tables_make_a_page_too() {
    for rows in [0, 1, 2] {
        assert!(page::page(&of(rows)).ends_with("</html>\n"), "{rows} rows");
    }
    assert!(page::page(&table(Vec::new())).contains("There are no points"));
    // One point has figures, and is neither the least nor the most of anything.
    let one = page::page(&of(1));
    assert!(!one.contains("There are no points") && one.contains("<dt>time_ms</dt><dd><b>1.500"), "{one}");
    assert!(one.contains("<li>1 point</li>") && !one.contains("id=\"effects\""), "it moves nothing");
    let failed = table(vec![
        words("status", Role::Status, &["failed", "failed"]),
        words("error", Role::Status, &["<too> small", "too small"]),
        figure("time_ms", &[f64::NAN, f64::NAN]),
    ]);
    let html = page::page(&failed);
    assert!(html.contains("&lt;too&gt; small") && html.contains("2 failed"));
    assert!(html.contains("2 points could not be computed; they stand in no chart."));
    // What a chosen point is stands in no section that may be hidden.
    let before = html.split("id=\"chosen\"").next().unwrap();
    assert!(before.rsplit("<section id=\"").next().unwrap().starts_with("points\""));
}

/// The PSNR of an identical picture has no number and is more than any.
#[test]
fn an_identical_picture_has_the_most_psnr() {
    let results = table(vec![
        words("policy", Role::Point, &["full", "a", "b"]),
        figure("psnr_db", &[f64::NAN, 40.0, 30.0]),
        field("identical", Role::Figure, Cells::Flag([true, false, false].map(Some).into())),
        figure("perf_per_watt", &[1.0, 2.0, 3.0]),
    ]);
    let html = page::page(&results);
    assert!(html.contains("<dt>most psnr_db</dt><dd><b>∞</b><span>policy full</span>"), "{html}");
    let view = view::SweepView::new(&results);
    let psnr = results.field("psnr_db").unwrap();
    assert_eq!(crate::analysis::best::best(|row| view.result(psnr, row), &[0, 1, 2], Goal::Max, 2), [0, 1]);
    assert_eq!((view.shown(psnr, 0), view.shown(psnr, 1)), ("∞".into(), "40".into()));
    assert!(html.contains("mean 35, without 1 infinite value<"), "no mean has it, and the page says so: {html}");
}

/// A bar compares points that have partners; the head of the card said the mean of those of the longest bar.
#[test]
fn the_mean_of_a_result_is_of_all_points() {
    let pairs = [(1, 0), (2, 0), (3, 0), (1, 1), (2, 1)];
    let column = |name: &str, of: fn(&(i64, i64)) -> i64| {
        axis(name, Cells::Int(pairs.iter().map(|pair| Some(of(pair))).collect()))
    };
    let time = figure("time_ms", &pairs.map(|(a, b)| (a + 100 * b) as f64));
    let results =
        table(vec![column("a", |p| p.0), column("b", |p| p.1), time, figure("energy_mj", &[1.0, 2.0, 3.0, 4.0, 5.0])]);
    let html = page::page(&results);
    // (1 + 2 + 3 + 101 + 102) / 5, and not the mean of the four that b compares.
    assert!(html.contains("<small>mean 41.80</small>"), "{html}");
}

/// An axis of very many values, however strong, is not the first that a map shows.
#[test]
fn heat_maps_take_axes_that_they_have_room_for() {
    let rows = 130_u32;
    let column = |name: &str, of: fn(u32) -> i64| axis(name, Cells::Int((0..rows).map(|i| Some(of(i))).collect()));
    let time = figure("time_ms", &(0..rows).map(|i| f64::from(i * i + i % 3)).collect::<Vec<_>>());
    let energy = figure("energy_mj", &(0..rows).map(f64::from).collect::<Vec<_>>());
    let results = table(vec![
        column("many", |i| i64::from(i / 2)),
        column("two", |i| i64::from(i % 2)),
        column("three", |i| i64::from(i % 3)),
        time,
        energy,
    ]);
    let view = view::SweepView::new(&results);
    assert_eq!(view.strongest()[0], "many");
    let mut axes = view.heat_axes().unwrap().map(|axis| axis.name.as_str());
    axes.sort_unstable();
    assert_eq!(axes, ["three", "two"]);
    drawn::keep(&view);
    assert!(view.charts.into_saved().iter().any(|chart| chart.name == "heat"));
}

/// As the button of the page gives it: how many points stand in a cell, and no values that none has.
#[test]
fn files_of_charts_have_what_the_page_gives() {
    let results = table(vec![
        axis("l1", Cells::Int([1, 1, 2, 2, 3].map(Some).into())),
        words("miss", Role::Axis, &["=a", "b", "=a", "b", "b"]),
        words("status", Role::Status, &["done", "done", "done", "done", "failed"]),
        figure("time_ms", &[1.0, 2.0, 3.0, 5.0, f64::NAN]),
        figure("energy_mj", &[1.0, 2.0, 3.0, 5.0, f64::NAN]),
    ]);
    let view = view::SweepView::new(&results);
    drawn::keep(&view);
    let saved = view.charts.into_saved();
    let csv = |name: &str| saved.iter().find(|chart| chart.name == name).map(|chart| chart.csv.as_str()).unwrap();
    assert_eq!(csv("heat"), "l1,miss,energy_mj,points\r\n1,'=a,1,1\r\n1,b,2,1\r\n2,'=a,3,1\r\n2,b,5,1\r\n");
    let effects = "axis,value,time_ms\r\nl1,1,1.5\r\nl1,2,4\r\nmiss,'=a,2\r\nmiss,b,3.5\r\n";
    assert_eq!(csv("effects-time_ms"), effects);
}

/// The steadiest of all ranked nowhere. A single frame has no flicker, and no decibels of it.
#[test]
fn what_does_not_flicker_has_infinite_decibels() {
    let results = table(vec![
        axis("l1", Cells::Int([1, 2, 3].map(Some).into())),
        figure("flicker", &[0.0, 2.0, f64::NAN]),
        figure("flicker_db", &[f64::NAN, 42.0, f64::NAN]),
    ]);
    let view = view::SweepView::new(&results);
    let decibels = results.field("flicker_db").unwrap();
    let shown = [0, 1, 2].map(|row| view.result(decibels, row));
    assert_eq!(shown, [Some(f64::INFINITY), Some(42.0), None]);
}

/// Ten thousand points of two hundred columns must still open on a phone.
#[test]
fn a_large_table_makes_a_page_of_bearable_size() {
    let rows = 10_000;
    let mut fields = of(rows).fields;
    // A third counts of work, which few axes change; a third counts of one point, a third ratios.
    for column in 0..200_u32 {
        let value = |i: usize| {
            let mixed = (i as u32 + 1).wrapping_mul(2_654_435_761).wrapping_add(column * 40_503) >> 8;
            match column % 3 {
                0 => f64::from(mixed % 12) * 1e5,
                1 => f64::from(mixed % 1_000_000),
                _ => f64::from(mixed) * 1e-7,
            }
        };
        fields.push(figure(&format!("c{column}"), &(0..rows).map(value).collect::<Vec<_>>()));
    }
    let bytes = page::page(&table(fields)).len();
    assert!(bytes < 16_000_000, "{bytes} bytes");
    eprintln!("{bytes} bytes of 10000 points and 200 columns");
}

#[test]
fn the_order_of_policies_stands_there_where_it_may_change() {
    let results = |gains: [f64; 6]| {
        table(vec![
            words("trace", Role::Point, &["a<b"; 6]),
            words("policy", Role::Point, &["full", "x", "y", "full", "x", "y"]),
            axis("l2", Cells::Int([64, 64, 64, 256, 256, 256].map(Some).into())),
            figure("perf_per_watt", &gains),
        ])
    };
    let changes = page::page(&results([1.0, 2.0, 3.0, 1.0, 4.0, 2.0]));
    assert!(changes.contains("The order changes: in 1 of 2 rows another policy is first in some trace."));
    assert!(changes.contains("<td>a&lt;b</td>") && changes.contains("256: x 4.00×"), "which trace, and by how much");
    // `x` is the second policy, as in the other charts, though `full` is none of this one's.
    let first = changes.find("id=\"order\"").expect("a section");
    let marks = changes[first..].split("class=\"dot p").skip(1).map(|rest| &rest[..1]);
    assert_eq!(marks.take(4).collect::<Vec<_>>(), ["1", "2", "1", "2"]);
    let holds = page::page(&results([1.0, 2.0, 3.0, 1.0, 2.0, 4.0]));
    assert!(holds.contains("The policy that is first in a trace is first there in every row."));
    assert!(!page::page(&of(6)).contains("Order of the policies"), "one policy has no order");
}

fn saved(results: &Results, name: &str) -> (String, String) {
    let view = view::SweepView::new(results);
    drawn::keep(&view);
    let chart = view.charts.into_saved().into_iter().find(|chart| chart.name == name).expect("a chart");
    (chart.svg, chart.csv)
}

/// They were left out, and nobody was told.
#[test]
fn charts_say_what_they_leave_out() {
    let results = table(vec![
        words("trace", Role::Point, &["a", "a", "a", "a", "b"]),
        words("policy", Role::Point, &["x", "y", "x", "", "x"]),
        axis("l1", Cells::Int([1, 1, 2, 2, 2].map(Some).into())),
        figure("psnr_db", &[30.0, 31.0, 32.0, 33.0, f64::NAN]),
        figure("perf_per_watt", &[1.0, 2.0, f64::NAN, 4.0, f64::NAN]),
    ]);
    let (svg, csv) = saved(&results, "pareto");
    assert!(svg.contains(">1 point without psnr_db is left out<"), "{svg}");
    assert!(svg.contains(">2 points without perf_per_watt are left out<"), "{svg}");
    // No path for the front of b, which has no point; and what has no policy looks like none.
    assert!(!svg.contains("d=\"M\"") && svg.contains("dot pfull") && svg.contains(">none</text>"), "{svg}");
    assert!(csv.starts_with("point,trace,policy,l1,psnr_db,perf_per_watt,front\r\n"), "{csv}");
    let (svg, _) = saved(&results, "heat");
    assert!(svg.contains("without perf_per_watt are left out<") && svg.contains(">1 point without "), "{svg}");
    // One result on both axes stands in the file once.
    let one = table(vec![axis("l1", Cells::Int([1, 2].map(Some).into())), figure("odd", &[1.0, 2.0])]);
    assert!(saved(&one, "pareto").1.starts_with("point,l1,odd,front\r\n"));
}

/// Values of both axes were cut to the same text.
#[test]
fn names_of_maps_are_told_apart() {
    let name = |i: usize| format!("sgrt-ti2-with-accumulate-{i}");
    let names: Vec<String> = (0..9).map(name).collect();
    let pick = |of: fn(usize) -> usize| (0..81).map(|i| names[of(i)].as_str()).collect::<Vec<_>>();
    let values = (0..81).map(f64::from).collect::<Vec<_>>();
    let results = table(vec![
        words("down", Role::Axis, &pick(|i| i / 9)),
        words("across", Role::Axis, &pick(|i| i % 9)),
        figure("time_ms", &values),
        figure("energy_mj", &values),
    ]);
    let (svg, _) = saved(&results, "heat");
    let texts = |class: &str| {
        let start = format!("class=\"{class}\">");
        svg.split(&start).skip(1).map(|rest| rest.split('<').next().unwrap()).collect::<Vec<_>>()
    };
    for (class, count) in [("tick e", 9), ("tick m", 3)] {
        let mut found = texts(class);
        assert!(found.len() >= count && found.iter().all(|text| text.contains('…')), "{found:?}");
        let all = found.len();
        found.sort_unstable();
        found.dedup();
        assert_eq!(found.len(), all, "{found:?}");
    }
}

#[test]
fn a_legend_says_how_many_it_lacks() {
    let names: Vec<String> = (0..30).map(|i| format!("p{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let values = (0..30).map(f64::from).collect::<Vec<_>>();
    let results =
        table(vec![words("policy", Role::Point, &names), figure("time_ms", &values), figure("energy_mj", &values)]);
    let (svg, _) = saved(&results, "pareto");
    assert!(svg.contains(">p23</text>") && svg.contains(">and 6 more</text>"), "{svg}");
}

/// A file that has a preset's name and is of another kind was taken for the preset.
#[test]
fn a_file_is_no_preset_for_its_name() {
    let preset = rayreel_replay::policy::NamedPolicy::load("adaptive", &[]).unwrap();
    let other = rayreel_replay::policy::NamedPolicy::load("multirate", &[]).unwrap();
    let [preset, other] = [preset, other].map(|found| serde_json::to_string(&found.policy).unwrap());
    let changed = preset.replacen("\"block\":2", "\"block\":4", 1);
    let results = table(vec![
        words("policy", Role::Point, &["adaptive", "adaptive", "adaptive"]),
        figure("time_ms", &[1.0, 2.0, 3.0]),
        words("policy_config", Role::Config, &[&preset, &changed, &other]),
    ]);
    let view = view::SweepView::new(&results);
    let half = crate::analysis::configs::Half::Policy;
    let changes = [0, 1, 2].map(|row| view.changes(row, half));
    let presets = changes.each_ref().map(|changes| changes.preset.as_deref());
    assert_eq!(presets, [Some("adaptive"), Some("adaptive"), None]);
    let list = |row: usize| changes[row].list.iter().map(|c| format!("{}={}", c.key, c.value)).collect::<Vec<_>>();
    assert_eq!((list(0), list(1)), (Vec::new(), vec!["block=4".to_owned()]));
    assert_eq!(data::data(&view)["files"], serde_json::json!({ "machine": [], "policy": [2] }));
}

#[test]
fn one_column_is_one() {
    let html = page::page(&table(vec![axis("l1", Cells::Int([1, 2].map(Some).into()))]));
    assert!(html.contains("<summary>1 column that varies</summary>"), "{html}");
}

/// The sentence about points that were only counted went with the first filter.
#[test]
fn the_script_finds_the_sentences_that_it_counts_again() {
    let results = table(vec![
        words("detail", Role::Point, &["full", "counts"]),
        figure("energy_mj", &[1.0, 2.0]),
        figure("psnr_db", &[1.0, 2.0]),
    ]);
    let html = page::page(&results);
    assert!(html.contains("<p class=\"read\" id=\"counts\"><span>1 of 2 points is</span> of <code>"), "{html}");
}
