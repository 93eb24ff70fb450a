//! A policy that is an object of Python: for trying an idea out. It decides each tile by itself.

use std::sync::{Arc, Mutex};

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayreel_formats::scene::{Camera, Meta};
use rayreel_replay::counts::TileStats;
use rayreel_replay::policy::{SamplePolicy, Sampler, TileView};

use crate::error::refuse;
use crate::view;

/// What was raised: by which tile of the frame, and what. Of several tiles the first counts, whichever thread came first.
type Failure = Arc<Mutex<Option<(u32, PyErr)>>>;

/// The object, with the name that results show.
pub struct InPython {
    object: Arc<Py<PyAny>>,
    name: String,
    failure: Failure,
}

impl InPython {
    /// A policy of an object with a method `begin_tile`.
    pub fn new(py: Python<'_>, object: Py<PyAny>) -> PyResult<Self> {
        let bound = object.bind(py);
        if !bound.getattr_opt("begin_tile")?.is_some_and(|method| method.is_callable()) {
            let kind = bound.get_type().name()?;
            return Err(refuse(format!(
                "a policy is the name of a preset, a file, or an object with a method begin_tile(view), not {kind}"
            )));
        }
        let name = match bound.getattr_opt("name")? {
            Some(name) => name.extract::<String>()?,
            None => bound.get_type().name()?.to_string(),
        };
        Ok(Self { object: Arc::new(object), name, failure: Failure::default() })
    }

    /// What the object raised, if it did.
    pub fn failure(&self) -> Option<PyErr> {
        self.failure.lock().ok()?.take().map(|(_, error)| error)
    }
}

impl SamplePolicy for InPython {
    fn name(&self) -> String {
        self.name.clone()
    }

    /// Nothing is kept under it: results of such a policy stand in no store.
    fn text(&self) -> String {
        format!("in Python: {}", self.name)
    }

    fn sampler(&self, _: &Meta) -> rayreel_replay::Result<Box<dyn Sampler>> {
        Ok(Box::new(AtWork { object: Arc::clone(&self.object), failure: Arc::clone(&self.failure) }))
    }
}

struct AtWork {
    object: Arc<Py<PyAny>>,
    failure: Failure,
}

impl AtWork {
    /// Notes what was raised.
    fn note(&self, tile: u32, result: PyResult<()>) {
        let (Err(error), Ok(mut first)) = (result, self.failure.lock()) else { return };
        if first.as_ref().is_none_or(|(known, _)| tile < *known) {
            *first = Some((tile, error));
        }
    }

    /// Calls a method that an object need not have.
    fn tell(&self, method: &str, arguments: impl FnOnce(Python<'_>) -> PyResult<Py<PyAny>>) {
        let told = Python::attach(|py| match self.object.bind(py).getattr_opt(method)? {
            Some(method) => method.call1((arguments(py)?,)).map(drop),
            None => Ok(()),
        });
        self.note(0, told);
    }
}

impl Sampler for AtWork {
    fn begin_frame(&mut self, frame: u32, _: &Camera) {
        self.tell("begin_frame", |py| Ok(frame.into_pyobject(py)?.into_any().unbind()));
    }

    fn begin_tile(&self, tile: &mut TileView) {
        let index = tile.index();
        let decided = Python::attach(|py| {
            view::lend(py, tile, |view| self.object.bind(py).call_method1("begin_tile", (view,)).map(drop))
        });
        self.note(index, decided);
    }

    fn end_frame(&mut self, tiles: &[TileStats]) {
        self.tell("end_frame", |py| {
            let tiles: PyResult<Vec<_>> = tiles.iter().map(|stats| about(py, stats)).collect();
            Ok(tiles?.into_pyobject(py)?.into_any().unbind())
        });
    }
}

/// What a policy learns of a tile that is decided: what it did itself.
fn about<'py>(py: Python<'py>, stats: &TileStats) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("tile", stats.tile)?;
    dict.set_item("rays_traced", stats.counts.rays_traced.total())?;
    dict.set_item("samples_traced", stats.counts.samples_traced)?;
    dict.set_item("samples_interpolated", stats.counts.samples_interpolated)?;
    Ok(dict)
}
