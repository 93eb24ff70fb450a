//! Rows that other sweeps and cache folders hold already.

use rayreel_study::Store;
use rayreel_study::sweep::folder::Folder;
use rayreel_study::sweep::reused::ReusedRows;
use rayreel_study::sweep::shard::Shard;

use super::{SMALL, Sweep, plan};

#[test]
fn rows_of_another_sweep_are_taken() {
    let first = Sweep::new(plan(SMALL).unwrap());
    first.run(Shard::WHOLE, "a");
    let wider = SMALL.replace("values = [2, 4]", "values = [8, 4, 2]");
    let second = Sweep::new(plan(&wider).unwrap());
    let outcome = second.run_with(Shard::WHOLE, "b", &ReusedRows::load([first.folder.path()]).unwrap());
    assert_eq!((outcome.reused, outcome.computed, outcome.points), (8, 3, 11));
    let alone = Sweep::new(plan(&wider).unwrap());
    alone.run(Shard::WHOLE, "a");
    assert!(second.bytes() == alone.bytes());
}

/// The cache folder of `rayreel paper` holds rows without a plan.
#[test]
fn rows_of_a_cache_folder_are_taken() {
    let first = Sweep::new(plan(SMALL).unwrap());
    first.run(Shard::WHOLE, "a");
    let held = ReusedRows::load([first.folder.path()]).unwrap();
    let cache = tempfile::tempdir().unwrap();
    let store = Store::open(&cache.path().join("results")).unwrap();
    held.rows.values().for_each(|row| store.keep_row(row, &held.columns).unwrap());
    let second = Sweep::new(plan(SMALL).unwrap());
    let outcome = second.run_with(Shard::WHOLE, "b", &ReusedRows::load([cache.path()]).unwrap());
    assert_eq!((outcome.reused, outcome.computed), (8, 0));
    assert!(second.bytes() == first.bytes());
    // A folder that is neither a sweep nor a cache.
    let error = ReusedRows::load([store.path()]).unwrap_err().to_string();
    assert!(error.contains("is this the folder of a sweep?"), "{error}");
}

/// A preset has other values now: what has changed is computed, and all else is taken.
#[test]
fn rows_of_another_build_are_taken_where_their_keys_are_known() {
    let first = Sweep::new(plan(SMALL).unwrap());
    first.run(Shard::WHOLE, "a");
    // As if the machine of three points had had five cores, whose rows have keys of today's.
    let mut older = first.folder.plan().clone();
    let toml = &mut older.machines[0].toml;
    let leaf = toml.find("gpu.cores = ").unwrap();
    *toml = toml[..leaf].to_owned() + &toml[leaf..].replacen("value = 4", "value = 5", 1);
    assert_ne!(&older, first.folder.plan());
    std::fs::write(first.folder.path().join("plan.json"), older.to_json().unwrap()).unwrap();
    let error = Folder::open(first.folder.path()).unwrap_err().to_string();
    assert!(error.contains("made by another build"), "{error}");
    let held = ReusedRows::load([first.folder.path()]).unwrap();
    assert_eq!((held.rows.len(), held.left_out), (5, 3));
    let second = Sweep::new(plan(SMALL).unwrap());
    let outcome = second.run_with(Shard::WHOLE, "b", &held);
    assert_eq!((outcome.reused, outcome.computed, outcome.points), (5, 3, 8));
    let alone = Sweep::new(plan(SMALL).unwrap());
    alone.run(Shard::WHOLE, "a");
    assert!(second.bytes() == alone.bytes());
}
