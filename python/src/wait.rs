//! Long work, during which Python stays free and Ctrl-C is heard.

use std::sync::OnceLock;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayreel_replay::Stop;

use crate::error::refuse;

scoped_tls_hkt::scoped_thread_local!(static AROUND: Stop);

/// How long Ctrl-C may wait.
pub const LOOK: Duration = Duration::from_millis(50);

/// The process that first used the threads of this package.
static FIRST_PROCESS: OnceLock<u32> = OnceLock::new();

/// Whether this process is a fork of one that used the threads of this package: a fork has none of them, and does not know.
pub fn is_forked() -> bool {
    *FIRST_PROCESS.get_or_init(std::process::id) != std::process::id()
}

/// Calls a policy: what it asks this package for meanwhile ends when `stop` is requested, as the replay around it does.
pub fn within<T>(stop: &Stop, call: impl FnOnce() -> T) -> T {
    AROUND.set(stop, call)
}

/// Refuses to wait where what is waited for would never come.
///
/// # Errors
/// In a thread of the pool that does the work: there a policy decides a tile. In a fork.
pub fn may_wait() -> PyResult<()> {
    if rayon::current_thread_index().is_some() {
        return Err(refuse(
            "a policy cannot ask rayreel for tables or replays in begin_tile; do so in begin_frame, or before",
        ));
    }
    if is_forked() {
        return Err(refuse(
            "this process was forked after rayreel was used; start it with multiprocessing's \"spawn\"",
        ));
    }
    Ok(())
}

/// Does `work` in another thread while other threads of Python run. After Ctrl-C the work is asked to stop, and what Python raises for
/// it is returned when it has ended.
///
/// # Errors
/// What `work` returns, or what a signal raises; where [`may_wait`] refuses.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> PyResult<T> + Send) -> PyResult<T> {
    let stop = Stop::default();
    interruptible_with(py, (&stop, |_| ()), || work(&stop))
}

/// As [`interruptible`], with a request to stop that others may make too. When Ctrl-C makes it, here or around a policy that asks
/// for this work, `hurry` is called.
///
/// # Errors
/// As [`interruptible`].
pub fn interruptible_with<T: Send>(
    py: Python<'_>,
    (stop, hurry): (&Stop, impl Fn(Python<'_>)),
    work: impl FnOnce() -> PyResult<T> + Send,
) -> PyResult<T> {
    may_wait()?;
    std::thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        let worker = scope.spawn(move || {
            // Dropped when the work ends, even by a panic.
            let _done = done;
            work()
        });
        let mut signal = None;
        // A receiver is not shared between threads, and this one is only lent to the closure.
        let mut waiting = std::sync::Mutex::new(waiting);
        while let Err(RecvTimeoutError::Timeout) = {
            let waiting = &mut waiting;
            py.detach(|| waiting.get_mut().map_or(Err(RecvTimeoutError::Disconnected), |w| w.recv_timeout(LOOK)))
        } {
            if let Err(raised) = py.check_signals() {
                signal.get_or_insert(raised);
                stop.request();
                hurry(py);
            }
            if AROUND.is_set() && AROUND.with(Stop::is_requested) && !stop.is_requested() {
                stop.request();
                hurry(py);
            }
        }
        let ended = py.detach(|| worker.join());
        match (signal, ended) {
            (Some(signal), _) => Err(signal),
            (None, Ok(ended)) => ended,
            (None, Err(_)) => Err(PyRuntimeError::new_err("a thread of rayreel panicked: a fault of this package")),
        }
    })
}
