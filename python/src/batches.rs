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
    made: Mutex<Receiver<PyResult<Batch>>>,
    stop: Stop,
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
            if let Err(error) = make(&trace, &wanted, &places, (&give, &stopped)) {
                // Nobody may be there to be told.
                let _ = give.send(Err(error));
            }
        });
        Ok(Self { head, made: Mutex::new(made), stop })
    }
}

fn make(
    trace: &Trace,
    wanted: &Wanted,
    places: &[usize],
    (give, stop): (&SyncSender<PyResult<Batch>>, &Stop),
) -> PyResult<()> {
    let mut take = |batch: Batch, _| give.send(Ok(batch)).map_err(|_| ReplayError::Interrupted.into());
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
            let next = py.detach(|| {
                let made = self.made.lock().map_err(|_| broken())?;
                Ok::<_, PyErr>(made.recv_timeout(LOOK))
            })?;
            match next {
                Ok(batch) => return Ok(Some(to_dict(py, &self.head, batch?)?)),
                Err(RecvTimeoutError::Disconnected) => return Ok(None),
                Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            }
        }
    }
}
