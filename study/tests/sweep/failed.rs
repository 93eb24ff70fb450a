//! Points that cannot be computed.

use rayreel_study::StudyError;
use rayreel_study::point::segment::Writer;
use rayreel_study::sweep::merge::merge;
use rayreel_study::sweep::reused::ReusedRows;
use rayreel_study::sweep::segment;
use rayreel_study::sweep::shard::Shard;

use super::{Sweep, plan};

/// Values that mean the same are one key, whatever they are called: what is wrong with them is said in the same words.
#[test]
fn rows_of_failed_points_know_no_names() {
    let body = r#"
machines = ["raycore"]
policies = ["adaptive"]
[[axis]]
name = "l1"
values = [{ name = "a", set = ["ti.trv_l1.size=8KiB"] }, { name = "b", set = ["ti.trv_l1.size=8192"] }]
"#;
    let run = |first: usize| {
        let sweep = Sweep::new(plan(body).unwrap());
        for index in [first, 1 - first] {
            sweep.run(Shard { index, count: 2 }, &format!("a{index}"));
        }
        sweep
    };
    let (forth, back) = (run(0), run(1));
    assert!(forth.bytes() == back.bytes());
    assert_eq!(merge(&forth.folder).unwrap().failed, 2);
    // Rows of one key that differ are refused wherever they come from.
    let all = ReusedRows::load([forth.folder.path(), back.folder.path()]).unwrap();
    assert_eq!(all.rows.len(), 1);
    let mut row = all.rows.into_values().next().unwrap();
    row.error = Some("another".into());
    let other = Sweep::new(plan(body).unwrap());
    let writer = Writer { attempt: "evil".into(), host: "h".into() };
    segment::write(&other.folder, 0, 0, &[row], &writer).unwrap();
    let conflict = ReusedRows::load([forth.folder.path(), other.folder.path()]);
    assert!(matches!(conflict, Err(StudyError::Conflict { .. })), "{conflict:?}");
}
