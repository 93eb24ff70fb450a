//! A policy that is an object of Python: for trying an idea out. It decides each tile by itself.

use std::io::{Write as _, stderr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, TryLockError, Weak};
use std::time::{Duration, Instant};

use pyo3::exceptions::{PyKeyboardInterrupt, PySystemExit};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString, PyType};
use rayreel_formats::scene::{Camera, Meta};
use rayreel_replay::Stop;
use rayreel_replay::counts::TileStats;
use rayreel_replay::policy::{SamplePolicy, Sampler, TileView};

use crate::error::refuse;
use crate::view;
use crate::wait::{LOOK, is_forked, within};

/// The policies that may be at work; nothing once the program ends.
static LIVE: Mutex<Option<Vec<Weak<Callee>>>> = Mutex::new(Some(Vec::new()));

/// How long the end of a program waits for a call before it says so.
const QUIET: Duration = Duration::from_secs(2);

/// No thread: Python gives none this number.
const NOBODY: u64 = 0;

/// When the object is called, in the order of a replay.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Moment {
    frame: u32,
    part: Part,
}

/// A part of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Begin,
    Tile(u32),
    End,
}

/// The object, which the threads of a replay call.
struct Callee {
    object: Py<PyAny>,
    /// The name that results show.
    name: String,
    /// Ends the replay.
    stop: Stop,
    /// Held during a call, so the object is called once at a time. It is taken before Python is: who waits for it keeps no one else
    /// from Python.
    turn: Mutex<()>,
    /// The thread that is in a call, as Python numbers threads. It changes only while Python is attached.
    caller: AtomicU64,
    /// What was raised first in the order of a replay, whichever thread came first.
    failure: Mutex<Option<(Moment, PyErr)>>,
}

fn lock<T>(of: &Mutex<T>) -> MutexGuard<'_, T> {
    of.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Callee {
    /// Calls the object, unless that is of no use any more: after a failure at an earlier moment, or a request to stop. Tiles before
    /// the one that failed are still decided, for one of them may fail too, and then counts.
    fn call(&self, at: Moment, what: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<()>) {
        let _turn = lock(&self.turn);
        if lock(&self.failure).as_ref().is_some_and(|(first, _)| *first < at) {
            return;
        }
        let called = Python::try_attach(|py| {
            // Looked at while Python is attached: who asks to stop has it attached too, and so either is seen here or sees the caller.
            if self.stop.is_requested() {
                return Ok(());
            }
            let number = py.import("threading")?.call_method0("get_ident")?.extract()?;
            self.caller.store(number, Ordering::Relaxed);
            let called = within(&self.stop, || what(self.object.bind(py)));
            self.caller.store(NOBODY, Ordering::Relaxed);
            called
        });
        match called {
            Some(Ok(())) => {}
            Some(Err(error)) => self.note(at, error),
            // The interpreter is ending.
            None => self.stop.request(),
        }
    }

    /// Notes what was raised. Between frames nothing else can come first, so the replay ends.
    fn note(&self, at: Moment, error: PyErr) {
        let mut first = lock(&self.failure);
        if first.as_ref().is_none_or(|(known, _)| at < *known) {
            *first = Some((at, error));
        }
        if !matches!(at.part, Part::Tile(_)) {
            self.stop.request();
        }
    }

    /// Raises an exception in the call that is being made, if one is: as soon as Python executes its next step there. A call that
    /// waits in C ends later.
    fn interrupt(&self, exception: &Bound<'_, PyType>) -> PyResult<()> {
        let ctypes = exception.py().import("ctypes")?;
        // By way of the standard library: our own call of this function would be unsafe code.
        let raise = ctypes.getattr("pythonapi")?.getattr("PyThreadState_SetAsyncExc")?;
        let exception = ctypes.call_method1("py_object", (exception,))?;
        // No step of Python lies between this and the call, so the thread is still there.
        let caller = self.caller.load(Ordering::Relaxed);
        if caller != NOBODY {
            raise.call1((ctypes.call_method1("c_ulong", (caller,))?, exception))?;
        }
        Ok(())
    }

    fn is_called(&self) -> bool {
        matches!(self.turn.try_lock(), Err(TryLockError::WouldBlock))
    }
}

/// Ends all replays under policies in Python, and waits for the calls that are being made. Python does so before it ends: a thread
/// that calls it later takes the process down.
#[pyfunction]
pub fn end_policies(py: Python<'_>) -> PyResult<()> {
    // A fork has none of the threads.
    if is_forked() {
        return Ok(());
    }
    let live: Vec<Arc<Callee>> =
        lock(&LIVE).take().into_iter().flatten().filter_map(|callee| callee.upgrade()).collect();
    for callee in live {
        // Threads of Python end quietly by this exception.
        callee.note(Moment { frame: 0, part: Part::Begin }, PySystemExit::new_err(()));
        // Without it the call ends by itself.
        let _ = callee.interrupt(&py.get_type::<PySystemExit>());
        let (began, mut told) = (Instant::now(), false);
        while callee.is_called() {
            // It is not left behind: if C returned to Python while Python ends, the process would abort.
            if !told && began.elapsed() >= QUIET {
                told = true;
                let name = &callee.name;
                let _ = writeln!(
                    stderr(),
                    "rayreel: the program ends when policy {name} returns from its call, or with Ctrl-C"
                );
            }
            py.detach(|| std::thread::sleep(LOOK));
            py.check_signals()?;
        }
    }
    Ok(())
}

