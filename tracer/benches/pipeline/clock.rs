//! Processor time: what other programs on the machine do hardly changes it.

use std::time::Instant;

/// Seconds of processor time of all threads so far; `None` where the system does not say.
fn processor() -> Option<f64> {
    let mut nanoseconds = 0;
    for task in std::fs::read_dir("/proc/self/task").ok()? {
        let text = std::fs::read_to_string(task.ok()?.path().join("schedstat")).ok()?;
        nanoseconds += text.split_whitespace().next()?.parse::<u64>().ok()?;
    }
    Some(nanoseconds as f64 / 1e9)
}

/// Seconds of processor time that `work` takes; where the system does not say, of all threads for as long as it lasts.
pub fn spent(work: impl FnOnce()) -> f64 {
    let (start, wall) = (processor(), Instant::now());
    work();
    let wall = wall.elapsed().as_secs_f64() * rayon::current_num_threads() as f64;
    processor().zip(start).map_or(wall, |(end, start)| end - start)
}
