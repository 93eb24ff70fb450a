//! A table as an iterator of batches, made in the background a few at a time.

use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::sync::{Arc, Mutex};

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayreel_columns::{Batch, Head, Use};
use rayreel_formats::Trace;
use rayreel_replay::{ReplayError, Stop};

use crate::columns::to_dict;
use crate::error::raise;
use crate::wait::{LOOK, may_wait};
use crate::wanted::Wanted;

/// Batches that wait for Python.
const AHEAD: usize = 2;

/// An iterator of batches, each a dictionary of columns.
#[pyclass(frozen, module = "rayreel._native")]
pub struct Batches {
    head: Head,
    made: Mutex<Made>,
    stop: Stop,
}

/// What comes from the thread that makes them.
struct Made {
    receiver: Receiver<Message>,
    /// A batch that came, and has not been given out.
    kept: Option<Batch>,
    ended: bool,
}

/// A batch, or none at the end.
type Message = PyResult<Option<Batch>>;

impl Made {
    /// Waits for the next batch a while, and keeps it; whether there is one to give out, or the end.
    fn wait(&mut self) -> PyResult<bool> {
        if self.kept.is_some() || self.ended {
            return Ok(true);
        }
        match self.receiver.recv_timeout(LOOK) {
            Ok(message) => {
                // Nothing comes behind an error.
                self.kept = message.inspect_err(|_| self.ended = true)?;
                self.ended = self.kept.is_none();
                Ok(true)
            }
            Err(RecvTimeoutError::Timeout) => Ok(false),
            Err(RecvTimeoutError::Disconnected) => {
                Err(PyRuntimeError::new_err("the thread that makes batches ended before the last one"))
            }
        }
    }
}

impl Batches {
    /// Begins to make them.
    ///
    /// # Errors
    /// Where [`may_wait`] refuses.
    pub fn new(trace: Arc<Trace>, wanted: Wanted, head: Head) -> PyResult<Self> {
        may_wait()?;
        let (give, made) = sync_channel(AHEAD);
        let (stop, places) = (Stop::default(), head.places.clone());
        let stopped = stop.clone();
        std::thread::spawn(move || {
            let made = make(&trace, &wanted, &places, (&give, &stopped));
            // Nobody may be there to be told.
            let _ = give.send(made.map(|()| None));
        });
        let made = Made { receiver: made, kept: None, ended: false };
        Ok(Self { head, made: Mutex::new(made), stop })
    }
}

fn make(trace: &Trace, wanted: &Wanted, places: &[usize], (give, stop): (&SyncSender<Message>, &Stop)) -> PyResult<()> {
    let mut take = |batch: Batch, _| give.send(Ok(Some(batch))).map_err(|_| ReplayError::Interrupted.into());
    let run = wanted.data(trace, stop).run(Use { make: &|batch: Batch| Ok(batch.select(places)), take: &mut take });
    run.map_err(|e| raise(&e))
}

impl Drop for Batches {
    fn drop(&mut self) {
        self.stop.request();
    }
}

#[pymethods]
impl Batches {
    fn __iter__(slf: Py<Self>) -> Py<Self> {
        slf
    }

    fn __next__<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        may_wait()?;
        let broken = || PyRuntimeError::new_err("another thread failed while it took a batch");
        loop {
            let there = py.detach(|| self.made.lock().map_err(|_| broken())?.wait())?;
            // Before a batch leaves: an exception behind that would lose it.
            py.check_signals()?;
            if there {
                let mut made = self.made.lock().map_err(|_| broken())?;
                match made.kept.take() {
                    Some(batch) => return to_dict(py, &self.head, batch).map(Some),
                    None if made.ended => return Ok(None),
                    // Another thread was faster.
                    None => {}
                }
            }
        }
    }
}
