//! Splitting shards into arrays that a site accepts.

use crate::cluster::slurm::indices;
use crate::cluster::slurm::limits::Limits;
use crate::error::{Result, StudyError};

/// Shards of one array. Task `t` does shard `offset + t`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Array {
    /// What is added to the index of a task.
    pub offset: usize,
    /// The indices of the tasks, increasing.
    pub tasks: Vec<usize>,
}

impl Array {
    /// Its tasks as `sbatch` reads them, at most `running` of them at a time.
    pub fn spec(&self, running: Option<usize>) -> String {
        let list = indices::list(&self.tasks);
        running.map_or_else(|| list.clone(), |running| format!("{list}%{running}"))
    }
}

/// The arrays of some shards, given in order. A shard has the same place in an array whichever others are submitted with it.
///
/// # Errors
/// More jobs than the controller keeps; a site without arrays.
pub fn split(shards: &[usize], limits: Limits) -> Result<Vec<Array>> {
    let Limits { array_size: size, job_count } = limits;
    let refuse = |detail: String| Err(StudyError::Usage { detail });
    if size < 2 {
        return refuse(format!(
            "this Slurm has no job arrays (MaxArraySize = {size}); ask its administrators for them"
        ));
    }
    // One more for the merge.
    if shards.len() >= job_count {
        let (all, most) = (shards.len(), job_count.saturating_sub(1));
        return refuse(format!(
            "{all} shards and a merge are more jobs than this Slurm keeps (MaxJobCount = {job_count}); use --shards {most} or fewer"
        ));
    }
    let mut arrays: Vec<Array> = Vec::new();
    for &shard in shards {
        let (offset, task) = (shard / size * size, shard % size);
        match arrays.last_mut() {
            Some(array) if array.offset == offset => array.tasks.push(task),
            _ => arrays.push(Array { offset, tasks: vec![task] }),
        }
    }
    Ok(arrays)
}

/// Tasks of one array that may run at a time so that all arrays together run about `most`, and each runs at all.
pub fn running(most: usize, arrays: usize) -> usize {
    (most / arrays.max(1)).max(1)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn limits(array_size: usize) -> Limits {
        Limits { array_size, ..Limits::default() }
    }

    #[test]
    fn few_shards_are_one_array() {
        let arrays = split(&[0, 1, 2, 5], limits(1001)).unwrap();
        assert_eq!(arrays, [Array { offset: 0, tasks: vec![0, 1, 2, 5] }]);
        assert_eq!(arrays[0].spec(None), "0-2,5");
        assert_eq!(arrays[0].spec(Some(20)), "0-2,5%20");
    }

    #[test]
    fn many_shards_are_split_where_the_site_says() {
        let all: Vec<usize> = (0..2500).collect();
        let arrays = split(&all, limits(1001)).unwrap();
        let specs: Vec<(usize, String)> = arrays.iter().map(|a| (a.offset, a.spec(None))).collect();
        assert_eq!(specs, [(0, "0-1000".into()), (1001, "0-1000".into()), (2002, "0-497".into())]);
        let some = split(&[3, 1000, 1001, 2499], limits(1001)).unwrap();
        let specs: Vec<(usize, String)> = some.iter().map(|a| (a.offset, a.spec(None))).collect();
        assert_eq!(specs, [(0, "3,1000".into()), (1001, "0".into()), (2002, "497".into())]);
    }

    #[test]
    fn what_the_controller_cannot_hold_is_refused() {
        let all: Vec<usize> = (0..10_000).collect();
        let error = split(&all, limits(1001)).unwrap_err().to_string();
        assert!(error.contains("MaxJobCount = 10000") && error.contains("--shards 9999"), "{error}");
        assert!(split(&all[1..], limits(1001)).is_ok());
        assert!(split(&[0], limits(0)).unwrap_err().to_string().contains("no job arrays"));
    }

    #[test]
    fn the_limit_of_running_tasks_is_shared() {
        assert_eq!((running(200, 1), running(200, 3), running(2, 3), running(5, 0)), (200, 66, 1, 5));
    }

    proptest! {
        #[test]
        fn every_shard_is_in_one_array(size in 2usize..40, shards in prop::collection::btree_set(0usize..500, 0..200)) {
            let shards: Vec<usize> = shards.into_iter().collect();
            let arrays = split(&shards, limits(size)).unwrap();
            let back: Vec<usize> = arrays.iter().flat_map(|a| a.tasks.iter().map(|t| a.offset + t)).collect();
            prop_assert_eq!(back, shards);
            prop_assert!(arrays.iter().all(|a| a.tasks.iter().all(|t| *t < size)));
        }
    }
}
