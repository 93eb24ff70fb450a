//! Replays and simulations: frames as arrays, figures as the JSON of a report.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayreel_columns::Selection;
use rayreel_formats::Trace;
use rayreel_machine::system::NoProbe;
use rayreel_replay::image::files::SOFTWARE;
use rayreel_replay::policy::SampleState;
use rayreel_replay::sequence::{FrameResult, Simulator};
use rayreel_replay::{
    Detail, FrameLoop, FrameReplay, NamedPolicy, Options, PathSource, ReplayError, SamplePolicy, Stop,
};
use rayreel_study::point::version::MODEL_VERSION;
use rayreel_study::report::{Made, Origin, Report};
use serde_json::Value;

use crate::columns::{picture, plane};
use crate::error::{raise, refuse};
use crate::policy::InPython;
use crate::wait::interruptible_with;
use crate::wanted::{Kind, settings};

/// What is to be replayed, and how.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub struct Request {
    /// Name or file, or an object.
    policy: Py<PyAny>,
    machine: Option<String>,
    overrides: Vec<String>,
    frames: Option<(u32, u32)>,
    detail: Option<String>,
    /// Keep the pictures.
    pictures: bool,
    /// Compare with full sampling.
    compare: bool,
}

/// A replayed frame.
#[pyclass(frozen, module = "rayreel._native")]
pub struct Frame {
    replay: FrameReplay,
    pictures: bool,
}

/// Replays the frames that are asked for.
pub fn frames_of(
    py: Python<'_>,
    (trace, file_name): (&Trace, &str),
    request: Request,
) -> PyResult<(String, Vec<Frame>)> {
    let name: Option<String> = request.policy.extract(py).ok();
    let lacks = |kind: Kind| match kind {
        Kind::Machine => "there is none in a replay; call simulate, or leave it out".into(),
        Kind::Policy => "this one is an object; set its values in Python, and leave this out".into(),
    };
    // What is no policy at all is said before what is wrong with its overrides.
    let stop = Stop::default();
    let in_python = match &name {
        Some(_) => None,
        None => Some(InPython::new(py, request.policy.clone_ref(py), stop.clone())?),
    };
    let (policy, machine) = settings(name.as_deref(), request.machine.as_deref(), &request.overrides, lacks)?;
    // What the command has an option of its own for is a detail here.
    let refused = |error: String| refuse(format!("detail: {error}; `precision P`, such as precision 0.01, is one too"));
    let detail: Detail = request.detail.as_deref().unwrap_or("full").parse().map_err(refused)?;
    let mut selection = Selection::all(trace.meta());
    if let Some((first, end)) = request.frames {
        selection = selection.frames(first..end).map_err(|e| raise(&e))?;
    }
    let frames = selection.frames;
    let hurry = |py: Python<'_>| in_python.iter().for_each(|policy| policy.interrupt(py));
    let (ran, failure) = interruptible_with(py, (&stop, hurry), || {
        let options = Options { reference: request.compare, perception: request.compare, ..Options::default() };
        let tree = machine.as_ref().map(|_| trace.topology());
        let simulator = machine.as_ref().zip(tree.as_ref()).map(|(machine, tree)| Simulator { machine, tree, detail });
        let ran = match (&policy, &in_python) {
            (Some(policy), _) => run(trace, &policy.policy, options, (frames, simulator, request.pictures), &stop),
            (None, Some(policy)) => run(trace, policy, options, (frames, simulator, request.pictures), &stop),
            (None, None) => Ok((Vec::new(), Vec::new())),
        };
        Ok((ran, in_python.as_ref().and_then(InPython::failure)))
    })?;
    // What the policy raised is the cause of what the replay says then.
    if let Some(failure) = failure {
        return Err(failure);
    }
    let (frames, runs) = ran.map_err(|e| raise(&e))?;
    let stats: Vec<_> = frames.iter().map(|frame| frame.replay.stats.clone()).collect();
    let origin = origin(trace, file_name)?;
    let report = |policy: &NamedPolicy| {
        let report = Report::new(&origin, policy, trace.meta(), &stats);
        match &machine {
            Some(machine) => report.with_machine(machine, &runs),
            None => report,
        }
    };
    let mut json = match (policy, in_python) {
        (Some(policy), _) => serde_json::to_value(report(&policy)),
        (None, in_python) => {
            let mut stand_in = NamedPolicy::load("full", &[]).map_err(|e| raise(&e))?;
            stand_in.name = in_python.map(|policy| policy.name()).unwrap_or_default();
            serde_json::to_value(report(&stand_in)).map(|mut report| {
                report["policy_config"] = Value::Null;
                report
            })
        }
    };
    // There was no command.
    if let Ok(Value::Object(report)) = &mut json {
        report.shift_remove("command");
    }
    Ok((json.map_err(|e| raise(&e))?.to_string(), frames))
}

