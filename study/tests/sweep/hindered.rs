//! Sweeps whose files are in the way of one another, or are not what they seem.

use std::fs;
use std::sync::Barrier;

use rayreel_study::StudyError;

use super::*;

/// One policy with and without a machine, then another: the columns of rows change with every row.
const BOTH: &str = "machines = [\"none\", \"sgrt-ti2\"]\npolicies = [\"full\", \"adaptive\"]";

/// It was listed again and again, without end.
#[test]
#[cfg(unix)]
fn a_link_to_nothing_is_told() {
    let sweep = Sweep::new(plan(SMALL).unwrap());
    fs::create_dir_all(sweep.folder.segments(0)).unwrap();
    let link = sweep.folder.segments(0).join("x.seg");
    std::os::unix::fs::symlink("nowhere", &link).unwrap();
    let reused = ReusedRows::default();
    for error in [
        segment::read(&sweep.folder, 0).unwrap_err(),
        run(&sweep.folder, &settings(Shard::WHOLE, "a", &reused, Stop::default()), |_| {}).unwrap_err(),
        merge(&sweep.folder).unwrap_err(),
        ReusedRows::load([sweep.folder.path()]).unwrap_err(),
    ] {
        let error = error.to_string();
        assert!(["000000/x.seg", "is not there", "remove it"].iter().all(|words| error.contains(words)), "{error}");
    }
    // What it says helps.
    fs::remove_file(&link).unwrap();
    assert_eq!(sweep.run(Shard::WHOLE, "b").computed, 8);
    // In a bucket that is sealed it keeps nobody from anything.
    std::os::unix::fs::symlink("nowhere", &link).unwrap();
    assert!(merge(&sweep.folder).unwrap().missing.is_empty());
}

/// Rows that waited for their segment were lost when something else failed.
#[test]
fn what_is_computed_is_written_whatever_ends_the_run() {
    let sweep = Sweep::new(plan(BOTH).unwrap());
    let (reused, columns) = (ReusedRows::default(), sweep.folder.columns());
    let whole = settings(Shard::WHOLE, "a", &reused, Stop::default());
    let settings = Settings { threads: 1, flush: Duration::from_secs(3600), ..whole };
    let mut before = 0.0;
    let error = run(&sweep.folder, &settings, |now| {
        // The columns of the next row can no longer be written.
        if now.done >= 1.0 && columns.is_dir() {
            before = now.done.floor();
            fs::remove_dir_all(&columns).unwrap();
            fs::write(&columns, "in the way").unwrap();
        }
    });
    assert!(matches!(error, Err(StudyError::Io { .. })), "{error:?}");
    fs::remove_file(&columns).unwrap();
    let second = sweep.run(Shard::WHOLE, "b");
    assert!(before >= 1.0 && second.skipped >= before as usize, "{before} {second:?}");
}

/// The second replaced the plan of the first, which went on with its own.
#[test]
fn of_two_plans_for_one_folder_one_is_refused() {
    let plans = [plan(SMALL).unwrap(), plan(BOTH).unwrap()];
    for _ in 0..20 {
        let place = tempfile::tempdir().unwrap();
        let (path, barrier) = (place.path().join("sweep"), Barrier::new(2));
        let create = &|plan: &Plan| {
            barrier.wait();
            Folder::create(&path, plan.clone()).map(|(folder, _)| folder.id().to_owned()).map_err(|e| e.to_string())
        };
        let made = std::thread::scope(|scope| {
            let threads = plans.each_ref().map(|plan| scope.spawn(move || create(plan)));
            threads.map(|thread| thread.join().unwrap())
        });
        let (won, refused): (Vec<_>, Vec<_>) = made.into_iter().partition(Result::is_ok);
        assert_eq!((won.len(), refused.len()), (1, 1));
        assert!(refused[0].as_ref().unwrap_err().contains("choose another folder"), "{refused:?}");
        assert_eq!(won[0].as_ref().unwrap(), Folder::open(&path).unwrap().id());
        assert_eq!(fs::read_dir(&path).unwrap().count(), 1, "no temporary file");
    }
}
