//! A trace, and the tables that it has.

use std::ops::Range;
use std::path::PathBuf;
use std::sync::Arc;

use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use rayreel_columns::{Batch, Head, Selection, What, aov};
use rayreel_formats::budget::Budget;
use rayreel_formats::{Camera, Limits, Trace as Recorded};
use rayreel_replay::image::layers::{Channel, Values};
use rayreel_replay::{NamedPolicy, Stop};
use rayreel_study::presets::Preset;

use crate::batches::Batches;
use crate::columns::{plane, to_dict};
use crate::error::raise;
use crate::replay::{Frame, Request, frames_of};
use crate::wait::interruptible;
use crate::wanted::{Asked, Wanted};

/// A trace that is open.
#[pyclass(frozen, module = "rayreel._native")]
pub struct Trace {
    recorded: Arc<Recorded>,
    /// The last part of its path, as reports name it.
    file_name: String,
}

#[pymethods]
impl Trace {
    /// Opens a trace file; decoding takes at most so many MiB at a time.
    #[new]
    fn new(py: Python<'_>, path: PathBuf, memory: u32) -> PyResult<Self> {
        let memory = Arc::new(Budget::new(u64::from(memory) << 20));
        let opened = py.detach(|| Recorded::open(&path, Limits { memory, ..Limits::default() }));
        let file_name = path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Self { recorded: Arc::new(opened.map_err(|e| raise(&e))?), file_name })
    }

    /// What was captured, by name.
    fn meta<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (meta, bvh) = (self.recorded.meta(), self.recorded.bvh());
        let dict = PyDict::new(py);
        dict.set_item("scene", &meta.scene)?;
        dict.set_item("tool", &meta.tool)?;
        dict.set_item("width", meta.width)?;
        dict.set_item("height", meta.height)?;
        dict.set_item("samples", meta.samples)?;
        dict.set_item("tile", meta.tile)?;
        dict.set_item("tiles", meta.tile_count())?;
        dict.set_item("first_frame", meta.first_frame)?;
        dict.set_item("frames", meta.frames)?;
        dict.set_item("max_depth", meta.max_depth)?;
        dict.set_item("lights", meta.lights.len())?;
        dict.set_item("nodes", bvh.nodes.len())?;
        dict.set_item("triangles", bvh.triangles.len())?;
        Ok(dict)
    }

    /// The camera of a frame, the first if none is named.
    fn camera<'py>(&self, py: Python<'py>, frame: Option<u32>) -> PyResult<Bound<'py, PyDict>> {
        let frame = frame.unwrap_or(self.recorded.meta().first_frame);
        let frames = Selection::all(self.recorded.meta()).frames(frame..frame.saturating_add(1));
        frames.map_err(|e| raise(&e))?;
        let Camera { eye, corner, right, down } = self.recorded.camera(frame).map_err(|e| raise(&e))?;
        let dict = PyDict::new(py);
        let vectors = [("eye", eye), ("corner", corner), ("right", right), ("down", down)];
        vectors.into_iter().try_for_each(|(name, v)| dict.set_item(name, (v.x, v.y, v.z)))?;
        Ok(dict)
    }

    /// The fingerprint, as sweeps and reports name the trace.
    fn fingerprint(&self) -> PyResult<String> {
        Ok(self.recorded.fingerprint().map_err(|e| raise(&e))?.to_string())
    }

    /// A table, all of it.
    fn table<'py>(&self, py: Python<'py>, what: &str, asked: Asked) -> PyResult<Bound<'py, PyDict>> {
        let wanted = Wanted::new(&self.recorded, what, asked)?;
        let head = wanted.head(&self.recorded)?;
        let batch = interruptible(py, |stop| collect(&wanted, &self.recorded, &head, stop))?;
        to_dict(py, &head, batch)
    }

    /// A table, batch by batch.
    fn batches(&self, what: &str, asked: Asked) -> PyResult<Batches> {
        let wanted = Wanted::new(&self.recorded, what, asked)?;
        let head = wanted.head(&self.recorded)?;
        Batches::new(Arc::clone(&self.recorded), wanted, head)
    }

    /// What a frame holds beside its colours, and what a policy makes of it: planes by name.
    fn aov<'py>(
        &self,
        py: Python<'py>,
        frame: Option<u32>,
        policy: &str,
        overrides: Vec<String>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let policy = NamedPolicy::load(policy, &overrides).map_err(|e| raise(&e))?;
        let meta = self.recorded.meta();
        let frame = frame.unwrap_or(meta.first_frame);
        let channels =
            interruptible(py, |stop| aov::channels(&self.recorded, &policy, frame, stop).map_err(|e| raise(&e)))?;
        let (dict, size) = (PyDict::new(py), (meta.width, meta.height));
        for Channel { name, values } in channels {
            let plane = match values {
                Values::Floats(values) => plane(py, size, values)?,
                Values::Whole(values) => plane(py, size, values)?,
            };
            dict.set_item(name, plane)?;
        }
        Ok(dict)
    }

    /// Replays frames, on a machine if one is named: the report as JSON, and the frames.
    fn replay(&self, py: Python<'_>, request: Request) -> PyResult<(String, Vec<Frame>)> {
        frames_of(py, (&self.recorded, &self.file_name), request)
    }

    /// The numbers of the frames.
    #[getter]
    fn frame_numbers(&self) -> (u32, u32) {
        let Range { start, end } = self.recorded.meta().frame_numbers();
        (start, end)
    }
}

/// The rows of the wanted columns alone: others are dropped batch by batch.
fn collect(wanted: &Wanted, trace: &Recorded, head: &Head, stop: &Stop) -> PyResult<Batch> {
    let mut all: Option<Batch> = None;
    let make = |batch: Batch| Ok(batch.select(&head.places));
    let mut take = |batch: Batch, _| {
        match &mut all {
            Some(all) => all.columns.iter_mut().zip(batch.columns).for_each(|(to, from)| to.extend(from)),
            None => all = Some(batch),
        }
        Ok(())
    };
    let data = wanted.data(trace, stop);
    data.run(rayreel_columns::Use { make: &make, take: &mut take }).map_err(|e| raise(&e))?;
    match all {
        Some(all) => Ok(all),
        // Without tiles, or of a trace without triangles.
        None => Ok(data.collect().map_err(|e| raise(&e))?.select(&head.places)),
    }
}

/// The tables: name, what a row is, and the columns: name, type, unit, meaning.
#[pyfunction]
pub fn tables(py: Python<'_>) -> PyResult<Bound<'_, PyList>> {
    let tables = What::ALL.map(What::table).map(|table| {
        let columns: Vec<_> =
            table.columns.iter().map(|column| (column.name, column.kind.name(), column.unit, column.meaning)).collect();
        (table.name, table.row, columns)
    });
    PyList::new(py, tables)
}

/// Names of the policies and of the machines.
#[pyfunction]
pub fn presets() -> (Vec<&'static str>, Vec<&'static str>) {
    let names = |presets: &[(&'static str, &'static str)]| presets.iter().map(|preset| preset.0).collect();
    (names(rayreel_replay::policy::PRESETS), names(rayreel_machine::config::schema::PRESETS))
}

/// The values of a policy or a machine, as JSON.
#[pyfunction]
pub fn preset(name: &str, overrides: Vec<String>) -> PyResult<String> {
    let json = Preset::load(name, &overrides).and_then(|preset| preset.json());
    Ok(json.map_err(|e| raise(&e))?.to_string())
}
