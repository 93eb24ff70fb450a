//! Long work, during which Python stays free and Ctrl-C is heard.

use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayreel_replay::Stop;

/// How long Ctrl-C may wait.
const LOOK: Duration = Duration::from_millis(50);

/// Does `work` in another thread while other threads of Python run. After Ctrl-C the work is asked to stop, and what Python raises for
/// it is returned when it has ended.
///
/// # Errors
/// What `work` returns, or what a signal raises.
pub fn interruptible<T: Send>(py: Python<'_>, work: impl FnOnce(&Stop) -> PyResult<T> + Send) -> PyResult<T> {
    let stop = Stop::default();
    std::thread::scope(|scope| {
        let (done, waiting) = channel::<()>();
        let stopped = &stop;
        let worker = scope.spawn(move || {
            // Dropped when the work ends, even by a panic.
            let _done = done;
            work(stopped)
        });
        let mut signal = None;
        // A receiver is not shared between threads, and this one is only lent to the closure.
        let mut waiting = std::sync::Mutex::new(waiting);
        while let Err(RecvTimeoutError::Timeout) = {
            let waiting = &mut waiting;
            py.detach(|| waiting.get_mut().map_or(Err(RecvTimeoutError::Disconnected), |w| w.recv_timeout(LOOK)))
        } {
            if signal.is_none() {
                signal = py.check_signals().err();
                signal.iter().for_each(|_| stop.request());
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