/// The object as a policy.
pub struct InPython {
    callee: Arc<Callee>,
}

impl InPython {
    /// A policy of an object with a method `begin_tile`. `stop` ends the replay, and is requested when the object fails.
    pub fn new(py: Python<'_>, object: Py<PyAny>, stop: Stop) -> PyResult<Self> {
        let bound = object.bind(py);
        if let Ok(class) = bound.cast::<PyType>() {
            let name = class.name()?;
            return Err(refuse(format!("a policy is an object, and {name} is a class; pass an instance: {name}()")));
        }
        if !bound.getattr_opt("begin_tile")?.is_some_and(|method| method.is_callable()) {
            let kind = bound.get_type().name()?;
            return Err(refuse(format!(
                "a policy is the name of a preset, a file, or an object with a method begin_tile(view), not {kind}"
            )));
        }
        for part in ["begin_frame", "end_frame"] {
            if let Some(other) = bound.getattr_opt(part)?.filter(|method| !method.is_callable()) {
                let kind = other.get_type().name()?;
                return Err(refuse(format!(
                    "{part} of a policy is a method, not {kind}; leave it out if it does nothing"
                )));
            }
        }
        let name = name_of(bound)?;
        let (turn, caller, failure) = (Mutex::default(), AtomicU64::new(NOBODY), Mutex::default());
        let callee = Arc::new(Callee { object, name, stop, turn, caller, failure });
        match &mut *lock(&LIVE) {
            Some(live) => {
                live.retain(|callee| callee.strong_count() > 0);
                live.push(Arc::downgrade(&callee));
            }
            None => return Err(too_late(py)?),
        }
        Ok(Self { callee })
    }

    /// What the object raised, if it did.
    pub fn failure(&self) -> Option<PyErr> {
        lock(&self.callee.failure).take().map(|(_, error)| error)
    }

    /// Raises KeyboardInterrupt in the call that is being made.
    pub fn interrupt(&self, py: Python<'_>) {
        // Without it the call ends by itself.
        let _ = self.callee.interrupt(&py.get_type::<PyKeyboardInterrupt>());
    }
}

/// The name that results show: that of the class, unless the object has one.
fn name_of(object: &Bound<'_, PyAny>) -> PyResult<String> {
    let Some(name) = object.getattr_opt("name")? else {
        return Ok(object.get_type().name()?.to_string());
    };
    let Ok(text) = name.cast::<PyString>() else {
        return Err(refuse(format!("the name of a policy is text, not {}", name.get_type().name()?)));
    };
    match text.to_str() {
        Ok(text) => Ok(text.to_owned()),
        Err(_) => Err(refuse(format!("the name of a policy is no UTF-8: {}", text.repr()?))),
    }
}

/// What is raised once policies have ended. A thread beside the program's own ends quietly by it, as those do that had one at work.
fn too_late(py: Python<'_>) -> PyResult<PyErr> {
    const TEXT: &str = "Python is ending: no policy in Python can be called any more";
    let threads = py.import("threading")?;
    let is_main = threads.call_method0("current_thread")?.is(&threads.call_method0("main_thread")?);
    Ok(if is_main { refuse(TEXT) } else { PySystemExit::new_err(TEXT) })
}

impl SamplePolicy for InPython {
    fn name(&self) -> String {
        self.callee.name.clone()
    }

    /// Nothing is kept under it: results of such a policy stand in no store.
    fn text(&self) -> String {
        format!("in Python: {}", self.callee.name)
    }

    fn sampler(&self, _: &Meta) -> rayreel_replay::Result<Box<dyn Sampler>> {
        Ok(Box::new(AtWork { callee: Arc::clone(&self.callee), frame: 0 }))
    }
}

struct AtWork {
    callee: Arc<Callee>,
    /// The frame that has begun.
    frame: u32,
}

impl AtWork {
    /// Calls a method that an object need not have.
    fn tell(&self, part: Part, method: &str, argument: impl FnOnce(Python<'_>) -> PyResult<Py<PyAny>>) {
        self.callee.call(Moment { frame: self.frame, part }, |object| match object.getattr_opt(method)? {
            Some(method) => method.call1((argument(object.py())?,)).map(drop),
            None => Ok(()),
        });
    }
}

impl Sampler for AtWork {
    fn begin_frame(&mut self, frame: u32, _: &Camera) {
        self.frame = frame;
        self.tell(Part::Begin, "begin_frame", |py| Ok(frame.into_pyobject(py)?.into_any().unbind()));
    }

    fn begin_tile(&self, tile: &mut TileView) {
        let at = Moment { frame: self.frame, part: Part::Tile(tile.index()) };
        self.callee.call(at, |object| {
            view::lend(object.py(), tile, |view| object.call_method1("begin_tile", (view,)).map(drop))
        });
    }

    /// All tiles of these rows have begun, so the first that failed is known.
    fn end_row(&mut self, _: &[TileStats]) {
        if lock(&self.callee.failure).is_some() {
            self.callee.stop.request();
        }
    }

    fn end_frame(&mut self, tiles: &[TileStats]) {
        self.tell(Part::End, "end_frame", |py| {
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