/// What the results are of. The digest is left out: making it takes longer than a replay without a machine.
fn origin(trace: &Trace, file_name: &str) -> PyResult<Origin> {
    let made = Made { program: SOFTWARE.into(), model_version: MODEL_VERSION, command: String::new() };
    let trace_fingerprint = Some(trace.fingerprint().map_err(|e| raise(&e))?.to_string());
    Ok(Origin { made: Some(made), trace: file_name.into(), trace_fingerprint, trace_digest: None })
}

type Ran = (Vec<Frame>, Vec<rayreel_replay::simulate::MachineRun>);

fn run<P: SamplePolicy + ?Sized>(
    trace: &Trace,
    policy: &P,
    options: Options,
    (frames, simulator, pictures): (std::ops::Range<u32>, Option<Simulator<'_>>, bool),
    stop: &Stop,
) -> Result<Ran, ReplayError> {
    let (mut kept, mut runs) = (Vec::new(), Vec::new());
    let mut frame_loop = FrameLoop::new(trace, policy, options, stop)?;
    frame_loop.run(frames, simulator, &mut NoProbe, |FrameResult { mut replay, run }| {
        if !pictures {
            replay.image.pixels = Vec::new();
            (replay.reference, replay.flip) = (None, None);
        }
        kept.push(Frame { replay, pictures });
        runs.extend(run);
        Ok::<_, ReplayError>(())
    })?;
    Ok((kept, runs))
}

#[pymethods]
impl Frame {
    /// Number of the frame.
    #[getter]
    fn number(&self) -> u32 {
        self.replay.frame
    }

    /// Linear RGB: rows, columns, channels.
    #[getter]
    fn image<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.picture(py, Some(&self.replay.image))
    }

    /// The picture of full sampling.
    #[getter]
    fn reference<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        self.picture(py, self.replay.reference.as_ref())
    }

    /// FLIP of each pixel.
    #[getter]
    fn flip<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyAny>>> {
        let map = self.replay.flip.as_ref().filter(|_| self.pictures);
        map.map(|map| plane(py, (map.width, map.height), map.values.clone())).transpose()
    }

    /// State of each sample.
    #[getter]
    fn states<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        let state = |x, y| match self.replay.states.state(x, y) {
            SampleState::Reference => 0u8,
            SampleState::Traced => 1,
            SampleState::Partial => 2,
            SampleState::Interpolated => 3,
        };
        self.samples(py, state)
    }

    /// Round of each sample.
    #[getter]
    fn rounds<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        self.samples(py, |x, y| self.replay.states.round(x, y))
    }

    /// Counts of rays and samples.
    #[getter]
    fn counts<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let (dict, counts) = (PyDict::new(py), &self.replay.stats.counts);
        dict.set_item("rays_full", counts.rays_full.total())?;
        dict.set_item("rays_traced", counts.rays_traced.total())?;
        dict.set_item("rays_apron", counts.rays_apron.total())?;
        dict.set_item("samples_traced", counts.samples_traced)?;
        dict.set_item("samples_interpolated", counts.samples_interpolated)?;
        dict.set_item("similarity_ratio", counts.similarity_ratio())?;
        Ok(dict)
    }

    /// How near the picture is to that of full sampling.
    #[getter]
    fn quality<'py>(&self, py: Python<'py>) -> PyResult<Option<Bound<'py, PyDict>>> {
        let Some(quality) = &self.replay.stats.quality else { return Ok(None) };
        let dict = PyDict::new(py);
        dict.set_item("psnr_db", quality.psnr_db())?;
        dict.set_item("ssim", quality.ssim)?;
        dict.set_item("flip", quality.flip)?;
        Ok(Some(dict))
    }

    fn __repr__(&self) -> String {
        let image = &self.replay.image;
        format!("<rayreel.Frame {}: {} x {}>", self.replay.frame, image.width, image.height)
    }
}

impl Frame {
    fn picture<'py>(
        &self,
        py: Python<'py>,
        image: Option<&rayreel_replay::image::Image>,
    ) -> PyResult<Option<Bound<'py, PyAny>>> {
        let image = image.filter(|_| self.pictures);
        image.map(|image| picture(py, (image.width, image.height), image.pixels.as_flattened().to_vec())).transpose()
    }

    fn samples<'py>(&self, py: Python<'py>, value: impl Fn(u32, u32) -> u8) -> PyResult<Bound<'py, PyAny>> {
        let (width, height) = (self.replay.states.width, self.replay.states.height);
        let values = (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| value(x, y)).collect();
        plane(py, (width, height), values)
    }
}
